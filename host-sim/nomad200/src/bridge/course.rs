//! A motion of the mind as commands to the three motors: steer at rest, forwards or in reverse, then roll.

use super::Ended;
use super::feed::position;
use crate::units::{M_PER_TENTH_INCH, RAD_PER_TENTH_DEGREE, whole};
use crate::{Command, Host, RobotError, State};
use amp::controller::{Motion, Progress};
use amp::units::Displacement;
use arena::robot::BaseLimits;
use arena::world::{Point, wrap_angle};
use core::f64::consts::{FRAC_PI_2, PI};

/// Speed of steering and turret: the greatest.
const TURN_SPEED: u16 = 450;

/// A goal to the side of the wheels by no more than this is rolled to as it is, rad.
const SAME_DIRECTION_RAD: f64 = PI / 180.0;

/// A motor that has not been seen to run after this time by the robot's clock has already arrived, ms.
const SETTLED_MS: u32 = 200;

/// What the base is at.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
enum Leg {
    #[default]
    Standing,
    /// Coming to rest; then on to the goal, if there is one.
    Braking(Option<Point>),
    Steering(Point),
    Rolling(Point),
}

/// The motion under way.
#[derive(Debug, Default)]
pub(super) struct Course {
    leg: Leg,
    /// Number of the latest motion.
    id: Option<u16>,
    /// Robot's time of the latest command to the motors, and whether they have been seen to run since.
    sent_ms: u32,
    seen_running: bool,
    speed: u16,
    touched: bool,
}

impl Course {
    /// Number of the motion that is carried out or was last.
    pub(super) fn id(&self) -> Option<u16> {
        self.id
    }

    /// Whether the base has a goal and has not been seen to roll to it yet, or is told to stand and still comes to rest:
    /// that takes 0.67 s from full speed, and a motion without any way left would be given 0.5 s.
    pub(super) fn is_steering(&self, state: &State) -> bool {
        let [rolling, turning, _] = state.velocity;
        match self.leg {
            Leg::Steering(_) | Leg::Braking(Some(_)) => true,
            Leg::Rolling(_) => !self.seen_running,
            Leg::Braking(None) => rolling != 0 || turning != 0,
            Leg::Standing => false,
        }
    }

    /// Begins a motion to `goal` (in the robot's frame, m), or changes the one under way; no displacement stops.
    pub(super) fn begin(
        &mut self,
        host: &mut Host,
        state: &State,
        goal: Point,
        motion: &Motion,
    ) -> Result<(), RobotError> {
        // A motion that was cut off for another reason is not taken up again by its own shortening.
        if self.id == Some(motion.id) && matches!(self.leg, Leg::Standing | Leg::Braking(None)) {
            return Ok(());
        }
        self.id = Some(motion.id);
        self.touched &= self.leg != Leg::Standing;
        if motion.displacement == Displacement::ZERO || motion.speed_mm_s == 0 {
            return self.brake(host, state, None);
        }
        self.set_speed(host, motion.speed_mm_s)?;
        match self.leg {
            Leg::Standing => self.steer(host, state, goal),
            Leg::Steering(_) => {
                self.leg = Leg::Steering(goal);
                Ok(())
            }
            Leg::Braking(_) => {
                self.leg = Leg::Braking(Some(goal));
                Ok(())
            }
            Leg::Rolling(_) => self.roll_on(host, state, goal),
        }
    }

    /// Looks at where the base is with its motion; says how that ended when it has.
    pub(super) fn follow(&mut self, host: &mut Host, state: &State) -> Result<Ended, RobotError> {
        let running = state.motors & 0b11 != 0 || state.velocity[0] != 0 || state.velocity[1] != 0;
        self.seen_running |= running;
        let waited_ms = state.time_ms.wrapping_sub(self.sent_ms);
        if self.leg == Leg::Standing || running || !(self.seen_running || waited_ms >= SETTLED_MS) {
            return Ok(None);
        }
        match self.leg {
            // Wheels that were stopped on their way are turned again.
            Leg::Braking(Some(goal)) | Leg::Steering(goal) => self.steer(host, state, goal)?,
            Leg::Braking(None) | Leg::Rolling(_) | Leg::Standing => self.leg = Leg::Standing,
        }
        let ended = match (self.leg, self.touched) {
            (Leg::Standing, true) => Some(Progress::Touched),
            (Leg::Standing, false) => Some(Progress::Ended),
            _ => None,
        };
        self.touched &= ended.is_none();
        Ok(ended)
    }

    /// A bumper has been pressed.
    pub(super) fn touched(&mut self, host: &mut Host) -> Result<(), RobotError> {
        if self.leg == Leg::Standing {
            return Ok(());
        }
        self.touched = true;
        self.leg = Leg::Braking(None);
        host.ask(&Command::Stop)?;
        Ok(())
    }

    /// The mind has been silent for too long. Returns whether that stopped anything.
    pub(super) fn expire(&mut self, host: &mut Host) -> Result<bool, RobotError> {
        if matches!(self.leg, Leg::Standing | Leg::Braking(None)) {
            return Ok(false);
        }
        self.leg = Leg::Braking(None);
        host.ask(&Command::Stop)?;
        Ok(true)
    }

    fn brake(
        &mut self,
        host: &mut Host,
        state: &State,
        then: Option<Point>,
    ) -> Result<(), RobotError> {
        self.leg = Leg::Braking(then);
        self.send(host, state, &Command::Stop)
    }

    /// Turns the wheels towards the goal, or away from it where that is the shorter turn; rolls at once if they look
    /// there already.
    fn steer(&mut self, host: &mut Host, state: &State, goal: Point) -> Result<(), RobotError> {
        let way = goal - position(&state.pose);
        let mut turn = wrap_angle(way.angle() - steering(state));
        if turn.abs() > FRAC_PI_2 {
            turn -= if turn > 0.0 { PI } else { -PI };
        }
        if turn.abs() <= SAME_DIRECTION_RAD {
            return self.roll(host, state, goal);
        }
        // Within ±900.
        let units = whole(turn, RAD_PER_TENTH_DEGREE) as i16;
        self.leg = Leg::Steering(goal);
        self.send(host, state, &Command::Relative([0, units, 0]))
    }

    /// Rolls along the wheels as far as the goal, never farther.
    fn roll(&mut self, host: &mut Host, state: &State, goal: Point) -> Result<(), RobotError> {
        let along = (goal - position(&state.pose)).dot(Point::unit(steering(state)));
        // Towards zero.
        let units = (along / M_PER_TENTH_INCH) as i16;
        if units == 0 {
            return self.brake(host, state, None);
        }
        self.leg = Leg::Rolling(goal);
        self.send(host, state, &Command::Relative([units, 0, 0]))
    }

    /// Another goal while it rolls: ahead and beyond the way it needs to stop, it rolls on to it, else it stops first.
    fn roll_on(&mut self, host: &mut Host, state: &State, goal: Point) -> Result<(), RobotError> {
        let way = (goal - position(&state.pose)).turned_back(Point::unit(steering(state)));
        let speed = f64::from(state.velocity[0]) * M_PER_TENTH_INCH;
        let ahead = way.x * if speed < 0.0 { -1.0 } else { 1.0 };
        let stopping = speed * speed / (2.0 * BaseLimits::default().acceleration_m_s2);
        let aside = way.y.abs() > ahead.abs() * SAME_DIRECTION_RAD + M_PER_TENTH_INCH;
        if speed == 0.0 || aside {
            self.brake(host, state, Some(goal))
        } else if ahead <= stopping {
            // It would come back: nearer is safer.
            self.brake(host, state, None)
        } else {
            self.roll(host, state, goal)
        }
    }

    fn send(
        &mut self,
        host: &mut Host,
        state: &State,
        command: &Command,
    ) -> Result<(), RobotError> {
        // Whoever was told to stop and stands has stopped; whoever was told to move may not have begun.
        (self.sent_ms, self.seen_running) = (state.time_ms, *command == Command::Stop);
        host.ask(command).map(drop)
    }

    fn set_speed(&mut self, host: &mut Host, speed_mm_s: u16) -> Result<(), RobotError> {
        // Rounded down, but never to none.
        let units = (f64::from(speed_mm_s) * 1e-3 / M_PER_TENTH_INCH) as u16;
        let speed = units.max(1);
        if speed != self.speed {
            host.ask(&Command::Speeds([speed, TURN_SPEED, TURN_SPEED]))?;
            self.speed = speed;
        }
        Ok(())
    }
}

fn steering(state: &State) -> f64 {
    f64::from(state.pose[2]) * RAD_PER_TENTH_DEGREE
}

#[cfg(test)]
mod tests;
