//! One echo as an arc: the nearest surface stands somewhere on it.

use super::cone::CONTRADICTIONS;
use crate::disc::magnitude;
use crate::scan::Echo;
use crate::units::{Bearing, Direction, Displacement, Millis, Range};

/// Points of an arc that are tested, evenly spaced from end to end: 5° of 30°. Where the lobes of
/// two neighbors leave a gap wider than the margin covers, a point lies in it.
pub(super) const POINTS: usize = 7;
/// One point more, between face and arc. It counts where the range is the shortest that the ring
/// can report.
pub(super) const BEFORE: usize = POINTS;

/// Longer ranges count as this, millimeters: products stay within 32 bits.
const LONGEST_MM: i32 = 1 << 15;

/// What a transducer heard at one place, in the shield's frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Arc {
    /// Where its face was, from where the robot is now.
    pub(super) face: Displacement,
    /// Where it looked.
    pub(super) axis: Direction,
    /// Range heard; `None` = no arc.
    pub(super) range: Option<Range>,
    /// Contradictions of each point and of the one before them, two bits each.
    contradictions: u16,
    pub(super) at: Millis,
}

impl Arc {
    /// No arc.
    pub(super) const NONE: Self = Self {
        face: Displacement::ZERO,
        axis: Direction { x_q14: 0, y_q14: 0 },
        range: None,
        contradictions: 0,
        at: Millis::from_ms(0),
    };

    /// What was heard from a face along an axis.
    pub(super) const fn heard(face: Displacement, axis: Direction, echo: Echo) -> Self {
        Self {
            face,
            axis,
            range: echo.range,
            contradictions: 0,
            at: echo.at,
        }
    }

    /// Where its face was, millimeters.
    pub(super) fn face_mm(&self) -> (i32, i32) {
        (self.face.dx_mm.into(), self.face.dy_mm.into())
    }

    /// How often a point was contradicted.
    const fn contradicted(&self, point: usize) -> u8 {
        (self.contradictions >> (2 * point)) as u8 & 3
    }

    /// Whether a point still counts.
    pub(super) const fn stands(&self, point: usize) -> bool {
        self.contradicted(point) < CONTRADICTIONS
    }

    /// Counts a contradiction of a point; drops the arc when no point is left.
    pub(super) fn contradict(&mut self, point: usize) {
        if self.stands(point) {
            self.contradictions = self.contradictions.wrapping_add(1 << (2 * point));
        }
        if (0..POINTS).all(|point| !self.stands(point)) {
            *self = Self::NONE;
        }
    }

    /// How far its nearest point that still counts is from the robot, as the square of half the
    /// distance; the greatest for no arc. What is below `limit` may be less.
    pub(super) fn half_distance_squared(&self, lobe: &LobeShape, limit: u32) -> u32 {
        const AHEAD: Direction = Direction {
            x_q14: 1 << 14,
            y_q14: 0,
        };
        let Some(range) = self.range else {
            return u32::MAX;
        };
        let face_mm = self.face_mm();
        let seen = ArcView::along(AHEAD, face_mm, self.axis, range.as_mm().into());
        let mut least = u32::MAX;
        for (point, (x, y)) in seen.points(lobe) {
            if self.stands(point) {
                // Halves, whose squares are at most 2³⁰ each.
                let (x, y) = (x >> 1, y >> 1);
                least = least.min(x.wrapping_mul(x).wrapping_add(y.wrapping_mul(y)) as u32);
                if least < limit {
                    break;
                }
            }
        }
        least
    }
}

/// The opening of a transducer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct LobeShape {
    pub(super) half: Bearing,
    /// Towards the points of an arc, relative to the axis, from its right end to its left.
    towards: [Direction; POINTS],
}

impl LobeShape {
    /// Half a lobe is at most a right angle.
    pub(super) fn of(half: Bearing) -> Self {
        const MIDDLE: i32 = POINTS as i32 / 2;
        let turns = i32::from(half.as_turns()).min(1 << 14);
        let towards = core::array::from_fn(|point| {
            let steps = point as i32 - MIDDLE;
            Bearing::from_turns((turns * steps / MIDDLE) as u16).direction()
        });
        Self { half, towards }
    }

    /// Cosine and sine of half its opening, Q14.
    pub(super) fn edge_q14(&self) -> (i32, i32) {
        let [.., edge] = self.towards;
        (edge.x_q14.into(), edge.y_q14.into())
    }
}

/// An arc seen along some direction: what lies along it and to the left of it, millimeters.
pub(super) struct ArcView {
    /// From where the direction begins to the arc's face.
    face: (i32, i32),
    /// From the face to the arc's middle.
    reach: (i32, i32),
    range_mm: i32,
}

/// Where all points of an arc are, at most.
pub(super) struct Extent {
    /// Least and greatest distance along the direction.
    pub(super) along: (i32, i32),
    /// Least distance from the line.
    pub(super) aside: i32,
}

impl ArcView {
    /// `x_mm` and `y_mm` lead to the face, within ±65.5 m.
    pub(super) fn along(
        direction: Direction,
        (x_mm, y_mm): (i32, i32),
        axis: Direction,
        range_mm: i32,
    ) -> Self {
        let range_mm = range_mm.min(LONGEST_MM);
        let (cos, sin) = direction.components(axis.x_q14.into(), axis.y_q14.into());
        let reach = |q14: i32| range_mm.wrapping_mul(q14) >> 14;
        Self {
            face: direction.components(x_mm, y_mm),
            reach: (reach(cos), reach(sin)),
            range_mm,
        }
    }

    /// The point on its axis that far from the face.
    pub(super) fn on_axis(&self, mm: i32) -> (i32, i32) {
        let part = |reach: i32| reach.wrapping_mul(mm) / self.range_mm.max(1);
        let along = self.face.0.wrapping_add(part(self.reach.0));
        (along, self.face.1.wrapping_add(part(self.reach.1)))
    }

    /// Its middle.
    pub(super) const fn middle(&self) -> (i32, i32) {
        let along = self.face.0.wrapping_add(self.reach.0);
        (along, self.face.1.wrapping_add(self.reach.1))
    }

    /// A point is the middle, turned about the face by at most half the lobe.
    pub(super) fn bounds(&self, lobe: &LobeShape) -> Extent {
        let (cos, sin) = lobe.edge_q14();
        let (along, aside) = self.middle();
        let turned = |inward: i32, sideward: i32| {
            let inward = magnitude(inward).wrapping_mul((1 << 14) - cos);
            let sideward = magnitude(sideward).wrapping_mul(sin);
            // Some millimeters for roundings.
            (inward.wrapping_add(sideward) >> 14).wrapping_add(4)
        };
        let depth = turned(self.reach.0, self.reach.1);
        let width = turned(self.reach.1, self.reach.0);
        Extent {
            along: (along.wrapping_sub(depth), along.wrapping_add(depth)),
            aside: magnitude(aside).wrapping_sub(width),
        }
    }

    /// Its points with their numbers.
    pub(super) fn points(&self, lobe: &LobeShape) -> impl Iterator<Item = (usize, (i32, i32))> {
        let (along, aside) = self.face;
        lobe.towards
            .iter()
            .enumerate()
            .map(move |(point, towards)| {
                let (x, y) = towards.rotate(self.reach.0, self.reach.1);
                (point, (along.wrapping_add(x), aside.wrapping_add(y)))
            })
    }

    /// Its range, at most the longest that counts.
    pub(super) const fn range_mm(&self) -> i32 {
        self.range_mm
    }
}

/// No point of an arc is nearer to the robot than its range less the distance of its face.
pub(super) const fn nearest_mm(face: (i32, i32), range_mm: i32) -> i32 {
    range_mm.wrapping_sub(magnitude(face.0).wrapping_add(magnitude(face.1)))
}
