//! A simulated robot with any ring of transducers, exact sensors and exact motion.
//!
//! [Episodes](sim::episode) drive a Nomad 200. Here body and ring come from the controller's
//! [`RobotSpec`](amp::robot::RobotSpec): the same crate drives the miniature robot and rings of 8
//! or 24.

use amp::config::Config;
use amp::controller::{Command, Decision, Event, Mode, Motion, Outputs, Progress, State, handle};
use amp::goal::Goal;
use amp::som::Grid;
use amp::units::{Bearing, Displacement, Millis, Range};
use arena::robot::TurretMode;
use arena::world::{ConeShape, ConeView, Point, Pose, World, wrap_angle};
use std::f64::consts::TAU;

/// Random moves in the memory, as in the paper.
pub const MOVES: u16 = 100;

/// Sensor model of a transducer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorModel {
    /// Half the opening of its cone, rad.
    pub half_angle_rad: f64,
    /// Longest range from its face, m.
    pub reach_m: f64,
}

/// A robot with `SENSORS` transducers in a world.
pub struct AnyRing<'w, const SENSORS: usize> {
    config: Config<SENSORS>,
    state: Box<State<SENSORS, 16, { MOVES as usize }>>,
    world: &'w World,
    turret: TurretMode,
    sensor_model: SensorModel,
    pose: Pose,
    time_ms: u32,
}

/// Counts while it drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Count {
    /// Executed decisions.
    pub steps: u32,
    /// Steps with contact.
    pub contacts: u32,
    /// Steps decided while the goal was met.
    pub goal_steps: u32,
}

/// A ring and the motion that followed it.
struct RingStep<const SENSORS: usize> {
    decision: Option<Decision<SENSORS>>,
    touched: bool,
    mode_changed: bool,
}

impl<'w, const SENSORS: usize> AnyRing<'w, SENSORS> {
    /// An untrained robot at the world's start.
    #[must_use]
    pub fn new(
        config: Config<SENSORS>,
        world: &'w World,
        turret: TurretMode,
        sensor_model: SensorModel,
    ) -> Self {
        Self {
            config,
            state: Box::new(State::new(Grid::rectangle(4, 4))),
            world,
            turret,
            sensor_model,
            pose: world.start(),
            time_ms: 0,
        }
    }

    /// The controller's state.
    #[must_use]
    pub fn state(&self) -> &State<SENSORS, 16, { MOVES as usize }> {
        &self.state
    }

    /// Makes the random moves and learns both maps. Calls `stood` with each pose at rest.
    pub fn explore_and_learn(&mut self, seed: u64, mut stood: impl FnMut(Pose)) -> Count {
        let _ = self.send(Event::Command(Command::Explore { moves: MOVES, seed }));
        let mut count = Count::default();
        loop {
            stood(self.pose);
            let turn = self.turn();
            if turn.mode_changed || *self.state.mode() == Mode::Idle {
                break;
            }
            count.steps += 1;
            count.contacts += u32::from(turn.touched);
        }
        let _ = self.send(Event::Command(Command::Learn));
        while matches!(self.state.mode(), Mode::Learn { .. }) {
            let _ = self.send(Event::Tick);
        }
        count
    }

    /// Pursues a goal for `steps` decisions.
    pub fn seek(&mut self, goal: Goal<SENSORS>, steps: u32) -> Count {
        let _ = self.send(Event::Command(Command::Seek(goal)));
        let mut count = Count::default();
        for _ in 0..steps {
            let turn = self.turn();
            let Some(decision) = turn.decision else { break };
            count.steps += 1;
            count.contacts += u32::from(turn.touched);
            count.goal_steps += u32::from(decision.at_goal);
        }
        count
    }

    fn send(&mut self, event: Event<SENSORS>) -> Outputs<SENSORS> {
        let now = Millis::from_ms(self.time_ms);
        handle(&self.config, &mut self.state, now, event)
    }

    fn turn(&mut self) -> RingStep<SENSORS> {
        self.time_ms = self
            .time_ms
            .wrapping_add(u32::from(self.config.robot.ring_period_ms));
        let face_m = f64::from(self.config.robot.face_radius_mm) / 1e3;
        let reach_m = self.sensor_model.reach_m;
        let view = self.world.view(self.pose.position, face_m, reach_m);
        let mut turn = RingStep {
            decision: None,
            touched: false,
            mode_changed: false,
        };
        for sensor in 0..SENSORS {
            let range = self.range(sensor, &view);
            let sensor = sensor as u8;
            let outputs = self.send(Event::Echo { sensor, range });
            turn.decision = turn.decision.or(outputs.decision);
            turn.mode_changed |= outputs.mode_changed;
            if let Some(motion) = outputs.motion {
                turn.touched |= self.carry_out(motion);
            }
        }
        turn
    }

    fn range(&self, sensor: usize, view: &ConeView) -> Option<Range> {
        let direction = self.config.robot.directions.get(sensor)?;
        let axis = Point::new(f64::from(direction.x_q14), f64::from(direction.y_q14));
        let axis = (axis * (1.0 / axis.length().max(1.0))).turned(Point::unit(self.pose.heading));
        let cone = ConeShape::new(self.sensor_model.half_angle_rad);
        let range = view.nearest_in_cone(axis, cone);
        // The cast saturates: a range beyond 65 m counts as 65 m.
        (range <= self.sensor_model.reach_m).then(|| Range::from_mm((range * 1e3) as u16))
    }

    /// Moves straight up to the first contact and reports it; returns whether there was one.
    fn carry_out(&mut self, motion: Motion) -> bool {
        let Displacement { dx_mm, dy_mm } = motion.displacement;
        let commanded = Point::new(f64::from(dx_mm), f64::from(dy_mm)) * 1e-3;
        let (from, ring) = (self.pose.position, Point::unit(self.pose.heading));
        let radius_m = f64::from(self.config.robot.body_radius_mm) / 1e3;
        let to = from + commanded.turned(ring);
        let sweep = self.world.sweep(from, to, radius_m);
        let length = commanded.length();
        let share = if sweep.touched() && length > 0.0 {
            (sweep.traveled_m / length).min(1.0)
        } else {
            1.0
        };
        let done = commanded * share;
        self.pose.position = from + done.turned(ring);
        let mut turned = Bearing::ZERO;
        if self.turret == TurretMode::Follow && length > 0.0 {
            let turns = libm::rint(commanded.angle() / TAU * 65_536.0);
            turned = Bearing::from_turns(turns as i64 as u16);
            let angle = f64::from(turned.as_signed_turns()) / 65_536.0 * TAU;
            self.pose.heading = wrap_angle(self.pose.heading + angle);
        }
        let millimeters = |meters: f64| libm::rint(meters * 1e3) as i32;
        let moved = Displacement::saturating(millimeters(done.x), millimeters(done.y));
        let progress = if sweep.touched() {
            Progress::Touched
        } else {
            Progress::Ended
        };
        let _ = self.send(Event::Odometry {
            motion: motion.id,
            moved,
            turned,
            progress,
        });
        sweep.touched()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use arena::sonar::SonarModel;
    use sim::behavior::Behavior;
    use sim::episode::Seeds;
    use sim::pilot::LocalController;

    #[test]
    fn a_ring_of_16_remembers_what_the_nomad_does() {
        let world = World::random(3);
        let mut config = Config::recommended();
        config.shield = None;
        let sensor_model = SensorModel {
            half_angle_rad: 12.5_f64.to_radians(),
            reach_m: 255.0 * 0.0254,
        };
        let mut robot = AnyRing::new(config.clone(), &world, TurretMode::Held, sensor_model);
        let moves = robot.explore_and_learn(Seeds::of(3).exploration, |_| {});
        let setup = sim::episode::Setup {
            config: config.clone(),
            preset: String::new(),
            behavior: Behavior::Avoid,
            explore_moves: MOVES,
            steps: 1,
            seed: 3,
            sonar: SonarModel::Ideal,
            turret: TurretMode::Held,
            robot: None,
            set_down: None,
            faults: Vec::new(),
            goal: None,
            second_robot: false,
            record: false,
        };
        let mut mind = LocalController::new(config);
        let episode = sim::episode::run_with(&world, &setup, &mut mind, |_, _, _| {});
        let report = episode.expect("an episode").report;
        assert_eq!(
            (moves.steps, moves.contacts),
            (report.explore_moves, report.explore_contacts)
        );
        let samples = |mine: &[amp::memory::Sample<16>]| mine.to_vec();
        let (mine, its) = (
            samples(robot.state().memory().samples()),
            samples(mind.state().memory().samples()),
        );
        let same = mine
            .iter()
            .zip(&its)
            .filter(|(a, b)| a.commanded == b.commanded && a.executed == b.executed)
            .count();
        assert!(same >= 95, "{same} of 100 moves are the same");
    }
}
