//! The base of a Nomad 200: three wheels that roll and steer together, and a turret of its own.
//!
//! Two ways to move it. [`Base::move_exactly`] puts it where the command says, or where it touches
//! something: instant and without noise. [`Base::command`] and [`Base::advance`] move it as the machine
//! does: steer first, then roll, each with limited speed and acceleration, and with slip. [`Axes`] has the three
//! motors at their own commands instead.
//!
//! Steering turns the wheels alone: the base keeps its bearing in the world, and its bumpers with it. The
//! turret carries the ring. *Held*, it keeps its bearing too; *follow*, it turns with the wheels.

use core::f64::consts::{FRAC_PI_2, PI};
use core::str::FromStr;

use crate::direction::Direction;
use crate::noise::Noise;
use crate::world::{Point, Pose, World, wrap_angle};
use files::error::BadInput;

mod axes;
mod chassis;
mod motion;
mod servo;

pub use axes::{Axes, Axis, AxisLimits};
use chassis::{Chassis, Line, share_of};
pub use motion::{Executed, Motion};
use servo::{Ramp, STRIDE, Way, sense, slow};

pub use crate::nomad::{BUMPERS, COLLISION_RADIUS_M};

/// Longest time step of the timed motion, s.
const MAX_STEP_S: f64 = 0.010;

/// Way and angle that count as none: far below what the Nomad can measure (m, rad).
const NEGLIGIBLE: f64 = 1e-9;

/// A new goal this near to the line on which the wheels already roll is reached without stopping, rad.
const SAME_DIRECTION_RAD: f64 = PI / 180.0;

/// A way told again in whole millimeters leads so far beside or before where it led, m.
const ROUNDING_M: f64 = 2e-3;

/// What the motors can do, and how well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaseLimits {
    /// Greatest speed, m/s: 20 in/s, the limit in the Nomad's own software.
    pub speed_m_s: f64,
    /// Acceleration and deceleration, m/s²: 30 in/s².
    pub acceleration_m_s2: f64,
    /// Greatest rate of steering and turret, rad/s: 45 °/s.
    pub turn_rate_rad_s: f64,
    /// Acceleration of steering and turret, rad/s²: 30 °/s².
    pub turn_acceleration_rad_s2: f64,
    /// Standard deviation of way (as a share) and direction (rad) of a timed motion, drawn once per
    /// command: what the wheels slip, unseen by the odometry.
    pub slip: f64,
}

impl Default for BaseLimits {
    fn default() -> Self {
        Self {
            speed_m_s: 0.508,
            acceleration_m_s2: 0.762,
            turn_rate_rad_s: PI / 4.0,
            turn_acceleration_rad_s2: PI / 6.0,
            slip: 0.02,
        }
    }
}

/// What the turret does while the base steers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TurretMode {
    /// It keeps its bearing in the world.
    #[default]
    Held,
    /// It turns with the wheels, which then always roll forward.
    Follow,
}

impl TurretMode {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Held => "held",
            Self::Follow => "follow",
        }
    }
}

impl FromStr for TurretMode {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        match text {
            "held" => Ok(Self::Held),
            "follow" => Ok(Self::Follow),
            _ => Err(BadInput::unknown("turret mode", text, &["held", "follow"])),
        }
    }
}

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

/// A time cut into equal steps.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Pace {
    whole_s: f64,
    steps: u32,
    step_s: f64,
}

impl Pace {
    fn of(whole_s: f64) -> Self {
        let steps = libm::ceil(whole_s / MAX_STEP_S).clamp(1.0, 1e7) as u32;
        Self {
            whole_s,
            steps,
            step_s: whole_s.max(0.0) / f64::from(steps),
        }
    }
}

/// The wheels on their way to a bearing, mirrored if need be so that their angle grows.
#[derive(Debug, Clone, Copy)]
struct Turn {
    bearing: f64,
    /// The half turns that the bearing is farther away than the end.
    halves: f64,
    wheels: f64,
}

impl Way for Turn {
    /// As [`Base::to_turn`] where as many half turns are off: to take them off is exact, one by one or at once. They never
    /// grow in number, so if they are the same at both ends of a stride they are so in between.
    fn left(&self) -> f64 {
        self.bearing - self.wheels - self.halves
    }

    fn go(&mut self, way: f64) {
        self.wheels += way;
    }
}

/// Whether an angle is in [−π, π).
fn is_wrapped(angle: f64) -> bool {
    wrap_angle(angle) == angle
}

/// The base: where it is, where its wheels and its turret point, and what it is doing.
#[derive(Debug, Clone, PartialEq)]
pub struct Base {
    limits: BaseLimits,
    turret: TurretMode,
    chassis: Chassis,
    steering: Direction,
    ring: Direction,
    drive: Drive,
    speed_limit: f64,
    /// Along the wheels; negative in reverse.
    speed: f64,
    turn_rate: f64,
    /// Of the last time that passed.
    pace: Pace,
}

impl Base {
    /// A base at rest: wheels, turret and front along the pose's heading.
    #[must_use]
    pub fn new(pose: Pose, limits: BaseLimits, turret: TurretMode) -> Self {
        Self {
            limits,
            turret,
            chassis: Chassis::new(pose),
            steering: Direction::new(pose.heading),
            ring: Direction::new(pose.heading),
            drive: Drive::Still,
            speed_limit: limits.speed_m_s,
            speed: 0.0,
            turn_rate: 0.0,
            pace: Pace::of(0.0),
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

    /// Whether the base brakes or turns its wheels before it rolls to its goal, or they still turn though it is told to stand.
    #[must_use]
    pub fn is_steering(&self) -> bool {
        matches!(self.drive, Drive::Brake(Some(_)) | Drive::Steer(..)) || self.turn_rate != 0.0
    }

    /// From now on gaps between disc and surfaces of so much or more, m, need not be told: they may be told as infinite.
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

    /// Lets the wheels, and a following turret, point along a displacement in the ring frame at once.
    fn point_wheels(&mut self, displacement: Point) {
        let bearing = displacement.angle();
        self.steering.set(wrap_angle(self.ring.angle() + bearing));
        if self.turret == TurretMode::Follow {
            self.ring = self.steering;
        }
    }

    /// Starts a timed motion; it replaces the present one. A displacement of zero brakes to a stop. A base
    /// that already rolls towards the new goal keeps rolling (it may pass beside it by 1° of the way left and 2 mm), or stops for
    /// good where it cannot stop before it; wheels that turn at rest go on turning, to the new bearing; otherwise it stops first.
    /// Slip is drawn from `noise`.
    pub fn command(&mut self, motion: Motion, noise: &mut Noise) {
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

    /// Lets `dt_s` seconds pass.
    pub fn advance(&mut self, dt_s: f64, world: &World) -> Executed {
        let mut done = Executed::nothing_yet();
        if dt_s != self.pace.whole_s {
            self.pace = Pace::of(dt_s);
        }
        let (mut steps, step_s) = (self.pace.steps, self.pace.step_s);
        while steps > 0 && self.is_moving() {
            steps -= if steps >= STRIDE as u32 && self.stride(step_s, world, &mut done) {
                STRIDE as u32
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

    /// Rolls a stride, mirrored if need be so that it goes forward: signs change nothing in how numbers are rounded.
    fn stride_rolling(&mut self, goal: Point, dt: f64, world: &World, done: &mut Executed) -> bool {
        let wheels = self.steering.unit();
        let mut line = Line {
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

    /// Slows wheels and steering down; once both rest, goes on to the goal.
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
        let left = self.to_turn(bearing, self.steering.angle());
        let (turned, turn_rate) = self.turning(dt).approach(left, self.turn_rate);
        self.turn_rate = turn_rate;
        self.turn(turned);
        if turn_rate == 0.0 && (left - turned).abs() <= NEGLIGIBLE {
            self.drive = Drive::Roll(goal);
        }
    }

    /// The angle to turn the wheels by, so that they point along a bearing: straight towards it, or straight away from it
    /// where that is the shorter turn and the turret does not follow.
    fn to_turn(&self, bearing: f64, wheels: f64) -> f64 {
        let left = wrap_angle(bearing - wheels);
        if self.turret == TurretMode::Held && left.abs() > FRAC_PI_2 {
            left - if left > 0.0 { PI } else { -PI }
        } else {
            left
        }
    }

    /// Turns the wheels by a stride, mirrored likewise, unless an angle is wrapped on the way.
    fn stride_steering(&mut self, bearing: f64, dt: f64) -> bool {
        let wheels = self.steering.angle();
        let left = self.to_turn(bearing, wheels);
        let sign = sense(self.turn_rate, left);
        let turn = Turn {
            bearing: bearing * sign,
            halves: (bearing - wheels - left) * sign,
            wheels: wheels * sign,
        };
        let Some(stride) = self.turning(dt).stride(turn, self.turn_rate * sign) else {
            return false;
        };
        let end = stride.end.wheels * sign;
        let same = self.to_turn(bearing, end) == stride.end.left() * sign;
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
