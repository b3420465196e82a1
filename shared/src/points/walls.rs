//! Directions of walls: two echoes of one wall, heard at two positions, have a common tangent.

use super::{AT_THIS_PLACE_MM, Point, PointMemory};
use crate::fixed::isqrt_u32;
use crate::units::{Bearing, Displacement};

/// A right angle has so many parts, of 2.8°.
pub(crate) const PARTS: usize = 32;
/// One part, in turns.
pub(crate) const PART: u16 = RIGHT_ANGLE / PARTS as u16;
const RIGHT_ANGLE: u16 = 1 << 14;
/// So many of the latest points may have been heard here.
pub(crate) const LATEST: u16 = 32;
/// The two positions are less than this apart, millimeters: farther off stands another wall.
const MAX_APART_MM: u32 = 800;
/// And at least this far: nearer to each other, the error of a range turns the tangent too much.
const MIN_APART_MM: u32 = 200;
/// What returned an echo is in a cone; this is the cosine of half its opening, 12.5°, 2⁻¹⁴.
const CONE_Q14: i64 = 15_996;

/// How much there is of walls in each direction, by parts of a right angle: most walls of a
/// building stand at right angles to each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct WallDirections {
    weights: [u16; PARTS],
}

impl WallDirections {
    pub(crate) const NONE: Self = Self {
        weights: [0; PARTS],
    };

    pub(crate) const fn weights(&self) -> &[u16; PARTS] {
        &self.weights
    }

    pub(crate) fn add(&mut self, normal: Bearing, weight: u16) {
        for (part, share) in shares(normal, weight) {
            if let Some(sum) = self.weights.get_mut(part) {
                *sum = sum.saturating_add(share);
            }
        }
    }
}

/// The two parts between whose middles a direction is, and their shares of its weight.
pub(crate) fn shares(normal: Bearing, weight: u16) -> [(usize, u16); 2] {
    let turns = normal.as_turns() % RIGHT_ANGLE;
    let (part, beyond) = (usize::from(turns / PART), u32::from(turns % PART));
    let next = (u32::from(weight) * beyond / u32::from(PART)) as u16;
    [(part, weight - next), ((part + 1) % PARTS, next)]
}

impl<const POINTS: usize> PointMemory<POINTS> {
    /// Adds the directions of the walls that one of the [`LATEST`] points tells of, if it is an
    /// echo heard here. `frame` turns from the frame of the start to that of the directions.
    pub(crate) fn add_walls(&self, latest: u16, frame: Bearing, walls: &mut WallDirections) {
        let echoes = || self.points.iter().filter(|point| point.is_echo());
        let is_from_here = |point: &&Point| point.seen_from.is_shorter_than(AT_THIS_PLACE_MM);
        let point = self.points.iter().rev().nth(latest.into());
        let Some(new) = point.filter(|point| point.is_echo()).filter(is_from_here) else {
            return;
        };
        let circle = Circle::of(new);
        for other in echoes() {
            let way = other.seen_from.minus(new.seen_from);
            if way.is_shorter_than(MAX_APART_MM)
                && !way.is_shorter_than(MIN_APART_MM)
                && let Some((normal, weight)) = circle.tangent(&Circle::of(other), way)
            {
                walls.add(normal.plus(frame), weight);
            }
        }
    }
}

/// A circle around where the robot stood that touches what returned an echo.
struct Circle {
    /// Along the beam.
    radius: Displacement,
    radius_mm: i32,
}

impl Circle {
    fn of(point: &Point) -> Self {
        let radius = point.at.minus(point.seen_from);
        Self {
            radius,
            radius_mm: radius.length_mm().into(),
        }
    }

    /// The normal of a wall that this circle and another one touch within their beams' cones, and
    /// its weight; the other one's center is one `way` off, less than 0.8 m.
    fn tangent(&self, other: &Self, way: Displacement) -> Option<(Bearing, u16)> {
        // The wall is as much nearer to the other position as that one's radius is shorter.
        let nearer_mm = self.radius_mm - other.radius_mm;
        let apart_mm2 = way.squared_mm2();
        let along_wall_mm2 = apart_mm2.checked_sub(nearer_mm.unsigned_abs().pow(2))?;
        // The wall is on the side to which the beam points.
        let (x, y) = (i32::from(way.dx_mm), i32::from(way.dy_mm));
        let [beam_x, beam_y] = [self.radius.dx_mm, self.radius.dy_mm].map(i32::from);
        let is_left = beam_y * x >= beam_x * y;
        let along_wall_mm = isqrt_u32(along_wall_mm2) as i32;
        let left_mm = if is_left {
            along_wall_mm
        } else {
            -along_wall_mm
        };
        // Its length is the squared distance of the positions, in units of 32 mm².
        let normal = Displacement::saturating(
            (nearer_mm * x - left_mm * y) / 32,
            (nearer_mm * y + left_mm * x) / 32,
        );
        let is_in_cone = |circle: &Self| {
            let product = |a: i16, b: i16| i64::from(a) * i64::from(b);
            let along = product(normal.dx_mm, circle.radius.dx_mm)
                + product(normal.dy_mm, circle.radius.dy_mm);
            along << 14 >= CONE_Q14 * i64::from(circle.radius_mm) * i64::from(apart_mm2 / 32)
        };
        // An error of a range turns a long tangent less.
        let weight = (along_wall_mm2 >> 12) as u16;
        (is_in_cone(self) && is_in_cone(other)).then(|| (normal.bearing(), weight))
    }
}

#[cfg(test)]
mod tests;
