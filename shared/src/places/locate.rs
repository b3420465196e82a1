//! Where the robot is: things are nearer or farther than they would be from where it thinks it is.

use super::Places;
use super::record::Record;
use crate::memory::{self, SituationBytes};
use crate::scan::Encoding;
use crate::units::{Bearing, Direction, Displacement};

/// A view is compared with that of a place that is not farther, millimeters: views from farther
/// off show other parts of the walls.
const NEAR_MM: u16 = 200;
/// What deviates more is something else, millimeters.
const SAME_MM: i32 = 100;
/// Sectors that must show the same things.
const AGREE: u32 = 6;
/// One part in so many of the error is corrected at a time: views are noisy.
const PARTS: i16 = 2;
/// It is corrected by at most one part in so many of the way since it was last: wheels slip by
/// less, and the view of a robot that stands tells nothing new.
const WAY_PARTS: u16 = 8;

impl<const SECTORS: usize, const RECORDS: usize> Places<SECTORS, RECORDS> {
    /// Corrects the position by what the robot, which stands, perceives in the frame of the start.
    /// The bearing of that frame has to be right.
    pub fn locate(&mut self, encoding: Encoding, view: &SituationBytes<SECTORS>) {
        let is_near = |record: &&Record<SECTORS>| record.distance_mm(self.here) < NEAR_MM;
        // Of the places near, the first was found with the least error of odometry.
        let Some(place) = self.graph.records().iter().find(is_near) else {
            return;
        };
        let thought = self.here.minus(place.at);
        let mut error = LeastSquares::NEW;
        for (sector, nearer_mm) in nearer_things(encoding, &place.view, view) {
            let axis = Bearing::of_place(sector, SECTORS).direction();
            let ahead_mm = nearer_mm - axis.along(thought.dx_mm.into(), thought.dy_mm.into());
            if ahead_mm.abs() <= SAME_MM {
                error.add(axis, ahead_mm);
            }
        }
        if let Some(Displacement { dx_mm, dy_mm }) = error.solution() {
            let half = Displacement {
                dx_mm: dx_mm / PARTS,
                dy_mm: dy_mm / PARTS,
            };
            let slips_mm = core::mem::take(&mut self.unlocated_mm) / WAY_PARTS;
            // One that was set down only guesses where it is.
            let most_mm = self.lost.first_uncertain().map_or(slips_mm, |_| u16::MAX);
            self.here = self.here.plus(half.shortened(most_mm));
        }
    }
}

/// By how much things are nearer now, millimeters, with their sectors. What is unknown or out of
/// range, whose value is 0, is left out.
pub(super) fn nearer_things<const SECTORS: usize>(
    encoding: Encoding,
    before: &SituationBytes<SECTORS>,
    now: &SituationBytes<SECTORS>,
) -> impl Iterator<Item = (usize, i32)> + use<SECTORS> {
    let [before, now] = [before, now].map(|view| memory::from_bytes(view).0);
    let pairs = before.into_iter().zip(now).enumerate();
    let seen = pairs.filter(|(_, (before, now))| before.to_bits() > 0 && now.to_bits() > 0);
    seen.map(move |(sector, (before, now))| {
        let change = i32::from(now.to_bits()) - i32::from(before.to_bits());
        (sector, encoding.nearer_mm(change))
    })
}

/// The vector whose components along some directions come nearest to those measured, by the sum of
/// squares. Two more measurements say that it is zero along x and y, so that there always is one.
struct LeastSquares {
    /// Normal equations, 2⁻¹⁴: of x with x, x with y, y with y.
    matrix: [i64; 3],
    /// Their right side, 2⁻¹⁴ mm.
    right: [i64; 2],
    components: u32,
    /// Sum of the squared components, mm².
    squares: i64,
}

impl LeastSquares {
    const NEW: Self = Self {
        matrix: [1 << 14, 0, 1 << 14],
        right: [0; 2],
        components: 0,
        squares: 0,
    };

    fn add(&mut self, direction: Direction, component_mm: i32) {
        let (x, y) = (i64::from(direction.x_q14), i64::from(direction.y_q14));
        for (cell, product) in self.matrix.iter_mut().zip([x * x, x * y, y * y]) {
            *cell += product >> 14;
        }
        for (cell, along) in self.right.iter_mut().zip([x, y]) {
            *cell += along * i64::from(component_mm);
        }
        self.components += 1;
        self.squares += i64::from(component_mm) * i64::from(component_mm);
    }

    /// The vector, millimeters; `None` if there are too few components, or if they have more than
    /// half of their squares from something else.
    fn solution(&self) -> Option<Displacement> {
        let ([xx, xy, yy], [right_x, right_y]) = (self.matrix, self.right);
        // At least 2²⁸.
        let determinant = xx * yy - xy * xy;
        let mm = |value: i64| value.checked_div(determinant).unwrap_or(0) as i32;
        let (x, y) = (
            mm(yy * right_x - xy * right_y),
            mm(xx * right_y - xy * right_x),
        );
        let explained = (i64::from(x) * right_x + i64::from(y) * right_y) >> 14;
        let is_clear = self.components >= AGREE && 2 * explained >= self.squares;
        is_clear.then(|| Displacement::saturating(x, y))
    }
}
