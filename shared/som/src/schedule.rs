//! Schedules of learning rate and radius over a training.

use crate::fixed::{exp2_neg, log2_ratio, q16};

/// Formula of the decay; t runs from 0 to 1 over the training.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Decay {
    /// start + (end − start) · t
    Linear,
    /// start · (end / start)^t
    Exponential,
    /// start / (1 + (start/end − 1) · t); with end = start/3 this is MiniSom's asymptotic decay.
    Inverse,
}

/// A value that decays from `start` to `end` over a training, in Q16 (65 536 = 1.0). It never
/// rises.
///
/// ```
/// # use tinysom::{Decay, Schedule};
/// let rate = Schedule::new(0.5, 0.125, Decay::Exponential);
/// assert_eq!(rate.at(0, 100), 32_768);
/// assert_eq!(rate.at(50, 100), 16_384);
/// assert_eq!(rate.at(100, 100), 8_192);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(from = "(u32, u32, Decay)", into = "(u32, u32, Decay)")
)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Schedule {
    start_q16: u32,
    end_q16: u32,
    decay: Decay,
    /// log2(start/end), for exponential decay.
    octaves_q16: u32,
}

impl From<(u32, u32, Decay)> for Schedule {
    fn from((start_q16, end_q16, decay): (u32, u32, Decay)) -> Self {
        Self::from_q16(start_q16, end_q16, decay)
    }
}

impl From<Schedule> for (u32, u32, Decay) {
    fn from(schedule: Schedule) -> Self {
        (schedule.start_q16, schedule.end_q16, schedule.decay)
    }
}

impl Schedule {
    /// Decay from `start` to `end`, both from 0 to 65 535. An end above the start is set to the
    /// start.
    ///
    /// Exponential and inverse decay never reach 0: they treat an end of 0 as 2⁻¹⁶.
    #[must_use]
    pub const fn new(start: f32, end: f32, decay: Decay) -> Self {
        Self::from_q16(q16(start), q16(end), decay)
    }

    /// As [`new`](Self::new), with both values in Q16.
    #[must_use]
    pub const fn from_q16(start_q16: u32, end_q16: u32, decay: Decay) -> Self {
        let end = if end_q16 > start_q16 {
            start_q16
        } else {
            end_q16
        };
        Self {
            start_q16,
            end_q16: end,
            decay,
            octaves_q16: log2_ratio(start_q16, if end == 0 { 1 } else { end }),
        }
    }

    /// A constant value in Q16.
    #[must_use]
    pub const fn constant(value_q16: u32) -> Self {
        Self::from_q16(value_q16, value_q16, Decay::Linear)
    }

    /// The value at the beginning, Q16.
    #[must_use]
    pub const fn start_q16(self) -> u32 {
        self.start_q16
    }

    /// The value at the end, Q16.
    #[must_use]
    pub const fn end_q16(self) -> u32 {
        self.end_q16
    }

    /// The formula of the decay.
    #[must_use]
    pub const fn decay(self) -> Decay {
        self.decay
    }

    /// The value at `step` of `steps`, Q16; `end` from the last step on.
    #[must_use]
    pub fn at(self, step: u32, steps: u32) -> u32 {
        if steps == 0 || step >= steps || self.start_q16 == self.end_q16 {
            return if step == 0 {
                self.start_q16
            } else {
                self.end_q16
            };
        }
        let (start, end) = (u64::from(self.start_q16), u64::from(self.end_q16));
        let (step, steps) = (u64::from(step), u64::from(steps));
        let value = match self.decay {
            Decay::Linear => start - ratio((start - end) * step, steps),
            Decay::Exponential => {
                let exponent = ratio(u64::from(self.octaves_q16) * step, steps) as u32;
                (start * u64::from(exp2_neg(exponent))) >> 31
            }
            Decay::Inverse => {
                let end = end.max(1);
                let (top, bottom) = (
                    u128::from(start) * u128::from(end) * u128::from(steps),
                    u128::from(end) * u128::from(steps)
                        + u128::from(start - end) * u128::from(step),
                );
                (top / bottom) as u64
            }
        };
        // `clamp` could panic: the compiler does not know that the end is at most the start.
        (value as u32).max(self.end_q16).min(self.start_q16)
    }
}

/// `numerator / denominator`; in 32 bits where both fit: one instruction instead of hundreds.
fn ratio(numerator: u64, denominator: u64) -> u64 {
    let small = (u32::try_from(numerator), u32::try_from(denominator));
    if let (Ok(numerator), Ok(denominator)) = small
        && let Some(ratio) = numerator.checked_div(denominator)
    {
        return u64::from(ratio);
    }
    numerator.checked_div(denominator).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn decays() -> impl Strategy<Value = Decay> {
        prop_oneof![
            Just(Decay::Linear),
            Just(Decay::Exponential),
            Just(Decay::Inverse)
        ]
    }

    fn formula(decay: Decay, start: f64, end: f64, t: f64) -> f64 {
        match decay {
            Decay::Linear => start + (end - start) * t,
            Decay::Exponential => start * libm::pow(end / start, t),
            Decay::Inverse => start / (1.0 + (start / end - 1.0) * t),
        }
    }

    #[test]
    fn a_schedule_returns_its_settings_and_handles_extreme_ones() {
        let inverse = Schedule::from_q16(500, 20, Decay::Inverse);
        assert_eq!(
            (inverse.start_q16(), inverse.end_q16(), inverse.decay()),
            (500, 20, Decay::Inverse)
        );
        assert_eq!(
            Schedule::from_q16(20, 500, Decay::Linear),
            Schedule::constant(20)
        );
        assert_eq!(
            <(u32, u32, Decay)>::from(inverse),
            (500, 20, Decay::Inverse)
        );
        assert_eq!(
            (inverse.at(0, 0), inverse.at(1, 0), inverse.at(9, 9)),
            (500, 20, 20)
        );
        assert_eq!(
            (
                Schedule::constant(7).at(3, 9),
                Schedule::constant(0).at(3, 9)
            ),
            (7, 0)
        );
        // The products exceed 32 bits.
        assert_eq!(
            Schedule::from_q16(1 << 31, 0, Decay::Linear).at(1 << 30, u32::MAX),
            (1 << 31) - (1 << 29)
        );
    }

    proptest! {
        #[test]
        fn never_rises_and_reaches_both_ends(
            decay in decays(), start in 0_u32..10_000_000, end in 0_u32..10_000_000, steps in 1_u32..2_000,
        ) {
            let schedule = Schedule::from_q16(start, end, decay);
            prop_assert_eq!(schedule.at(0, steps), start);
            prop_assert_eq!(schedule.at(steps, steps), end.min(start));
            let mut last = u32::MAX;
            for step in 0..=steps {
                let value = schedule.at(step, steps);
                prop_assert!(value <= last && value >= end.min(start));
                last = value;
            }
        }

        #[test]
        fn follows_its_formula(decay in decays(), start in 600_u32..655_360, ratio in 1.0_f64..100.0, t in 0_u32..=1000) {
            let end = (f64::from(start) / ratio) as u32;
            prop_assume!(end > 0);
            let value = f64::from(Schedule::from_q16(start, end, decay).at(t, 1000));
            let exact = formula(decay, f64::from(start), f64::from(end), f64::from(t) / 1000.0);
            prop_assert!((value - exact).abs() <= 1.5 + exact * 2e-4, "{value} {exact}");
        }
    }
}
