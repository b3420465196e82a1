//! What an action brings: a linear map fitted to the pairs of the action map.

use crate::action_map::{ActionCode, ActionMap};
use crate::fixed::{Weight, coarse};
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
        let mut plane = [[0_i16; 2]; NEURONS];
        let (mut xx, mut xy, mut yy) = (0_i64, 0_i64, 0_i64);
        for (place, action) in plane.iter_mut().zip(actions.actions().code()) {
            *place = in_plane(code, action.map(coarse), step_mm);
            let [x, y] = place.map(i64::from);
            (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
        }
        let inverse = Inverse::of(xx, xy, yy);
        for (sensor, line) in self.lines.iter_mut().enumerate() {
            // The sums of one transducer stay in registers.
            let (mut sum_x, mut sum_y) = (0_i64, 0_i64);
            let blocks = plane
                .chunks(BLOCK)
                .zip(actions.changes().code().chunks(BLOCK));
            for (plane, changes) in blocks {
                let (mut block_x, mut block_y) = (0_i32, 0_i32);
                for ([x, y], change) in plane.iter().zip(changes) {
                    let change = change.get(sensor).copied().map_or(Weight::ZERO, coarse);
                    let change = i32::from(change.to_bits());
                    block_x = block_x.wrapping_add(i32::from(*x).wrapping_mul(change));
                    block_y = block_y.wrapping_add(i32::from(*y).wrapping_mul(change));
                }
                sum_x = sum_x.wrapping_add(i64::from(block_x));
                sum_y = sum_y.wrapping_add(i64::from(block_y));
            }
            (line.along_x, line.along_y) = inverse.slopes(saturated(sum_x), saturated(sum_y));
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

    /// What the value surely lies between after any displacement up to the longest step; unit vectors may be too long by
    /// a sixteenth.
    pub(super) fn range(&self) -> (i32, i32) {
        let most = self.along_x.abs().wrapping_add(self.along_y.abs());
        let most = most.wrapping_add(most >> 4).wrapping_add(2);
        let end = |change: i32| self.now.wrapping_add(change).max(0);
        (end(most.wrapping_neg()), end(most))
    }
}

/// Products summed in 32 bits before they are widened: 16 · 2²⁶ = 2³⁰.
const BLOCK: usize = 16;

/// An action as a vector in units of 2⁻¹³ of the longest step.
fn in_plane(code: ActionCode, action: [Weight; 2], step_mm: u16) -> [i16; 2] {
    let vector = match code {
        ActionCode::Displacement => action,
        ActionCode::TurnStep => {
            ActionCode::Displacement.encode(code.decode(action, step_mm), step_mm)
        }
    };
    vector.map(Weight::to_bits)
}

/// 32 bits of a sum; that of 31 neurons always fits.
fn saturated(sum: i64) -> i32 {
    sum.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32
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
    fn slopes(&self, sum_x: i32, sum_y: i32) -> (i32, i32) {
        let (x, y) = (i64::from(sum_x), i64::from(sum_y));
        let slope = |a: i32, b: i32| {
            let sum = (i64::from(a) * x).wrapping_add(i64::from(b) * y);
            ((sum >> 32) as i32).clamp(-(1 << 14), 1 << 14)
        };
        (slope(self.xx, self.xy), slope(self.xy, self.yy))
    }
}
