//! Coordinate search for the methods' constants, in rooms that no comparison uses.
//!
//! Tries each value of one constant after another, keeps the best, and repeats the round.

use super::drive::{Conditions, MethodOutcome, MethodUnderTest, drive};
use super::method::{ComparedMethod, Constants};
use arena::world::World;
use rayon::prelude::*;
use sim::error::EpisodeError;

/// A constant and the values it may take.
pub struct TunedConstant {
    /// Its name.
    pub name: &'static str,
    /// Values to try.
    pub range: &'static [f64],
    get: fn(&Constants) -> f64,
    set: fn(&mut Constants, f64),
}

/// Defines a constant: accessor and values.
macro_rules! constant {
    ($name:literal, $range:expr, $($place:tt)+) => {
        TunedConstant {
            name: $name,
            range: &$range,
            get: |constants| constants.$($place)+,
            set: |constants, value| constants.$($place)+ = value,
        }
    };
}

/// As [`constant!`], for a whole number.
macro_rules! whole {
    ($name:literal, $range:expr, $($place:tt)+) => {
        TunedConstant {
            name: $name,
            range: &$range,
            get: |constants| constants.$($place)+ as f64,
            set: |constants, value| constants.$($place)+ = value as usize,
        }
    };
}

/// As [`constant!`], for a switch: on (1) or off (0).
macro_rules! switch {
    ($name:literal, $($place:tt)+) => {
        TunedConstant {
            name: $name,
            range: &[0.0, 1.0],
            get: |constants| f64::from(u8::from(constants.$($place)+)),
            set: |constants, value| constants.$($place)+ = value > 0.0,
        }
    };
}

/// Below 0: the heading is never kept.
const FREE: [f64; 4] = [-1.0, 0.0, 0.2, 0.4];

/// The constants of a learner's training.
macro_rules! training {
    ($method:ident) => {
        [
            constant!("far m", [0.6, 0.8, 1.0, 1.5, 2.5], $method.1.far_m),
            constant!(
                "fallen",
                [0.05, 0.1, 0.2, 0.4, 0.8],
                $method.1.reward.fallen
            ),
            constant!(
                "in front",
                [0.5, 1.0, 1.5, 2.5, 4.0],
                $method.1.reward.in_front
            ),
            constant!("behind", [0.5, 1.0, 1.5, 2.5, 7.0], $method.1.reward.behind),
            constant!(
                "explores for",
                [50.0, 150.0, 300.0, 600.0],
                $method.1.explores_for
            ),
            constant!(
                "explores least",
                [0.0, 0.05, 0.1, 0.3],
                $method.1.explores_least
            ),
            whole!("turns", [1.0, 16.0], $method.1.turns),
            constant!("free below", FREE, $method.1.free_below),
            switch!("learns on", $method.1.learns_on),
        ]
    };
}

static POTENTIAL_FIELD: [TunedConstant; 2] = [
    constant!(
        "reach m",
        [0.4, 0.6, 0.8, 1.0, 1.5],
        potential_field.reach_m
    ),
    constant!(
        "strength",
        [0.005, 0.01, 0.02, 0.05, 0.1, 0.2],
        potential_field.strength
    ),
];

static BRAITENBERG: [TunedConstant; 2] = [
    constant!("far m", [0.5, 0.7, 0.9, 1.2, 1.6], braitenberg.far_m),
    constant!("push", [1.0, 2.0, 4.0, 8.0], braitenberg.push),
];

static VFH_PLUS: [TunedConstant; 6] = [
    constant!("safety m", [0.05, 0.1, 0.15, 0.2], vfh_plus.safety_m),
    constant!("blocked m", [0.5, 0.6, 0.8, 1.0], vfh_plus.blocked_m),
    constant!("free m", [0.8, 1.0, 1.2, 1.4], vfh_plus.free_m),
    whole!("wide", [8.0, 12.0, 16.0, 24.0], vfh_plus.wide),
    constant!("slowest", [0.2, 0.5, 1.0], vfh_plus.slowest),
    constant!("last choice", [0.0, 1.0, 2.0], vfh_plus.weights[2]),
];

static NEAREST_CHANGE: [TunedConstant; 3] = [
    constant!("far m", [0.8, 1.0, 1.5, 2.5, 4.5], nearest_change.1),
    constant!("goal", [0.05, 0.2, 0.4, 0.6, 0.8], nearest_change.0.goal),
    whole!("turns", [1.0, 16.0], nearest_change.0.turns),
];

static NEAREST_PAIR: [TunedConstant; 3] = [
    constant!("far m", [0.8, 1.0, 1.5, 2.5, 4.5], nearest_pair.1),
    constant!("goal", [0.05, 0.2, 0.4, 0.6, 0.8], nearest_pair.0.goal),
    whole!("turns", [1.0, 16.0], nearest_pair.0.turns),
];

static Q_LAZY: [TunedConstant; 9] = [
    whole!("neighbors", [1.0, 2.0, 4.0, 8.0], q_lazy.0.neighbors),
    constant!("discount", [0.0, 0.5, 0.8, 0.9], q_lazy.0.discount),
    constant!(
        "action weight",
        [0.2, 0.5, 0.7, 1.0, 1.5],
        q_lazy.0.action_weight
    ),
    whole!("turns", [1.0, 16.0], q_lazy.0.turns),
    constant!("far m", [0.6, 0.8, 1.0, 1.5, 2.5], q_lazy.1.far_m),
    constant!("fallen", [0.05, 0.1, 0.2, 0.4, 0.8], q_lazy.1.reward.fallen),
    constant!(
        "in front",
        [0.5, 1.0, 1.5, 2.5, 4.0],
        q_lazy.1.reward.in_front
    ),
    constant!("behind", [0.5, 1.0, 1.5, 2.5, 7.0], q_lazy.1.reward.behind),
    constant!("free below", FREE, q_lazy.1.free_below),
];

static Q_TABLE: [TunedConstant; 3] = [
    constant!("threshold", [0.05, 0.1, 0.2, 0.3, 0.5], q_table.0.threshold),
    constant!("rate", [0.05, 0.1, 0.3, 0.6], q_table.0.rate),
    constant!("discount", [0.0, 0.5, 0.8, 0.9], q_table.0.discount),
];
static Q_TABLE_TRAINING: [TunedConstant; 9] = training!(q_table);

static Q_SOM: [TunedConstant; 8] = [
    constant!("rate", [0.1, 0.3, 0.5, 0.9], q_som.0.rate),
    constant!("discount", [0.0, 0.5, 0.8, 0.9], q_som.0.discount),
    constant!("pull", [0.1, 0.3, 0.5, 0.9], q_som.0.pull),
    constant!("pull least", [0.005, 0.02, 0.05], q_som.0.pull_least),
    constant!("fades", [500.0, 2_000.0, 10_000.0], q_som.0.fades),
    constant!("share", [0.0, 0.1, 0.25, 0.5], q_som.0.share),
    constant!("action weight", [0.3, 0.5, 0.7, 1.0], q_som.0.action_weight),
    constant!("value weight", [0.1, 0.25, 0.5, 1.0], q_som.0.value_weight),
];
static Q_SOM_TRAINING: [TunedConstant; 9] = training!(q_som);

static Q_TWO_SOMS: [TunedConstant; 6] = [
    constant!("rate", [0.1, 0.3, 0.5, 0.9], q_two_soms.0.rate),
    constant!("discount", [0.0, 0.5, 0.8, 0.9], q_two_soms.0.discount),
    constant!("pull", [0.05, 0.1, 0.3, 0.6], q_two_soms.0.pull),
    constant!("width", [0.3, 0.5, 1.0, 1.5], q_two_soms.0.width),
    constant!("fades", [500.0, 2_000.0, 10_000.0], q_two_soms.0.fades),
    constant!("least", [0.02, 0.1, 0.3], q_two_soms.0.least),
];
static Q_TWO_SOMS_TRAINING: [TunedConstant; 9] = training!(q_two_soms);

/// The constants to search for: those of the method and of its training. None for random moves and
/// for the controller, which has an ablation.
#[must_use]
pub fn tuned_constants(method: ComparedMethod) -> Vec<&'static TunedConstant> {
    let (own, training): (&[TunedConstant], &[TunedConstant]) = match method {
        ComparedMethod::Braitenberg => (&BRAITENBERG, &[]),
        ComparedMethod::PotentialField => (&POTENTIAL_FIELD, &[]),
        ComparedMethod::VfhPlus => (&VFH_PLUS, &[]),
        ComparedMethod::NearestChange => (&NEAREST_CHANGE, &[]),
        ComparedMethod::NearestPair => (&NEAREST_PAIR, &[]),
        ComparedMethod::QLazy => (&Q_LAZY, &[]),
        ComparedMethod::QTable => (&Q_TABLE, &Q_TABLE_TRAINING),
        ComparedMethod::QSom => (&Q_SOM, &Q_SOM_TRAINING),
        ComparedMethod::QTwoSoms => (&Q_TWO_SOMS, &Q_TWO_SOMS_TRAINING),
        ComparedMethod::Random
        | ComparedMethod::Cosine
        | ComparedMethod::LeastSquares
        | ComparedMethod::NearestFit
        | ComparedMethod::Default
        | ComparedMethod::Probe
        | ComparedMethod::Touzet => (&[], &[]),
    };
    own.iter().chain(training).collect()
}

/// Seed of the first room of the search.
pub const FIRST_ROOM: u64 = 20_001;
/// Rounds over all constants.
pub const ROUNDS: usize = 2;

/// Conditions of the search.
#[derive(Debug, Clone)]
pub struct ConstantSearch {
    /// The method.
    pub method: ComparedMethod,
    /// Learning moves of the methods that learn by reward.
    pub moves: u32,
    /// Number of rooms, beginning at [`FIRST_ROOM`].
    pub rooms: u32,
    /// Conditions of the measurement.
    pub conditions: Conditions,
}

impl ConstantSearch {
    /// Score of a method with these constants: mean area swept in m², divided by 1 + contacts per
    /// 100 m.
    ///
    /// # Errors
    /// When an episode fails.
    pub fn score(&self, constants: &Constants) -> Result<f64, EpisodeError> {
        let budgets = self.method.budgets(&[self.moves]);
        let candidate = MethodUnderTest {
            method: self.method,
            constants,
            budgets: budgets.get(..1).unwrap_or_default(),
        };
        let rooms = (FIRST_ROOM..FIRST_ROOM + u64::from(self.rooms)).into_par_iter();
        let outcomes: Result<Vec<Vec<MethodOutcome>>, EpisodeError> = rooms
            .map(|room| drive(&candidate, &World::random(room), room, &self.conditions))
            .collect();
        let (mut contacts, mut distance, mut area) = (0.0, 0.0, 0.0);
        for outcome in outcomes?.iter().flatten() {
            contacts += f64::from(outcome.contacts);
            distance += outcome.distance_m;
            area += outcome.coverage_m2;
        }
        Ok(
            area / f64::from(self.rooms.max(1))
                / (1.0 + 100.0 * contacts / f64::max(distance, 1.0)),
        )
    }

    /// Runs the search. Calls `tried` for every constant that is settled: its name, its value and
    /// the score reached.
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
            for knob in tuned_constants(self.method) {
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

    /// The documented constants must be those in use: every default lies in its range.
    #[test]
    fn every_default_is_one_of_the_values_tried() {
        let constants = Constants::of(false);
        for method in ComparedMethod::ALL {
            for knob in tuned_constants(method) {
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
