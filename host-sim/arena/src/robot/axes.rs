//! The base with separate commands for its motors: translation, steering and turret.
//!
//! The axes move simultaneously: the robot rolls in arcs while it steers, and only its own motor
//! turns the turret. Each axis is a servo with a speed, an acceleration, and one of three tasks:
//! hold, run at a velocity, go to a position.

use super::chassis::Chassis;
use super::limits::{BaseLimits, NEGLIGIBLE};
use super::motion::Executed;
use super::servo::{Ramp, brake};
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
    /// All axes, in the order of the Nomad's commands.
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
    /// Limits of a base, in the order of [`Axis::ALL`].
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
    /// Commanded speed and acceleration, within the limits.
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

    /// Computes one time step: updates the rate and returns the displacement. The caller updates
    /// the position.
    fn step(&mut self, dt: f64) -> f64 {
        let a = self.set.acceleration;
        let (moved, rate) = match self.task {
            ServoTask::Hold => brake(self.rate, a, dt),
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

    fn stop_at_once(&mut self) {
        self.rate = 0.0;
        self.task = ServoTask::Hold;
    }
}

/// The three axes and the body that they move.
#[derive(Debug, Clone, PartialEq)]
pub struct Axes {
    servos: [Servo; 3],
    chassis: Chassis,
    /// Bearing of steering and turret at position 0.
    front: f64,
    slip: f64,
    bumpers: u32,
    /// The wheels are blocked: their motor has no effect.
    blocked: bool,
}

impl Axes {
    /// A base at rest, all axes at 0: wheels, turret and front along the pose's heading.
    #[must_use]
    pub fn new(pose: Pose, limits: &BaseLimits) -> Self {
        Self {
            servos: AxisLimits::of(limits).map(Servo::new),
            chassis: Chassis::new(pose, limits.radius_m),
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

    /// Position of an axis: total m rolled, or rad, not wrapped.
    #[must_use]
    pub fn at(&self, axis: Axis) -> f64 {
        self.servos[axis as usize].at
    }

    /// Velocity of an axis.
    #[must_use]
    pub fn rate(&self, axis: Axis) -> f64 {
        self.servos[axis as usize].rate
    }

    /// Commanded speed and acceleration of an axis.
    #[must_use]
    pub fn set(&self, axis: Axis) -> AxisLimits {
        self.servos[axis as usize].set
    }

    /// Whether an axis moves or has a task to move.
    #[must_use]
    pub fn is_active(&self, axis: Axis) -> bool {
        self.servos[axis as usize].is_active()
    }

    /// Bit i: bumper switch i is pressed. It stays pressed until the base rolls away.
    #[must_use]
    pub fn bumpers(&self) -> u32 {
        self.bumpers
    }

    /// Sets the speed of moves, at most the limit.
    pub fn set_speed(&mut self, axis: Axis, speed: f64) {
        let servo = &mut self.servos[axis as usize];
        servo.set.speed = speed.clamp(0.0, servo.limits.speed);
    }

    /// Sets the acceleration, at most the limit. 0 sets the limit, because an axis without
    /// acceleration could not stop.
    pub fn set_acceleration(&mut self, axis: Axis, acceleration: f64) {
        let servo = &mut self.servos[axis as usize];
        servo.set.acceleration = if acceleration > 0.0 {
            acceleration.min(servo.limits.acceleration)
        } else {
            servo.limits.acceleration
        };
    }

    /// Blocks the wheels from now on: their motor has no effect.
    pub fn block_wheels(&mut self) {
        self.blocked = true;
    }

    /// Brakes to rest and holds.
    pub fn hold(&mut self, axis: Axis) {
        self.servos[axis as usize].task = ServoTask::Hold;
    }

    /// Runs at a velocity, at most the limit. When the wheels begin to roll, their slip is drawn
    /// from
    /// `noise`.
    pub fn run(&mut self, axis: Axis, velocity: f64, noise: &mut Noise) {
        self.begin(axis, noise);
        let servo = &mut self.servos[axis as usize];
        let max_speed = servo.limits.speed;
        servo.task = if velocity == 0.0 {
            ServoTask::Hold
        } else {
            ServoTask::Run(velocity.clamp(-max_speed, max_speed))
        };
    }

    /// Goes to a position at the commanded speed; holds if that is 0.
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
            self.chassis.draw_slip(self.slip, noise);
        }
    }

    /// Advances the time by `dt_s` seconds. Returns the motion, and the displacement in odometry,
    /// in the frame in which steering 0 points along x.
    pub fn advance(&mut self, dt_s: f64, world: &World) -> (Executed, Point) {
        let mut done = Executed::none();
        let mut counted = Point::default();
        let time = TimeSteps::new(dt_s);
        for _ in 0..time.steps {
            counted = counted + self.step(time.step_s, world, &mut done);
        }
        self.chassis.report_gap(world, &mut done);
        done.moving = Axis::ALL.into_iter().any(|axis| self.is_active(axis));
        (done, counted)
    }

    fn step(&mut self, dt: f64, world: &World, done: &mut Executed) -> Point {
        let [distance, turned, turret] = self.servos.each_mut().map(|servo| servo.step(dt));
        let [translation, steering, ring] = &mut self.servos;
        let distance = if self.blocked {
            translation.rate = 0.0;
            0.0
        } else {
            distance
        };
        ring.at += turret;
        // Approximates the arc by its chord.
        let bearing = steering.at + turned / 2.0;
        steering.at += turned;
        if distance == 0.0 {
            return Point::default();
        }
        let mut rolled = Executed {
            min_clearance_m: done.min_clearance_m,
            ..Executed::none()
        };
        let count = self.chassis.roll(
            distance,
            Point::unit(self.front + bearing),
            world,
            &mut rolled,
        );
        translation.at += count;
        self.bumpers = rolled.bumpers;
        if rolled.touched {
            translation.stop_at_once();
        }
        done.touched |= rolled.touched;
        done.bumpers |= rolled.bumpers;
        done.traveled_m += rolled.traveled_m;
        done.min_clearance_m = rolled.min_clearance_m;
        Point::unit(bearing) * count
    }
}

#[cfg(test)]
mod tests;
