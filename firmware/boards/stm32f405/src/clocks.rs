//! The clocks: measures the crystal and multiplies it, or the internal oscillator, to 168 MHz.
//!
//! The wait for the crystal is limited, the watchdog ends all other waits, and a failed crystal is
//! not tried again ([`firmware::clock`]). An emulated chip stays on its internal oscillator.

use crate::chip::CORE_HZ;
use crate::fault;
use amp::wire::message::Oscillator;
use firmware::clock::TrialRecord;
#[cfg(not(feature = "qemu"))]
use firmware::clock::{ClockSource, Measurement, PollBudget, choose_source};
use firmware::crash::ResetFlags;
use stm32f4xx_hal::pac;
#[cfg(not(feature = "qemu"))]
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Config, Rcc, RccExt};

/// Time after which the crystal counts as proven, milliseconds.
pub const PROVEN_AFTER_MS: u32 = 1_000;

/// Notes that the program has run for [`PROVEN_AFTER_MS`].
pub fn mark_proven() {
    fault::write_trial(TrialRecord::of(fault::read_trial().trial().on_proven()));
}

/// Starts the clocks.
#[cfg(feature = "qemu")]
pub fn start(rcc: pac::RCC, _: pac::TIM11, _: ResetFlags) -> (Rcc, Oscillator) {
    const { assert!(CORE_HZ > 0) };
    (rcc.freeze(Config::hsi()), Oscillator::Unknown)
}

/// Frequency of the internal oscillator, which clocks the chip after a reset.
#[cfg(not(feature = "qemu"))]
const INTERNAL_HZ: u32 = 16_000_000;

/// Most polls of a whole measurement: 100 ms, at 13 cycles of the internal oscillator each. A
/// crystal starts within 2 ms (data sheet DS8626, HSE); measuring 4 MHz, the slowest, takes 7 ms.
#[cfg(not(feature = "qemu"))]
const MAX_POLLS: u32 = 120_000;

/// Divider of the crystal's clock before it is captured.
#[cfg(not(feature = "qemu"))]
const DIVIDER: u8 = 25;

/// Captures per measurement, each after eight periods of the divided clock.
#[cfg(not(feature = "qemu"))]
const CAPTURES: u32 = 64;

/// Starts the clocks.
#[cfg(not(feature = "qemu"))]
pub fn start(rcc: pac::RCC, timer: pac::TIM11, flags: ResetFlags) -> (Rcc, Oscillator) {
    let trial = fault::read_trial().trial().on_start(flags);
    // Before the crystal is used.
    fault::write_trial(TrialRecord::of(trial));
    let source = choose_source(trial, || measure(&rcc, &timer));
    let config = match source {
        ClockSource::Crystal { hz } => Config::hse(hz.Hz()),
        ClockSource::Internal => {
            rcc.cr().modify(|_, w| w.hseon().clear_bit());
            Config::hsi()
        }
    };
    let rcc = rcc.freeze(config.sysclk(CORE_HZ.Hz()));
    if source != ClockSource::Internal {
        // A stopped crystal raises NMI: see `fault`.
        rcc.cr().modify(|_, w| w.csson().set_bit());
    }
    (rcc, source.oscillator())
}

/// Counts periods of the internal oscillator during some of the crystal's (RM0090, 7.2.10:
/// timer 11 captures HSE_RTC).
///
/// Once the clocks run, it counts periods of the processor's clock.
#[cfg(not(feature = "qemu"))]
pub fn measure(rcc: &pac::RCC, timer: &pac::TIM11) -> Option<Measurement> {
    let mut budget = PollBudget::new(MAX_POLLS);
    rcc.cr().modify(|_, w| w.hseon().set_bit());
    budget.poll_until(|| rcc.cr().read().hserdy().bit_is_set())?;
    rcc.cfgr().modify(|_, w| w.rtcpre().set(DIVIDER));
    rcc.apb2enr().modify(|_, w| w.tim11en().set_bit());
    // SAFETY: 2 selects HSE_RTC.
    #[allow(unsafe_code)]
    timer.or().write(|w| unsafe { w.rmp().bits(2) });
    timer
        .ccmr1_input()
        .write(|w| w.cc1s().ti1().ic1psc().set(0b11));
    timer.ccer().write(|w| w.cc1e().set_bit());
    timer.cr1().write(|w| w.cen().set_bit());
    let ticks = capture_ticks(timer, budget);
    timer.cr1().reset();
    rcc.apb2enr().modify(|_, w| w.tim11en().clear_bit());
    Some(Measurement {
        periods: CAPTURES * 8 * u32::from(DIVIDER),
        ticks: ticks?,
        reference_hz: INTERNAL_HZ,
    })
}

/// Ticks of the timer from the first capture to the last; `None` if the polls run out.
#[cfg(not(feature = "qemu"))]
fn capture_ticks(timer: &pac::TIM11, mut budget: PollBudget) -> Option<u32> {
    let mut captured = || {
        budget.poll_until(|| timer.sr().read().cc1if().bit_is_set())?;
        // Reading clears the flag.
        Some(timer.ccr1().read().ccr().bits())
    };
    // The first capture may be an old one.
    captured()?;
    let mut last = captured()?;
    let mut ticks = 0;
    for _ in 0..CAPTURES {
        let next = captured()?;
        ticks += u32::from(next.wrapping_sub(last));
        last = next;
    }
    Some(ticks)
}
