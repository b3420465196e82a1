//! Echoes and odometry: what the robot hears and how far it has moved, and the motion that both may
//! shorten.

use super::tracked::Tracked;
use super::{Motion, Outputs, Progress, State, patience_ms};
use crate::config::Config;
use crate::scan::{Aligned, Echo};
use crate::shield::Allowed;
use crate::units::{Bearing, Displacement, Millis};

/// A motion under way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Pending<const SENSORS: usize> {
    pub(super) before: Aligned<SENSORS>,
    pub(super) commanded: Displacement,
    /// Executed so far, in the ring's frame at the decision.
    pub(super) executed: Displacement,
    /// Still to go.
    pub(super) remaining: Tracked,
    /// How far the ring has turned since the decision.
    pub(super) turned: Bearing,
    pub(super) speed_mm_s: u16,
}

impl<const SENSORS: usize> Pending<SENSORS> {
    /// Less than half of it was carried out.
    pub(super) fn was_cut(&self) -> bool {
        let half = u32::from(self.commanded.length_mm() / 2);
        self.executed.is_shorter_than(half)
    }

    /// The base has overrun its target: braking takes some distance.
    fn was_overrun(&self) -> bool {
        let left = self.remaining.now().rotated(self.turned.direction());
        left.opposes(self.commanded)
    }
}

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    State<SENSORS, NEURONS, SAMPLES>
{
    /// The motion wanted, a first step aside or (for a planned motion) a detour, and how much of it
    /// the shield allows.
    pub(super) fn limit_motion(
        &self,
        config: &Config<SENSORS>,
        now: Millis,
        wanted: Displacement,
        planned: bool,
    ) -> (Displacement, Allowed) {
        let enabled = self.enabled(config);
        let side_step = self.shield.step_aside(config, enabled, wanted, now);
        side_step.unwrap_or_else(|| {
            if planned {
                (self.shield).detour(config, enabled, wanted, now, self.blocked)
            } else {
                (wanted, self.shield.allow(config, enabled, wanted, now))
            }
        })
    }

    /// Takes an echo: shield and fault detector hear it, and a complete ring becomes a decision.
    pub(super) fn echo(
        &mut self,
        config: &Config<SENSORS>,
        sensor: u8,
        echo: Echo,
    ) -> Outputs<SENSORS> {
        if let Some(age_ms) = self.stale_ms(config, echo.at) {
            return stale(age_ms);
        }
        let index = usize::from(sensor);
        if (self.scan.heard_at(index)).is_some_and(|heard| echo.at.is_before(heard)) {
            return stale(self.age_ms(echo.at));
        }
        if self.enabled(config).contains(index) {
            self.shield.hear(config, index, echo);
            self.heard_any |= echo.range.is_some();
        }
        let verdict = self.detector.update(config, sensor, echo.range);
        self.scan.hear(index, echo);
        let mut outputs = if self.moving {
            self.guard(config)
        } else if self.scan.is_complete(self.enabled(config)) {
            self.decide(config, echo.at)
        } else {
            Outputs::none()
        };
        outputs.verdict = verdict;
        outputs
    }

    /// The age of what was heard at `at`, milliseconds.
    fn age_ms(&self, at: Millis) -> u32 {
        self.now.after(at)
    }

    /// The age of an echo that is not to be used: it is too old, or was heard at another place.
    pub(crate) fn stale_ms(&self, config: &Config<SENSORS>, at: Millis) -> Option<u32> {
        let age_ms = self.age_ms(at);
        let is_of_elsewhere = !self.moving && at.is_before(self.waiting_since);
        (age_ms > patience_ms(config) || is_of_elsewhere).then_some(age_ms)
    }

    /// Shortens the motion under way where the newest echo asks for it.
    fn guard(&mut self, config: &Config<SENSORS>) -> Outputs<SENSORS> {
        let Some(pending) = &mut self.pending else {
            return Outputs::none();
        };
        let remaining = pending.remaining.now();
        let Some(allowed) = self.shield.shorten(config, remaining) else {
            return Outputs::none();
        };
        // A base that has overrun its target stands; it does not return.
        let left_mm = if pending.was_overrun() {
            0
        } else {
            allowed.distance_mm
        };
        let shorter = remaining.with_length(left_mm);
        pending.remaining = Tracked::new(shorter);
        let faster = Motion {
            id: self.motion_id,
            displacement: shorter,
            speed_mm_s: pending.speed_mm_s,
        };
        pending.speed_mm_s = allowed.speed_mm_s.min(pending.speed_mm_s);
        let motion = Motion {
            speed_mm_s: pending.speed_mm_s,
            ..faster
        };
        // Only by the time that the lower speed adds: an approaching obstacle must not postpone the
        // deadline without end.
        let slower_ms = motion.longest_ms().saturating_sub(faster.longest_ms());
        self.deadline = self.deadline.plus_ms(slower_ms);
        Outputs {
            motion: Some(motion),
            ..Outputs::none()
        }
    }

    /// Takes a report of the base.
    #[inline(never)]
    pub(super) fn odometry(
        &mut self,
        config: &Config<SENSORS>,
        at: Millis,
        motion: u16,
        moved: Displacement,
        turned: Bearing,
        progress: Progress,
    ) {
        if progress == Progress::Touched {
            self.detector.touched(config, moved);
        }
        self.detector.moved(config, moved, turned);
        self.shield.moved(moved, turned);
        self.course.turn(turned);
        let Some(pending) = &mut self.pending else {
            return;
        };
        let since_decision = if pending.turned == Bearing::ZERO {
            moved
        } else {
            moved.rotated(pending.turned.direction())
        };
        pending.executed = pending.executed.plus(since_decision);
        pending.remaining.go(moved, turned);
        pending.turned = pending.turned.plus(turned);
        if motion != self.motion_id || !self.moving {
            return;
        }
        match progress {
            Progress::Moving => {}
            Progress::Steering => self.allow_steering(config, at),
            Progress::Ended | Progress::Touched => {
                self.moving = false;
                self.await_ring(at);
            }
        }
    }

    /// Ends the motion under way before it began: nothing is learned from it.
    pub(crate) fn abandon_motion(&mut self, at: Millis) {
        self.pending = None;
        self.moving = false;
        self.acting_neuron = None;
        self.await_ring(at);
    }

    /// From now on every transducer has to be heard again.
    pub(crate) fn await_ring(&mut self, at: Millis) {
        self.scan.renew();
        self.waiting_since = at;
    }

    /// The order to stand.
    pub(super) const fn standing(&self) -> Motion {
        Motion {
            id: self.motion_id,
            displacement: Displacement::ZERO,
            speed_mm_s: 0,
        }
    }
}

/// An echo of this age was not used.
pub(crate) fn stale<const SENSORS: usize>(age_ms: u32) -> Outputs<SENSORS> {
    Outputs {
        stale_ms: Some(age_ms),
        ..Outputs::none()
    }
}
