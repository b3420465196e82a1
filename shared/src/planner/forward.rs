//! What an action brings: a linear map fitted to the pairs of the action map.

use crate::action_map::{ActionCode, ActionMap};
use crate::fixed::{Fine, Weight, coarse};
use crate::scan::Situation;
use crate::units::Direction;

/// The linear map from displacements to changes of situation, from the present one on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Forward<const SENSORS: usize> {
    lines: [Line; SENSORS],
}

impl<const SENSORS: usize> Forward<SENSORS> {
    /// From this situation nothing changes, whatever the action.
    pub(super) fn from(situation: &Situation<SENSORS>) -> Self {
        let mut lines = [Line::default(); SENSORS];
        for (line, value) in lines.iter_mut().zip(situation) {
            line.now = i32::from(value.to_bits());
        }
        Self { lines }
    }

    /// Fits an action map's neurons; no change at all where their actions do not span the plane.
    #[inline(never)]
    pub(super) fn fit<const NEURONS: usize>(
        &mut self,
        actions: &ActionMap<NEURONS, SENSORS>,
        code: ActionCode,
        step_mm: u16,
    ) {
        if code == ActionCode::Displacement
            && let Some(products) = actions.products()
        {
            let [xx, xy, yy] = products.plane.map(i64::from);
            let inverse = Inverse::of(xx, xy, yy);
            for (line, sums) in self.lines.iter_mut().zip(&products.changes) {
                (line.along_x, line.along_y) = inverse.slopes(*sums);
            }
            return;
        }
        let mut plane = [Packed(0); NEURONS];
        let (mut xx, mut xy, mut yy) = (0_i64, 0_i64, 0_i64);
        for (place, action) in plane.iter_mut().zip(actions.actions().code()) {
            *place = in_plane(code, action.map(coarse), step_mm);
            let (x, y) = (i64::from(place.x()), i64::from(place.y()));
            (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
        }
        let inverse = Inverse::of(xx, xy, yy);
        let changes = actions.changes().code();
        let (pairs, last) = self.lines.as_chunks_mut::<2>();
        for (pair, [first, second]) in pairs.iter_mut().enumerate() {
            let [a, b] = products_of_two(&plane, changes, |row| row.as_chunks().0.get(pair));
            (first.along_x, first.along_y) = inverse.slopes(a);
            (second.along_x, second.along_y) = inverse.slopes(b);
        }
        for last in last {
            let [_, sums] = products_of_two(&plane, changes, |row| row.last_chunk());
            (last.along_x, last.along_y) = inverse.slopes(sums);
        }
    }

    /// How each transducer's value changes.
    pub(super) const fn lines(&self) -> &[Line; SENSORS] {
        &self.lines
    }

    /// The values (2⁻¹³, from 0 on but not limited to 1) after a displacement given as shares of the longest step, Q14.
    pub(super) fn after(&self, share: Direction) -> [i32; SENSORS] {
        let mut values = [0; SENSORS];
        for (value, line) in values.iter_mut().zip(&self.lines) {
            *value = line.after(share);
        }
        values
    }
}

/// How one transducer's value changes with the displacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Line {
    /// Present value, 2⁻¹³.
    now: i32,
    /// Change per longest step along x, 2⁻¹³.
    along_x: i32,
    /// Change per longest step along y, 2⁻¹³.
    along_y: i32,
}

impl Line {
    /// The value after a displacement given as shares of the longest step.
    #[inline(always)]
    pub(super) fn after(&self, share: Direction) -> i32 {
        let change = share.along(self.along_x, self.along_y);
        change.wrapping_add(self.now).max(0)
    }

    /// What the value, which counts as 0 below 0, surely lies between after any displacement up to the longest step; unit
    /// vectors may be too long by a sixteenth.
    pub(super) fn range(&self) -> (i32, i32) {
        let most = self.along_x.abs().wrapping_add(self.along_y.abs());
        let most = most.wrapping_add(most >> 4).wrapping_add(2);
        (self.now.wrapping_sub(most), self.now.wrapping_add(most))
    }

    /// Present value, changes per longest step along x and along y.
    pub(super) const fn coefficients(&self) -> (i32, i32, i32) {
        (self.now, self.along_x, self.along_y)
    }
}

/// Products summed in 32 bits before they are widened: 16 · 2²⁶ = 2³⁰.
const BLOCK: usize = 16;

/// A vector of two 16-bit components in a word: the chip multiplies either half without unpacking it.
#[derive(Debug, Clone, Copy)]
struct Packed(u32);

impl Packed {
    fn new(x: i16, y: i16) -> Self {
        Self(u32::from(x as u16) | u32::from(y as u16) << 16)
    }

    #[inline(always)]
    fn x(self) -> i32 {
        i32::from(self.0 as i16)
    }

    #[inline(always)]
    fn y(self) -> i32 {
        i32::from((self.0 >> 16) as i16)
    }
}

/// An action as a vector in units of 2⁻¹³ of the longest step.
fn in_plane(code: ActionCode, action: [Weight; 2], step_mm: u16) -> Packed {
    let vector = match code {
        ActionCode::Displacement => action,
        ActionCode::TurnStep => {
            ActionCode::Displacement.encode(code.decode(action, step_mm), step_mm)
        }
    };
    let [x, y] = vector.map(Weight::to_bits);
    Packed::new(x, y)
}

/// Sums over all neurons of action times change (2⁻²⁶) for two transducers at once: they stay in registers.
#[inline(always)]
fn products_of_two<const SENSORS: usize>(
    plane: &[Packed],
    changes: &[[Fine; SENSORS]],
    two: impl Fn(&[Fine; SENSORS]) -> Option<&[Fine; 2]>,
) -> [[i32; 2]; 2] {
    let mut totals = [[0_i64; 2]; 2];
    for (plane, changes) in plane.chunks(BLOCK).zip(changes.chunks(BLOCK)) {
        let [mut first_x, mut first_y, mut second_x, mut second_y] = [0_i32; 4];
        for (action, row) in plane.iter().zip(changes) {
            let Some(two) = two(row) else { continue };
            let [first, second] = two.map(|change| i32::from(coarse(change).to_bits()));
            first_x = first_x.wrapping_add(action.x().wrapping_mul(first));
            first_y = first_y.wrapping_add(action.y().wrapping_mul(first));
            second_x = second_x.wrapping_add(action.x().wrapping_mul(second));
            second_y = second_y.wrapping_add(action.y().wrapping_mul(second));
        }
        let sums = [[first_x, first_y], [second_x, second_y]];
        for (total, sum) in totals
            .as_flattened_mut()
            .iter_mut()
            .zip(sums.as_flattened())
        {
            *total = total.wrapping_add(i64::from(*sum));
        }
    }
    // The sum over 31 neurons always fits.
    let most = |sum: i64| sum.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32;
    totals.map(|sums| sums.map(most))
}

/// The inverse of the symmetric 2 × 2 matrix of the actions' products, in units of 2⁻¹⁹ of its own: sums of products in
/// 2⁻²⁶ times this are slopes in 2⁻⁴⁵, whose upper half is a slope in 2⁻¹³.
struct Inverse {
    xx: i32,
    xy: i32,
    yy: i32,
}

impl Inverse {
    /// Of sums of squares and products in units of 2⁻²⁶; zero where there is none.
    fn of(xx: i64, xy: i64, yy: i64) -> Self {
        // 2⁻¹³ is fine enough, and the products stay below 2⁴⁸.
        let (xx, xy, yy) = (xx >> 13, xy >> 13, yy >> 13);
        let determinant = (xx * yy - xy * xy).max(0);
        // 15 bits of it are left, so that one 32-bit division is enough.
        let shift = (64 - determinant.leading_zeros()).saturating_sub(15);
        let divisor = (determinant >> shift) as u32;
        let part = |numerator: i64| {
            let scaled = (numerator.unsigned_abs() << 13).min(u64::from(u32::MAX)) as u32;
            let ratio = i64::from(scaled.checked_div(divisor).unwrap_or(0)) << 19 >> shift;
            // Actions that hardly span the plane: slopes are limited anyway.
            let ratio = ratio.min(1 << 30) as i32;
            if numerator < 0 { -ratio } else { ratio }
        };
        Self {
            xx: part(yy),
            xy: part(-xy),
            yy: part(xx),
        }
    }

    /// Both slopes (2⁻¹³) from both sums of products (2⁻²⁶), each within ±2 per step.
    #[inline(always)]
    fn slopes(&self, sums: [i32; 2]) -> (i32, i32) {
        let [x, y] = sums.map(i64::from);
        let slope = |a: i32, b: i32| {
            let sum = (i64::from(a) * x).wrapping_add(i64::from(b) * y);
            ((sum >> 32) as i32).clamp(-(1 << 14), 1 << 14)
        };
        (slope(self.xx, self.xy), slope(self.xy, self.yy))
    }
}
