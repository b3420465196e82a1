//! The action that brings values nearest to their intervals: least squares with bounds.
//!
//! Coordinate descent: each actuator in turn takes the value that is best with the others as they
//! are. Numbers have 20 fractional bits.

use crate::fixed::{ONE_BITS, Weight, Weight32, unit_weight};
use crate::goal::Component;

/// Rounds over all actuators, at most.
pub const MAX_SWEEPS: u32 = 100;

/// 1.0.
const ONE: i64 = 1 << 20;
/// Rounds end when no actuator moves by more than this: a thousandth of its longest move.
const STILL: i64 = ONE >> 10;
/// The same at a half space, along which actuators move by little in each round.
const STILL_BESIDE: i64 = ONE >> 15;
/// Weight of the squared action, 2⁻⁴⁰: it keeps an action short that would change nothing.
const DAMPING: i64 = 1 << 27;
/// Weight of keeping off, against 1 for a component of weight 1.
const KEEP_OFF_WEIGHT: i64 = 100;

/// A half space that the values must stay in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct KeepOff<const VALUES: usize> {
    /// Its normal, units of 2⁻²⁰.
    pub(super) normal: [i64; VALUES],
    /// Least change along the normal, units of 2⁻²⁰.
    pub(super) least: i64,
    /// Longest action of each actuator, units of 2⁻²⁰.
    pub(super) longest: i64,
}

/// The predicted values while an action is sought.
struct Predicted<'a, const VALUES: usize> {
    values: [i64; VALUES],
    bounds: &'a [Component; VALUES],
    /// Change along the normal.
    along: i64,
    keep_off: Option<&'a KeepOff<VALUES>>,
}

impl<const VALUES: usize> Predicted<'_, VALUES> {
    /// Slope and curvature of the squared deviations along the changes of one actuator, 2⁻⁴⁰.
    fn slope(&self, row: &[i64; VALUES]) -> (i64, i64) {
        let (mut slope, mut curvature) = (0_i64, 0_i64);
        for ((value, component), effect) in self.values.iter().zip(self.bounds).zip(row) {
            let bound = |weight: Weight| i64::from(weight.to_bits()) << 7;
            let nearest = (*value)
                .max(bound(component.low))
                .min(bound(component.high));
            let weighted = effect.wrapping_mul(i64::from(component.weight));
            slope = slope.wrapping_add(weighted.wrapping_mul(value.wrapping_sub(nearest)));
            curvature = curvature.wrapping_add(weighted.wrapping_mul(*effect));
        }
        if let Some(keep_off) = self.keep_off {
            let effect = along(row, keep_off);
            let short = self.along.wrapping_sub(keep_off.least).min(0);
            let weighted = effect.wrapping_mul(KEEP_OFF_WEIGHT);
            slope = slope.wrapping_add(weighted.wrapping_mul(short));
            curvature = curvature.wrapping_add(weighted.wrapping_mul(effect));
        }
        (slope, curvature)
    }

    fn add(&mut self, row: &[i64; VALUES], step: i64) {
        for (value, effect) in self.values.iter_mut().zip(row) {
            *value = value.wrapping_add(effect.wrapping_mul(step) >> 20);
        }
        if let Some(keep_off) = self.keep_off {
            let change = along(row, keep_off).wrapping_mul(step) >> 20;
            self.along = self.along.wrapping_add(change);
        }
    }
}

/// Change along the normal by the whole action of one actuator.
fn along<const VALUES: usize>(row: &[i64; VALUES], keep_off: &KeepOff<VALUES>) -> i64 {
    let products = row.iter().zip(&keep_off.normal);
    products.fold(0_i64, |sum, (effect, part)| {
        sum.wrapping_add(effect.wrapping_mul(*part) >> 20)
    })
}

/// The action, each actuator within its longest move.
pub(super) fn solve<const VALUES: usize, const ACTION: usize>(
    rows: &[[Weight32; VALUES]; ACTION],
    situation: &[Weight; VALUES],
    bounds: &[Component; VALUES],
    keep_off: Option<&KeepOff<VALUES>>,
) -> [Weight; ACTION] {
    let rows = rows.map(|row| row.map(|effect| i64::from(effect.to_bits()) >> 9));
    let (longest, still) = match keep_off {
        None => (ONE, STILL),
        Some(keep_off) => (keep_off.longest, STILL_BESIDE),
    };
    let mut predicted = Predicted {
        values: situation.map(|value| i64::from(value.to_bits()) << 7),
        bounds,
        along: 0,
        keep_off,
    };
    let mut action = [0_i64; ACTION];
    for _ in 0..MAX_SWEEPS {
        let mut largest = 0;
        for (share, row) in action.iter_mut().zip(&rows) {
            let (slope, curvature) = predicted.slope(row);
            let damped = slope.wrapping_add(share.wrapping_mul(DAMPING >> 20));
            let curvature = curvature.wrapping_add(DAMPING) >> 20;
            let step = damped.checked_div(curvature).unwrap_or(0);
            let next = share.wrapping_sub(step).clamp(-longest, longest);
            let step = next.wrapping_sub(*share);
            predicted.add(row, step);
            *share = next;
            largest = largest.max(step.abs());
        }
        if largest <= still {
            break;
        }
    }
    let one = i64::from(ONE_BITS);
    action.map(|share| {
        let bits = (share >> 7).clamp(-one, one);
        unit_weight(i32::try_from(bits).unwrap_or(0))
    })
}
