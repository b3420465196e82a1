//! Which oscillator clocks the processor: a crystal of a known frequency, else the internal one.
//!
//! A board measures its crystal against the internal oscillator at each start. A record in RAM
//! survives a reset: a crystal that passes and fails later is not used until the next power-on, so
//! it causes one restart at most.

use crate::crash::ResetFlags;
use amp::wire::message::Oscillator;

/// Frequencies of crystals that can be multiplied to the processor's clock, hertz.
const CRYSTALS_HZ: [u32; 5] = [4_000_000, 8_000_000, 12_000_000, 16_000_000, 25_000_000];

/// Largest deviation of a measurement, percent: the internal oscillator's is 8 over temperature
/// (STM32F405 data sheet DS8626), a crystal's is below 0.01.
const TOLERANCE_PERCENT: u64 = 9;

/// What clocks the processor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClockSource {
    /// A crystal.
    Crystal {
        /// Nominal frequency, hertz.
        hz: u32,
    },
    /// The internal oscillator: accurate to 1 % at 25 °C, which suffices for a serial link.
    Internal,
}

impl ClockSource {
    /// The oscillator as the Hello reports it.
    #[must_use]
    pub const fn oscillator(self) -> Oscillator {
        match self {
            Self::Crystal { .. } => Oscillator::Crystal,
            Self::Internal => Oscillator::Internal,
        }
    }
}

/// Duration of some periods of the crystal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Measurement {
    /// Periods of the crystal.
    pub periods: u32,
    /// Periods of the reference in the same time.
    pub ticks: u32,
    /// Frequency of the reference, hertz.
    pub reference_hz: u32,
}

/// Number of polls left; several waits share it.
#[derive(Debug)]
pub struct PollBudget(u32);

impl PollBudget {
    /// A budget of `budget` polls.
    #[must_use]
    pub const fn new(budget: u32) -> Self {
        Self(budget)
    }

    /// Polls until `is_so` returns true; `None` when the budget is used up.
    pub fn poll_until(&mut self, is_so: impl Fn() -> bool) -> Option<()> {
        while let Some(left) = self.0.checked_sub(1) {
            self.0 = left;
            if is_so() {
                return Some(());
            }
        }
        None
    }
}

/// What earlier runs since power-on say about the crystal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrystalTrial {
    /// No failure is known.
    NoFailure,
    /// The crystal is being measured, or has clocked the program for less than a second.
    OnTrial,
    /// The crystal has failed.
    Failed,
}

impl CrystalTrial {
    /// The state at a start: `OnTrial` if the crystal may be used, else `Failed`.
    ///
    /// Power-on starts a new trial. A reset by the watchdog during a trial counts as a failure,
    /// though its cause is unknown. Other resets do not.
    #[must_use]
    pub const fn on_start(self, flags: ResetFlags) -> Self {
        let has_failed = match self {
            Self::NoFailure => false,
            Self::OnTrial => flags.watchdog,
            Self::Failed => true,
        };
        if has_failed && !flags.power {
            Self::Failed
        } else {
            Self::OnTrial
        }
    }

    /// The state after a crash. A crash during the trial counts as a failure.
    #[must_use]
    pub const fn on_crash(self) -> Self {
        match self {
            Self::OnTrial => Self::Failed,
            other => other,
        }
    }

    /// The state after the program has run for a second.
    #[must_use]
    pub const fn on_proven(self) -> Self {
        match self {
            Self::OnTrial => Self::NoFailure,
            other => other,
        }
    }
}

/// A [`CrystalTrial`] as it is kept in RAM. Every bit pattern is a valid value of this type;
/// an unknown one means `NoFailure`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct TrialRecord {
    code: u32,
    complement: u32,
}

impl TrialRecord {
    /// Codes of the states; arbitrary numbers.
    const ON_TRIAL: u32 = 0x5eed_c1a1;
    const FAILED: u32 = 0x5eed_c1a2;

    /// The record of a state.
    #[must_use]
    pub const fn of(trial: CrystalTrial) -> Self {
        let code = match trial {
            CrystalTrial::NoFailure => 0,
            CrystalTrial::OnTrial => Self::ON_TRIAL,
            CrystalTrial::Failed => Self::FAILED,
        };
        Self {
            code,
            complement: !code,
        }
    }

    /// The recorded state.
    #[must_use]
    pub const fn trial(self) -> CrystalTrial {
        match self.code {
            _ if self.complement != !self.code => CrystalTrial::NoFailure,
            Self::ON_TRIAL => CrystalTrial::OnTrial,
            Self::FAILED => CrystalTrial::Failed,
            _ => CrystalTrial::NoFailure,
        }
    }
}

/// Chooses the clock source. `measure` is called only if the crystal may be used; it returns
/// `None` if the crystal does not start.
#[must_use]
pub fn choose_source(
    trial: CrystalTrial,
    measure: impl FnOnce() -> Option<Measurement>,
) -> ClockSource {
    match trial {
        CrystalTrial::Failed => ClockSource::Internal,
        CrystalTrial::NoFailure | CrystalTrial::OnTrial => source_by(measure()),
    }
}

/// The clock source by a measurement of the crystal.
fn source_by(measured: Option<Measurement>) -> ClockSource {
    let hz = measured.and_then(|measured| {
        let periods = u64::from(measured.periods) * u64::from(measured.reference_hz);
        periods.checked_div(measured.ticks.into())
    });
    let known = hz.and_then(|hz| {
        CRYSTALS_HZ.into_iter().find(|&crystal_hz| {
            let nominal = u64::from(crystal_hz);
            hz.abs_diff(nominal) * 100 <= nominal * TOLERANCE_PERCENT
        })
    });
    match known {
        Some(hz) => ClockSource::Crystal { hz },
        None => ClockSource::Internal,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REFERENCE_HZ: u32 = 16_000_000;

    /// 25 600 periods of a crystal, measured by a reference that deviates by `deviation` per mille.
    fn measured(crystal_hz: u64, deviation: i64) -> Option<Measurement> {
        let reference_hz = (i64::from(REFERENCE_HZ) * (1_000 + deviation) / 1_000) as u64;
        Some(Measurement {
            periods: 25_600,
            ticks: (25_600 * reference_hz / crystal_hz) as u32,
            reference_hz: REFERENCE_HZ,
        })
    }

    #[test]
    fn each_crystal_is_recognized_over_the_references_whole_range() {
        for hz in [4_000_000, 8_000_000, 12_000_000, 16_000_000, 25_000_000] {
            for deviation in -80..=45 {
                let chosen =
                    choose_source(CrystalTrial::OnTrial, || measured(hz.into(), deviation));
                assert_eq!(chosen, ClockSource::Crystal { hz }, "{deviation}");
            }
        }
    }

    #[test]
    fn a_crystal_that_no_board_has_is_not_used() {
        for hz in [
            32_768, 1_000_000, 6_000_000, 10_000_000, 20_000_000, 50_000_000,
        ] {
            assert_eq!(source_by(measured(hz, 0)), ClockSource::Internal, "{hz}");
        }
    }

    #[test]
    fn a_dead_crystal_is_not_used() {
        assert_eq!(source_by(None), ClockSource::Internal);
        let none = Measurement {
            periods: 25_600,
            ticks: 0,
            reference_hz: REFERENCE_HZ,
        };
        assert_eq!(source_by(Some(none)), ClockSource::Internal);
    }

    #[test]
    fn all_waits_of_a_measurement_share_one_budget() {
        let mut budget = PollBudget::new(5);
        let looked = core::cell::Cell::new(0);
        // True at each third poll.
        let rare = || {
            looked.set(looked.get() + 1);
            looked.get() % 3 == 0
        };
        assert_eq!(budget.poll_until(rare), Some(()));
        assert_eq!(budget.poll_until(rare), None);
        assert_eq!(looked.get(), 5);
        assert_eq!(budget.poll_until(|| true), None);
    }

    const POWER: ResetFlags = ResetFlags {
        power: true,
        watchdog: false,
        software: false,
        pin: true,
    };
    const WATCHDOG: ResetFlags = ResetFlags {
        power: false,
        watchdog: true,
        ..POWER
    };
    const SOFTWARE: ResetFlags = ResetFlags {
        power: false,
        software: true,
        ..POWER
    };
    const PIN: ResetFlags = ResetFlags {
        power: false,
        ..POWER
    };

    #[test]
    fn a_failed_crystal_is_not_used_until_power_on() {
        use CrystalTrial::{Failed, NoFailure, OnTrial};
        for (before, flags, now) in [
            (NoFailure, POWER, OnTrial),
            (NoFailure, WATCHDOG, OnTrial),
            (NoFailure, SOFTWARE, OnTrial),
            (NoFailure, PIN, OnTrial),
            (OnTrial, POWER, OnTrial),
            (OnTrial, WATCHDOG, Failed),
            (OnTrial, SOFTWARE, OnTrial),
            (OnTrial, PIN, OnTrial),
            (Failed, POWER, OnTrial),
            (Failed, WATCHDOG, Failed),
            (Failed, SOFTWARE, Failed),
            (Failed, PIN, Failed),
        ] {
            assert_eq!(before.on_start(flags), now, "{before:?}, {flags:?}");
        }
        let unmeasured = choose_source(Failed, || panic!("it is left alone"));
        assert_eq!(unmeasured, ClockSource::Internal);
    }

    #[test]
    fn crashes_and_time_change_the_trial() {
        use CrystalTrial::{Failed, NoFailure, OnTrial};
        for (before, crashed, proved) in [
            (NoFailure, NoFailure, NoFailure),
            (OnTrial, Failed, NoFailure),
            (Failed, Failed, Failed),
        ] {
            assert_eq!(before.on_crash(), crashed, "{before:?}");
            assert_eq!(before.on_proven(), proved, "{before:?}");
        }
    }

    /// The crystal passes each measurement, then stops, or crashes or hangs the program.
    #[test]
    fn no_crystal_restarts_the_chip_more_than_once() {
        #[derive(Debug, Clone, Copy, PartialEq)]
        enum CrystalDefect {
            Stops,
            Crashes,
            Hangs,
        }
        for end in [
            CrystalDefect::Stops,
            CrystalDefect::Crashes,
            CrystalDefect::Hangs,
        ] {
            let (mut record, mut flags, mut restarts) =
                (TrialRecord::of(CrystalTrial::Failed), POWER, 0);
            loop {
                let trial = record.trial().on_start(flags);
                record = TrialRecord::of(trial);
                let chosen = choose_source(trial, || measured(8_000_000, 0));
                if chosen == ClockSource::Internal {
                    break;
                }
                (record, flags) = match end {
                    CrystalDefect::Stops => (TrialRecord::of(CrystalTrial::Failed), SOFTWARE),
                    CrystalDefect::Crashes => {
                        (TrialRecord::of(record.trial().on_crash()), SOFTWARE)
                    }
                    CrystalDefect::Hangs => (record, WATCHDOG),
                };
                restarts += 1;
                assert_eq!(restarts, 1, "{end:?}");
            }
            assert_eq!((restarts, record.trial()), (1, CrystalTrial::Failed));
        }
    }

    #[test]
    fn a_trial_survives_its_record_and_random_memory_is_no_record() {
        for trial in [
            CrystalTrial::NoFailure,
            CrystalTrial::OnTrial,
            CrystalTrial::Failed,
        ] {
            let record = TrialRecord::of(trial);
            assert_eq!(record.trial(), trial);
            for bit in 0..32 {
                let flip = 1 << bit;
                for (code, complement) in [(flip, 0), (0, flip), (flip, flip)] {
                    let changed = TrialRecord {
                        code: record.code ^ code,
                        complement: record.complement ^ complement,
                    };
                    assert_eq!(changed.trial(), CrystalTrial::NoFailure, "{trial:?}, {bit}");
                }
            }
        }
        for (code, complement) in [(0, 0), (u32::MAX, u32::MAX), (0, u32::MAX)] {
            assert_eq!(
                TrialRecord { code, complement }.trial(),
                CrystalTrial::NoFailure
            );
        }
        for halves in [[0x5eed_c1a1, 0], [0x5eed_c1a2, 0x5eed_c1a2]] {
            let [code, complement] = halves;
            assert_eq!(
                TrialRecord { code, complement }.trial(),
                CrystalTrial::NoFailure
            );
        }
    }

    #[test]
    fn the_hello_reports_the_oscillator() {
        let crystal = ClockSource::Crystal { hz: 8_000_000 };
        assert_eq!(crystal.oscillator(), Oscillator::Crystal);
        assert_eq!(ClockSource::Internal.oscillator(), Oscillator::Internal);
    }
}
