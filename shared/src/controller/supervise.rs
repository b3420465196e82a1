//! Supervision: stops a robot that explores or seeks when a motion is overdue or transducers fall
//! silent.

use super::{Mode, Motion, Outputs, State, StopReason, patience_ms};
use crate::config::Config;
use crate::units::Millis;

/// Rings in a row without any echo after which the robot stops.
pub(crate) const SILENT_RINGS: u8 = 3;
/// Time a motion may take beyond twice its distance over its speed, milliseconds: a base that gains
/// 0.3 m/s in a second, as a Pioneer does, takes 0.8 s for 5 cm.
pub(crate) const SLACK_MS: u32 = 1_000;

impl Motion {
    /// The longest time it may take once the base rolls, milliseconds.
    pub(super) fn longest_ms(&self) -> u32 {
        let distance_mm = u32::from(self.displacement.length_mm());
        let speed_mm_s = u32::from(self.speed_mm_s.max(1));
        (2_000 * distance_mm / speed_mm_s).wrapping_add(SLACK_MS)
    }
}

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    State<SENSORS, NEURONS, SAMPLES>
{
    /// Stores the latest time. Ticks and commands carry the present time: if it lies far back, the
    /// clock was set back or has wrapped.
    pub(super) fn pass_time(&mut self, config: &Config<SENSORS>, at: Millis, is_present: bool) {
        if self.now.is_before(at) {
            self.now = at;
        } else if is_present && self.now.since(at) > patience_ms(config) {
            self.now = at;
            self.wait_anew(at);
        }
    }

    /// Whatever it waits for may take as long as if it had begun to wait now.
    fn wait_anew(&mut self, at: Millis) {
        self.deadline = at.plus_ms(SLACK_MS);
        self.await_ring(at);
    }

    /// Stops a robot whose motion is overdue, or one of whose transducers has not been heard for
    /// two ring periods.
    pub(super) fn supervise(&mut self, config: &Config<SENSORS>, at: Millis) -> Outputs<SENSORS> {
        match self.overdue(config, at) {
            Some(reason) => self.alarm(at, reason),
            None => Outputs::none(),
        }
    }

    /// A robot that got no ticks for so long that the next one would stop it waits anew: it was
    /// off, and perhaps carried elsewhere.
    pub(super) fn forgive_pause(&mut self, config: &Config<SENSORS>, at: Millis) {
        if self.overdue(config, at).is_some() {
            self.wait_anew(at);
        }
    }

    /// What the robot has waited for too long.
    fn overdue(&self, config: &Config<SENSORS>, at: Millis) -> Option<StopReason> {
        if self.moving && self.deadline.is_before(at) {
            return Some(StopReason::Overdue);
        }
        let is_late = at.after(self.waiting_since) > patience_ms(config);
        (is_late && self.lacks_echo(config, at)).then_some(StopReason::RingIncomplete)
    }

    /// A ring that is still awaited lacks an echo. During a motion each transducer has to be heard
    /// again and again.
    fn lacks_echo(&self, config: &Config<SENSORS>, at: Millis) -> bool {
        let is_late = |sensor: usize| {
            let heard = self.scan.heard_at(sensor);
            heard.is_none_or(|heard| at.after(heard) > patience_ms(config))
        };
        // A random move of a body that finds its sensors is listened to by the body alone.
        let is_heard_elsewhere = matches!(self.mode, Mode::Babble { .. });
        let falls_silent =
            !is_heard_elsewhere && self.enabled(config).indices(SENSORS).any(is_late);
        !self.moving || falls_silent
    }

    /// The base turns its wheels: the motion's time counts from now, unless this takes longer than
    /// it can.
    pub(super) fn allow_steering(&mut self, config: &Config<SENSORS>, at: Millis) {
        let is_possible = at.after(self.waiting_since) <= u32::from(config.robot.steer_ms);
        if let Some(pending) = self.pending.as_ref().filter(|_| is_possible) {
            let motion = Motion {
                id: self.motion_id,
                displacement: pending.remaining.now(),
                speed_mm_s: pending.speed_mm_s,
            };
            self.deadline = at.plus_ms(motion.longest_ms());
        }
    }

    /// Counts a complete ring that heard nothing. Returns whether these are too many in a row.
    pub(super) fn hears_nothing(&mut self) -> bool {
        let heard = core::mem::take(&mut self.heard_any);
        self.silent_rings = if heard {
            0
        } else {
            self.silent_rings.saturating_add(1)
        };
        self.silent_rings >= SILENT_RINGS && !self.open_space
    }

    /// Ends the motion under way: the next ring is awaited as after a motion the base has ended.
    #[inline(never)]
    pub(super) fn touched(&mut self, config: &Config<SENSORS>, at: Millis) -> Outputs<SENSORS> {
        if !self.moving {
            return Outputs::none();
        }
        if let Some(pending) = &self.pending {
            self.detector.touched(config, pending.remaining.now());
        }
        self.moving = false;
        self.await_ring(at);
        self.motion_id = self.motion_id.wrapping_add(1);
        Outputs {
            motion: Some(self.standing()),
            ..Outputs::none()
        }
    }
}
