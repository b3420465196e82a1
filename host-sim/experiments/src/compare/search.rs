//! The search for the methods' constants: one after the other each is tried with every value of its range, the best is
//! kept, and all of them once more. It is made in rooms that nothing is compared in.

use super::drive::{Candidate, Conditions, Outcome, drive};
use super::method::{Constants, Method};
use arena::world::World;
use rayon::prelude::*;
use sim::error::EpisodeError;

/// A constant and the values it may take.
pub struct Knob {
    /// Its name.
    pub name: &'static str,
    /// Values tried.
    pub range: &'static [f64],
    get: fn(&Constants) -> f64,
    set: fn(&mut Constants, f64),
}

/// Shorthand: the place of a number inside the constants.
macro_rules! knob {
    ($name:literal, $range:expr, $($place:tt)+) => {
        Knob {
            name: $name,
            range: &$range,
            get: |constants| constants.$($place)+,
            set: |constants, value| constants.$($place)+ = value,
        }
    };
}

/// As [`knob!`], for a whole number.
macro_rules! whole {
    ($name:literal, $range:expr, $($place:tt)+) => {
        Knob {
            name: $name,
            range: &$range,
            get: |constants| constants.$($place)+ as f64,
            set: |constants, value| constants.$($place)+ = value as usize,
        }
    };
}

/// As [`knob!`], for what is done (1) or not (0).
macro_rules! switch {
    ($name:literal, $($place:tt)+) => {
        Knob {
            name: $name,
            range: &[0.0, 1.0],
            get: |constants| f64::from(u8::from(constants.$($place)+)),
            set: |constants, value| constants.$($place)+ = value > 0.0,
        }
    };
}

/// Below 0: the course is never kept.
const FREE: [f64; 4] = [-1.0, 0.0, 0.2, 0.4];

/// The constants of how a learner by reward is taught.
macro_rules! schooling {
    ($method:ident) => {
        [
            knob!("far m", [0.6, 0.8, 1.0, 1.5, 2.5], $method.1.far_m),
            knob!(
                "fallen",
                [0.05, 0.1, 0.2, 0.4, 0.8],
                $method.1.reward.fallen
            ),
            knob!(
                "in front",
                [0.5, 1.0, 1.5, 2.5, 4.0],
                $method.1.reward.in_front
            ),
            knob!("behind", [0.5, 1.0, 1.5, 2.5, 7.0], $method.1.reward.behind),
            knob!(
                "explores for",
                [50.0, 150.0, 300.0, 600.0],
                $method.1.explores_for
            ),
            knob!(
                "explores least",
                [0.0, 0.05, 0.1, 0.3],
                $method.1.explores_least
            ),
            whole!("turns", [1.0, 16.0], $method.1.turns),
            knob!("free below", FREE, $method.1.free_below),
            switch!("learns on", $method.1.learns_on),
        ]
    };
}

static POTENTIAL_FIELD: [Knob; 2] = [
    knob!(
        "reach m",
        [0.4, 0.6, 0.8, 1.0, 1.5],
        potential_field.reach_m
    ),
    knob!(
        "strength",
        [0.005, 0.01, 0.02, 0.05, 0.1, 0.2],
        potential_field.strength
    ),
];

static BRAITENBERG: [Knob; 2] = [
    knob!("far m", [0.5, 0.7, 0.9, 1.2, 1.6], braitenberg.far_m),
    knob!("push", [1.0, 2.0, 4.0, 8.0], braitenberg.push),
];

static VFH_PLUS: [Knob; 6] = [
    knob!("safety m", [0.05, 0.1, 0.15, 0.2], vfh_plus.safety_m),
    knob!("blocked m", [0.5, 0.6, 0.8, 1.0], vfh_plus.blocked_m),
    knob!("free m", [0.8, 1.0, 1.2, 1.4], vfh_plus.free_m),
    whole!("wide", [8.0, 12.0, 16.0, 24.0], vfh_plus.wide),
    knob!("slowest", [0.2, 0.5, 1.0], vfh_plus.slowest),
    knob!("last choice", [0.0, 1.0, 2.0], vfh_plus.weights[2]),
];

static NEAREST_CHANGE: [Knob; 3] = [
    knob!("far m", [0.8, 1.0, 1.5, 2.5, 4.5], nearest_change.1),
    knob!("goal", [0.05, 0.2, 0.4, 0.6, 0.8], nearest_change.0.goal),
    whole!("turns", [1.0, 16.0], nearest_change.0.turns),
];

static NEAREST_PAIR: [Knob; 3] = [
    knob!("far m", [0.8, 1.0, 1.5, 2.5, 4.5], nearest_pair.1),
    knob!("goal", [0.05, 0.2, 0.4, 0.6, 0.8], nearest_pair.0.goal),
    whole!("turns", [1.0, 16.0], nearest_pair.0.turns),
];

static Q_LAZY: [Knob; 9] = [
    whole!("neighbors", [1.0, 2.0, 4.0, 8.0], q_lazy.0.neighbors),
    knob!("discount", [0.0, 0.5, 0.8, 0.9], q_lazy.0.discount),
    knob!(
        "action weight",
        [0.2, 0.5, 0.7, 1.0, 1.5],
        q_lazy.0.action_weight
    ),
    whole!("turns", [1.0, 16.0], q_lazy.0.turns),
    knob!("far m", [0.6, 0.8, 1.0, 1.5, 2.5], q_lazy.1.far_m),
    knob!("fallen", [0.05, 0.1, 0.2, 0.4, 0.8], q_lazy.1.reward.fallen),
    knob!(
        "in front",
        [0.5, 1.0, 1.5, 2.5, 4.0],
        q_lazy.1.reward.in_front
    ),
    knob!("behind", [0.5, 1.0, 1.5, 2.5, 7.0], q_lazy.1.reward.behind),
    knob!("free below", FREE, q_lazy.1.free_below),
];

static Q_TABLE: [Knob; 3] = [
    knob!("threshold", [0.05, 0.1, 0.2, 0.3, 0.5], q_table.0.threshold),
    knob!("rate", [0.05, 0.1, 0.3, 0.6], q_table.0.rate),
    knob!("discount", [0.0, 0.5, 0.8, 0.9], q_table.0.discount),
];
static Q_TABLE_SCHOOLING: [Knob; 9] = schooling!(q_table);

static Q_SOM: [Knob; 8] = [
    knob!("rate", [0.1, 0.3, 0.5, 0.9], q_som.0.rate),
    knob!("discount", [0.0, 0.5, 0.8, 0.9], q_som.0.discount),
    knob!("pull", [0.1, 0.3, 0.5, 0.9], q_som.0.pull),
    knob!("pull least", [0.005, 0.02, 0.05], q_som.0.pull_least),
    knob!("fades", [500.0, 2_000.0, 10_000.0], q_som.0.fades),
    knob!("share", [0.0, 0.1, 0.25, 0.5], q_som.0.share),
    knob!("action weight", [0.3, 0.5, 0.7, 1.0], q_som.0.action_weight),
    knob!("value weight", [0.1, 0.25, 0.5, 1.0], q_som.0.value_weight),
];
static Q_SOM_SCHOOLING: [Knob; 9] = schooling!(q_som);

static Q_TWO_SOMS: [Knob; 6] = [
    knob!("rate", [0.1, 0.3, 0.5, 0.9], q_two_soms.0.rate),
    knob!("discount", [0.0, 0.5, 0.8, 0.9], q_two_soms.0.discount),
    knob!("pull", [0.05, 0.1, 0.3, 0.6], q_two_soms.0.pull),
    knob!("width", [0.3, 0.5, 1.0, 1.5], q_two_soms.0.width),
    knob!("fades", [500.0, 2_000.0, 10_000.0], q_two_soms.0.fades),
    knob!("least", [0.02, 0.1, 0.3], q_two_soms.0.least),
];
static Q_TWO_SOMS_SCHOOLING: [Knob; 9] = schooling!(q_two_soms);

/// The constants of a method that are searched for: its own, and those of how it is taught. None for the mind, whose open
/// choices have an ablation of their own, and for random moves.
#[must_use]
pub fn knobs(method: Method) -> Vec<&'static Knob> {
    let (own, schooling): (&[Knob], &[Knob]) = match method {
        Method::Braitenberg => (&BRAITENBERG, &[]),
        Method::PotentialField => (&POTENTIAL_FIELD, &[]),
        Method::VfhPlus => (&VFH_PLUS, &[]),
        Method::NearestChange => (&NEAREST_CHANGE, &[]),
        Method::NearestPair => (&NEAREST_PAIR, &[]),
        Method::QLazy => (&Q_LAZY, &[]),
        Method::QTable => (&Q_TABLE, &Q_TABLE_SCHOOLING),
        Method::QSom => (&Q_SOM, &Q_SOM_SCHOOLING),
        Method::QTwoSoms => (&Q_TWO_SOMS, &Q_TWO_SOMS_SCHOOLING),
        Method::Random | Method::Default | Method::Probe | Method::Touzet => (&[], &[]),
    };
    own.iter().chain(schooling).collect()
}

/// First room of the search.
pub const FIRST_ROOM: u64 = 20_001;
/// Rounds over all constants.
pub const ROUNDS: usize = 2;

/// What is searched with.
#[derive(Debug, Clone)]
pub struct Search {
    /// The method.
    pub method: Method,
    /// Learning moves of those that go on learning.
    pub moves: u32,
    /// Rooms, from [`FIRST_ROOM`] on.
    pub rooms: u32,
    /// How it is measured.
    pub conditions: Conditions,
}

impl Search {
    /// What a method is worth with these constants: mean area swept in m², divided by 1 + contacts per 100 m.
    ///
    /// # Errors
    /// When an episode fails.
    pub fn score(&self, constants: &Constants) -> Result<f64, EpisodeError> {
        let budgets = self.method.budgets(&[self.moves]);
        let candidate = Candidate {
            method: self.method,
            constants,
            budgets: budgets.get(..1).unwrap_or_default(),
        };
        let rooms = (FIRST_ROOM..FIRST_ROOM + u64::from(self.rooms)).into_par_iter();
        let outcomes: Result<Vec<Vec<Outcome>>, EpisodeError> = rooms
            .map(|room| drive(&candidate, &World::random(room), room, &self.conditions))
            .collect();
        let (mut contacts, mut way, mut area) = (0.0, 0.0, 0.0);
        for outcome in outcomes?.iter().flatten() {
            contacts += f64::from(outcome.contacts);
            way += outcome.distance_m;
            area += outcome.coverage_m2;
        }
        Ok(area / f64::from(self.rooms.max(1)) / (1.0 + 100.0 * contacts / f64::max(way, 1.0)))
    }

    /// Searches; `tried` hears of every constant that was settled: its name, its value and the score reached.
    ///
    /// # Errors
    /// When an episode fails.
    pub fn run(
        &self,
        from: Constants,
        mut tried: impl FnMut(&str, f64, f64),
    ) -> Result<Constants, EpisodeError> {
        let (mut best, mut most) = (from, self.score(&from)?);
        tried("as it is", f64::NAN, most);
        for _ in 0..ROUNDS {
            for knob in knobs(self.method) {
                for value in knob.range {
                    let mut changed = best;
                    (knob.set)(&mut changed, *value);
                    let score = self.score(&changed)?;
                    if score > most {
                        (best, most) = (changed, score);
                    }
                }
                tried(knob.name, (knob.get)(&best), most);
            }
        }
        Ok(best)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is documented as found has to be what is used: every default lies in its range.
    #[test]
    fn every_default_is_one_of_the_values_tried() {
        let constants = Constants::of(false);
        for method in Method::ALL {
            for knob in knobs(method) {
                let value = (knob.get)(&constants);
                assert!(
                    knob.range.contains(&value),
                    "{method:?} {} {value}",
                    knob.name
                );
                let mut changed = constants;
                (knob.set)(&mut changed, knob.range[0]);
                assert_eq!((knob.get)(&changed), knob.range[0]);
            }
        }
    }
}
