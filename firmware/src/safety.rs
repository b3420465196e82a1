//! Safety lines that stop the robot without the link: emergency stop, bumper and motion permit.
//!
//! | line | level | meaning |
//! |---|---|---|
//! | emergency stop | low: contact closed to ground | the robot may move |
//! | | high by pull-up: contact open or wire broken | stop until it closes |
//! | bumper | low: contact closed to ground | nothing is touched |
//! | | high | the motion in progress ends |
//! | | high for 10 s or since the start: held, or wire broken | stop until it closes |
//! | motion permit | changes every 10 ms | a charge pump holds the motors' relay |
//! | | constant, low or high | the relay drops |

use amp::units::Millis;
use core::convert::Infallible;
use embedded_hal::digital::{InputPin, OutputPin};

/// Debounce time, milliseconds: a contact must keep its new level for this long.
const DEBOUNCE_MS: u32 = 20;

/// A bumper that is open for longer counts as stuck, milliseconds: a robot that touched something
/// backs off within two motions.
const BUMPER_STUCK_MS: u32 = 10_000;

/// Shortest time between two changes of the permit, milliseconds.
const HALF_PERIOD_MS: u32 = 10;

/// State of the safety inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Alarms {
    /// The emergency stop is open.
    pub emergency_stop: bool,
    /// The bumper has just opened.
    pub touched: bool,
    /// The bumper has been open since the start, or for more than 10 s.
    pub bumper_open: bool,
}

/// A debounced contact.
#[derive(Debug, Clone, Copy, Default)]
struct DebouncedContact {
    open: bool,
    /// When the other level was first read.
    changing_since: Option<Millis>,
}

impl DebouncedContact {
    /// Takes the level at `now`; returns whether the contact is open.
    fn update(&mut self, open: bool, now: Millis) -> bool {
        if open == self.open {
            self.changing_since = None;
            return self.open;
        }
        let since = *self.changing_since.get_or_insert(now);
        if now.since(since) >= DEBOUNCE_MS {
            (self.open, self.changing_since) = (open, None);
        }
        self.open
    }
}

/// The pins and their state.
#[derive(Debug)]
pub struct SafetyLines<I, O> {
    emergency_stop: I,
    bumper: I,
    permit: O,
    stop_contact: DebouncedContact,
    bumper_contact: DebouncedContact,
    /// When the bumper opened; `None` = long ago, or it has not been closed since the start.
    bumper_opened: Option<Millis>,
    /// When the permit changed last, and its level.
    changed: Millis,
    level: bool,
}

impl<I, O> SafetyLines<I, O>
where
    I: InputPin<Error = Infallible>,
    O: OutputPin<Error = Infallible>,
{
    /// Lines whose contacts count as open until they have been closed for the debounce time.
    pub const fn new(emergency_stop: I, bumper: I, permit: O) -> Self {
        Self {
            emergency_stop,
            bumper,
            permit,
            stop_contact: DebouncedContact {
                open: true,
                changing_since: None,
            },
            bumper_contact: DebouncedContact {
                open: true,
                changing_since: None,
            },
            bumper_opened: None,
            changed: Millis::from_ms(0),
            level: false,
        }
    }

    /// Reads the contacts. Called at the begin of each run of the control task.
    pub fn read(&mut self, now: Millis) -> Alarms {
        let Ok(stop) = self.emergency_stop.is_high();
        let Ok(bumper) = self.bumper.is_high();
        let was_open = self.bumper_contact.open;
        let is_open = self.bumper_contact.update(bumper, now);
        if !is_open || !was_open {
            self.bumper_opened = Some(now);
        }
        let opened = self.bumper_opened;
        self.bumper_opened = opened.filter(|opened| now.since(*opened) <= BUMPER_STUCK_MS);
        Alarms {
            emergency_stop: self.stop_contact.update(stop, now),
            touched: is_open && !was_open,
            bumper_open: is_open && self.bumper_opened.is_none(),
        }
    }

    /// Changes the permit's level if the robot may move and the time has come. Called at the end of
    /// each run of the control task, so the permit stops changing when that task hangs.
    pub fn toggle_permit(&mut self, may_move: bool, now: Millis) {
        if may_move && !self.stop_contact.open && now.since(self.changed) >= HALF_PERIOD_MS {
            self.changed = now;
            self.level = !self.level;
            let Ok(()) = self.permit.set_state(self.level.into());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::cell::Cell;
    use embedded_hal::digital::ErrorType;

    /// A pin whose level the test sets or reads.
    struct TestPin<'a>(&'a Cell<bool>);

    impl ErrorType for TestPin<'_> {
        type Error = Infallible;
    }

    impl InputPin for TestPin<'_> {
        fn is_high(&mut self) -> Result<bool, Infallible> {
            Ok(self.0.get())
        }

        fn is_low(&mut self) -> Result<bool, Infallible> {
            Ok(!self.0.get())
        }
    }

    impl OutputPin for TestPin<'_> {
        fn set_high(&mut self) -> Result<(), Infallible> {
            self.0.set(true);
            Ok(())
        }

        fn set_low(&mut self) -> Result<(), Infallible> {
            self.0.set(false);
            Ok(())
        }
    }

    /// Three pins; a high input is an open contact.
    #[derive(Default)]
    struct TestPins {
        stop: Cell<bool>,
        bumper: Cell<bool>,
        permit: Cell<bool>,
    }

    type Lines<'a> = SafetyLines<TestPin<'a>, TestPin<'a>>;

    fn at(ms: u32) -> Millis {
        Millis::from_ms(ms)
    }

    /// Lines at 1000 ms whose contacts have been closed since the start.
    fn closed(pins: &TestPins) -> Lines<'_> {
        let mut lines = SafetyLines::new(
            TestPin(&pins.stop),
            TestPin(&pins.bumper),
            TestPin(&pins.permit),
        );
        for now_ms in (0..=1_000).step_by(10) {
            let _ = lines.read(at(now_ms));
        }
        lines
    }

    /// Changes of the permit within one second.
    fn changes(lines: &mut Lines<'_>, pins: &TestPins, may_move: bool) -> u32 {
        let mut changes = 0;
        for now_ms in (1_010..=2_000).step_by(10) {
            let before = pins.permit.get();
            let _ = lines.read(at(now_ms));
            lines.toggle_permit(may_move, at(now_ms));
            changes += u32::from(pins.permit.get() != before);
        }
        changes
    }

    #[test]
    fn the_permit_is_a_square_wave_only_while_the_robot_may_move() {
        let pins = TestPins::default();
        assert_eq!(changes(&mut closed(&pins), &pins, true), 100);
        assert_eq!(changes(&mut closed(&pins), &pins, false), 0);
    }

    #[test]
    fn the_permit_does_not_follow_the_rate_of_the_runs() {
        let pins = TestPins::default();
        let mut lines = closed(&pins);
        let before = pins.permit.get();
        for _ in 0..50 {
            lines.toggle_permit(true, at(1_010));
        }
        assert_ne!(pins.permit.get(), before);
    }

    #[test]
    fn an_open_emergency_stop_is_an_alarm_in_each_run_and_ends_the_permit() {
        let pins = TestPins::default();
        let mut lines = closed(&pins);
        pins.stop.set(true);
        let alarms = [1_010, 1_020, 1_030, 1_040].map(|ms| lines.read(at(ms)).emergency_stop);
        assert_eq!(alarms, [false, false, true, true]);
        assert_eq!(changes(&mut lines, &pins, true), 0);
        pins.stop.set(false);
        let alarms = [2_010, 2_020, 2_030].map(|ms| lines.read(at(ms)).emergency_stop);
        assert_eq!(alarms, [true, true, false]);
    }

    #[test]
    fn a_bouncing_contact_is_no_alarm() {
        let pins = TestPins::default();
        let mut lines = closed(&pins);
        for now_ms in 1_001..1_200 {
            pins.stop.set(now_ms % 19 != 0);
            assert_eq!(lines.read(at(now_ms)), Alarms::default(), "{now_ms}");
        }
    }

    #[test]
    fn the_stop_counts_as_open_until_it_has_been_closed_for_some_time() {
        let pins = TestPins::default();
        let mut lines = SafetyLines::new(
            TestPin(&pins.stop),
            TestPin(&pins.bumper),
            TestPin(&pins.permit),
        );
        let alarms = [0, 10, 20].map(|ms| lines.read(at(ms)).emergency_stop);
        assert_eq!(alarms, [true, true, false]);
    }

    #[test]
    fn a_bumper_touches_once_each_time_it_opens() {
        let pins = TestPins::default();
        let mut lines = closed(&pins);
        let mut touches = 0;
        for now_ms in (1_010..2_000).step_by(10) {
            pins.bumper.set(now_ms % 500 < 250);
            touches += u32::from(lines.read(at(now_ms)).touched);
        }
        assert_eq!(touches, 2);
    }

    /// Runs between `from` and `to` in which the bumper stops the robot.
    fn held(lines: &mut Lines<'_>, from: u32, to: u32) -> usize {
        let rounds = (from..=to).step_by(10);
        rounds
            .filter(|now_ms| lines.read(at(*now_ms)).bumper_open)
            .count()
    }

    #[test]
    fn a_bumper_that_has_not_been_closed_since_the_start_stops_the_robot() {
        let pins = TestPins::default();
        pins.bumper.set(true);
        let mut lines = closed(&pins);
        assert_eq!(held(&mut lines, 1_010, 2_000), 100);
        pins.bumper.set(false);
        // Until the contact is debounced.
        assert_eq!(held(&mut lines, 2_010, 3_000), 2);
    }

    #[test]
    fn a_bumper_that_stays_open_stops_the_robot_after_10_s() {
        let pins = TestPins::default();
        let mut lines = closed(&pins);
        pins.bumper.set(true);
        // Debounced, the contact is open from 1030 ms on.
        assert_eq!(held(&mut lines, 1_010, 11_030), 0);
        assert_eq!(held(&mut lines, 11_040, 12_030), 100);
        pins.bumper.set(false);
        assert_eq!(held(&mut lines, 12_040, 13_000), 2);
        pins.bumper.set(true);
        assert_eq!(held(&mut lines, 13_010, 23_000), 0);
    }
}
