//! One method in one world with one seed: it learns, is set down at the start again, and is measured.

use super::method::{Constants, MOVES, Method};
use super::watch::{Seen, Watched};
use crate::baselines::{
    Learner, Nearest, PotentialField, QLazy, QSom, QTable, QTwoSoms, RandomMoves, Trainee, VfhPlus,
    learning::Schooling, nearest,
};
use amp::config::Config;
use amp::controller::Part;
use arena::noise::Noise;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::World;
use sim::behavior::Behavior;
use sim::braitenberg::Braitenberg;
use sim::episode::{Body, Seeds, Setup, drive_pilot, run_with};
use sim::error::EpisodeError;
use sim::pilot::LocalController;
use sim::ring_pilot::{Policy, RingPilot};
use std::f64::consts::TAU;

/// How a method is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditions {
    /// Decisions that are measured, after learning.
    pub steps: u32,
    /// What the sonars return.
    pub sonar: SonarModel,
    /// The shield limits every motion, while learning too.
    pub shield: bool,
    /// Look at the machine's clock.
    pub timed: bool,
}

/// What came of one method with one budget, world and seed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Contacts while learning.
    pub learning_contacts: u32,
    /// Steps with contact, of those measured.
    pub contacts: u32,
    /// Way traveled, m.
    pub distance_m: f64,
    /// Area swept, m².
    pub coverage_m2: f64,
    /// Least gap to any surface, m.
    pub clearance_m: f64,
    /// Bytes of what it has learned or remembers.
    pub bytes: usize,
    /// What was seen of its decisions.
    pub seen: Seen,
}

/// A method about to be measured.
pub struct Candidate<'a> {
    /// The method.
    pub method: Method,
    /// Its constants.
    pub constants: &'a Constants,
    /// Learning moves after which it is measured, rising; those of [`Method::budgets`].
    pub budgets: &'a [u32],
}

/// Measures a method after each of its budgets of learning moves; the longer trainings go on from the shorter ones.
///
/// # Errors
/// When the mind refuses a command or falls silent.
pub fn drive(
    candidate: &Candidate<'_>,
    world: &World,
    seed: u64,
    conditions: &Conditions,
) -> Result<Vec<Outcome>, EpisodeError> {
    let constants = candidate.constants;
    let place = Place {
        world,
        seeds: Seeds::of(seed),
        conditions,
    };
    let budgets = candidate.budgets;
    let course = place.course();
    match candidate.method {
        Method::Random => place.fixed(RandomMoves::new(place.seeds.exploration)),
        Method::Braitenberg => place.fixed(Braitenberg::towards(constants.braitenberg, course)),
        Method::PotentialField => {
            place.fixed(PotentialField::new(constants.potential_field, course))
        }
        Method::VfhPlus => place.fixed(VfhPlus::new(constants.vfh_plus, course)),
        Method::NearestChange => place.nearest(constants.nearest_change, budgets),
        Method::NearestPair => place.nearest(constants.nearest_pair, budgets),
        Method::QLazy => {
            let (tuning, schooling) = constants.q_lazy;
            place.taught(QLazy::new(tuning), schooling, budgets)
        }
        Method::QTable => {
            let (tuning, schooling) = constants.q_table;
            place.taught(QTable::new(tuning), schooling, budgets)
        }
        Method::QSom => {
            let (tuning, schooling) = constants.q_som;
            place.taught(QSom::new(tuning), schooling, budgets)
        }
        Method::QTwoSoms => {
            let (tuning, schooling) = constants.q_two_soms;
            place.taught(QTwoSoms::new(tuning), schooling, budgets)
        }
        Method::Default => place.mind(Config::recommended(), TurretMode::Held, seed),
        Method::Probe => place.mind(Config::probing(), TurretMode::Held, seed),
        Method::Touzet => place.mind(Config::touzet(), TurretMode::Follow, seed),
    }
}

/// A world, a seed and how it is measured there.
struct Place<'a> {
    world: &'a World,
    seeds: Seeds,
    conditions: &'a Conditions,
}

impl Place<'_> {
    /// The course with which a driver begins that has none of its own.
    fn course(&self) -> f64 {
        Noise::new(self.seeds.exploration).uniform_in(0.0, TAU)
    }

    fn body(&self) -> Body<'_> {
        let sonar = self.conditions.sonar;
        Body::new(self.world, sonar, TurretMode::Held, self.seeds.noise)
    }

    fn pilot<P: Policy>(&self, policy: P) -> RingPilot<P> {
        let shield = Config::recommended().shield;
        RingPilot::new(policy, shield.filter(|_| self.conditions.shield))
    }

    /// Measures a policy as it is.
    fn measured<P: Policy>(
        &self,
        policy: P,
        learning_contacts: u32,
    ) -> Result<Outcome, EpisodeError> {
        let mut watched = Watched::new(self.pilot(policy), self.conditions.timed);
        let tally = drive_pilot(self.world, &mut watched, self.body(), self.conditions.steps)?;
        Ok(Outcome {
            learning_contacts,
            contacts: tally.contacts,
            distance_m: tally.distance_m,
            coverage_m2: tally.coverage_m2(),
            clearance_m: tally.min_clearance_m.unwrap_or(0.0),
            bytes: watched.driver().policy().bytes(),
            seen: watched.seen(),
        })
    }

    fn fixed<P: Policy>(&self, policy: P) -> Result<Vec<Outcome>, EpisodeError> {
        Ok(vec![self.measured(policy, 0)?])
    }

    /// Teaches a learner in this world and measures it after each budget. Nothing is reset in between: after a contact the
    /// robot stays where it is.
    fn taught<L: Learner>(
        &self,
        learner: L,
        schooling: Schooling,
        budgets: &[u32],
    ) -> Result<Vec<Outcome>, EpisodeError> {
        let trainee = Trainee::new(learner, schooling, self.seeds.exploration);
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
        (tuning, far_m): (nearest::Tuning, f64),
        budgets: &[u32],
    ) -> Result<Vec<Outcome>, EpisodeError> {
        let schooling = nearest::schooling(&tuning, far_m);
        self.taught(Nearest::new(tuning), schooling, budgets)
    }

    fn mind(
        &self,
        mut config: Config<16>,
        turret: TurretMode,
        seed: u64,
    ) -> Result<Vec<Outcome>, EpisodeError> {
        if !self.conditions.shield {
            config.shield = None;
        }
        let setup = Setup {
            config: config.clone(),
            preset: String::new(),
            behavior: Behavior::Avoid,
            explore_moves: MOVES as u16,
            steps: self.conditions.steps,
            seed,
            sonar: self.conditions.sonar,
            turret,
            // All methods are measured from the world's start.
            set_down: Some(self.world.start().position),
            faults: Vec::new(),
            record: false,
        };
        let mut watched = Watched::new(LocalController::new(config), self.conditions.timed);
        let report = run_with(self.world, &setup, &mut watched, |_, _, _| {})?.report;
        let state = watched.driver().state();
        let parts = [Part::Situations, Part::Changes, Part::Actions, Part::Memory];
        Ok(vec![Outcome {
            learning_contacts: report.explore_contacts,
            contacts: report.contacts,
            distance_m: report.distance_m,
            coverage_m2: report.coverage_m2,
            clearance_m: report.min_clearance_m,
            bytes: parts.iter().map(|part| state.part_len(*part)).sum(),
            seen: watched.seen(),
        }])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONDITIONS: Conditions = Conditions {
        steps: 60,
        sonar: SonarModel::Ideal,
        shield: false,
        timed: false,
    };

    fn outcomes(method: Method, budgets: &[u32], shield: bool) -> Vec<Outcome> {
        let candidate = Candidate {
            method,
            constants: &Constants::of(false),
            budgets,
        };
        let conditions = Conditions {
            shield,
            ..CONDITIONS
        };
        drive(&candidate, &World::random(20_001), 4, &conditions).expect("it drives")
    }

    #[test]
    fn every_method_drives_and_touches_nothing_with_the_shield() {
        for method in Method::ALL {
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
                assert!(outcome.seen.decisions >= 60, "{method:?}");
            }
        }
    }

    #[test]
    fn a_long_training_goes_on_from_the_short_one() {
        let alone = outcomes(Method::QTable, &[150], false);
        let both = outcomes(Method::QTable, &[50, 150], false);
        assert_eq!(alone[0], both[1]);
        assert_ne!(both[0], both[1]);
    }
}
