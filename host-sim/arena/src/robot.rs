//! The base of a Nomad 200: three wheels that roll and steer together, and a turret of its own.
//!
//! [`Base::move_exactly`] moves it at once and without noise; [`Base::command`] and
//! [`Base::advance`] as the machine does, with limited speed and acceleration and with slip.
//! Steering turns the wheels alone. The turret with the ring keeps its bearing (*held*) or turns
//! with the wheels (*follow*).

use core::f64::consts::PI;

use crate::direction::CachedDirection;
use crate::noise::Noise;
use crate::world::{Point, Pose, World, wrap_angle};

mod axes;
mod chassis;
mod limits;
mod motion;
mod servo;
mod steering;
mod time_steps;

pub use axes::{Axes, Axis, AxisLimits};
use chassis::{Chassis, RollingWay, share_of};
use limits::NEGLIGIBLE;
pub use limits::{BaseLimits, TurretMode};
pub use motion::{BaseMotion, Executed};
use servo::{Ramp, STEPS_PER_STRIDE, TravelLeft, sense, slow};
use steering::{SteeringWay, angle_to_turn, is_wrapped};
use time_steps::TimeSteps;

pub use crate::nomad::{BUMPERS, COLLISION_RADIUS_M};

/// A new goal this near to the line on which the wheels already roll is reached without stopping,
/// rad.
const SAME_DIRECTION_RAD: f64 = PI / 180.0;

/// A displacement repeated in whole millimeters may differ by this, m.
const ROUNDING_M: f64 = 2e-3;

/// What the wheels are doing.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Drive {
    Still,
    /// Coming to rest, then on to the goal (odometry frame) if there is one.
    Brake(Option<Point>),
    /// Turning the wheels at rest towards the goal, which lies at this bearing, rad.
    Steer(Point, f64),
    /// Rolling along the wheels to the goal.
    Roll(Point),
}

/// The base: where it is, where its wheels and its turret point, and what it is doing.
#[derive(Debug, Clone, PartialEq)]
pub struct Base {
    limits: BaseLimits,
    turret: TurretMode,
    chassis: Chassis,
    steering: CachedDirection,
    ring: CachedDirection,
    drive: Drive,
    speed_limit: f64,
    /// Along the wheels; negative in reverse.
    speed: f64,
    turn_rate: f64,
    /// Of the last time that passed.
    time_steps: TimeSteps,
}

impl Base {
    /// A base at rest: wheels, turret and front along the pose's heading.
    #[must_use]
    pub fn new(pose: Pose, limits: BaseLimits, turret: TurretMode) -> Self {
        Self {
            limits,
            turret,
            chassis: Chassis::new(pose),
            steering: CachedDirection::new(pose.heading),
            ring: CachedDirection::new(pose.heading),
            drive: Drive::Still,
            speed_limit: limits.speed_m_s,
            speed: 0.0,
            turn_rate: 0.0,
            time_steps: TimeSteps::of(0.0),
        }
    }

    /// True position and bearing of the ring.
    #[must_use]
    pub fn pose(&self) -> Pose {
        Pose::new(self.chassis.position, self.ring.angle())
    }

    /// Direction in which the wheels roll forward, in the world, rad.
    #[must_use]
    pub fn steering(&self) -> f64 {
        self.steering.angle()
    }

    /// Where the odometry believes to be, m: the truth without slip, from the same start.
    #[must_use]
    pub fn odometry(&self) -> Point {
        self.chassis.odometry
    }

    /// Direction of travel relative to the ring, rad in [−π, π).
    #[must_use]
    pub fn heading_in_ring(&self) -> f64 {
        let reverse = if self.speed < 0.0 { PI } else { 0.0 };
        wrap_angle(self.steering.angle() + reverse - self.ring.angle())
    }

    /// Speed along the wheels, m/s; negative in reverse.
    #[must_use]
    pub fn speed_m_s(&self) -> f64 {
        self.speed
    }

    /// Whether the base is under way.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        self.drive != Drive::Still
    }

    /// Whether the base brakes or turns its wheels before it rolls to its goal, or its wheels still
    /// turn after a stop.
    #[must_use]
    pub fn is_steering(&self) -> bool {
        matches!(self.drive, Drive::Brake(Some(_)) | Drive::Steer(..)) || self.turn_rate != 0.0
    }

    /// Gaps between disc and surfaces of `gap_m` m or more may be reported as infinite from now on.
    pub fn tell_gaps_below(&mut self, gap_m: f64) {
        self.chassis.tell_gaps_below(gap_m);
    }

    /// Moves at once by (`dx_m`, `dy_m`) in the ring frame, straight, up to the first touch. In
    /// [`TurretMode::Follow`] the ring then looks where the motion went.
    pub fn move_exactly(&mut self, world: &World, dx_m: f64, dy_m: f64) -> Executed {
        let asked = Point::new(dx_m, dy_m);
        let length = asked.length();
        let (from, ring_before) = (self.chassis.position, self.ring.unit());
        let sweep = self.chassis.sweep(asked.turned(ring_before), world);
        let share = share_of(&sweep, length);
        let done = asked * share;
        self.chassis.position = from + done.turned(ring_before);
        self.chassis.odometry = self.chassis.odometry + done.turned(ring_before);
        if length > 0.0 {
            self.point_wheels(asked);
        }
        Executed {
            touched: sweep.touched(),
            bumpers: self.chassis.bumpers_at(&sweep),
            moving: false,
            traveled_m: sweep.traveled_m,
            min_clearance_m: sweep.min_clearance_m,
        }
    }

    /// Points the wheels, and a following turret, along a displacement in the ring frame at once.
    fn point_wheels(&mut self, displacement: Point) {
        let bearing = displacement.angle();
        self.steering.set(wrap_angle(self.ring.angle() + bearing));
        if self.turret == TurretMode::Follow {
            self.ring = self.steering;
        }
    }

    /// Starts a timed motion, which replaces the present one. Slip is drawn from `noise`.
    ///
    /// * A displacement of zero brakes to a stop.
    /// * A base that already rolls towards the new goal keeps rolling; it may pass the goal by 1°
    ///   of the way left and 2 mm. Where it cannot stop before the goal, it stops for good.
    /// * Wheels that turn at rest keep turning, to the new bearing.
    /// * Otherwise the base stops first.
    pub fn command(&mut self, motion: BaseMotion, noise: &mut Noise) {
        self.chassis.slip(self.limits.slip, noise);
        let asked = Point::new(motion.dx_m, motion.dy_m);
        let finite = asked.x.is_finite() && asked.y.is_finite() && motion.speed_m_s.is_finite();
        if !finite || asked.length() <= NEGLIGIBLE || motion.speed_m_s <= 0.0 {
            self.drive = Drive::Brake(None);
            return;
        }
        self.speed_limit = motion.speed_m_s.min(self.limits.speed_m_s);
        let goal = self.chassis.odometry + asked.turned(self.ring.unit());
        let stopping = self.speed * self.speed / (2.0 * self.limits.acceleration_m_s2);
        self.drive = match self.ahead(goal) {
            _ if matches!(self.drive, Drive::Steer(..)) => self.steered(goal),
            // It would come back.
            Some(ahead) if ahead <= stopping => Drive::Brake(None),
            Some(_) => Drive::Roll(goal),
            None => Drive::Brake(Some(goal)),
        };
    }

    /// How far ahead a goal lies to which the wheels already roll.
    fn ahead(&mut self, goal: Point) -> Option<f64> {
        let way = (goal - self.chassis.odometry).turned_back(self.steering.unit());
        let ahead = way.x * self.speed.signum();
        let aside = way.y.abs() > ahead.abs() * SAME_DIRECTION_RAD + ROUNDING_M;
        (self.speed != 0.0 && ahead > -ROUNDING_M && !aside).then_some(ahead)
    }

    /// Advances the time by `dt_s` seconds.
    pub fn advance(&mut self, dt_s: f64, world: &World) -> Executed {
        let mut done = Executed::nothing_yet();
        if dt_s != self.time_steps.whole_s {
            self.time_steps = TimeSteps::of(dt_s);
        }
        let (mut steps, step_s) = (self.time_steps.steps, self.time_steps.step_s);
        while steps > 0 && self.is_moving() {
            steps -= if steps >= STEPS_PER_STRIDE as u32 && self.stride(step_s, world, &mut done) {
                STEPS_PER_STRIDE as u32
            } else {
                self.step(step_s, world, &mut done);
                1
            };
        }
        self.chassis.tell_gap(world, &mut done);
        Executed {
            moving: self.is_moving(),
            ..done
        }
    }

    /// Takes a whole stride, if its steps are plain ones; does nothing if not.
    fn stride(&mut self, dt: f64, world: &World, done: &mut Executed) -> bool {
        match self.drive {
            Drive::Still | Drive::Brake(_) => false,
            Drive::Steer(_, bearing) => self.stride_steering(bearing, dt),
            Drive::Roll(goal) => self.stride_rolling(goal, dt, world, done),
        }
    }

    fn step(&mut self, dt: f64, world: &World, done: &mut Executed) {
        match self.drive {
            Drive::Still => {}
            Drive::Brake(goal) => self.brake(goal, dt, world, done),
            Drive::Steer(goal, bearing) => self.steer(goal, bearing, dt),
            Drive::Roll(goal) => {
                let way = (goal - self.chassis.odometry).dot(self.steering.unit());
                let (moved, speed) = self.rolling(dt).approach(way, self.speed);
                self.speed = speed;
                self.roll(moved, world, done);
                let arrived = speed == 0.0 && (way - moved).abs() <= NEGLIGIBLE;
                if arrived && self.drive != Drive::Still {
                    self.drive = Drive::Still;
                }
            }
        }
    }

    /// How fast the wheels roll.
    fn rolling(&self, dt: f64) -> Ramp {
        Ramp::new(self.speed_limit, self.limits.acceleration_m_s2, dt)
    }

    /// How fast they are turned.
    fn turning(&self, dt: f64) -> Ramp {
        let limits = &self.limits;
        Ramp::new(limits.turn_rate_rad_s, limits.turn_acceleration_rad_s2, dt)
    }

    /// Rolls a stride, mirrored if it leads backward: a sign does not change how numbers are
    /// rounded.
    fn stride_rolling(&mut self, goal: Point, dt: f64, world: &World, done: &mut Executed) -> bool {
        let wheels = self.steering.unit();
        let mut line = RollingWay {
            goal,
            wheels,
            odometry: self.chassis.odometry,
        };
        let sign = sense(self.speed, line.left());
        line.wheels = wheels * sign;
        let Some(stride) = self.rolling(dt).stride(line, self.speed * sign) else {
            return false;
        };
        self.speed = stride.velocity * sign;
        if !self.chassis.take(&stride, world, done) {
            for way in stride.ways {
                self.roll(way * sign, world, done);
                if self.drive == Drive::Still {
                    break;
                }
            }
        }
        true
    }

    /// Slows wheels and steering down; once both rest, heads for the goal.
    fn brake(&mut self, goal: Option<Point>, dt: f64, world: &World, done: &mut Executed) {
        let (turned, rate) = slow(self.turn_rate, self.limits.turn_acceleration_rad_s2, dt);
        self.turn_rate = rate;
        self.turn(turned);
        let (moved, speed) = slow(self.speed, self.limits.acceleration_m_s2, dt);
        self.speed = speed;
        self.roll(moved, world, done);
        if self.drive == Drive::Still || self.speed != 0.0 || self.turn_rate != 0.0 {
            return;
        }
        let goal = goal.filter(|goal| goal.distance(self.chassis.odometry) > NEGLIGIBLE);
        self.drive = goal.map_or(Drive::Still, |goal| self.steered(goal));
    }

    /// The wheels turn at rest until they look at a goal.
    fn steered(&self, goal: Point) -> Drive {
        Drive::Steer(goal, (goal - self.chassis.odometry).angle())
    }

    /// Turns the wheels at rest.
    fn steer(&mut self, goal: Point, bearing: f64, dt: f64) {
        let left = angle_to_turn(self.turret, bearing, self.steering.angle());
        let (turned, turn_rate) = self.turning(dt).approach(left, self.turn_rate);
        self.turn_rate = turn_rate;
        self.turn(turned);
        if turn_rate == 0.0 && (left - turned).abs() <= NEGLIGIBLE {
            self.drive = Drive::Roll(goal);
        }
    }

    /// Turns the wheels by a stride, mirrored likewise, unless an angle wraps on the way.
    fn stride_steering(&mut self, bearing: f64, dt: f64) -> bool {
        let wheels = self.steering.angle();
        let left = angle_to_turn(self.turret, bearing, wheels);
        let sign = sense(self.turn_rate, left);
        let turn = SteeringWay {
            bearing: bearing * sign,
            halves: (bearing - wheels - left) * sign,
            wheels: wheels * sign,
        };
        let Some(stride) = self.turning(dt).stride(turn, self.turn_rate * sign) else {
            return false;
        };
        let end = stride.end.wheels * sign;
        let same = angle_to_turn(self.turret, bearing, end) == stride.end.left() * sign;
        if !(same && is_wrapped(wheels) && is_wrapped(end)) {
            return false;
        }
        self.steering.set(end);
        if self.turret == TurretMode::Follow {
            let turned = |ring, way| wrap_angle(ring + way * sign);
            self.ring
                .set(stride.ways.into_iter().fold(self.ring.angle(), turned));
        }
        self.turn_rate = stride.velocity * sign;
        true
    }

    fn turn(&mut self, angle: f64) {
        self.steering.set(wrap_angle(self.steering.angle() + angle));
        if self.turret == TurretMode::Follow {
            self.ring.set(wrap_angle(self.ring.angle() + angle));
        }
    }

    /// Rolls `way` m along the wheels, as the odometry counts, up to the first touch.
    fn roll(&mut self, way: f64, world: &World, done: &mut Executed) {
        let wheels = if way == 0.0 {
            Point::default()
        } else {
            self.steering.unit()
        };
        self.chassis.roll(way, wheels, world, done);
        if done.touched {
            (self.speed, self.turn_rate) = (0.0, 0.0);
            self.drive = Drive::Still;
        }
    }
}

#[cfg(test)]
mod tests;
