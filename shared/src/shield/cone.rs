//! What an echo says about points that were heard earlier.
//!
//! An echo from range *r* proves that nothing stands inside the cone nearer than *r*. A point that was heard earlier and lies
//! in that empty part is contradicted. One contradiction may be a missed echo, so a point is dropped after
//! [`CONTRADICTIONS`] of them.

use super::{Arc, Lobe, POINTS};
use crate::scan::Echo;
use crate::units::{Direction, Displacement, Range};

/// Contradictions after which a point is dropped. A sonar misses about 1 % of its echoes.
pub(super) const CONTRADICTIONS: u8 = 2;

/// An echo contradicts a point only if it comes from this much farther, millimeters: four standard deviations of a near range
/// and the rounding to whole inches.
const TOLERANCE_MM: i32 = 60;

/// A point lies this much inside the cone at least, millimeters, besides 1/32 of the arc's range: what was heard may stand
/// beside the point by half of the points' spacing, by the range's error and by slip.
const ASIDE_MM: i32 = 20;

/// Nearer than this to their faces two neighboring lobes leave a gap, millimeters. Farther away everything is in a lobe and
/// is heard again by the next ring.
const GAP_MM: i32 = 650;

/// Arcs farther than this from the robot are not tested, millimeters: no motion reaches them before the next ring.
const FARTHEST_MM: i32 = 2_000;

/// Two axes differ by less than this, Q14, if they are the same: 0.2°.
const SAME_AXIS_Q14: i32 = 57;

/// The cone of one echo, in the shield's frame.
pub(super) struct Cone {
    pub(super) face: Displacement,
    pub(super) axis: Direction,
    /// Range of the echo, millimeters; the longest for silence.
    range_mm: i32,
}

impl Cone {
    pub(super) fn new(face: Displacement, axis: Direction, echo: Echo) -> Self {
        let range_mm = i32::from(echo.range.map_or(u16::MAX, Range::as_mm));
        Self {
            face,
            axis,
            range_mm,
        }
    }

    /// Whether an arc was heard through the same cone, as far as anything near it is concerned.
    pub(super) fn is_same(&self, face: Displacement, arc: &Arc, spacing_mm: u16) -> bool {
        let apart = self.face.minus(face);
        let (dx, dy) = (apart.dx_mm.unsigned_abs(), apart.dy_mm.unsigned_abs());
        let differ = |a: i16, b: i16| (i32::from(a) - i32::from(b)).abs() >= SAME_AXIS_Q14;
        dx.max(dy) < spacing_mm.max(1)
            && !differ(self.axis.x_q14, arc.axis.x_q14)
            && !differ(self.axis.y_q14, arc.axis.y_q14)
    }

    /// Whether this echo comes from beyond `range_mm`.
    pub(super) fn is_beyond(&self, range_mm: i32) -> bool {
        self.range_mm > range_mm.saturating_add(TOLERANCE_MM + (range_mm >> 5))
    }

    /// Counts the contradictions of an arc of another cone.
    pub(super) fn look_at(&self, lobe: &Lobe, face: Displacement, arc: &mut Arc, range_mm: i32) {
        if !self.may_contain(face, arc, range_mm) {
            return;
        }
        let aside_mm = ASIDE_MM.wrapping_add(range_mm >> 5);
        for point in 0..POINTS {
            let (x_mm, y_mm) = arc.point(lobe, face, range_mm, point);
            if self.contains(lobe, x_mm, y_mm, aside_mm) {
                arc.contradict(point);
            }
        }
    }

    /// Whether an arc is near enough to the robot to matter, and in front of the face. Spares most arcs their ends.
    fn may_contain(&self, face: Displacement, arc: &Arc, range_mm: i32) -> bool {
        // No point of an arc is nearer than its range less the distance of its face.
        let (x, y) = (i32::from(face.dx_mm), i32::from(face.dy_mm));
        if range_mm.wrapping_sub(x.abs().wrapping_add(y.abs())) > FARTHEST_MM {
            return false;
        }
        let (x, y) = arc.middle(face, range_mm);
        let dx = x.wrapping_sub(i32::from(self.face.dx_mm));
        let dy = y.wrapping_sub(i32::from(self.face.dy_mm));
        if dx.abs().max(dy.abs()) > FARTHEST_MM {
            return false;
        }
        let along = self.axis.along(dx, dy);
        let across = self.axis.along(dy, dx.wrapping_neg()).abs();
        // The ends of an arc of ±15° are less than half of its range from the middle.
        along > 0 && across <= (along >> 1).wrapping_add(range_mm >> 1)
    }

    /// Whether a point lies in the empty part of the cone.
    fn contains(&self, lobe: &Lobe, x_mm: i32, y_mm: i32, aside_mm: i32) -> bool {
        let dx = x_mm.wrapping_sub(i32::from(self.face.dx_mm));
        let dy = y_mm.wrapping_sub(i32::from(self.face.dy_mm));
        // Products stay within 32 bits.
        if dx.abs().max(dy.abs()) > 4 * FARTHEST_MM {
            return false;
        }
        let along = self.axis.along(dx, dy);
        let across = self.axis.along(dy, dx.wrapping_neg()).abs();
        let edge = lobe.edge();
        let aside_mm = if along < GAP_MM { aside_mm } else { 0 };
        let (cos, sin) = (i32::from(edge.x_q14), i32::from(edge.y_q14));
        if along <= 0 || across.wrapping_add(aside_mm).wrapping_mul(cos) > along.wrapping_mul(sin) {
            return false;
        }
        // Inside the lobe the distance is at most the sum of both.
        let distance = along.wrapping_add(across >> 2);
        self.is_beyond(distance)
    }
}
