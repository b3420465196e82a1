//! Which oscillator clocks the processor: the crystal, if its frequency is a known one, else the internal oscillator.
//!
//! A board measures its crystal against the internal oscillator at the start. A crystal that does not start, or has a
//! frequency that no board has, is not used: the serial link would run at a wrong rate. The internal oscillator is accurate
//! to 1 % at 25 °C, which a serial link bears.

use amp::wire::message::Oscillator;

/// Frequencies of crystals that can be multiplied to the processor's clock, hertz.
const CRYSTALS_HZ: [u32; 5] = [4_000_000, 8_000_000, 12_000_000, 16_000_000, 25_000_000];

/// Largest deviation of a measurement, percent: the internal oscillator's over temperature is 8 (STM32F405 data sheet
/// DS8626), a crystal's is below 0.01.
const TOLERANCE_PERCENT: u64 = 9;

/// What clocks the processor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClockSource {
    /// A crystal of so many hertz.
    Crystal {
        /// Its nominal frequency.
        hz: u32,
    },
    /// The internal oscillator.
    Internal,
}

impl ClockSource {
    /// What the hello says.
    #[must_use]
    pub const fn oscillator(self) -> Oscillator {
        match self {
            Self::Crystal { .. } => Oscillator::Crystal,
            Self::Internal => Oscillator::Internal,
        }
    }
}

/// How long some periods of the crystal took.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Measurement {
    /// Periods of the crystal.
    pub periods: u32,
    /// Periods of the reference meanwhile.
    pub ticks: u32,
    /// Frequency of the reference, hertz.
    pub reference_hz: u32,
}

/// The clock source by a measurement of the crystal; `None` = the crystal did not start.
#[must_use]
pub fn choose(measured: Option<Measurement>) -> ClockSource {
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

    /// 25 600 periods of a crystal, by a reference that deviates by so many parts of a thousand.
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
                let chosen = choose(measured(hz.into(), deviation));
                assert_eq!(chosen, ClockSource::Crystal { hz }, "{deviation}");
            }
        }
    }

    #[test]
    fn a_crystal_that_no_board_has_is_not_used() {
        for hz in [
            32_768, 1_000_000, 6_000_000, 10_000_000, 20_000_000, 50_000_000,
        ] {
            assert_eq!(choose(measured(hz, 0)), ClockSource::Internal, "{hz}");
        }
    }

    #[test]
    fn a_dead_crystal_is_not_used() {
        assert_eq!(choose(None), ClockSource::Internal);
        let none = Measurement {
            periods: 25_600,
            ticks: 0,
            reference_hz: REFERENCE_HZ,
        };
        assert_eq!(choose(Some(none)), ClockSource::Internal);
    }

    #[test]
    fn the_hello_says_which() {
        let crystal = ClockSource::Crystal { hz: 8_000_000 };
        assert_eq!(crystal.oscillator(), Oscillator::Crystal);
        assert_eq!(ClockSource::Internal.oscillator(), Oscillator::Internal);
    }
}
