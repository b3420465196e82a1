//! A controller that explores by itself and then pursues its goals as a rival does.

use super::codebook::replace_action_map;
use super::goal_cost::number;
use super::policy::{CostModel, ModelPolicy};
use super::transition::Transition;
use super::{Part, Rival};
use amp::config::Config;
use amp::controller::{Command, Event, Mode, Outputs, StatePart};
use amp::goal::Goal;
use amp::scan::Situation;
use amp::units::{Displacement, Millis};
use arena::world::Point;
use sim::error::EpisodeError;
use sim::pilot::{InspectableController, LocalController, Pilot, SimState};
use sim::ring_pilot::RingPilot;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Wall times of a controller; all zero unless they are measured.
#[derive(Debug, Clone, Copy, Default)]
pub struct RivalTimes {
    /// Of learning from the random moves.
    pub learning: Duration,
    /// Of all decisions towards the goal.
    pub decisions: Duration,
    /// How many decisions these are.
    pub count: u32,
}

/// What a rival has learned from the random moves.
#[derive(Clone)]
pub enum Learned {
    /// A model.
    Model(Arc<dyn CostModel>),
    /// The controller's state with its maps.
    Maps(Box<SimState>),
}

/// The controller of the Nomad 200 with a rival in it.
pub struct RivalController {
    rival: Rival,
    symmetric: bool,
    seed: u64,
    config: Config<16>,
    inner: LocalController,
    /// Situation in which the current random move was chosen.
    before: Option<Situation<16>>,
    transitions: Vec<Transition>,
    /// What it has learned, if it has.
    learned: Option<Learned>,
    /// What drives while a model pursues a goal.
    ring: Option<RingPilot<ModelPolicy>>,
    settled: bool,
    timed: bool,
    times: RivalTimes,
}

impl RivalController {
    /// A controller without any knowledge; `seed` is that of the rival's own random choices.
    /// `learned` is what it has learned from the same random moves before: it makes them again, and
    /// does not learn again.
    #[must_use]
    pub fn new(
        rival: Rival,
        symmetric: bool,
        config: &Config<16>,
        seed: u64,
        learned: Option<Learned>,
        timed: bool,
    ) -> Self {
        let mut config = config.clone();
        config.learning.augment_rotations = symmetric;
        if rival == Rival::FrozenMaps {
            config.online = None;
        }
        let mut exploring = config.clone();
        if rival.is_model() || learned.is_some() {
            // These maps are not used.
            exploring.learning.epochs = 1;
        }
        Self {
            rival,
            symmetric,
            seed,
            inner: LocalController::new(exploring),
            config,
            before: None,
            transitions: Vec::new(),
            learned,
            ring: None,
            settled: false,
            timed,
            times: RivalTimes::default(),
        }
    }

    /// What it has learned, if it has pursued a goal.
    #[must_use]
    pub fn learned(&self) -> Option<&Learned> {
        self.learned.as_ref()
    }

    /// The random moves and what they changed.
    #[must_use]
    pub fn transitions(&self) -> &[Transition] {
        &self.transitions
    }

    /// Its wall times.
    #[must_use]
    pub const fn times(&self) -> RivalTimes {
        self.times
    }

    /// Bytes of what a decision needs, at four per number: the model, or the maps.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let maps = [
            StatePart::Situations,
            StatePart::Changes,
            StatePart::Actions,
        ];
        match &self.learned {
            Some(Learned::Model(model)) => 4 * model.numbers(),
            _ => maps
                .map(|map| self.inner.state().part_len(map))
                .iter()
                .sum(),
        }
    }

    /// Keeps the last random move if the controller has just remembered it.
    fn record(&mut self, outputs: &Outputs<16>) {
        let state = self.inner.state();
        let samples = state.memory().samples();
        if let (Some(before), Some(sample)) = (self.before, samples.last())
            && samples.len() > self.transitions.len()
        {
            let after = self.config.encoding.situation(state.scan());
            let most_mm = self.config.learning.largest_change_mm;
            let same = self
                .config
                .encoding
                .changed_within(&before, &after, most_mm);
            let known = state.enabled(&self.config).and(same);
            let (from, to) = (before.map(number), after.map(number));
            self.transitions.push(Transition {
                before: from,
                moved: steps(sample.executed, &self.config),
                change: std::array::from_fn(|i| to[i] - from[i]),
                known: std::array::from_fn(|i| known.contains(i)),
            });
        }
        if let Some(decision) = &outputs.decision {
            self.before = Some(decision.situation);
        }
    }

    /// Uses what the rival learns from the random moves.
    fn settle(&mut self) {
        if std::mem::replace(&mut self.settled, true) {
            return;
        }
        let learned = self.learned.take().unwrap_or_else(|| self.learn());
        if let Learned::Maps(state) = &learned {
            let state = (**state).clone();
            self.inner = LocalController::with_state(self.config.clone(), state);
        }
        self.learned = Some(learned);
    }

    fn learn(&self) -> Learned {
        let mut state = Box::new(self.inner.state().clone());
        match self.rival.part() {
            Part::Model(fit) => {
                return Learned::Model(fit(&self.transitions, self.symmetric, self.seed));
            }
            Part::Codebook(train) => {
                let codes = train(&self.transitions, self.symmetric, self.seed);
                // Never refused: it has learned and is idle.
                let _ = replace_action_map(&mut state, &codes);
            }
            Part::Whole => {}
        }
        Learned::Maps(state)
    }

    /// Lets the model drive, if there is one.
    fn drive_to(&mut self, goal: &Goal<16>) {
        let Some(Learned::Model(model)) = &self.learned else {
            return;
        };
        let samples = self.inner.state().memory().samples();
        let last = samples
            .last()
            .map_or(Displacement::ZERO, |one| one.commanded);
        let course = steps(last, &self.config);
        let policy = ModelPolicy::new(Arc::clone(model), &self.config, *goal, course);
        self.ring = Some(RingPilot::new(policy, self.config.shield));
    }
}

/// A displacement in units of the longest step.
fn steps(way: Displacement, config: &Config<16>) -> Point {
    let step = f64::from(config.robot.step_mm);
    Point::new(f64::from(way.dx_mm) / step, f64::from(way.dy_mm) / step)
}

impl Pilot for RivalController {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        let began = self.timed.then(Instant::now);
        let elapsed = || began.map_or(Duration::ZERO, |began| began.elapsed());
        if let Event::Command(Command::Seek(goal)) = &event {
            self.settle();
            self.times.learning += elapsed();
            self.drive_to(goal);
            if self.ring.is_some() {
                return Outputs::NONE;
            }
        }
        if let Some(ring) = &mut self.ring {
            let outputs = ring.handle(at, event);
            if outputs.decision.is_some() {
                self.times.decisions += elapsed();
                self.times.count += 1;
            }
            return outputs;
        }
        let explores = matches!(self.inner.state().mode(), Mode::Explore { .. });
        let learns = matches!(self.inner.state().mode(), Mode::Learn { .. });
        let outputs = self.inner.handle(at, event);
        if explores {
            self.record(&outputs);
        } else if learns && !self.rival.is_model() {
            self.times.learning += elapsed();
        } else if outputs.decision.is_some() {
            self.times.decisions += elapsed();
            self.times.count += 1;
        }
        outputs
    }
}

impl InspectableController for RivalController {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        Ok(self.inner.state())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use arena::robot::TurretMode;
    use arena::sonar::SonarModel;
    use arena::world::World;
    use sim::behavior::Behavior;
    use sim::episode::{Setup, run, run_with};

    fn setup(behavior: Behavior) -> Setup {
        let mut config = Config::recommended();
        config.shield = None;
        Setup {
            config,
            preset: "default".to_owned(),
            behavior,
            explore_moves: 30,
            steps: 100,
            seed: 5,
            sonar: SonarModel::Ideal,
            turret: TurretMode::Held,
            robot: None,
            set_down: None,
            faults: Vec::new(),
            goal: None,
            second_robot: false,
            record: false,
        }
    }

    fn controller(rival: Rival, symmetric: bool, setup: &Setup) -> RivalController {
        RivalController::new(rival, symmetric, &setup.config, 1, None, false)
    }

    #[test]
    fn without_a_rival_it_is_the_controller() {
        let (world, setup) = (World::random(205), setup(Behavior::WallRight));
        let mut whole = controller(Rival::Maps, true, &setup);
        let report = |episode: sim::episode::Episode| episode.report;
        let ours = run_with(&world, &setup, &mut whole, |_, _, _| {}).map(report);
        let theirs = run(&world, &setup, |_, _, _| {}).map(report);
        assert_eq!(ours, theirs);
    }

    #[test]
    fn every_rival_learns_from_the_same_moves_and_drives_to_every_goal() {
        let world = World::random(206);
        for behavior in [Behavior::Avoid, Behavior::WallRight, Behavior::NEST] {
            let setup = setup(behavior);
            let mut first = None;
            for rival in Rival::ALL {
                let mut controller = controller(rival, true, &setup);
                let episode = run_with(&world, &setup, &mut controller, |_, _, _| {});
                let report = episode.expect("it drives").report;
                assert!(report.distance_m > 0.5, "{rival:?}: {report:?}");
                assert_eq!(controller.transitions().len(), 30, "{rival:?}");
                let seen = first.get_or_insert_with(|| controller.transitions().to_vec());
                assert_eq!(controller.transitions(), seen, "{rival:?}");
                assert!(controller.bytes() > 100, "{rival:?}");
            }
        }
    }

    /// The recorded transitions are those of the lazy memory, in full resolution.
    #[test]
    fn transitions_are_the_samples_of_the_memory() {
        let (world, setup) = (World::random(207), setup(Behavior::Avoid));
        let mut whole = controller(Rival::Maps, true, &setup);
        run_with(&world, &setup, &mut whole, |_, _, _| {}).expect("it drives");
        let samples = whole.inner.state().memory().samples();
        let mut unknown = 0;
        for (sample, transition) in samples.iter().zip(&whole.transitions) {
            assert_eq!(transition.moved, steps(sample.executed, &setup.config));
            for sensor in 0..16 {
                let [before, after] = [sample.before, sample.after].map(|bytes| bytes[sensor]);
                if before == u8::MAX {
                    unknown += 1;
                    assert!(!transition.known[sensor]);
                    continue;
                }
                let change = (f64::from(after) - f64::from(before)) / 254.0;
                assert!(transition.known[sensor]);
                assert!((transition.change[sensor] - change).abs() < 0.005);
            }
        }
        assert!(unknown > 0 && unknown < 240, "{unknown}");
    }
}
