//! The base of a Nomad 200: three wheels that roll and steer together, and a separate turret.
//!
//! [`Base::move_exactly`] moves the base instantly and without noise. [`Base::command`] and
//! [`Base::advance`] simulate limited speed, limited acceleration and slip. Steering turns only the
//! wheels. The turret with the ring keeps its bearing (*held*) or turns with the wheels (*follow*).

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
use chassis::{Chassis, RollingPath, traveled_share};
use limits::NEGLIGIBLE;
pub use limits::{BaseLimits, TurretMode};
pub use motion::{BaseMotion, Executed};
use servo::{Ramp, RemainingDistance, STEPS_PER_STRIDE, stride_sign};
use steering::{SteeringPath, angle_to_turn, is_wrapped};
use time_steps::TimeSteps;

pub use crate::nomad::{BUMPERS, COLLISION_RADIUS_M};

/// Largest angle between the rolling direction and a new goal that is reached without stopping,
/// rad.
const SAME_DIRECTION_RAD: f64 = PI / 180.0;

/// Largest rounding error of a displacement that is repeated in whole millimeters, m.
const ROUNDING_M: f64 = 2e-3;

/// State of the drive.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Drive {
    Still,
    /// Brakes to rest, then drives to the goal (odometry frame) if there is one.
    Brake(Option<Point>),
    /// Turns the wheels at rest towards the goal, which is at this bearing, rad.
    Steer(Point, f64),
    /// Rolls to the goal.
    Roll(Point),
}

/// The base: position, directions of wheels and turret, and state of the drive.
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
    /// Steps of the last call of [`Base::advance`].
    time_steps: TimeSteps,
}

impl Base {
    /// A base at rest: wheels, turret and front along the pose's heading.
    #[must_use]
    pub fn new(pose: Pose, limits: BaseLimits, turret: TurretMode) -> Self {
        Self {
            limits,
            turret,
            chassis: Chassis::new(pose, limits.radius_m),
            steering: CachedDirection::new(pose.heading),
            ring: CachedDirection::new(pose.heading),
            drive: Drive::Still,
            speed_limit: limits.speed_m_s,
            speed: 0.0,
            turn_rate: 0.0,
            time_steps: TimeSteps::new(0.0),
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

    /// Position by odometry, m: the true position without slip.
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

    /// Whether the base moves.
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

    /// From now on, gaps between disc and surfaces of `gap_m` m or more may be reported as
    /// infinite.
    pub fn limit_reported_gaps(&mut self, gap_m: f64) {
        self.chassis.limit_reported_gaps(gap_m);
    }

    /// Moves instantly and straight by (`dx_m`, `dy_m`) in the ring frame, up to the first contact.
    /// In [`TurretMode::Follow`] the ring then points in the direction of the motion.
    pub fn move_exactly(&mut self, world: &World, dx_m: f64, dy_m: f64) -> Executed {
        let commanded = Point::new(dx_m, dy_m);
        let length = commanded.length();
        let (from, ring_before) = (self.chassis.position, self.ring.unit());
        let sweep = self.chassis.sweep(commanded.turned(ring_before), world);
        let share = traveled_share(&sweep, length);
        let done = commanded * share;
        self.chassis.position = from + done.turned(ring_before);
        self.chassis.odometry = self.chassis.odometry + done.turned(ring_before);
        if length > 0.0 {
            self.point_wheels(commanded);
        }
        Executed {
            touched: sweep.touched(),
            bumpers: self.chassis.bumpers_at(&sweep),
            moving: false,
            traveled_m: sweep.traveled_m,
            min_clearance_m: sweep.min_clearance_m,
        }
    }

    /// Turns wheels and ring on the spot, instantly, by `angle` rad to the left.
    pub fn turn_exactly(&mut self, angle: f64) {
        self.ring.set(wrap_angle(self.ring.angle() + angle));
        self.steering = self.ring;
    }

    /// Turns the whole robot by `angle` rad to the left, as slipping wheels do.
    pub fn drift(&mut self, angle: f64) {
        for direction in [&mut self.ring, &mut self.steering] {
            direction.set(wrap_angle(direction.angle() + angle));
        }
    }

    /// Points the wheels, and a following turret, along a displacement in the ring frame,
    /// instantly.
    fn point_wheels(&mut self, displacement: Point) {
        let bearing = displacement.angle();
        self.steering.set(wrap_angle(self.ring.angle() + bearing));
        if self.turret == TurretMode::Follow {
            self.ring = self.steering;
        }
    }

    /// Starts a timed motion, which replaces the current one. Slip is drawn from `noise`.
    ///
    /// * A displacement of zero brakes to a stop.
    /// * A base that already rolls towards the new goal keeps rolling, if the goal is within 1° and
    ///   2 mm of its line. If it cannot stop before the goal, it brakes and ignores the goal.
    /// * Wheels that turn at rest turn on to the new bearing.
    /// * Otherwise the base stops first.
    pub fn command(&mut self, motion: BaseMotion, noise: &mut Noise) {
        self.chassis.draw_slip(self.limits.slip, noise);
        let commanded = Point::new(motion.dx_m, motion.dy_m);
        let finite =
            commanded.x.is_finite() && commanded.y.is_finite() && motion.speed_m_s.is_finite();
        if !finite || commanded.length() <= NEGLIGIBLE || motion.speed_m_s <= 0.0 {
            self.drive = Drive::Brake(None);
            return;
        }
        self.speed_limit = motion.speed_m_s.min(self.limits.speed_m_s);
        let goal = self.chassis.odometry + commanded.turned(self.ring.unit());
        let stopping = self.speed * self.speed / (2.0 * self.limits.acceleration_m_s2);
        self.drive = match self.ahead(goal) {
            _ if matches!(self.drive, Drive::Steer(..)) => self.steered(goal),
            // Otherwise the base would overshoot and drive back.
            Some(ahead) if ahead <= stopping => Drive::Brake(None),
            Some(_) => Drive::Roll(goal),
            None => Drive::Brake(Some(goal)),
        };
    }

    /// Distance to a goal towards which the wheels already roll; `None` for other goals.
    fn ahead(&mut self, goal: Point) -> Option<f64> {
        let offset = (goal - self.chassis.odometry).turned_back(self.steering.unit());
        let ahead = offset.x * self.speed.signum();
        let is_aside = offset.y.abs() > ahead.abs() * SAME_DIRECTION_RAD + ROUNDING_M;
        (self.speed != 0.0 && ahead > -ROUNDING_M && !is_aside).then_some(ahead)
    }

    /// Advances the time by `dt_s` seconds.
    pub fn advance(&mut self, dt_s: f64, world: &World) -> Executed {
        let mut done = Executed::none();
        if dt_s != self.time_steps.whole_s {
            self.time_steps = TimeSteps::new(dt_s);
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
        self.chassis.report_gap(world, &mut done);
        Executed {
            moving: self.is_moving(),
            ..done
        }
    }

    /// Takes a whole stride if none of its steps needs [`Base::step`]; otherwise does nothing.
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
                let left = (goal - self.chassis.odometry).dot(self.steering.unit());
                let (moved, speed) = self.rolling(dt).approach(left, self.speed);
                self.speed = speed;
                self.roll(moved, world, done);
                let arrived = speed == 0.0 && (left - moved).abs() <= NEGLIGIBLE;
                if arrived && self.drive != Drive::Still {
                    self.drive = Drive::Still;
                }
            }
        }
    }

    /// Velocity ramp of rolling.
    fn rolling(&self, dt: f64) -> Ramp {
        Ramp::new(self.speed_limit, self.limits.acceleration_m_s2, dt)
    }

    /// Velocity ramp of steering.
    fn turning(&self, dt: f64) -> Ramp {
        let limits = &self.limits;
        Ramp::new(limits.turn_rate_rad_s, limits.turn_acceleration_rad_s2, dt)
    }

    /// Rolls a stride. Mirrors a backward motion: a sign does not change the rounding.
    fn stride_rolling(&mut self, goal: Point, dt: f64, world: &World, done: &mut Executed) -> bool {
        let wheels = self.steering.unit();
        let mut path = RollingPath {
            goal,
            wheels,
            odometry: self.chassis.odometry,
        };
        let sign = stride_sign(self.speed, path.remaining());
        path.wheels = wheels * sign;
        let Some(stride) = self.rolling(dt).stride(path, self.speed * sign) else {
            return false;
        };
        self.speed = stride.velocity * sign;
        if !self.chassis.apply_stride(&stride, world, done) {
            for distance in stride.distances {
                self.roll(distance * sign, world, done);
                if self.drive == Drive::Still {
                    break;
                }
            }
        }
        true
    }

    /// Brakes rolling and steering; once both are at rest, turns the wheels to the goal.
    fn brake(&mut self, goal: Option<Point>, dt: f64, world: &World, done: &mut Executed) {
        let (turned, rate) = servo::brake(self.turn_rate, self.limits.turn_acceleration_rad_s2, dt);
        self.turn_rate = rate;
        self.turn(turned);
        let (moved, speed) = servo::brake(self.speed, self.limits.acceleration_m_s2, dt);
        self.speed = speed;
        self.roll(moved, world, done);
        if self.drive == Drive::Still || self.speed != 0.0 || self.turn_rate != 0.0 {
            return;
        }
        let goal = goal.filter(|goal| goal.distance(self.chassis.odometry) > NEGLIGIBLE);
        self.drive = goal.map_or(Drive::Still, |goal| self.steered(goal));
    }

    /// The state that turns the wheels at rest towards a goal.
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

    /// Turns the wheels by a stride, mirrored as in rolling. Does nothing if an angle would wrap.
    fn stride_steering(&mut self, bearing: f64, dt: f64) -> bool {
        let wheels = self.steering.angle();
        let left = angle_to_turn(self.turret, bearing, wheels);
        let sign = stride_sign(self.turn_rate, left);
        let path = SteeringPath {
            bearing: bearing * sign,
            half_turns: (bearing - wheels - left) * sign,
            wheels: wheels * sign,
        };
        let Some(stride) = self.turning(dt).stride(path, self.turn_rate * sign) else {
            return false;
        };
        let end = stride.end.wheels * sign;
        let same = angle_to_turn(self.turret, bearing, end) == stride.end.remaining() * sign;
        if !(same && is_wrapped(wheels) && is_wrapped(end)) {
            return false;
        }
        self.steering.set(end);
        if self.turret == TurretMode::Follow {
            let turned = |ring, angle| wrap_angle(ring + angle * sign);
            self.ring
                .set(stride.distances.into_iter().fold(self.ring.angle(), turned));
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

    /// Rolls `distance` m of odometry along the wheels, up to the first contact.
    fn roll(&mut self, distance: f64, world: &World, done: &mut Executed) {
        let wheels = if distance == 0.0 {
            Point::default()
        } else {
            self.steering.unit()
        };
        self.chassis.roll(distance, wheels, world, done);
        if done.touched {
            (self.speed, self.turn_rate) = (0.0, 0.0);
            self.drive = Drive::Still;
        }
    }
}

#[cfg(test)]
mod tests;
