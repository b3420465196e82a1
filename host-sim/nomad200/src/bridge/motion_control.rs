//! Executes a motion with the base's motors: steer at rest, then roll forwards or in reverse.

use super::Ended;
use super::events::position;
use crate::units::{M_PER_TENTH_INCH, RAD_PER_TENTH_DEGREE, whole};
use crate::{Host, NomadCommand, NomadReadings, RobotError};
use amp::controller::{Motion, Progress};
use amp::units::Displacement;
use arena::robot::BaseLimits;
use arena::world::{Point, wrap_angle};
use core::f64::consts::{FRAC_PI_2, PI};

/// Speed of steering and turret: the maximum.
const TURN_SPEED: u16 = 450;

/// A goal within this angle of the wheels needs no steering, rad.
const SAME_DIRECTION_RAD: f64 = PI / 180.0;

/// A motor that never reported running within this time by the robot's clock has arrived, ms.
const SETTLE_TIME_MS: u32 = 200;

/// Stage of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
enum MotionStage {
    #[default]
    Standing,
    /// Braking; then to the goal, if there is one.
    Braking(Option<Point>),
    Steering(Point),
    Rolling(Point),
}

/// The current motion.
#[derive(Debug, Default)]
pub(super) struct MotionControl {
    stage: MotionStage,
    /// Number of the latest motion.
    id: Option<u16>,
    /// The robot's time of the latest motor command, and whether the motors have run since.
    sent_ms: u32,
    has_run: bool,
    speed: u16,
    touched: bool,
}

impl MotionControl {
    /// Number of the current or last motion.
    pub(super) fn id(&self) -> Option<u16> {
        self.id
    }

    /// Whether the base prepares to roll, or still brakes. Braking takes 0.67 s from full speed,
    /// more than the controller allows for a motion without displacement.
    pub(super) fn is_steering(&self, state: &NomadReadings) -> bool {
        let [rolling, turning, _] = state.velocity;
        match self.stage {
            MotionStage::Steering(_) | MotionStage::Braking(Some(_)) => true,
            MotionStage::Rolling(_) => !self.has_run,
            MotionStage::Braking(None) => rolling != 0 || turning != 0,
            MotionStage::Standing => false,
        }
    }

    /// Begins or changes a motion to `goal`, m in the robot's frame. Zero displacement stops.
    pub(super) fn begin(
        &mut self,
        host: &mut Host,
        state: &NomadReadings,
        goal: Point,
        motion: &Motion,
    ) -> Result<(), RobotError> {
        // A motion that was cut off does not restart when the controller shortens it.
        if self.id == Some(motion.id)
            && matches!(
                self.stage,
                MotionStage::Standing | MotionStage::Braking(None)
            )
        {
            return Ok(());
        }
        self.id = Some(motion.id);
        self.touched &= self.stage != MotionStage::Standing;
        if motion.displacement == Displacement::ZERO || motion.speed_mm_s == 0 {
            return self.brake(host, state, None);
        }
        self.set_speed(host, motion.speed_mm_s)?;
        match self.stage {
            MotionStage::Standing => self.steer(host, state, goal),
            MotionStage::Steering(_) => {
                self.stage = MotionStage::Steering(goal);
                Ok(())
            }
            MotionStage::Braking(_) => {
                self.stage = MotionStage::Braking(Some(goal));
                Ok(())
            }
            MotionStage::Rolling(_) => self.change_goal(host, state, goal),
        }
    }

    /// Follows the motion; returns how it ended, if it has.
    pub(super) fn follow(
        &mut self,
        host: &mut Host,
        state: &NomadReadings,
    ) -> Result<Ended, RobotError> {
        let running = state.motors & 0b11 != 0 || state.velocity[0] != 0 || state.velocity[1] != 0;
        self.has_run |= running;
        let waited_ms = state.time_ms.wrapping_sub(self.sent_ms);
        if self.stage == MotionStage::Standing
            || running
            || !(self.has_run || waited_ms >= SETTLE_TIME_MS)
        {
            return Ok(None);
        }
        match self.stage {
            // Wheels that were stopped while steering are turned again.
            MotionStage::Braking(Some(goal)) | MotionStage::Steering(goal) => {
                self.steer(host, state, goal)?
            }
            MotionStage::Braking(None) | MotionStage::Rolling(_) | MotionStage::Standing => {
                self.stage = MotionStage::Standing
            }
        }
        let ended = match (self.stage, self.touched) {
            (MotionStage::Standing, true) => Some(Progress::Touched),
            (MotionStage::Standing, false) => Some(Progress::Ended),
            _ => None,
        };
        self.touched &= ended.is_none();
        Ok(ended)
    }

    /// A bumper was pressed.
    pub(super) fn touched(&mut self, host: &mut Host) -> Result<(), RobotError> {
        if self.stage == MotionStage::Standing {
            return Ok(());
        }
        self.touched = true;
        self.stage = MotionStage::Braking(None);
        host.request(&NomadCommand::Stop)?;
        Ok(())
    }

    /// The controller was silent for too long. Returns whether this stopped a motion.
    pub(super) fn expire(&mut self, host: &mut Host) -> Result<bool, RobotError> {
        if matches!(
            self.stage,
            MotionStage::Standing | MotionStage::Braking(None)
        ) {
            return Ok(false);
        }
        self.stage = MotionStage::Braking(None);
        host.request(&NomadCommand::Stop)?;
        Ok(true)
    }

    fn brake(
        &mut self,
        host: &mut Host,
        state: &NomadReadings,
        then: Option<Point>,
    ) -> Result<(), RobotError> {
        self.stage = MotionStage::Braking(then);
        self.send(host, state, &NomadCommand::Stop)
    }

    /// Turns the wheels towards the goal or away from it, whichever is the smaller turn. Rolls at
    /// once if they already point there.
    fn steer(
        &mut self,
        host: &mut Host,
        state: &NomadReadings,
        goal: Point,
    ) -> Result<(), RobotError> {
        let direction = (goal - position(&state.pose)).angle();
        let mut turn = wrap_angle(direction - steering(state));
        if turn.abs() > FRAC_PI_2 {
            turn -= if turn > 0.0 { PI } else { -PI };
        }
        if turn.abs() <= SAME_DIRECTION_RAD {
            return self.roll(host, state, goal);
        }
        // Within ±900.
        let units = whole(turn, RAD_PER_TENTH_DEGREE) as i16;
        self.stage = MotionStage::Steering(goal);
        self.send(host, state, &NomadCommand::Relative([0, units, 0]))
    }

    /// Rolls along the wheels up to the goal, never farther.
    fn roll(
        &mut self,
        host: &mut Host,
        state: &NomadReadings,
        goal: Point,
    ) -> Result<(), RobotError> {
        let along = (goal - position(&state.pose)).dot(Point::unit(steering(state)));
        // Rounded towards zero.
        let units = (along / M_PER_TENTH_INCH) as i16;
        if units == 0 {
            return self.brake(host, state, None);
        }
        self.stage = MotionStage::Rolling(goal);
        self.send(host, state, &NomadCommand::Relative([units, 0, 0]))
    }

    /// Changes the goal while rolling. Continues if the goal is ahead, beyond the braking distance;
    /// otherwise it brakes first.
    fn change_goal(
        &mut self,
        host: &mut Host,
        state: &NomadReadings,
        goal: Point,
    ) -> Result<(), RobotError> {
        let to_goal = (goal - position(&state.pose)).turned_back(Point::unit(steering(state)));
        let speed = f64::from(state.velocity[0]) * M_PER_TENTH_INCH;
        let ahead = to_goal.x * if speed < 0.0 { -1.0 } else { 1.0 };
        let stopping = speed * speed / (2.0 * BaseLimits::default().acceleration_m_s2);
        let aside = to_goal.y.abs() > ahead.abs() * SAME_DIRECTION_RAD + M_PER_TENTH_INCH;
        if speed == 0.0 || aside {
            self.brake(host, state, Some(goal))
        } else if ahead <= stopping {
            // Otherwise the base would return; the nearer position is safer.
            self.brake(host, state, None)
        } else {
            self.roll(host, state, goal)
        }
    }

    fn send(
        &mut self,
        host: &mut Host,
        state: &NomadReadings,
        command: &NomadCommand,
    ) -> Result<(), RobotError> {
        // A stopped motor has already ended; a commanded motion may not have begun.
        (self.sent_ms, self.has_run) = (state.time_ms, *command == NomadCommand::Stop);
        host.request(command).map(drop)
    }

    fn set_speed(&mut self, host: &mut Host, speed_mm_s: u16) -> Result<(), RobotError> {
        // Rounded down, but at least 1.
        let units = (f64::from(speed_mm_s) * 1e-3 / M_PER_TENTH_INCH) as u16;
        let speed = units.max(1);
        if speed != self.speed {
            host.request(&NomadCommand::Speeds([speed, TURN_SPEED, TURN_SPEED]))?;
            self.speed = speed;
        }
        Ok(())
    }
}

fn steering(state: &NomadReadings) -> f64 {
    f64::from(state.pose[2]) * RAD_PER_TENTH_DEGREE
}

#[cfg(test)]
mod tests;
