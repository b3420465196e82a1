//! Robots whose sensors stand on the body: they turn, listen on the way, and go.

use super::{Body, Moved, Odometer, StepResult, WrongBase};
use crate::pilot::{AgedEcho, Pilot};
use crate::robot::AnyRobot;
use amp::controller::{Event, Motion, Progress};
use amp::units::Displacement;
use arena::noise::Noise;
use arena::robot::{Base, Executed};
use arena::sonar::{Ring, SonarModel};
use arena::world::{Point, World};
use std::borrow::Cow;
use std::sync::Arc;

/// With the ideal sonars the robot listens each time it has turned by this angle, rad: 15°.
const LISTEN_RAD: f64 = std::f64::consts::PI / 12.0;
/// The base reports at least this often, s.
const REPORT_S: f64 = 0.040;
/// Turns of one step, at most: a robot that changes its mind again and again goes at last.
const MAX_TURNS: u32 = 200;

impl<'w> Body<'w> {
    /// Another robot than the Nomad at the world's start.
    #[must_use]
    pub fn of_robot(
        world: &'w World,
        robot: &AnyRobot,
        sonar: SonarModel,
        noise_seed: u64,
    ) -> Self {
        Self::of_robot_within(Cow::Borrowed(world), robot, sonar, noise_seed)
    }

    /// As [`of_robot`](Self::of_robot); an owned world can be replaced later.
    #[must_use]
    pub fn of_robot_within(
        world: Cow<'w, World>,
        robot: &AnyRobot,
        sonar: SonarModel,
        noise_seed: u64,
    ) -> Self {
        let mut noise = Noise::new(noise_seed);
        let config = robot.sensing(sonar);
        let ring = Ring::with_mounts(sonar, &robot.mounts(), config, &mut noise);
        let (limits, turret) = (robot.limits(), robot.turret());
        let start = world.start();
        Self {
            base: Base::new(start, limits, turret),
            limits,
            turret,
            robot: Some(Arc::new(robot.clone())),
            ring,
            noise,
            odometer: Odometer::new(start),
            wrong_base: WrongBase::new(robot.miswiring()),
            ..Self::within(world, sonar, turret, noise_seed)
        }
    }

    /// The robot, if it is not the Nomad with its own ring.
    #[must_use]
    pub fn robot(&self) -> Option<&AnyRobot> {
        self.robot.as_deref()
    }

    /// One ring of exact sensors, and the motion it causes.
    pub(super) fn ideal_step(&mut self, pilot: &mut impl Pilot, robot: &AnyRobot) -> StepResult {
        let pose = self.base.pose();
        self.time_s += robot.model().period_s;
        let mut result = StepResult::new(pose, self.time_s);
        let Some(motion) = self.listen(pilot, robot, &mut result) else {
            return result;
        };
        let way = self.turn_towards(motion, pilot, robot, &mut result);
        let way = way.turned_back(Point::unit(self.base.pose().heading));
        let world = super::world_with_leader(&self.world, self.leader.as_ref());
        let done = self.base.move_exactly(world, way.x, way.y);
        self.time_s += done.traveled_m / self.limits.speed_m_s;
        result.moved = Some(self.report(pilot, pose.position, &done));
        result
    }

    /// Turns towards where a motion leads, and listens on the way. Returns the displacement to go,
    /// in the world.
    fn turn_towards(
        &mut self,
        motion: Motion,
        pilot: &mut impl Pilot,
        robot: &AnyRobot,
        result: &mut StepResult,
    ) -> Point {
        let mut way = self.begin_exactly(motion);
        for _ in 0..MAX_TURNS {
            let ahead = way.turned_back(Point::unit(self.base.pose().heading));
            let left = ahead.angle();
            if !robot.turns() || way.length() < 1e-9 || left.abs() < 1e-6 {
                break;
            }
            let turn = left.clamp(-LISTEN_RAD, LISTEN_RAD);
            self.base.turn_exactly(turn);
            self.time_s += turn.abs() / robot.model().max_turn_rad_s;
            self.report_turn(pilot);
            if let Some(newer) = self.listen(pilot, robot, result) {
                way = self.begin_exactly(newer);
            }
        }
        way
    }

    /// Notes a motion; returns its displacement in the world, m.
    fn begin_exactly(&mut self, motion: Motion) -> Point {
        self.motion = motion;
        let [x, y] = self.wrong_base.executed(motion.displacement);
        Point::new(x, y).turned(Point::unit(self.base.pose().heading))
    }

    fn report_turn(&mut self, pilot: &mut impl Pilot) {
        let turned = self.odometer.turned(self.base.pose().heading);
        let (moved, turned) = self.wrong_base.reported(Displacement::ZERO, turned);
        let event = Event::Odometry {
            motion: self.motion.id,
            moved,
            turned,
            progress: Progress::Steering,
        };
        let _ = pilot.handle(self.now(), event);
    }

    /// All sensors at once; returns the last motion that the pilot orders.
    fn listen(
        &mut self,
        pilot: &mut impl Pilot,
        robot: &AnyRobot,
        result: &mut StepResult,
    ) -> Option<Motion> {
        let world = super::world_with_leader(&self.world, self.leader.as_ref());
        let pose = self.base.pose();
        let (ranges, noise) = (&mut self.ranges_m, &mut self.noise);
        self.ring
            .scan_with_faults(world, &pose, self.time_s, ranges, noise);
        let sensors = robot.model().sensors.len().min(self.ranges_m.len());
        let echoes = (0..sensors).map(|sensor| AgedEcho::now(sensor as u8, self.range(sensor)));
        let echoes: Vec<_> = echoes.collect();
        let mut rest = &echoes[..];
        let mut motion = None;
        while !rest.is_empty() {
            let (taken, outputs) = pilot.echoes(self.now(), rest);
            rest = rest.get(taken.max(1)..).unwrap_or(&[]);
            result.add(&outputs);
            motion = outputs.motion.or(motion);
        }
        motion
    }

    /// One slot of firings, and the motion of the base meanwhile.
    pub(super) fn timed_step(&mut self, pilot: &mut impl Pilot, robot: &AnyRobot) -> StepResult {
        let pose = self.base.pose();
        let mut result = StepResult::new(pose, self.time_s);
        let sensors = robot.model().sensors.len().min(self.ranges_m.len());
        let (firing, slot_s) = match &robot.model().firing_order {
            Some(order) => {
                let sensor = order[self.slot % order.len()];
                (
                    sensor..sensor + 1,
                    robot.model().period_s / order.len() as f64,
                )
            }
            None => (0..sensors, robot.model().period_s),
        };
        self.slot += 1;
        for sensor in firing {
            let world = super::world_with_leader(&self.world, self.leader.as_ref());
            let (time_s, noise) = (self.time_s, &mut self.noise);
            self.ranges_m[sensor] = self.ring.ping(world, &pose, sensor, time_s, noise);
            let range = self.range(sensor);
            let sensor = sensor as u8;
            let outputs = pilot.handle(self.now(), Event::Echo { sensor, range });
            result.add(&outputs);
            if let Some(motion) = outputs.motion {
                self.begin(motion);
            }
        }
        result.moved = Some(self.roll_for(pilot, slot_s, robot.model().heading_drift));
        result
    }

    /// The base moves on for this time, and reports. Meanwhile it turns a little that it does not
    /// measure: `drift`, rad/√m.
    fn roll_for(&mut self, pilot: &mut impl Pilot, time_s: f64, drift: f64) -> Moved {
        let reports = (time_s / REPORT_S).ceil().max(1.0);
        let from = self.base.pose().position;
        let mut whole = Executed::none();
        for _ in 0..reports as u32 {
            let world = super::world_with_leader(&self.world, self.leader.as_ref());
            let done = self.base.advance(time_s / reports, world);
            self.time_s += time_s / reports;
            if drift > 0.0 && done.traveled_m > 0.0 {
                let angle = self.noise.normal() * drift * done.traveled_m.sqrt();
                self.base.drift(angle);
                self.odometer.drifted(angle);
            }
            let _ = self.report(pilot, from, &done);
            whole.touched |= done.touched;
            whole.traveled_m += done.traveled_m;
            whole.min_clearance_m = whole.min_clearance_m.min(done.min_clearance_m);
        }
        Moved {
            from,
            to: self.base.pose().position,
            traveled_m: whole.traveled_m,
            clearance_m: whole.min_clearance_m,
            touched: whole.touched,
        }
    }
}
