//! The compared methods, their names and their constants.

use crate::baselines::{
    learning::LearnerTraining, nearest, potential_field, q_lazy, q_som, q_table, q_two_soms,
    vfh_plus,
};

use crate::controls::Slot;
use files::error::BadInput;
use sim::braitenberg;
use std::str::FromStr;

/// A method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ComparedMethod {
    /// Random moves without end.
    Random,
    /// The hand-written reference.
    Braitenberg,
    /// Khatib's potential field.
    PotentialField,
    /// VFH+ of Ulrich and Borenstein.
    VfhPlus,
    /// The sample with the nearest change, without maps.
    NearestChange,
    /// The sample with the nearest pair of situations, without maps.
    NearestPair,
    /// Lazy Q-learning.
    QLazy,
    /// Q-learning with a table.
    QTable,
    /// Q-learning with one map.
    QSom,
    /// Q-learning between two maps.
    QTwoSoms,
    /// `default` with one cosine, which nobody learned, in place of its action map.
    Cosine,
    /// `default` with least squares on its samples in place of its action map.
    LeastSquares,
    /// `default` with a fit to the 32 nearest samples in place of its action map.
    NearestFit,
    /// The controller with the preset `default`.
    Default,
    /// The controller with the preset `probe`.
    Probe,
    /// The controller with the preset `touzet`.
    Touzet,
}

impl ComparedMethod {
    /// All methods, in the order of the tables.
    pub const ALL: [Self; 16] = [
        Self::Default,
        Self::Probe,
        Self::Touzet,
        Self::Random,
        Self::Braitenberg,
        Self::PotentialField,
        Self::VfhPlus,
        Self::NearestChange,
        Self::NearestPair,
        Self::Cosine,
        Self::LeastSquares,
        Self::NearestFit,
        Self::QLazy,
        Self::QTable,
        Self::QSom,
        Self::QTwoSoms,
    ];

    /// Name on the command line and in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::Braitenberg => "braitenberg",
            Self::PotentialField => "potential-field",
            Self::VfhPlus => "vfh-plus",
            Self::NearestChange => "nearest-change",
            Self::NearestPair => "nearest-pair",
            Self::QLazy => "q-lazy",
            Self::QTable => "q-table",
            Self::QSom => "q-som",
            Self::QTwoSoms => "q-two-soms",
            Self::Cosine => "cosine",
            Self::LeastSquares => "least-squares",
            Self::NearestFit => "nearest-fit",
            Self::Default => "default",
            Self::Probe => "probe",
            Self::Touzet => "touzet",
        }
    }

    /// What stands in place of the action map of `default`, without learning online. Only on the
    /// Nomad's own ring.
    #[must_use]
    pub const fn slot(self) -> Option<Slot> {
        match self {
            Self::Cosine => Some(Slot::Cosine { gain: 1.0 }),
            Self::LeastSquares => Some(Slot::LeastSquares { turned: true }),
            Self::NearestFit => Some(Slot::Nearest {
                count: 32,
                turned: true,
            }),
            _ => None,
        }
    }

    /// Whether it learns by reward, move by move: more moves may improve it.
    #[must_use]
    pub const fn learns_by_reward(self) -> bool {
        matches!(self, Self::QTable | Self::QSom | Self::QTwoSoms)
    }

    /// Numbers of learning moves with which the method is measured, from those in `requested`.
    ///
    /// All of them for learners by reward; the controller's 100 for methods with a memory (lazy
    /// Q-learning also 200); 0 for methods that do not learn.
    #[must_use]
    pub fn budgets(self, requested: &[u32]) -> Vec<u32> {
        match self {
            Self::Random
            | Self::Braitenberg
            | Self::PotentialField
            | Self::VfhPlus
            | Self::Cosine => vec![0],
            Self::QLazy => vec![MOVES, 2 * MOVES],
            _ if self.learns_by_reward() => requested.to_vec(),
            _ => vec![MOVES],
        }
    }
}

/// Random moves of the controller and of the methods with a lazy memory.
pub const MOVES: u32 = 100;

impl FromStr for ComparedMethod {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        let found = Self::ALL.into_iter().find(|method| method.name() == text);
        found.ok_or_else(|| BadInput::unknown("method", text, &Self::ALL.map(Self::name)))
    }
}

/// The constants of all methods; [`Constants::of`] returns those that the search found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constants {
    /// Of the hand-written reference.
    pub braitenberg: braitenberg::BraitenbergTuning,
    /// Of the potential field.
    pub potential_field: potential_field::PotentialFieldTuning,
    /// Of VFH+.
    pub vfh_plus: vfh_plus::VfhPlusTuning,
    /// Of the nearest change, and its far limit in m.
    pub nearest_change: (nearest::NearestTuning, f64),
    /// Of the nearest change, and its far limit in m.
    pub nearest_pair: (nearest::NearestTuning, f64),
    /// Of lazy Q-learning.
    pub q_lazy: (q_lazy::QLazyTuning, LearnerTraining),
    /// Of Q-learning with a table.
    pub q_table: (q_table::QTableTuning, LearnerTraining),
    /// Of Q-learning with one map.
    pub q_som: (q_som::QSomTuning, LearnerTraining),
    /// Of Q-learning between two maps.
    pub q_two_soms: (q_two_soms::QTwoSomsTuning, LearnerTraining),
}

impl Constants {
    /// The constants found with or without the shield.
    #[must_use]
    pub fn of(shield: bool) -> Self {
        Self {
            braitenberg: braitenberg::BraitenbergTuning::default(),
            potential_field: potential_field::PotentialFieldTuning::default(),
            vfh_plus: vfh_plus::VfhPlusTuning::of(shield),
            nearest_change: (nearest::NearestTuning::CHANGE, nearest::FAR_M),
            nearest_pair: (nearest::NearestTuning::PAIR, nearest::FAR_M),
            q_lazy: (q_lazy::QLazyTuning::default(), q_lazy::TRAINING),
            q_table: (q_table::QTableTuning::default(), q_table::TRAINING),
            q_som: (q_som::QSomTuning::default(), q_som::TRAINING),
            q_two_soms: (q_two_soms::QTwoSomsTuning::default(), q_two_soms::TRAINING),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_taken_back_and_the_nearest_is_suggested() {
        for method in ComparedMethod::ALL {
            assert_eq!(method.name().parse(), Ok(method));
        }
        let error = "q-tabel"
            .parse::<ComparedMethod>()
            .expect_err("no such method");
        assert!(error.to_string().contains("did you mean \"q-table\"?"));
    }
}
