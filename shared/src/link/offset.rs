//! The least delay of about the last minute, in clocks that do not agree.
//!
//! The *difference* of a frame is its arrival time by the clock here minus its send time by the
//! other clock, modulo 2³². It is the frame's delay plus a constant, and the constant drifts with
//! the clocks: at 200 ppm by 12 ms a minute. The least difference of a window of [`SLOTS`] ×
//! [`SLOT_MS`] stands for a frame without delay.
//!
//! One frame with a wrong time must not count for a minute. So the greater of two consecutive
//! differences goes into the window. A clock that was set forward counts from its second frame on;
//! one that was set back, when the window has passed.

use crate::units::Millis;

/// The window has this many slots.
pub(crate) const SLOTS: usize = 6;
/// Length of a slot, milliseconds.
pub(crate) const SLOT_MS: u32 = 10_000;

/// The least differences of the window's slots; all zeros when new.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct OffsetWindow {
    /// Least difference in each slot, the newest slot first.
    least: [Option<u32>; SLOTS],
    /// When the newest slot began.
    began: Millis,
    /// The latest frame's difference.
    latest: Option<u32>,
    /// The first difference that went into the window.
    first: Option<u32>,
}

impl OffsetWindow {
    pub(super) const fn new() -> Self {
        Self {
            least: [None; SLOTS],
            began: Millis::from_ms(0),
            latest: None,
            first: None,
        }
    }

    /// Takes the difference of a frame that arrived at `now`.
    pub(super) fn add(&mut self, difference: u32, now: Millis) {
        let Some(previous) = self.latest.replace(difference) else {
            self.began = now;
            return;
        };
        self.pass_slots(now);
        // A single frame from the future is less than both of its neighbors.
        let sample = if is_less(difference, previous) {
            previous
        } else {
            difference
        };
        self.first = self.first.or(Some(sample));
        let [newest, ..] = &mut self.least;
        if newest.is_none_or(|least| is_less(sample, least)) {
            *newest = Some(sample);
        }
    }

    /// Begins new slots for the time that has passed. After a silence longer than the window its
    /// last value stays for one more window: the first frame after a stall is old.
    fn pass_slots(&mut self, now: Millis) {
        let slots = now.since(self.began) / SLOT_MS;
        let known = self.least_of_window();
        for _ in 0..slots.min(SLOTS as u32) {
            self.least.rotate_right(1);
            let [newest, ..] = &mut self.least;
            *newest = None;
        }
        if self.least == [None; SLOTS] && slots > 0 {
            let [newest, ..] = &mut self.least;
            *newest = known;
        }
        self.began = self.began.plus_ms(slots.wrapping_mul(SLOT_MS));
    }

    fn least_of_window(&self) -> Option<u32> {
        let known = self.least.iter().copied().flatten();
        known.reduce(|a, b| if is_less(b, a) { b } else { a })
    }

    /// The least difference of the window; before it has one, the latest frame's.
    fn least(&self) -> Option<u32> {
        self.least_of_window().or(self.latest)
    }

    /// How much a difference exceeds the least one, milliseconds.
    pub(super) fn excess_ms(&self, difference: u32) -> u32 {
        let least = self.least().unwrap_or(difference);
        if is_less(difference, least) {
            0
        } else {
            difference.wrapping_sub(least)
        }
    }

    /// How far the least difference has risen since the first one, milliseconds.
    pub(super) fn drift_ms(&self) -> i32 {
        match (self.least(), self.first) {
            (Some(least), Some(first)) => least.wrapping_sub(first) as i32,
            _ => 0,
        }
    }
}

/// Whether `a` is less than `b`, which is less than 24.8 days away from it modulo 2³².
const fn is_less(a: u32, b: u32) -> bool {
    (a.wrapping_sub(b) as i32) < 0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A host whose clock runs `ppm` fast and was set by `step_ms`, heard every 100 ms after 3 to
    /// 20 ms on the way.
    struct FakeHost {
        ppm: i64,
        step_ms: i64,
        window: OffsetWindow,
    }

    impl FakeHost {
        fn new(ppm: i64) -> Self {
            let window = OffsetWindow::new();
            Self {
                ppm,
                step_ms: 0,
                window,
            }
        }

        /// The difference of a frame that arrives at `now_ms` after `delay_ms`.
        fn difference(&self, now_ms: i64, delay_ms: i64) -> u32 {
            let sent_ms = now_ms - delay_ms;
            let stamp_ms = sent_ms + sent_ms * self.ppm / 1_000_000 + self.step_ms;
            (now_ms - stamp_ms) as u32
        }

        /// Takes the frame; returns its age.
        fn frame(&mut self, now_ms: i64, delay_ms: i64) -> u32 {
            let difference = self.difference(now_ms, delay_ms);
            self.window.add(difference, Millis::from_ms(now_ms as u32));
            self.window.excess_ms(difference)
        }

        /// Frames from one moment to another; returns the greatest age.
        fn run(&mut self, from_ms: i64, to_ms: i64) -> u32 {
            let frames = (from_ms..to_ms).step_by(100).enumerate();
            let delay_ms = |number: usize| 3 + 7 * number as i64 % 18;
            let ages = frames.map(|(number, now_ms)| self.frame(now_ms, delay_ms(number)));
            ages.max().unwrap_or(0)
        }
    }

    const HOUR_MS: i64 = 3_600_000;
    const DAY_MS: i64 = if cfg!(miri) {
        HOUR_MS / 6
    } else {
        24 * HOUR_MS
    };

    #[test]
    fn clocks_that_drift_by_200_ppm_for_a_day_make_no_frame_old() {
        for ppm in [-200, 200] {
            let mut host = FakeHost::new(ppm);
            // 17 ms more than the promptest on the way, 12 ms of drift in the window.
            let oldest = host.run(0, DAY_MS);
            assert!(oldest <= 30, "{ppm} ppm: {oldest} ms");
            // 17.28 s a day.
            let drift = i64::from(host.window.drift_ms());
            let expected = -DAY_MS * ppm / 1_000_000;
            assert!((drift - expected).abs() <= 30, "{ppm} ppm: {drift} ms");
        }
    }

    #[test]
    fn a_clock_set_forward_makes_no_frame_old() {
        for step_ms in [1_000, HOUR_MS] {
            let mut host = FakeHost::new(0);
            host.run(0, 120_000);
            host.step_ms = step_ms;
            assert!(host.run(120_000, 300_000) <= 20, "{step_ms}");
        }
    }

    #[test]
    fn a_clock_set_back_makes_frames_old_for_a_minute_at_most() {
        for step_ms in [1_000, HOUR_MS] {
            let mut host = FakeHost::new(0);
            host.run(0, 120_000);
            host.step_ms = -step_ms;
            let oldest = i64::from(host.run(120_000, 180_100));
            assert!((step_ms..step_ms + 20).contains(&oldest), "{oldest}");
            assert!(host.run(180_100, 300_000) <= 20, "{step_ms}");
        }
    }

    #[test]
    fn one_frame_from_the_future_counts_for_nothing() {
        let mut host = FakeHost::new(0);
        host.run(0, 5_000);
        for number in 0..50 {
            host.step_ms = 60_000;
            host.frame(5_000 + 200 * number, 3);
            host.step_ms = 0;
            assert!(host.frame(5_100 + 200 * number, 3) <= 20);
        }
        // Nor does the very first one.
        let mut host = FakeHost::new(0);
        host.step_ms = 60_000;
        assert_eq!(host.frame(0, 3), 0);
        host.step_ms = 0;
        assert!(host.run(100, 20_000) <= 20);
    }

    #[test]
    fn a_delayed_frame_is_old_by_its_delay() {
        let mut host = FakeHost::new(0);
        host.run(0, 20_000);
        // The window's least is that of two frames in a row: 3 and 10 ms.
        assert_eq!(host.frame(20_000, 1_510), 1_500);
        // Frames that a stalled line kept back for minutes are old as well.
        assert_eq!(host.frame(200_000, 170_010), 170_000);
        assert_eq!(host.frame(200_001, 165_010), 165_000);
        assert_eq!(host.frame(200_002, 3), 0);
    }
}
