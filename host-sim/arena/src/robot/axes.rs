//! The base at its motors: translation, steering and turret, each with its own command.
//!
//! The axes run together: the robot rolls in arcs while it steers, and only its own motor turns the
//! turret. Each axis is a servo with a speed, an acceleration, and one of three tasks: hold, run at
//! a velocity, go to a position.

use super::chassis::Chassis;
use super::limits::{BaseLimits, NEGLIGIBLE};
use super::motion::Executed;
use super::servo::{Ramp, slow};
use super::time_steps::TimeSteps;
use crate::noise::Noise;
use crate::world::{Point, Pose, World, wrap_angle};

/// A motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Rolls the base along its wheels, m.
    Translation = 0,
    /// Turns the wheels, rad.
    Steering = 1,
    /// Turns the turret, rad.
    Turret = 2,
}

impl Axis {
    /// The three, in the order of the Nomad's commands.
    pub const ALL: [Self; 3] = [Self::Translation, Self::Steering, Self::Turret];
}

/// Greatest speed and acceleration of an axis (m or rad, and seconds).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisLimits {
    /// Speed.
    pub speed: f64,
    /// Acceleration.
    pub acceleration: f64,
}

impl AxisLimits {
    /// Those of a base, in the order of [`Axis::ALL`].
    #[must_use]
    pub fn of(limits: &BaseLimits) -> [Self; 3] {
        let turn = Self {
            speed: limits.turn_rate_rad_s,
            acceleration: limits.turn_acceleration_rad_s2,
        };
        let roll = Self {
            speed: limits.speed_m_s,
            acceleration: limits.acceleration_m_s2,
        };
        [roll, turn, turn]
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum ServoTask {
    Hold,
    Run(f64),
    GoTo(f64),
}

#[derive(Debug, Clone, PartialEq)]
struct Servo {
    limits: AxisLimits,
    /// As set, within the limits.
    set: AxisLimits,
    at: f64,
    rate: f64,
    task: ServoTask,
}

impl Servo {
    fn new(limits: AxisLimits) -> Self {
        Self {
            limits,
            set: limits,
            at: 0.0,
            rate: 0.0,
            task: ServoTask::Hold,
        }
    }

    fn is_active(&self) -> bool {
        self.rate != 0.0 || matches!(self.task, ServoTask::GoTo(_) | ServoTask::Run(_))
    }

    /// One time step: how far the axis should go. Its rate is that after the step, its position is
    /// not.
    fn step(&mut self, dt: f64) -> f64 {
        let a = self.set.acceleration;
        let (moved, rate) = match self.task {
            ServoTask::Hold => slow(self.rate, a, dt),
            ServoTask::Run(wanted) => {
                let next = wanted.clamp(self.rate - a * dt, self.rate + a * dt);
                ((self.rate + next) / 2.0 * dt, next)
            }
            ServoTask::GoTo(goal) => {
                let left = goal - self.at;
                let (moved, rate) = Ramp::new(self.set.speed, a, dt).approach(left, self.rate);
                if rate == 0.0 && (left - moved).abs() <= NEGLIGIBLE {
                    self.task = ServoTask::Hold;
                }
                (moved, rate)
            }
        };
        self.rate = rate;
        moved
    }

    fn stop_dead(&mut self) {
        self.rate = 0.0;
        self.task = ServoTask::Hold;
    }
}

/// The three axes and the body they move.
#[derive(Debug, Clone, PartialEq)]
pub struct Axes {
    servos: [Servo; 3],
    chassis: Chassis,
    /// Bearing at which steering and turret stand at 0.
    front: f64,
    slip: f64,
    bumpers: u32,
    /// The wheels do not roll, whatever their motor does.
    blocked: bool,
}

impl Axes {
    /// A base at rest, all axes at 0: wheels, turret and front along the pose's heading.
    #[must_use]
    pub fn new(pose: Pose, limits: &BaseLimits) -> Self {
        Self {
            servos: AxisLimits::of(limits).map(Servo::new),
            chassis: Chassis::new(pose),
            front: pose.heading,
            slip: limits.slip,
            bumpers: 0,
            blocked: false,
        }
    }

    /// True position and bearing of the turret.
    #[must_use]
    pub fn pose(&self) -> Pose {
        let bearing = wrap_angle(self.front + self.at(Axis::Turret));
        Pose::new(self.chassis.position, bearing)
    }

    /// Where an axis stands: m rolled in all, or rad, not wrapped.
    #[must_use]
    pub fn at(&self, axis: Axis) -> f64 {
        self.servos[axis as usize].at
    }

    /// How fast it runs.
    #[must_use]
    pub fn rate(&self, axis: Axis) -> f64 {
        self.servos[axis as usize].rate
    }

    /// Speed of its moves and acceleration, as set.
    #[must_use]
    pub fn set(&self, axis: Axis) -> AxisLimits {
        self.servos[axis as usize].set
    }

    /// Whether it runs or is about to.
    #[must_use]
    pub fn is_active(&self, axis: Axis) -> bool {
        self.servos[axis as usize].is_active()
    }

    /// Bit i: switch i is pressed; it stays so until the base rolls away.
    #[must_use]
    pub fn bumpers(&self) -> u32 {
        self.bumpers
    }

    /// Sets the speed of moves, at most the limit.
    pub fn set_speed(&mut self, axis: Axis, speed: f64) {
        let servo = &mut self.servos[axis as usize];
        servo.set.speed = speed.clamp(0.0, servo.limits.speed);
    }

    /// Sets the acceleration, at most the limit. Without any, an axis could never stop: 0 stands
    /// for the limit.
    pub fn set_acceleration(&mut self, axis: Axis, acceleration: f64) {
        let servo = &mut self.servos[axis as usize];
        servo.set.acceleration = if acceleration > 0.0 {
            acceleration.min(servo.limits.acceleration)
        } else {
            servo.limits.acceleration
        };
    }

    /// From now on the wheels do not roll: their motor runs against them without effect.
    pub fn block_wheels(&mut self) {
        self.blocked = true;
    }

    /// Brakes to rest and holds.
    pub fn hold(&mut self, axis: Axis) {
        self.servos[axis as usize].task = ServoTask::Hold;
    }

    /// Runs at a velocity, at most the limit. What the wheels slip is drawn from `noise` when they
    /// begin to roll.
    pub fn run(&mut self, axis: Axis, velocity: f64, noise: &mut Noise) {
        self.begin(axis, noise);
        let servo = &mut self.servos[axis as usize];
        let most = servo.limits.speed;
        servo.task = if velocity == 0.0 {
            ServoTask::Hold
        } else {
            ServoTask::Run(velocity.clamp(-most, most))
        };
    }

    /// Goes to a position, at the set speed; nowhere if that is 0.
    pub fn go_to(&mut self, axis: Axis, goal: f64, noise: &mut Noise) {
        self.begin(axis, noise);
        let servo = &mut self.servos[axis as usize];
        servo.task = if servo.set.speed > 0.0 {
            ServoTask::GoTo(goal)
        } else {
            ServoTask::Hold
        };
    }

    fn begin(&mut self, axis: Axis, noise: &mut Noise) {
        if axis == Axis::Translation && self.rate(axis) == 0.0 {
            self.chassis.slip(self.slip, noise);
        }
    }

    /// Advances the time by `dt_s` seconds. Returns what the base did, and the way rolled as the
    /// odometry counts it: a displacement in the frame in which steering 0 is along x.
    pub fn advance(&mut self, dt_s: f64, world: &World) -> (Executed, Point) {
        let mut done = Executed::nothing_yet();
        let mut counted = Point::default();
        let time = TimeSteps::of(dt_s);
        for _ in 0..time.steps {
            counted = counted + self.step(time.step_s, world, &mut done);
        }
        self.chassis.tell_gap(world, &mut done);
        done.moving = Axis::ALL.into_iter().any(|axis| self.is_active(axis));
        (done, counted)
    }

    fn step(&mut self, dt: f64, world: &World, done: &mut Executed) -> Point {
        let [way, turned, turret] = self.servos.each_mut().map(|servo| servo.step(dt));
        let [translation, steering, ring] = &mut self.servos;
        let way = if self.blocked {
            translation.rate = 0.0;
            0.0
        } else {
            way
        };
        ring.at += turret;
        // An arc is rolled as its chord.
        let along = steering.at + turned / 2.0;
        steering.at += turned;
        if way == 0.0 {
            return Point::default();
        }
        let mut rolled = Executed {
            min_clearance_m: done.min_clearance_m,
            ..Executed::nothing_yet()
        };
        let count = self
            .chassis
            .roll(way, Point::unit(self.front + along), world, &mut rolled);
        translation.at += count;
        self.bumpers = rolled.bumpers;
        if rolled.touched {
            translation.stop_dead();
        }
        done.touched |= rolled.touched;
        done.bumpers |= rolled.bumpers;
        done.traveled_m += rolled.traveled_m;
        done.min_clearance_m = rolled.min_clearance_m;
        Point::unit(along) * count
    }
}

#[cfg(test)]
mod tests;
