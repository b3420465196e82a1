//! An echo's cone, which contradicts points of earlier arcs.
//!
//! An echo from range *r* proves that nothing stands inside the cone nearer than *r*. A point that
//! was heard earlier and lies in that empty part is contradicted. One contradiction may be a missed
//! echo, so a point is dropped after [`CONTRADICTIONS`] of them.

use super::ShieldConfig;
use super::arc::{Arc, ArcView, BEFORE, LobeShape, POINTS, nearest_mm};
use crate::disc::magnitude;
use crate::scan::Echo;
use crate::units::{Direction, Displacement, Millis, Range};

/// Contradictions after which a point is dropped. A sonar misses about 1 % of its echoes, and walls
/// that it meets at a slant more. At most 3: two bits count them.
pub(super) const CONTRADICTIONS: u8 = 2;

/// An echo contradicts a point only if it comes from this much farther, millimeters: four standard
/// deviations of a near range and the rounding to whole inches.
const TOLERANCE_MM: i32 = 60;

/// A point lies this much inside the cone at least, millimeters, besides 1/32 of the arc's range:
/// what was heard may stand beside the point by half of the points' spacing, by the range's error
/// and by slip.
const ASIDE_MM: i32 = 20;

/// Nearer than this to their faces two neighboring lobes leave a gap, millimeters. Farther away
/// everything is in a lobe and is heard again by the next ring.
const GAP_MM: i32 = 650;

/// Arcs farther than this from the robot are not tested, millimeters: no motion reaches them before
/// the next ring.
const FARTHEST_MM: i32 = 1_200;

/// Cosine of the angle between two axes, Q14, beyond which an echo does not contradict an arc: 60°.
/// From another side, the echo may come from another surface.
const SIMILAR_AXIS_Q14: i32 = 8_192;

/// Two axes differ by less than this, Q14, if they are the same: 0.2°.
const SAME_AXIS_Q14: i32 = 57;

/// The cone of one echo, in the shield's frame.
pub(super) struct Cone {
    pub(super) face: Displacement,
    pub(super) axis: Direction,
    /// Range of the echo, millimeters; the longest for silence.
    range_mm: i32,
    pub(super) at: Millis,
}

impl Cone {
    pub(super) fn new(face: Displacement, axis: Direction, echo: Echo) -> Self {
        let range_mm = i32::from(echo.range.map_or(u16::MAX, Range::as_mm));
        Self {
            face,
            axis,
            range_mm,
            at: echo.at,
        }
    }

    /// Whether an arc was heard in nearly this direction.
    pub(super) fn looks_along(&self, arc: &Arc) -> bool {
        let (x, y) = (i32::from(arc.axis.x_q14), i32::from(arc.axis.y_q14));
        self.axis.along(x, y) >= SIMILAR_AXIS_Q14
    }

    /// Whether an arc was heard through the same cone, as far as anything near it is concerned.
    pub(super) fn is_same(&self, arc: &Arc, spacing_mm: u16) -> bool {
        let differ = |a: i16, b: i16| (i32::from(a) - i32::from(b)).abs() >= SAME_AXIS_Q14;
        if differ(self.axis.x_q14, arc.axis.x_q14) || differ(self.axis.y_q14, arc.axis.y_q14) {
            return false;
        }
        let apart = self.face.minus(arc.face);
        let (dx, dy) = (apart.dx_mm.unsigned_abs(), apart.dy_mm.unsigned_abs());
        dx.max(dy) < spacing_mm.max(1)
    }

    /// Whether this echo comes from beyond `range_mm`.
    fn is_beyond(&self, range_mm: i32) -> bool {
        self.range_mm > range_mm.saturating_add(TOLERANCE_MM + (range_mm >> 5))
    }

    /// Drops an arc heard in nearly this direction through the same cone, unless this echo comes
    /// from farther away; counts what it contradicts of others.
    pub(super) fn look(&self, limits: &ShieldConfig, lobe: &LobeShape, arc: &mut Arc) {
        let Some(range) = arc.range.filter(|_| !self.at.is_before(arc.at)) else {
            return;
        };
        let range_mm = range.as_mm().into();
        if !self.is_same(arc, limits.spacing_mm) {
            self.look_at(limits, lobe, arc, range_mm);
        } else if self.is_beyond(range_mm) {
            (0..POINTS).for_each(|point| arc.contradict(point));
        } else {
            *arc = Arc::NONE;
        }
    }

    /// Counts the contradictions of an arc of another cone.
    pub(super) fn look_at(
        &self,
        limits: &ShieldConfig,
        lobe: &LobeShape,
        arc: &mut Arc,
        range_mm: i32,
    ) {
        let (x, y) = arc.face_mm();
        if nearest_mm((x, y), range_mm) > FARTHEST_MM {
            return;
        }
        let face_mm = (
            x.wrapping_sub(self.face.dx_mm.into()),
            y.wrapping_sub(self.face.dy_mm.into()),
        );
        // The points as they count where a way is asked for.
        let least_mm = i32::from(limits.least_range_mm);
        let seen = ArcView::along(self.axis, face_mm, arc.axis, range_mm.max(least_mm));
        if range_mm <= least_mm && arc.stands(BEFORE) {
            let before = seen.on_axis(limits.before_mm());
            if self.contains(lobe, before, ASIDE_MM) {
                arc.contradict(BEFORE);
            }
        }
        if !self.may_contain(lobe, &seen) {
            return;
        }
        let aside_mm = ASIDE_MM.wrapping_add(seen.range_mm() >> 5);
        for (point, at) in seen.points(lobe) {
            if arc.stands(point) && self.contains(lobe, at, aside_mm) {
                arc.contradict(point);
            }
        }
    }

    /// Whether a point of an arc can lie in the empty part of the cone: a quick test that spares
    /// most arcs the test of each point.
    fn may_contain(&self, lobe: &LobeShape, seen: &ArcView) -> bool {
        let (along, aside) = seen.middle();
        if magnitude(along) > FARTHEST_MM || magnitude(aside) > FARTHEST_MM {
            return false;
        }
        let (cos, sin) = lobe.edge_q14();
        let bounds = seen.bounds(lobe);
        bounds.aside.wrapping_mul(cos) <= bounds.along.1.wrapping_mul(sin)
            && self.is_beyond(bounds.along.0)
    }

    /// Whether a point along the cone's axis and aside of it lies in the empty part.
    fn contains(&self, lobe: &LobeShape, (along, aside): (i32, i32), aside_mm: i32) -> bool {
        // Inside the lobe the distance is at most the sum of both.
        let aside = aside.wrapping_abs();
        if along <= 0 || !self.is_beyond(along.wrapping_add(aside >> 2)) {
            return false;
        }
        // Products stay within 32 bits.
        let most_mm = 4 * FARTHEST_MM;
        let inside_mm = if along < GAP_MM { aside_mm } else { 0 };
        let (cos, sin) = lobe.edge_q14();
        along.max(aside) < most_mm
            && aside.wrapping_add(inside_mm).wrapping_mul(cos) <= along.wrapping_mul(sin)
    }
}
