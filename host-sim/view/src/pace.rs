//! How fast simulated time passes for those who watch.

/// Slowest and fastest speed, simulated seconds per second.
pub const SPEEDS: [f64; 2] = [0.05, 1_000.0];

/// When the next step is due. Times are seconds on any clock that only goes on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pace {
    /// Simulated seconds per second; `None` = as fast as it goes.
    speed: Option<f64>,
    paused: bool,
    /// Paused, but so many steps are still to be taken.
    owed: u32,
    /// When the next step is due.
    due_s: f64,
}

impl Pace {
    /// Running at this speed; one out of range is brought into it.
    #[must_use]
    pub fn new(speed: Option<f64>) -> Self {
        let mut pace = Self {
            speed: None,
            paused: false,
            owed: 0,
            due_s: 0.0,
        };
        pace.set_speed(speed);
        pace
    }

    /// Simulated seconds per second; `None` = as fast as it goes.
    #[must_use]
    pub fn speed(&self) -> Option<f64> {
        self.speed
    }

    /// From now on at this speed; one out of range is brought into it.
    pub fn set_speed(&mut self, speed: Option<f64>) {
        let [slow, fast] = SPEEDS;
        let finite = speed.filter(|speed| !speed.is_nan());
        self.speed = finite.map(|speed| speed.clamp(slow, fast));
        self.due_s = 0.0;
    }

    /// Whether time stands still.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.paused && self.owed == 0
    }

    /// Lets time stand still or go on.
    pub fn pause(&mut self, paused: bool) {
        (self.paused, self.owed) = (paused, 0);
        self.due_s = 0.0;
    }

    /// Lets time stand still but for one step, to be taken at once.
    pub fn single(&mut self) {
        (self.paused, self.owed) = (true, 1);
        self.due_s = 0.0;
    }

    /// How long until the next step is due, seconds; `None` = never.
    #[must_use]
    pub fn wait_s(&self, now_s: f64) -> Option<f64> {
        (!self.is_paused()).then(|| (self.due_s - now_s).max(0.0))
    }

    /// A step was taken that lasted `took_s` in its own time; `whole` when a decision was taken or nothing goes on. What
    /// is late is made up for, but not more than a tenth of a second of it.
    pub fn took(&mut self, now_s: f64, took_s: f64, whole: bool) {
        if whole {
            self.owed = self.owed.saturating_sub(1);
        }
        if let Some(speed) = self.speed {
            self.due_s = self.due_s.max(now_s - 0.1) + took_s / speed;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_come_at_their_speed() {
        let mut pace = Pace::new(Some(2.0));
        let mut now_s = 100.0;
        for _ in 0..10 {
            now_s += pace.wait_s(now_s).unwrap();
            pace.took(now_s, 1.0, true);
        }
        // The first is due at once; what was never waited for counts as late by a tenth of a second.
        assert!((now_s - 104.4).abs() < 1e-9, "{now_s}");
    }

    #[test]
    fn a_slow_step_is_made_up_for_and_a_long_gap_is_not() {
        let mut pace = Pace::new(Some(1.0));
        pace.took(10.0, 1.0, true);
        pace.took(10.95, 1.0, true);
        assert!((pace.wait_s(10.95).unwrap() - 0.95).abs() < 1e-9);
        pace.took(500.0, 1.0, true);
        assert!((pace.wait_s(500.0).unwrap() - 0.9).abs() < 1e-9);
    }

    #[test]
    fn paused_is_paused_but_for_single_steps() {
        let mut pace = Pace::new(None);
        assert_eq!(pace.wait_s(3.0), Some(0.0));
        pace.pause(true);
        assert_eq!(pace.wait_s(3.0), None);
        pace.single();
        assert_eq!(pace.wait_s(3.0), Some(0.0));
        pace.took(3.0, 0.04, false);
        assert_eq!(pace.wait_s(3.0), Some(0.0));
        pace.took(3.0, 0.04, true);
        assert_eq!(pace.wait_s(3.0), None);
        pace.pause(false);
        assert_eq!(pace.wait_s(3.0), Some(0.0));
    }

    #[test]
    fn speeds_are_brought_into_range() {
        assert_eq!(Pace::new(Some(1e9)).speed(), Some(1_000.0));
        assert_eq!(Pace::new(Some(-1.0)).speed(), Some(0.05));
        assert_eq!(Pace::new(Some(f64::NAN)).speed(), None);
    }
}
