//! Drives one method in one world with one seed: it learns, restarts at the world's start, is
//! measured.

use super::method::{ComparedMethod, Constants, MOVES};
use super::observer::{DriverObservation, ObservedDriver};
use crate::baselines::{
    Learner, LearnerDriver, NearestSample, PotentialField, QLazy, QSom, QTable, QTwoSoms,
    RandomMoves, VfhPlus, learning::LearnerTraining, nearest,
};
use crate::controls::{ControlPilot, Slot};
use amp::config::Config;
use amp::controller::StatePart;
use arena::noise::Noise;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::World;
use sim::behavior::Behavior;
use sim::braitenberg::Braitenberg;
use sim::episode::{Body, Seeds, Setup, drive_pilot, run_with};
use sim::error::EpisodeError;
use sim::pilot::InspectableController;
use sim::ring_pilot::Policy;
use sim::robot::AnyRobot;
use sim::sim_controller::SimController;
use sim::turret_pilot::PolicyPilot;
use std::f64::consts::TAU;

/// How a method is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Conditions {
    /// The robot; `None` = the Nomad as it is.
    pub robot: Option<AnyRobot>,
    /// Measured decisions, after learning.
    pub steps: u32,
    /// Sonar model.
    pub sonar: SonarModel,
    /// The shield limits every motion, including those of learning; a robot has a guard instead.
    pub shield: bool,
    /// Measures wall time.
    pub timed: bool,
}

/// Result of one method with one budget, world and seed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodOutcome {
    /// Contacts while learning.
    pub learning_contacts: u32,
    /// Measured steps with contact.
    pub contacts: u32,
    /// Distance traveled, m.
    pub distance_m: f64,
    /// Area swept, m².
    pub coverage_m2: f64,
    /// Smallest gap to any surface, m.
    pub clearance_m: f64,
    /// Bytes of the learned state.
    pub bytes: usize,
    /// Observation of its decisions.
    pub observation: DriverObservation,
}

/// A method with its constants and budgets.
pub struct MethodUnderTest<'a> {
    /// The method.
    pub method: ComparedMethod,
    /// Its constants.
    pub constants: &'a Constants,
    /// Numbers of learning moves after which it is measured, rising; those of
    /// [`ComparedMethod::budgets`].
    pub budgets: &'a [u32],
}

/// Measures a method after each of its budgets; a longer training continues the shorter one.
///
/// # Errors
/// When the controller refuses a command or does not answer.
pub fn drive(
    candidate: &MethodUnderTest<'_>,
    world: &World,
    seed: u64,
    conditions: &Conditions,
) -> Result<Vec<MethodOutcome>, EpisodeError> {
    let constants = candidate.constants;
    let robot = conditions.robot.clone();
    let place = MeasuredSite {
        world,
        seeds: Seeds::of(seed),
        conditions,
        robot: robot.map(|robot| robot.with_guard(conditions.shield)),
    };
    let budgets = candidate.budgets;
    let course = place.course();
    match candidate.method {
        ComparedMethod::Random => place.fixed(RandomMoves::new(place.seeds.exploration)),
        ComparedMethod::Braitenberg => {
            place.fixed(Braitenberg::towards(constants.braitenberg, course))
        }
        ComparedMethod::PotentialField => {
            place.fixed(PotentialField::new(constants.potential_field, course))
        }
        ComparedMethod::VfhPlus => place.fixed(VfhPlus::new(constants.vfh_plus, course)),
        ComparedMethod::NearestChange => place.nearest(constants.nearest_change, budgets),
        ComparedMethod::NearestPair => place.nearest(constants.nearest_pair, budgets),
        ComparedMethod::QLazy => {
            let (tuning, training) = constants.q_lazy;
            place.train_and_measure(QLazy::new(tuning), training, budgets)
        }
        ComparedMethod::QTable => {
            let (tuning, training) = constants.q_table;
            place.train_and_measure(QTable::new(tuning), training, budgets)
        }
        ComparedMethod::QSom => {
            let (tuning, training) = constants.q_som;
            place.train_and_measure(QSom::new(tuning), training, budgets)
        }
        ComparedMethod::QTwoSoms => {
            let (tuning, training) = constants.q_two_soms;
            place.train_and_measure(QTwoSoms::new(tuning), training, budgets)
        }
        ComparedMethod::Cosine | ComparedMethod::LeastSquares | ComparedMethod::NearestFit => {
            place.control(candidate.method, budgets, seed)
        }
        ComparedMethod::Default => place.controller(Config::recommended(), TurretMode::Held, seed),
        ComparedMethod::Probe => place.controller(Config::probing(), TurretMode::Held, seed),
        ComparedMethod::Touzet => place.controller(Config::touzet(), TurretMode::Follow, seed),
    }
}

/// A world, a seed and the conditions.
struct MeasuredSite<'a> {
    world: &'a World,
    seeds: Seeds,
    conditions: &'a Conditions,
    /// The robot, with a guard or without.
    robot: Option<AnyRobot>,
}

impl MeasuredSite<'_> {
    /// First heading of a driver that has none of its own.
    fn course(&self) -> f64 {
        Noise::new(self.seeds.exploration).uniform_in(0.0, TAU)
    }

    fn body(&self) -> Body<'_> {
        let (world, sonar, noise) = (self.world, self.conditions.sonar, self.seeds.noise);
        match &self.robot {
            None => Body::new(world, sonar, TurretMode::Held, noise),
            Some(robot) => Body::of_robot(world, robot, sonar, noise),
        }
    }

    fn pilot<P: Policy>(&self, policy: P) -> PolicyPilot<P> {
        let config = Config::recommended();
        match &self.robot {
            None => {
                let shield = config.shield.filter(|_| self.conditions.shield);
                PolicyPilot::of_nomad(policy, shield)
            }
            Some(robot) => PolicyPilot::of_robot(robot.config(config), robot, policy),
        }
    }

    /// Measures a policy without training.
    fn measured<P: Policy>(
        &self,
        policy: P,
        learning_contacts: u32,
    ) -> Result<MethodOutcome, EpisodeError> {
        let mut observer = ObservedDriver::new(self.pilot(policy), self.conditions.timed);
        let tally = drive_pilot(
            self.world,
            &mut observer,
            self.body(),
            self.conditions.steps,
        )?;
        Ok(MethodOutcome {
            learning_contacts,
            contacts: tally.contacts,
            distance_m: tally.distance_m,
            coverage_m2: tally.coverage_m2(),
            clearance_m: tally.min_clearance_m.unwrap_or(0.0),
            bytes: observer.driver().policy().bytes(),
            observation: observer.observation(),
        })
    }

    fn fixed<P: Policy>(&self, policy: P) -> Result<Vec<MethodOutcome>, EpisodeError> {
        Ok(vec![self.measured(policy, 0)?])
    }

    /// Trains a learner in this world and measures it after each budget. Nothing is reset in
    /// between: after a contact the robot stays where it is.
    fn train_and_measure<L: Learner>(
        &self,
        learner: L,
        training: LearnerTraining,
        budgets: &[u32],
    ) -> Result<Vec<MethodOutcome>, EpisodeError> {
        let trainee = LearnerDriver::new(learner, training, self.seeds.exploration);
        let mut pilot = self.pilot(trainee);
        let mut body = self.body();
        let mut outcomes = Vec::new();
        for budget in budgets {
            while pilot.policy().moves() < *budget {
                let _ = body.advance(&mut pilot);
            }
            let settled = pilot.policy().settled(self.course());
            outcomes.push(self.measured(settled, pilot.policy().contacts())?);
        }
        Ok(outcomes)
    }

    fn nearest(
        &self,
        (tuning, far_m): (nearest::NearestTuning, f64),
        budgets: &[u32],
    ) -> Result<Vec<MethodOutcome>, EpisodeError> {
        let training = nearest::training(&tuning, far_m);
        self.train_and_measure(NearestSample::new(tuning), training, budgets)
    }

    fn controller(
        &self,
        config: Config<16>,
        turret: TurretMode,
        seed: u64,
    ) -> Result<Vec<MethodOutcome>, EpisodeError> {
        let setup = self.setup(config, turret, seed);
        let controller = SimController::new(&setup.config, self.robot.as_ref());
        Ok(vec![self.observed(&setup, controller)?])
    }

    /// The preset `default` with something else in place of its action map.
    fn control(
        &self,
        method: ComparedMethod,
        budgets: &[u32],
        seed: u64,
    ) -> Result<Vec<MethodOutcome>, EpisodeError> {
        let mut config = Config::recommended();
        config.online = None;
        let mut setup = self.setup(config, TurretMode::Held, seed);
        // The controller seeks after it has explored: one move where none is needed.
        let moves = budgets.first().copied().unwrap_or(MOVES);
        setup.explore_moves = moves.max(1) as u16;
        let slot = method.slot().unwrap_or(Slot::Trained);
        let controller = ControlPilot::<16>::new(setup.config.clone(), slot);
        Ok(vec![self.observed(&setup, controller)?])
    }

    fn setup(&self, mut config: Config<16>, turret: TurretMode, seed: u64) -> Setup {
        if !self.conditions.shield {
            config.shield = None;
        }
        if let Some(robot) = &self.robot {
            config = robot.config(config);
        }
        Setup {
            config,
            preset: String::new(),
            behavior: Behavior::Avoid,
            explore_moves: MOVES as u16,
            steps: self.conditions.steps,
            seed,
            sonar: self.conditions.sonar,
            turret,
            robot: self.robot.clone(),
            // Every method is measured from the world's start.
            set_down: Some(self.world.start().position),
            faults: Vec::new(),
            goal: None,
            second_robot: false,
            record: false,
        }
    }

    /// Measures the controller.
    fn observed(
        &self,
        setup: &Setup,
        controller: impl InspectableController,
    ) -> Result<MethodOutcome, EpisodeError> {
        let mut observer = ObservedDriver::new(controller, self.conditions.timed);
        let report = run_with(self.world, setup, &mut observer, |_, _, _| {})?.report;
        let observation = observer.observation();
        let state = observer.knowledge()?;
        let parts = [
            StatePart::Situations,
            StatePart::Changes,
            StatePart::Actions,
            StatePart::Memory,
        ];
        Ok(MethodOutcome {
            learning_contacts: report.explore_contacts,
            contacts: report.contacts,
            distance_m: report.distance_m,
            coverage_m2: report.coverage_m2,
            clearance_m: report.min_clearance_m,
            bytes: parts.iter().map(|part| state.part_len(*part)).sum(),
            observation,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use arena::robot_model::RobotModel;
    use sim::robot::Ranges;

    const CONDITIONS: Conditions = Conditions {
        robot: None,
        steps: 60,
        sonar: SonarModel::Ideal,
        shield: false,
        timed: false,
    };

    fn outcomes(method: ComparedMethod, budgets: &[u32], shield: bool) -> Vec<MethodOutcome> {
        let conditions = Conditions {
            shield,
            ..CONDITIONS
        };
        of(method, budgets, &conditions)
    }

    fn of(method: ComparedMethod, budgets: &[u32], conditions: &Conditions) -> Vec<MethodOutcome> {
        let candidate = MethodUnderTest {
            method,
            constants: &Constants::of(false),
            budgets,
        };
        drive(&candidate, &World::random(20_001), 4, conditions).expect("it drives")
    }

    #[test]
    fn every_method_drives_and_touches_nothing_with_the_shield() {
        for method in ComparedMethod::ALL {
            let budgets = method.budgets(&[20, 40]);
            let outcomes = outcomes(method, &budgets, true);
            assert_eq!(outcomes.len(), budgets.len());
            for outcome in outcomes {
                assert_eq!(
                    outcome.contacts + outcome.learning_contacts,
                    0,
                    "{method:?}"
                );
                assert!(outcome.distance_m > 0.5 && outcome.bytes > 0, "{method:?}");
                assert!(outcome.observation.decisions >= 60, "{method:?}");
            }
        }
    }

    #[test]
    fn every_method_drives_another_robot_and_its_guard_keeps_it_from_what_it_sees() {
        let model = RobotModel::builtin("p3dx").expect("built in");
        let robot = AnyRobot::new(model, Ranges::Nomad, false).expect("it fits");
        let on_any_robot = |method: &ComparedMethod| method.slot().is_none();
        for method in ComparedMethod::ALL.into_iter().filter(on_any_robot) {
            let conditions = Conditions {
                robot: Some(robot.clone()),
                shield: true,
                ..CONDITIONS
            };
            let outcome = of(method, &method.budgets(&[20]), &conditions)[0];
            let contacts = (outcome.learning_contacts, outcome.contacts);
            assert_eq!(contacts, (0, 0), "{method:?}");
            assert!(
                outcome.distance_m > 0.5 && outcome.bytes > 0,
                "{method:?}: {outcome:?}"
            );
        }
    }

    #[test]
    fn a_long_training_goes_on_from_the_short_one() {
        let alone = outcomes(ComparedMethod::QTable, &[150], false);
        let both = outcomes(ComparedMethod::QTable, &[50, 150], false);
        assert_eq!(alone[0], both[1]);
        assert_ne!(both[0], both[1]);
    }
}
