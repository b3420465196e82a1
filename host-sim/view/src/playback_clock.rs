//! The speed of simulated time in the view.

/// Minimum and maximum speed, simulated seconds per second.
pub const SPEEDS: [f64; 2] = [0.05, 1_000.0];

/// Computes when the next step is due. Times are seconds on any monotonic clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaybackClock {
    /// Simulated seconds per second; `None` = maximum.
    speed: Option<f64>,
    paused: bool,
    /// Steps to take while paused.
    pending_steps: u32,
    /// Time of the next step.
    due_s: f64,
}

impl PlaybackClock {
    /// Running at this speed, clamped to [`SPEEDS`].
    #[must_use]
    pub fn new(speed: Option<f64>) -> Self {
        let mut clock = Self {
            speed: None,
            paused: false,
            pending_steps: 0,
            due_s: 0.0,
        };
        clock.set_speed(speed);
        clock
    }

    /// Simulated seconds per second; `None` = maximum.
    #[must_use]
    pub fn speed(&self) -> Option<f64> {
        self.speed
    }

    /// Sets the speed, clamped to [`SPEEDS`].
    pub fn set_speed(&mut self, speed: Option<f64>) {
        let [slow, fast] = SPEEDS;
        let finite = speed.filter(|speed| !speed.is_nan());
        self.speed = finite.map(|speed| speed.clamp(slow, fast));
        self.due_s = 0.0;
    }

    /// Whether time is paused.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.paused && self.pending_steps == 0
    }

    /// Pauses or resumes time.
    pub fn pause(&mut self, paused: bool) {
        (self.paused, self.pending_steps) = (paused, 0);
        self.due_s = 0.0;
    }

    /// Pauses after one more step, which is due at once.
    pub fn single_step(&mut self) {
        (self.paused, self.pending_steps) = (true, 1);
        self.due_s = 0.0;
    }

    /// Time until the next step, seconds; `None` while paused.
    #[must_use]
    pub fn wait_s(&self, now_s: f64) -> Option<f64> {
        (!self.is_paused()).then(|| (self.due_s - now_s).max(0.0))
    }

    /// Records a step of `took_s` simulated seconds; `whole` means that a decision was taken or the
    /// source is idle. A lag is made up for by a tenth of a second at most.
    pub fn step_taken(&mut self, now_s: f64, took_s: f64, whole: bool) {
        if whole {
            self.pending_steps = self.pending_steps.saturating_sub(1);
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
        let mut clock = PlaybackClock::new(Some(2.0));
        let mut now_s = 100.0;
        for _ in 0..10 {
            now_s += clock.wait_s(now_s).unwrap();
            clock.step_taken(now_s, 1.0, true);
        }
        // The first step is due at once; the initial lag counts as a tenth of a second.
        assert!((now_s - 104.4).abs() < 1e-9, "{now_s}");
    }

    #[test]
    fn a_slow_step_is_made_up_for_and_a_long_gap_is_not() {
        let mut clock = PlaybackClock::new(Some(1.0));
        clock.step_taken(10.0, 1.0, true);
        clock.step_taken(10.95, 1.0, true);
        assert!((clock.wait_s(10.95).unwrap() - 0.95).abs() < 1e-9);
        clock.step_taken(500.0, 1.0, true);
        assert!((clock.wait_s(500.0).unwrap() - 0.9).abs() < 1e-9);
    }

    #[test]
    fn paused_is_paused_but_for_single_steps() {
        let mut clock = PlaybackClock::new(None);
        assert_eq!(clock.wait_s(3.0), Some(0.0));
        clock.pause(true);
        assert_eq!(clock.wait_s(3.0), None);
        clock.single_step();
        assert_eq!(clock.wait_s(3.0), Some(0.0));
        clock.step_taken(3.0, 0.04, false);
        assert_eq!(clock.wait_s(3.0), Some(0.0));
        clock.step_taken(3.0, 0.04, true);
        assert_eq!(clock.wait_s(3.0), None);
        clock.pause(false);
        assert_eq!(clock.wait_s(3.0), Some(0.0));
    }

    #[test]
    fn speeds_are_brought_into_range() {
        assert_eq!(PlaybackClock::new(Some(1e9)).speed(), Some(1_000.0));
        assert_eq!(PlaybackClock::new(Some(-1.0)).speed(), Some(0.05));
        assert_eq!(PlaybackClock::new(Some(f64::NAN)).speed(), None);
    }
}
