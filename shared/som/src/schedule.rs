//! How learning rate and radius fall while a map learns.

use crate::fixed::{exp2_neg, log2_ratio, q16};

/// The shape of the fall; t runs from 0 to 1 over the training.
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

/// A value that falls from `start` to `end` over a training and never rises; kept in Q16 (65 536 =
/// 1.0).
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
    /// log2(start/end), for the exponential fall.
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
    /// A fall from `start` to `end`, from 0 to 65 535; an end above the start is lowered to it.
    ///
    /// An exponential or inverse fall never reaches 0: an end of 0 counts as 2⁻¹⁶ there.
    #[must_use]
    pub const fn new(start: f32, end: f32, decay: Decay) -> Self {
        Self::from_q16(q16(start), q16(end), decay)
    }

    /// The same with both ends in Q16.
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

    /// A value in Q16 that does not fall.
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

    /// The shape of the fall.
    #[must_use]
    pub const fn decay(self) -> Decay {
        self.decay
    }

    /// The value at `step` of `steps`, Q16; the end from the last step on.
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
        // Not `clamp`: it panics where the end is above the start, which `from_q16` rules out.
        (value as u32).max(self.end_q16).min(self.start_q16)
    }
}

/// `numerator / denominator`, in 32 bits where they suffice: one instruction instead of hundreds.
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
    fn a_schedule_is_what_it_was_made_of_and_at_the_worst_constant() {
        let fall = Schedule::from_q16(500, 20, Decay::Inverse);
        assert_eq!(
            (fall.start_q16(), fall.end_q16(), fall.decay()),
            (500, 20, Decay::Inverse)
        );
        assert_eq!(
            Schedule::from_q16(20, 500, Decay::Linear),
            Schedule::constant(20)
        );
        assert_eq!(<(u32, u32, Decay)>::from(fall), (500, 20, Decay::Inverse));
        assert_eq!((fall.at(0, 0), fall.at(1, 0), fall.at(9, 9)), (500, 20, 20));
        assert_eq!(
            (
                Schedule::constant(7).at(3, 9),
                Schedule::constant(0).at(3, 9)
            ),
            (7, 0)
        );
        // Numbers beyond 32 bits.
        assert_eq!(
            Schedule::from_q16(1 << 31, 0, Decay::Linear).at(1 << 30, u32::MAX),
            (1 << 31) - (1 << 29)
        );
    }

    proptest! {
        #[test]
        fn never_rises_and_keeps_its_ends(
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
