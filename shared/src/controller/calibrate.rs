//! Modes of a body that finds where its sensors look. Its moves and readings are the body's; time
//! and alarms are supervised as in the other modes.

use super::{Mode, Motion, Outputs, State, StopReason};
use crate::config::Config;
use crate::units::{Displacement, Millis};

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    State<SENSORS, NEURONS, SAMPLES>
{
    /// Begins random moves of the body.
    pub(crate) fn begin_babble(&mut self, at: Millis, moves: u16) -> Outputs<SENSORS> {
        self.enter(at, Mode::Babble { left: moves })
    }

    /// One of the random moves, after which so many are left.
    pub(crate) fn babble(
        &mut self,
        config: &Config<SENSORS>,
        at: Millis,
        displacement: Displacement,
        left: u16,
    ) -> Motion {
        self.mode = Mode::Babble { left };
        self.motion_id = self.motion_id.wrapping_add(1);
        self.moving = true;
        let motion = Motion {
            id: self.motion_id,
            displacement,
            speed_mm_s: config.robot.speed_mm_s,
        };
        let turning_ms = u32::from(config.robot.steer_ms);
        self.deadline = at.plus_ms(turning_ms.saturating_add(motion.longest_ms()));
        motion
    }

    /// Takes a report that a motion is over.
    pub(crate) fn end_babble(&mut self, at: Millis, motion: u16) {
        if self.moving && motion == self.motion_id {
            self.moving = false;
            self.await_ring(at);
        }
    }

    /// The random moves are over: the body thinks.
    pub(crate) fn begin_calibration(&mut self, at: Millis) -> Outputs<SENSORS> {
        self.enter(at, Mode::Calibrate)
    }

    /// It knows where its sensors look, or has found none: what they heard did not change.
    pub(crate) fn end_calibration(&mut self, at: Millis, has_sensors: bool) -> Outputs<SENSORS> {
        let mode = if has_sensors {
            Mode::Idle
        } else {
            Mode::Stopped(StopReason::NoEchoes)
        };
        self.enter(at, mode)
    }
}
