//! The simulated body: turns the world into events, carries motions out.
//!
//! With the *ideal* sonars all transducers are heard at once, the motion is carried out exactly, and
//! time is counted, not simulated: 0.64 s for the ring and the way at full speed. With the others
//! every transducer fires in its own slot of 40 ms while the base steers, accelerates and slips.

use super::leader::Leader;
use super::places;
use crate::pilot::{HeardEcho, Pilot};
use amp::controller::{Decision, Event, Motion, Outputs, Progress, StopReason};
use amp::units::{Bearing, Displacement, Millis, Range};
use arena::noise::Noise;
use arena::robot::{Base, BaseLimits, BaseMotion, COLLISION_RADIUS_M, Executed, TurretMode};
use arena::sonar::{FIRING_ORDER, FIRING_SLOT_S, RING_PERIOD_S, Ring, SonarModel, TransducerFault};
use arena::world::{Point, Pose, World};
use std::borrow::Cow;

/// A robot in a world.
pub struct Body<'w> {
    world: Cow<'w, World>,
    /// A second robot, and the world with it.
    leader: Option<(Leader, World)>,
    base: Base,
    limits: BaseLimits,
    turret: TurretMode,
    ring: Ring,
    noise: Noise,
    time_s: f64,
    slot: usize,
    ranges_m: [Option<f64>; 16],
    motion: Motion,
    /// Where the odometry reported so far puts the base, and the ring's heading as it was reported, rounded to its bearing.
    reported: Point,
    /// Where the odometry stood when the report before told of no way.
    stood: Option<Point>,
    reported_heading: f64,
    reported_bearing: Bearing,
    /// The unit vector along that bearing.
    reported_axis: Point,
}

/// What one turn of the simulation brought about.
#[derive(Debug)]
pub struct StepResult {
    /// Where the robot stood, and when.
    pub pose: Pose,
    /// Simulated time, seconds.
    pub time_s: f64,
    /// A decision was taken.
    pub decision: Option<Decision<16>>,
    /// The pilot changed its mode.
    pub mode_changed: bool,
    /// The pilot stopped the robot, for this reason.
    pub stopped: Option<StopReason>,
    /// A motion under way was shortened.
    pub shortened: bool,
    /// The base moved (after the decision, if there was one).
    pub moved: Option<Moved>,
    /// The other robot's motion ended in a touch.
    pub collision: Option<Collision>,
}

/// Who closed the gap when the other robot moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Collision {
    /// The robot rolled towards the other one.
    ByRobot,
    /// The robot stood, rolled past or rolled away.
    ByOther,
}

/// A piece of the way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moved {
    /// From here.
    pub from: Point,
    /// To here.
    pub to: Point,
    /// Way traveled, meters.
    pub traveled_m: f64,
    /// Least gap between body and surfaces on the way, meters; perhaps infinite where
    /// [nobody asked](Body::tell_gaps_below).
    pub clearance_m: f64,
    /// The body touched something.
    pub touched: bool,
}

impl<'w> Body<'w> {
    /// A robot at the world's start.
    #[must_use]
    pub fn new(world: &'w World, sonar: SonarModel, turret: TurretMode, noise_seed: u64) -> Self {
        Self::within(Cow::Borrowed(world), sonar, turret, noise_seed)
    }

    /// The same in a world of its own, if it is to be changed.
    #[must_use]
    pub fn within(
        world: Cow<'w, World>,
        sonar: SonarModel,
        turret: TurretMode,
        noise_seed: u64,
    ) -> Self {
        let mut noise = Noise::new(noise_seed);
        let ring = Ring::new(sonar, &mut noise);
        let limits = BaseLimits::default();
        let start = world.start();
        Self {
            world,
            leader: None,
            base: Base::new(start, limits, turret),
            limits,
            turret,
            ring,
            noise,
            time_s: 0.0,
            slot: 0,
            ranges_m: [None; 16],
            motion: Motion {
                id: 0,
                displacement: Displacement::ZERO,
                speed_mm_s: 0,
            },
            reported: start.position,
            stood: None,
            reported_heading: start.heading,
            reported_bearing: bearing(start.heading),
            reported_axis: Point::unit(angle(bearing(start.heading))),
        }
    }

    /// The same robot, something wrong with its transducers.
    #[must_use]
    pub fn with_faults(mut self, faults: &[TransducerFault]) -> Self {
        self.ring = self.ring.with_faults(faults);
        self
    }

    /// Simulated time, seconds.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// Simulated time as the mind hears it.
    #[must_use]
    pub fn now(&self) -> Millis {
        milliseconds(self.time_s)
    }

    /// Time one ring takes, seconds.
    #[must_use]
    pub fn ring_s(&self) -> f64 {
        RING_PERIOD_S
    }

    /// Until the robot is set down elsewhere, gaps between body and surfaces of so much or more, meters, need not be told:
    /// they may be told as infinite. For those who look for the least gap.
    pub fn tell_gaps_below(&mut self, gap_m: f64) {
        self.base.tell_gaps_below(gap_m);
    }

    /// One turn: a whole ring and its motion with the ideal sonars, one firing slot with the others.
    pub fn advance(&mut self, pilot: &mut impl Pilot) -> StepResult {
        let (before_s, before) = (self.time_s, self.base.pose().position);
        let mut happened = self.turn(pilot);
        let way = self.base.pose().position - before;
        happened.collision = self.lead(self.time_s - before_s, way);
        happened
    }

    fn turn(&mut self, pilot: &mut impl Pilot) -> StepResult {
        let mut happened = if self.ring.model() == SonarModel::Ideal {
            self.ideal_ring(pilot)
        } else {
            self.slot(pilot)
        };
        self.pass_time(pilot, &mut happened);
        happened
    }

    /// Lets the pilot look at the time: it stops a robot whose motion is overdue or whose ring stays incomplete.
    fn pass_time(&mut self, pilot: &mut impl Pilot, happened: &mut StepResult) {
        let outputs = pilot.handle(self.now(), Event::Tick);
        happened.take(&outputs);
        if let Some(motion) = outputs.motion {
            self.begin(motion);
        }
    }

    fn ideal_ring(&mut self, pilot: &mut impl Pilot) -> StepResult {
        let pose = self.base.pose();
        self.time_s += RING_PERIOD_S;
        let world = crowded(&self.world, self.leader.as_ref());
        self.ring
            .scan_with_faults(world, &pose, &mut self.ranges_m, &mut self.noise);
        let mut happened = self.nothing_yet(pose);
        let echoes: [_; 16] =
            std::array::from_fn(|sensor| HeardEcho::now(sensor as u8, self.range(sensor)));
        let mut left = &echoes[..];
        while !left.is_empty() {
            let (taken, outputs) = pilot.echoes(self.now(), left);
            left = left.get(taken.max(1)..).unwrap_or(&[]);
            happened.take(&outputs);
            if let Some(motion) = outputs.motion {
                self.motion = motion;
                let [dx_m, dy_m] = meters(motion.displacement);
                let world = crowded(&self.world, self.leader.as_ref());
                let done = self.base.move_exactly(world, dx_m, dy_m);
                self.time_s += done.traveled_m / self.limits.speed_m_s;
                happened.moved = Some(self.report(pilot, pose.position, &done));
            }
        }
        happened
    }

    fn slot(&mut self, pilot: &mut impl Pilot) -> StepResult {
        let pose = self.base.pose();
        let sensor = FIRING_ORDER[self.slot % FIRING_ORDER.len()];
        self.slot += 1;
        let world = crowded(&self.world, self.leader.as_ref());
        self.ranges_m[sensor] = self
            .ring
            .ping(world, &pose, sensor, self.time_s, &mut self.noise);
        let echo = Event::Echo {
            sensor: sensor as u8,
            range: self.range(sensor),
        };
        let time_s = self.time_s;
        let outputs = pilot.handle(self.now(), echo);
        if let Some(motion) = outputs.motion {
            self.begin(motion);
        }
        let world = crowded(&self.world, self.leader.as_ref());
        let done = self.base.advance(FIRING_SLOT_S, world);
        self.time_s += FIRING_SLOT_S;
        let moved = Some(self.report(pilot, pose.position, &done));
        StepResult {
            pose,
            time_s,
            decision: outputs.decision,
            mode_changed: outputs.mode_changed,
            stopped: outputs.stopped,
            shortened: shortens(&outputs),
            moved,
            collision: None,
        }
    }

    /// Sends the base on its way, or changes the motion under way.
    fn begin(&mut self, motion: Motion) {
        self.motion = motion;
        let [dx_m, dy_m] = meters(motion.displacement);
        let speed_m_s = f64::from(motion.speed_mm_s) / 1e3;
        self.base.command(
            BaseMotion {
                dx_m,
                dy_m,
                speed_m_s,
            },
            &mut self.noise,
        );
    }

    fn nothing_yet(&self, pose: Pose) -> StepResult {
        StepResult {
            pose,
            time_s: self.time_s,
            decision: None,
            mode_changed: false,
            stopped: None,
            shortened: false,
            moved: None,
            collision: None,
        }
    }

    /// What each transducer heard last, meters.
    #[must_use]
    pub fn ranges_m(&self) -> &[Option<f64>; 16] {
        &self.ranges_m
    }

    /// The same of one, as the mind hears it.
    fn range(&self, sensor: usize) -> Option<Range> {
        // A range beyond 65 m cannot come from a sonar; the cast saturates.
        self.ranges_m[sensor].map(|m| Range::from_mm((m * 1e3) as u16))
    }

    /// Reports what the base has done since its last report, in whole millimeters; what rounding
    /// leaves over goes into the next report.
    fn report(&mut self, pilot: &mut impl Pilot, from: Point, done: &Executed) -> Moved {
        let moved = self.moved();
        let before = self.reported_bearing;
        self.set_reported_heading(self.base.pose().heading);
        let turned = self.reported_bearing.minus(before);
        let progress = match (done.touched, done.moving) {
            (true, _) => Progress::Touched,
            (false, true) if self.base.is_steering() => Progress::Steering,
            (false, true) => Progress::Moving,
            (false, false) => Progress::Ended,
        };
        let _ = pilot.handle(
            self.now(),
            Event::Odometry {
                motion: self.motion.id,
                moved,
                turned,
                progress,
            },
        );
        Moved {
            from,
            to: self.base.pose().position,
            traveled_m: done.traveled_m,
            clearance_m: done.min_clearance_m,
            touched: done.touched,
        }
    }

    /// The way from what was reported so far, in whole millimeters, which is reported now.
    fn moved(&mut self) -> Displacement {
        let odometry = self.base.odometry();
        if self.stood == Some(odometry) {
            return Displacement::ZERO;
        }
        let Point { x: cos, y: sin } = self.reported_axis;
        let way = odometry - self.reported;
        let (x, y) = (way.x * cos + way.y * sin, way.y * cos - way.x * sin);
        let moved = Displacement {
            dx_mm: millimeters(x),
            dy_mm: millimeters(y),
        };
        let [x, y] = meters(moved);
        self.reported = self.reported + Point::new(x * cos - y * sin, x * sin + y * cos);
        self.stood = (moved == Displacement::ZERO).then_some(odometry);
        moved
    }

    fn set_reported_heading(&mut self, heading: f64) {
        if heading.to_bits() == self.reported_heading.to_bits() {
            return;
        }
        self.reported_heading = heading;
        let bearing = bearing(heading);
        if bearing != self.reported_bearing {
            self.reported_bearing = bearing;
            self.reported_axis = Point::unit(angle(bearing));
            self.stood = None;
        }
    }

    /// Lets the leader drive for as long as the robot has; whether it touched the robot, and who closed the gap.
    ///
    /// A touch is the robot's own if its way meanwhile has a component towards the leader. With the ideal sonars the robot
    /// has no speed that could be asked for: it is at its way's end at once.
    fn lead(&mut self, dt_s: f64, way: Point) -> Option<Collision> {
        let robot = self.base.pose().position;
        let (leader, world) = self.leader.as_mut()?;
        let before = leader.position();
        let touched = leader.advance(dt_s, &self.world, robot);
        if leader.position() != before {
            world.move_post(leader.position());
        }
        touched.then(|| collision(leader.position() - robot, way))
    }

    /// Sets a second robot down about 1 m ahead of where this one stands.
    pub fn add_leader(&mut self) {
        let leader = Leader::ahead_of(self.base.pose(), &self.world);
        let world = self.world.with_post(leader.position(), COLLISION_RADIUS_M);
        self.leader = Some((leader, world));
    }

    /// Where the second robot is, if there is one.
    #[must_use]
    pub fn leader(&self) -> Option<Point> {
        self.leader.as_ref().map(|(leader, _)| leader.position())
    }

    /// Where the robot is and where its ring looks.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.base.pose()
    }

    /// Whether the base is under way.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        self.base.is_moving()
    }

    /// The world without the second robot.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// From now on the world is another one; the robot stays where it is.
    pub fn set_world(&mut self, world: World) {
        if let Some((leader, crowded)) = &mut self.leader {
            *crowded = world.with_post(leader.position(), COLLISION_RADIUS_M);
        }
        self.world = Cow::Owned(world);
    }

    /// Brakes, whatever was under way.
    pub fn halt(&mut self) {
        self.base.command(BaseMotion::default(), &mut self.noise);
    }

    /// What the ring would hear from here, meters, as if at rest: nothing happens, neither noise nor time is used up.
    #[must_use]
    pub fn look(&self) -> [Option<f64>; 16] {
        let (mut ring, mut noise) = (self.ring.clone(), self.noise.clone());
        let world = crowded(&self.world, self.leader.as_ref());
        let pose = self.base.pose();
        let mut ranges_m = [None; 16];
        for sensor in FIRING_ORDER {
            if let Some(range) = ranges_m.get_mut(sensor) {
                *range = ring.ping(world, &pose, sensor, self.time_s, &mut noise);
            }
        }
        ranges_m
    }

    /// Lets time pass while the robot is carried.
    pub fn wait(&mut self, dt_s: f64) {
        self.time_s += dt_s;
    }

    /// Sets the robot down at a free place elsewhere in the world, drawn by the noise, at rest and with the same bearing.
    pub fn set_down_elsewhere(&mut self, nest: Point) {
        let place = places::elsewhere(&self.world, nest, &mut self.noise);
        self.set_down_at(place);
    }

    /// Sets the robot down at a place, at rest and with the same bearing.
    pub fn set_down_at(&mut self, place: Point) {
        self.set_down(Pose::new(place, self.base.pose().heading));
    }

    /// Puts the robot back to the world's start, at rest.
    pub fn restart(&mut self) {
        self.set_down(self.world.start());
    }

    fn set_down(&mut self, start: Pose) {
        self.base = Base::new(start, self.limits, self.turret);
        self.reported = start.position;
        self.stood = None;
        self.set_reported_heading(start.heading);
    }
}

impl StepResult {
    fn take(&mut self, outputs: &Outputs<16>) {
        self.decision = self.decision.or(outputs.decision);
        self.mode_changed |= outputs.mode_changed;
        self.stopped = self.stopped.or(outputs.stopped);
        self.shortened |= shortens(outputs);
    }
}

/// Who closes the gap to a thing in this direction while the robot goes this way.
fn collision(to_thing: Point, way: Point) -> Collision {
    if way.dot(to_thing) > 0.0 {
        Collision::ByRobot
    } else {
        Collision::ByOther
    }
}

/// Whether they shorten a motion under way.
fn shortens(outputs: &Outputs<16>) -> bool {
    outputs.motion.is_some() && outputs.decision.is_none() && !outputs.mode_changed
}

/// The world as it is met: with the second robot, if there is one.
#[inline]
fn crowded<'a>(world: &'a World, leader: Option<&'a (Leader, World)>) -> &'a World {
    leader.map_or(world, |(_, crowded)| crowded)
}

/// Simulated time as the mind hears it.
pub fn milliseconds(time_s: f64) -> Millis {
    // Signed, which processors convert at once; no time is below 0.
    Millis::from_ms((time_s * 1e3 + 0.5) as i64 as u32)
}

fn meters(displacement: Displacement) -> [f64; 2] {
    [
        f64::from(displacement.dx_mm) / 1e3,
        f64::from(displacement.dy_mm) / 1e3,
    ]
}

/// To the nearest millimeter, halves to the even one, as far as a displacement reaches.
fn millimeters(m: f64) -> i16 {
    // Of a sum from 2⁵² to 2⁵³ the lowest bits are those of an integer.
    const ROUNDS: f64 = (3_u64 << 51) as f64;
    let most = f64::from(i16::MAX);
    ((m * 1e3).clamp(-most - 1.0, most) + ROUNDS).to_bits() as i16
}

fn bearing(angle_rad: f64) -> Bearing {
    let turns = libm::rint(angle_rad / std::f64::consts::TAU * 65_536.0);
    Bearing::from_turns(turns as i64 as u16)
}

fn angle(bearing: Bearing) -> f64 {
    f64::from(bearing.as_turns()) / 65_536.0 * std::f64::consts::TAU
}

#[cfg(test)]
mod tests;
