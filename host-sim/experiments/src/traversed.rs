//! Whether the neuron aimed at is reached, and whether that helps to find a nest.
//!
//! An *aim* is one leg: the plan names another neuron than the present one, and the leg ends when
//! the best-matching neuron changes or after [`MAX_LEG`] moves. It is *reached* if the neuron that
//! follows is the one named at its begin. Legs that the plan gives up for one step are not counted.
//! Two controls on the same legs predict what follows from what followed the neuron before in the
//! same drive: the most frequent successor, whatever the action, and a random one of all.

use crate::bodies::Generator;
use amp::config::Config;
use amp::controller::{Command, Event, Outputs};
use amp::graph::MAX_LEG;
use amp::planner::{Plan, Why};
use amp::units::Millis;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use rayon::prelude::*;
use sim::behavior::{Behavior, Tour, TourBy};
use sim::episode::{Setup, run_with};
use sim::error::EpisodeError;
use sim::pilot::{InspectableController, LocalController, Pilot, SimState};

/// Neurons of the map.
const NEURONS: usize = 16;

/// Counts over the drives to the nest; counts of several drives can be added.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Aims {
    /// Drives.
    pub drives: u32,
    /// Of `drives`: ended at the nest.
    pub at_nest: u32,
    /// Of `drives`: touched something.
    pub touched: u32,
    /// Decisions.
    pub decisions: u32,
    /// Decisions that aimed at another neuron and were followed by another decision.
    pub moves: u32,
    /// Of `moves`: that neuron was the next one.
    pub after_one: u32,
    /// Legs.
    pub legs: u32,
    /// Of `legs`: the neuron aimed at was reached.
    pub reached: u32,
    /// Of `legs`: the most frequent successor until then followed.
    pub most_frequent: u32,
    /// Expected number of `legs` in which a random one of the successors until then followed.
    pub random: f64,
}

impl Aims {
    /// Counts the plans of one drive.
    #[must_use]
    pub fn of(plans: &[Plan<16>]) -> Self {
        let mut aims = Self {
            decisions: plans.len() as u32,
            ..Self::default()
        };
        let mut followed = [[0_u32; NEURONS]; NEURONS];
        let mut leg: Option<(u8, u8)> = None;
        for pair in plans.windows(2) {
            let [now, next] = [pair[0], pair[1]];
            let (from, to) = (now.current_neuron, next.current_neuron);
            let is_aim = now.why == Why::Neighbor && now.subgoal_neuron != from && !now.at_goal;
            if is_aim {
                aims.moves += 1;
                aims.after_one += u32::from(to == now.subgoal_neuron);
            }
            let (aim, moves) = leg.unwrap_or((now.subgoal_neuron, 0));
            leg = is_aim.then_some((aim, moves + 1));
            if is_aim && (from != to || moves + 1 >= MAX_LEG) {
                aims.end(
                    &followed[usize::from(from)],
                    (from != to).then_some(to),
                    aim,
                );
                leg = None;
            }
            if from != to {
                followed[usize::from(from)][usize::from(to)] += 1;
                leg = None;
            }
        }
        aims
    }

    /// A leg has ended at a neuron, if it has left its own.
    fn end(&mut self, followed: &[u32; NEURONS], at: Option<u8>, aim: u8) {
        self.legs += 1;
        let Some(at) = at else { return };
        self.reached += u32::from(at == aim);
        let often = followed[usize::from(at)];
        let first = followed
            .iter()
            .position(|n| Some(n) == followed.iter().max());
        self.most_frequent += u32::from(often > 0 && first == Some(usize::from(at)));
        if often > 0 {
            let successors = followed.iter().filter(|count| **count > 0).count();
            self.random += 1.0 / successors as f64;
        }
    }

    /// The sum of both.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            drives: self.drives + other.drives,
            at_nest: self.at_nest + other.at_nest,
            touched: self.touched + other.touched,
            decisions: self.decisions + other.decisions,
            moves: self.moves + other.moves,
            after_one: self.after_one + other.after_one,
            legs: self.legs + other.legs,
            reached: self.reached + other.reached,
            most_frequent: self.most_frequent + other.most_frequent,
            random: self.random + other.random,
        }
    }
}

/// The drives of a table: one in each world, with its seed.
#[derive(Debug, Clone, Copy)]
pub struct Drives {
    /// Where the worlds come from.
    pub generator: Generator,
    /// Seed of the first world.
    pub first: u64,
    /// Number of worlds.
    pub worlds: u32,
    /// Decisions of obstacle avoidance before the robot is set down elsewhere.
    pub tour: u32,
}

impl Drives {
    /// The seeds of the worlds, in order.
    #[must_use]
    pub fn seeds(&self) -> Vec<u64> {
        let numbers = 0..u64::from(self.worlds);
        numbers
            .map(|number| self.first.saturating_add(number))
            .collect()
    }
}

/// Plans of the last goal.
struct Observer {
    inner: LocalController,
    plans: Vec<Plan<16>>,
}

impl Pilot for Observer {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        if matches!(event, Event::Command(Command::Seek(_))) {
            self.plans.clear();
        }
        let outputs = self.inner.handle(at, event);
        let plan = outputs.decision.and_then(|decision| decision.plan);
        self.plans.extend(plan);
        outputs
    }
}

impl InspectableController for Observer {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        self.inner.knowledge()
    }
}

/// Drives to the nest in worlds of other kinds (`random2`), for 1000 decisions each, after a tour
/// of obstacle avoidance; one result per world, in order. The seed of a drive is its world's.
///
/// # Errors
/// When an episode fails.
pub fn measure(
    config: &Config<16>,
    turret: TurretMode,
    drives: &Drives,
    done: &(impl Fn() + Sync),
) -> Result<Vec<Aims>, EpisodeError> {
    let &Drives {
        generator, tour, ..
    } = drives;
    let one = |seed: u64| {
        let tour = Tour {
            steps: tour,
            by: TourBy::Avoid,
        };
        let setup = Setup {
            config: config.clone(),
            preset: String::new(),
            behavior: Behavior::Nest {
                tour,
                is_turned: false,
            },
            explore_moves: 100,
            steps: 1_000,
            seed,
            sonar: SonarModel::Ideal,
            turret,
            robot: None,
            set_down: None,
            faults: Vec::new(),
            goal: None,
            second_robot: false,
            record: false,
        };
        let mut observer = Observer {
            inner: LocalController::new(config.clone()),
            plans: Vec::new(),
        };
        let episode = run_with(&generator.world(seed), &setup, &mut observer, |_, _, _| {})?;
        done();
        Ok(Aims {
            drives: 1,
            at_nest: u32::from(episode.report.success > 0.5),
            touched: u32::from(episode.report.contacts > 0),
            ..Aims::of(&observer.plans)
        })
    };
    drives.seeds().into_par_iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::fixed::Weight;
    use amp::units::Displacement;

    fn plan(current_neuron: u8, subgoal_neuron: u8, why: Why) -> Plan<16> {
        Plan {
            goal_neuron: 9,
            current_neuron,
            subgoal_neuron,
            wanted: [Weight::ZERO; 16],
            action_neuron: 0,
            at_goal: false,
            recalled: false,
            action: Displacement::ZERO,
            why,
        }
    }

    #[test]
    fn a_leg_is_one_aim_whatever_its_moves() {
        let to = |now, aim| plan(now, aim, Why::Neighbor);
        let drive = [
            to(1, 2),
            to(1, 2),
            to(2, 3),
            to(4, 1),
            to(1, 2),
            to(2, 3),
            to(4, 4),
        ];
        let aims = Aims::of(&drive);
        assert_eq!((aims.moves, aims.after_one), (6, 3));
        assert_eq!((aims.legs, aims.reached), (5, 3));
        assert_eq!(aims.most_frequent, 2);
        assert!((aims.random - 2.0).abs() < 1e-9);
        // Aimed at nothing else.
        assert_eq!(Aims::of(&[plan(1, 1, Why::Neighbor), to(2, 3)]).legs, 0);
        assert_eq!(Aims::of(&[plan(1, 2, Why::LookAhead), to(2, 3)]).legs, 0);
        // What counts is the neuron named at the begin of the leg.
        let changed = Aims::of(&[to(1, 2), to(1, 3), to(1, 3), to(2, 3)]);
        assert_eq!((changed.legs, changed.reached), (1, 1));
        // A leg that does not end is an aim that was not reached.
        let stuck = Aims::of(&[to(1, 2); 14]);
        assert_eq!((stuck.legs, stuck.reached), (1, 0));
    }

    /// As in docs/graph.md, in fewer worlds.
    #[test]
    fn the_neuron_aimed_at_is_mostly_reached() {
        let worlds = Drives {
            generator: Generator::Random2,
            first: 1,
            worlds: 12,
            tour: 300,
        };
        let drives = measure(&Config::traversing(), TurretMode::Held, &worlds, &|| {});
        let all = drives.expect("they drive").into_iter();
        let all = all.fold(Aims::default(), Aims::plus);
        assert!(all.legs >= 100, "{all:?}");
        assert!(2 * all.reached >= all.legs, "{all:?}");
    }
}
