//! The simulated body: turns the world into events and carries out motions.
//!
//! With the *ideal* sonars all transducers fire at once, motions are exact, and time is counted:
//! 0.64 s for the ring and the path at full speed. With the other sonars each transducer fires in
//! its own slot of 40 ms while the base steers, accelerates and slips.

mod odometer;
mod on_body;
mod sensing;
mod step_result;
mod units;
mod wrong_base;

pub use step_result::{Collision, Moved, StepResult};
pub use units::{bearing, milliseconds};

use super::leader::Leader;
use super::places;
use crate::pilot::{AgedEcho, Pilot};
use crate::robot::AnyRobot;
use amp::controller::{Event, Motion, Progress};
use amp::units::{Displacement, Millis, Range};
use arena::noise::Noise;
use arena::robot::{Base, BaseLimits, BaseMotion, COLLISION_RADIUS_M, Executed, TurretMode};
use arena::sonar::{FIRING_ORDER, FIRING_SLOT_S, RING_PERIOD_S, Ring, SonarModel, TransducerFault};
use arena::world::{Point, Pose, World};
use odometer::Odometer;
use std::borrow::Cow;
use std::f64::consts::PI;
use std::sync::Arc;
use step_result::collision;
use units::meters;
use wrong_base::WrongBase;

/// A robot in a world.
pub struct Body<'w> {
    world: Cow<'w, World>,
    /// A second robot, and the world that contains it.
    leader: Option<(Leader, World)>,
    base: Base,
    limits: BaseLimits,
    turret: TurretMode,
    /// The robot, if it is not the Nomad.
    robot: Option<Arc<AnyRobot>>,
    ring: Ring,
    noise: Noise,
    time_s: f64,
    slot: usize,
    ranges_m: [Option<f64>; 16],
    motion: Motion,
    odometer: Odometer,
    wrong_base: WrongBase,
    /// Of what is sensed beside ranges.
    sense_noise: Noise,
}

impl<'w> Body<'w> {
    /// A robot at the world's start.
    #[must_use]
    pub fn new(world: &'w World, sonar: SonarModel, turret: TurretMode, noise_seed: u64) -> Self {
        Self::within(Cow::Borrowed(world), sonar, turret, noise_seed)
    }

    /// As [`new`](Self::new); an owned world can be replaced later.
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
            robot: None,
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
            odometer: Odometer::new(start),
            wrong_base: WrongBase::default(),
            sense_noise: Noise::new(0),
        }
    }

    /// The same robot with faulty transducers.
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

    /// Simulated time on the controller's clock.
    #[must_use]
    pub fn now(&self) -> Millis {
        milliseconds(self.time_s)
    }

    /// Time one ring takes, seconds.
    #[must_use]
    pub fn ring_s(&self) -> f64 {
        RING_PERIOD_S
    }

    /// Allows [`Moved::clearance_m`] to be infinite from this gap on, meters, which saves the
    /// search for far surfaces. Lasts until the robot is placed elsewhere.
    pub fn ignore_gaps_above(&mut self, gap_m: f64) {
        self.base.limit_reported_gaps(gap_m);
    }

    /// Simulates one step: a whole ring and its motion with the ideal sonars, one firing slot with
    /// the others.
    pub fn advance(&mut self, pilot: &mut impl Pilot) -> StepResult {
        let (before_s, before) = (self.time_s, self.base.pose().position);
        let is_ideal = self.ring.model() == SonarModel::Ideal;
        let mut result = match (&self.robot, is_ideal) {
            (None, true) => self.ideal_ring(pilot),
            (None, false) => self.firing_slot(pilot),
            (Some(robot), true) => self.ideal_step(pilot, &Arc::clone(robot)),
            (Some(robot), false) => self.timed_step(pilot, &Arc::clone(robot)),
        };
        // After a change of mode the caller has the next word.
        if !result.mode_changed {
            self.tick(pilot, &mut result);
        }
        let way = self.base.pose().position - before;
        result.collision = self.advance_leader(self.time_s - before_s, way);
        result
    }

    /// Sends a tick: the pilot stops a robot whose motion is overdue or whose ring is incomplete.
    fn tick(&mut self, pilot: &mut impl Pilot, result: &mut StepResult) {
        let outputs = pilot.handle(self.now(), Event::Tick);
        result.add(&outputs);
        if let Some(motion) = outputs.motion {
            self.begin(motion);
        }
    }

    fn ideal_ring(&mut self, pilot: &mut impl Pilot) -> StepResult {
        let pose = self.base.pose();
        self.time_s += RING_PERIOD_S;
        let world = world_with_leader(&self.world, self.leader.as_ref());
        let (ranges, noise) = (&mut self.ranges_m, &mut self.noise);
        self.ring
            .scan_with_faults(world, &pose, self.time_s, ranges, noise);
        let mut result = StepResult::new(pose, self.time_s);
        let echoes: [_; 16] =
            std::array::from_fn(|sensor| AgedEcho::now(sensor as u8, self.range(sensor)));
        let mut rest = &echoes[..];
        while !rest.is_empty() {
            let (taken, outputs) = pilot.echoes(self.now(), rest);
            rest = rest.get(taken.max(1)..).unwrap_or(&[]);
            result.add(&outputs);
            if let Some(motion) = outputs.motion {
                self.motion = motion;
                let [dx_m, dy_m] = meters(motion.displacement);
                let world = world_with_leader(&self.world, self.leader.as_ref());
                let done = self.base.move_exactly(world, dx_m, dy_m);
                self.time_s += done.traveled_m / self.limits.speed_m_s;
                result.moved = Some(self.report(pilot, pose.position, &done));
            }
        }
        result
    }

    fn firing_slot(&mut self, pilot: &mut impl Pilot) -> StepResult {
        let pose = self.base.pose();
        let sensor = FIRING_ORDER[self.slot % FIRING_ORDER.len()];
        self.slot += 1;
        let world = world_with_leader(&self.world, self.leader.as_ref());
        self.ranges_m[sensor] = self
            .ring
            .ping(world, &pose, sensor, self.time_s, &mut self.noise);
        let echo = Event::Echo {
            sensor: sensor as u8,
            range: self.range(sensor),
        };
        let mut result = StepResult::new(pose, self.time_s);
        let outputs = pilot.handle(self.now(), echo);
        result.add(&outputs);
        if let Some(motion) = outputs.motion {
            self.begin(motion);
        }
        let world = world_with_leader(&self.world, self.leader.as_ref());
        let done = self.base.advance(FIRING_SLOT_S, world);
        self.time_s += FIRING_SLOT_S;
        result.moved = Some(self.report(pilot, pose.position, &done));
        result
    }

    /// Commands a motion, which replaces the one under way.
    fn begin(&mut self, motion: Motion) {
        self.motion = motion;
        let [dx_m, dy_m] = self.wrong_base.executed(motion.displacement);
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

    /// Latest range of each transducer, meters.
    #[must_use]
    pub fn ranges_m(&self) -> &[Option<f64>; 16] {
        &self.ranges_m
    }

    /// Latest range of one transducer in the controller's unit.
    fn range(&self, sensor: usize) -> Option<Range> {
        // A range beyond 65 m cannot come from a sonar; the cast saturates.
        self.ranges_m[sensor].map(|m| Range::from_mm((m * 1e3) as u16))
    }

    /// Reports to the pilot what the base has done since the last report.
    fn report(&mut self, pilot: &mut impl Pilot, from: Point, done: &Executed) -> Moved {
        let moved = self.odometer.moved(self.base.odometry());
        let turned = self.odometer.turned(self.base.pose().heading);
        let (moved, turned) = self.wrong_base.reported(moved, turned);
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

    /// Advances the leader by the time of the robot's step. Returns who closed the gap if the
    /// leader touched the robot.
    ///
    /// The robot closed it if its displacement has a component towards the leader. The displacement
    /// stands for the speed, which the ideal sonars do not simulate.
    fn advance_leader(&mut self, dt_s: f64, way: Point) -> Option<Collision> {
        let robot = self.base.pose().position;
        let (leader, world) = self.leader.as_mut()?;
        let before = leader.position();
        let touched = leader.advance(dt_s, &self.world, robot);
        if leader.position() != before {
            world.move_post(leader.position());
        }
        touched.then(|| collision(leader.position() - robot, way))
    }

    /// Adds a second robot about 1 m ahead of this one.
    pub fn add_leader(&mut self) {
        let leader = Leader::ahead_of(self.base.pose(), &self.world);
        let world = self.world.with_post(leader.position(), COLLISION_RADIUS_M);
        self.leader = Some((leader, world));
    }

    /// Position of the second robot, if there is one.
    #[must_use]
    pub fn leader(&self) -> Option<Point> {
        self.leader.as_ref().map(|(leader, _)| leader.position())
    }

    /// Position of the robot and heading of its ring.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.base.pose()
    }

    /// Number of the latest motion.
    pub(super) fn motion_id(&self) -> u16 {
        self.motion.id
    }

    /// Whether the base moves.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        self.base.is_moving()
    }

    /// The world without the second robot.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Replaces the world; the robot keeps its pose.
    pub fn set_world(&mut self, world: World) {
        if let Some((leader, with_leader)) = &mut self.leader {
            *with_leader = world.with_post(leader.position(), COLLISION_RADIUS_M);
        }
        self.world = Cow::Owned(world);
    }

    /// Brakes.
    pub fn halt(&mut self) {
        self.base.command(BaseMotion::default(), &mut self.noise);
    }

    /// Ranges the ring would return at rest in this pose, meters. Uses up neither noise nor time.
    #[must_use]
    pub fn look(&self) -> [Option<f64>; 16] {
        let (mut ring, mut noise) = (self.ring.clone(), self.noise.clone());
        let world = world_with_leader(&self.world, self.leader.as_ref());
        let pose = self.base.pose();
        let mut ranges_m = [None; 16];
        let count = self.robot.as_ref().map_or(16, |robot| robot.mounts().len());
        for sensor in FIRING_ORDER {
            if let Some(range) = ranges_m
                .get_mut(..count)
                .and_then(|all| all.get_mut(sensor))
            {
                *range = ring.ping(world, &pose, sensor, self.time_s, &mut noise);
            }
        }
        ranges_m
    }

    /// Radius of its body, meters.
    #[must_use]
    pub fn radius_m(&self) -> f64 {
        self.limits.radius_m
    }

    /// Advances the time without simulating anything.
    pub fn wait(&mut self, dt_s: f64) {
        self.time_s += dt_s;
    }

    /// Places the robot at a random free position at least 1 m from `nest`, at rest, with the same
    /// heading.
    pub fn set_down_elsewhere(&mut self, nest: Point) {
        let place = places::elsewhere(&self.world, self.radius_m(), nest, &mut self.noise);
        self.set_down_at(place);
    }

    /// Places the robot at `position`, at rest, with the same heading.
    pub fn set_down_at(&mut self, position: Point) {
        self.set_down(Pose::new(position, self.base.pose().heading));
    }

    /// Turns the robot by a random angle; it does not perceive it.
    pub fn turn_anywhere(&mut self) {
        let pose = self.base.pose();
        let heading = pose.heading + self.noise.uniform_in(-PI, PI);
        self.set_down(Pose::new(pose.position, heading));
    }

    /// Places the robot at the world's start, at rest.
    pub fn restart(&mut self) {
        self.set_down(self.world.start());
    }

    fn set_down(&mut self, pose: Pose) {
        self.base = Base::new(pose, self.limits, self.turret);
        self.odometer = Odometer::new(pose);
    }
}

/// The world, with the second robot if there is one.
#[inline]
fn world_with_leader<'a>(world: &'a World, leader: Option<&'a (Leader, World)>) -> &'a World {
    leader.map_or(world, |(_, with_leader)| with_leader)
}

#[cfg(test)]
mod tests;
