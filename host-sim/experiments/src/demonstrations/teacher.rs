//! A teacher drives the robot, and its steps are recorded.

use super::measure::Path;
use super::rules::{Rule, TeacherView};
use super::tasks::{Task, TaskKind};
use amp::config::Config;
use amp::fixed::Mask;
use amp::goal::Goal;
use amp::planner::Planner;
use amp::scan::Situation;
use amp::units::Displacement;
use arena::noise::Noise;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::{Point, World};
use sim::demonstration::{DemonstrationRecorder, ShownStep};
use sim::episode::{Body, Seeds};
use sim::error::EpisodeError;
use sim::pilot::SimState;
use sim::ring_pilot::{Perception, Policy, RingPilot, STEP_M};
use std::f64::consts::TAU;

/// Each move of this number is random.
const DISTURBED: u32 = 5;

/// Who demonstrates a task.
pub struct Demonstrator<'a> {
    /// The task.
    pub task: &'a Task,
    /// The controller's configuration.
    pub config: &'a Config<16>,
    /// What the teacher's robot learned.
    pub state: &'a SimState,
    /// Some moves are random.
    pub disturbed: bool,
}

/// A drive.
pub struct Driven {
    /// The demonstrated steps, without the random ones.
    pub shown: Vec<ShownStep>,
    /// The path.
    pub path: Path,
}

impl Demonstrator<'_> {
    /// Drives from a place for so many decisions.
    ///
    /// # Errors
    /// When the robot stops deciding.
    pub fn drive(
        &self,
        world: &World,
        start: Point,
        sonar: SonarModel,
        steps: u32,
        seed: u64,
    ) -> Result<Driven, EpisodeError> {
        let teaching = match self.task.kind {
            TaskKind::BuiltIn => {
                let goal = self.task.behavior().fixed_goal(self.config);
                Teaching::Goal(Box::new(
                    goal.unwrap_or_else(|| Goal::avoiding(self.config)),
                ))
            }
            TaskKind::ByRule { rule, .. } => Teaching::Rule(rule),
        };
        let mut body = Body::new(world, sonar, TurretMode::Held, Seeds::of(seed).noise);
        body.set_down_at(start);
        if self.task.leader {
            body.add_leader();
        }
        let mut pilot = RingPilot::new(self.teacher(world, teaching, seed), None);
        let mut path = Path::default();
        let mut decisions = 0;
        // With timed sonars a ring takes 16 steps of the simulation, and a motion several.
        let limit = steps.saturating_mul(1_000);
        for _ in 0..limit {
            pilot.policy_mut().see(&body);
            let result = body.advance(&mut pilot);
            path.contacts += u32::from(result.collision.is_some());
            if result.decision.is_some() {
                path.places.push((body.pose().position, body.leader()));
                decisions += 1;
                if decisions >= steps {
                    let shown = pilot.into_policy().recorder.into_shown();
                    return Ok(Driven { shown, path });
                }
            }
        }
        Err(EpisodeError::Silent)
    }

    fn teacher<'w>(&'w self, world: &'w World, teaching: Teaching, seed: u64) -> Teacher<'w> {
        Teacher {
            config: self.config,
            state: self.state,
            teaching,
            noise: self.disturbed.then(|| Noise::new(seed ^ 0x5eed)),
            view: TeacherView {
                world,
                at: Point::default(),
                leader: None,
                course: Point::new(1.0, 0.0),
            },
            decisions: 0,
            recorder: DemonstrationRecorder::default(),
        }
    }
}

enum Teaching {
    /// A built-in goal, pursued by the planner.
    Goal(Box<Goal<16>>),
    /// A rule that sees the world.
    Rule(Rule),
}

/// A policy that records what it does.
struct Teacher<'w> {
    config: &'w Config<16>,
    state: &'w SimState,
    teaching: Teaching,
    /// Random moves.
    noise: Option<Noise>,
    view: TeacherView<'w>,
    decisions: u32,
    recorder: DemonstrationRecorder,
}

impl Teacher<'_> {
    fn see(&mut self, body: &Body<'_>) {
        self.view.at = body.pose().position;
        self.view.leader = body.leader();
    }

    /// The motion before this decision, in mm.
    fn moved(&mut self, perceived: &Perception) -> Displacement {
        let Some(last) = perceived.last else {
            return Displacement::ZERO;
        };
        let millimeters = |meters: f64| libm::round(meters * 1e3) as i32;
        let moved = Displacement::saturating(millimeters(last.moved.x), millimeters(last.moved.y));
        if moved != Displacement::ZERO {
            self.view.course = last.moved;
        }
        moved
    }

    fn taught(&self, situation: &Situation<16>) -> Point {
        match &self.teaching {
            Teaching::Rule(rule) => rule(&self.view),
            Teaching::Goal(goal) => {
                let planner = Planner {
                    config: self.config,
                    situations: self.state.situations(),
                    actions: self.state.actions(),
                    enabled: Mask::ALL,
                    allowed: Mask::ALL,
                    current: None,
                    course: self.recorder.course(),
                    cut: false,
                };
                let action = planner.plan(situation, goal).action;
                let meters = |mm: i16| f64::from(mm) / 1e3;
                Point::new(meters(action.dx_mm), meters(action.dy_mm))
            }
        }
    }
}

impl Policy for Teacher<'_> {
    fn decide(&mut self, perceived: &Perception) -> Point {
        let moved = self.moved(perceived);
        self.decisions += 1;
        let disturbed = match &mut self.noise {
            Some(noise) if self.decisions.is_multiple_of(DISTURBED) => {
                Some(Point::unit(noise.uniform_in(0.0, TAU)) * STEP_M)
            }
            _ => None,
        };
        let value = |range| self.config.encoding.value(range);
        let situation = perceived.ranges.map(value);
        let shown = disturbed.is_none().then_some((situation, Mask::ALL));
        self.recorder.decided(moved, perceived.turned, shown);
        disturbed.unwrap_or_else(|| self.taught(&situation))
    }
}
