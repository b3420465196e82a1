//! When the status LED is lit: the state of the firmware, visible without a computer.
//!
//! | LED | meaning |
//! |---|---|
//! | a short flash each second | the firmware runs; no host is connected |
//! | half a second on, half a second off | a host is connected |
//! | flickers for three seconds after a start | the last run ended by a crash or the watchdog |
//! | constantly on or off | the firmware does not run |

use amp::units::Millis;
use amp::wire::message::ResetCause;

/// How long the LED flickers after a crash, milliseconds.
const CRASH_SIGNAL_MS: u32 = 3_000;

/// Whether the LED is lit at `now`, counted from the start.
#[must_use]
pub const fn is_lit(now: Millis, linked: bool, reset: ResetCause) -> bool {
    let now_ms = now.as_ms();
    if now_ms < CRASH_SIGNAL_MS && is_crash(reset) {
        return now_ms % 100 < 50;
    }
    let lit_ms = if linked { 500 } else { 50 };
    now_ms % 1_000 < lit_ms
}

const fn is_crash(reset: ResetCause) -> bool {
    matches!(
        reset,
        ResetCause::Watchdog
            | ResetCause::Panic
            | ResetCause::HardFault
            | ResetCause::StackOverflow
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Milliseconds lit within the second that begins at `from_ms`.
    fn lit_ms(from_ms: u32, linked: bool, reset: ResetCause) -> usize {
        let lit = |ms: &u32| is_lit(Millis::from_ms(*ms), linked, reset);
        (from_ms..from_ms + 1_000).filter(lit).count()
    }

    #[test]
    fn led_patterns_match_the_table() {
        assert_eq!(lit_ms(0, false, ResetCause::PowerOn), 50);
        assert_eq!(lit_ms(0, true, ResetCause::PowerOn), 500);
        assert_eq!(lit_ms(2_000, false, ResetCause::Watchdog), 500);
        assert_eq!(lit_ms(3_000, false, ResetCause::Watchdog), 50);
    }

    #[test]
    fn a_crash_flickers_faster_than_a_link() {
        let changes = |reset| {
            let lit = |ms| is_lit(Millis::from_ms(ms), true, reset);
            (0..1_000).filter(|&ms| lit(ms) != lit(ms + 1)).count()
        };
        assert_eq!(changes(ResetCause::Panic), 20);
        assert_eq!(changes(ResetCause::Unknown), 2);
    }
}
