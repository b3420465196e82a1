//! The methods that are compared, their names and their constants.

use crate::baselines::{
    learning::Schooling, nearest, potential_field, q_lazy, q_som, q_table, q_two_soms, vfh_plus,
};

use files::error::BadInput;
use sim::braitenberg;
use std::str::FromStr;

/// A method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Random moves for ever.
    Random,
    /// The hand-written yardstick.
    Braitenberg,
    /// Khatib's forces.
    PotentialField,
    /// Ulrich and Borenstein's histogram.
    VfhPlus,
    /// The sample with the nearest change, no maps.
    NearestChange,
    /// The sample with the nearest pair of situations, no maps.
    NearestPair,
    /// Lazy Q-learning.
    QLazy,
    /// Q-learning with a table.
    QTable,
    /// Q-learning with one map.
    QSom,
    /// Q-learning between two maps.
    QTwoSoms,
    /// The mind, preset `default`.
    Default,
    /// The mind, preset `probe`.
    Probe,
    /// The mind, preset `touzet`.
    Touzet,
}

impl Method {
    /// All of them, in the tables' order.
    pub const ALL: [Self; 13] = [
        Self::Default,
        Self::Probe,
        Self::Touzet,
        Self::Random,
        Self::Braitenberg,
        Self::PotentialField,
        Self::VfhPlus,
        Self::NearestChange,
        Self::NearestPair,
        Self::QLazy,
        Self::QTable,
        Self::QSom,
        Self::QTwoSoms,
    ];

    /// Its name on the command line and in tables.
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
            Self::Default => "default",
            Self::Probe => "probe",
            Self::Touzet => "touzet",
        }
    }

    /// Whether it learns by reward, move by move, so that more moves may make it better.
    #[must_use]
    pub const fn goes_on_learning(self) -> bool {
        matches!(self, Self::QTable | Self::QSom | Self::QTwoSoms)
    }

    /// The budgets of learning moves it is measured with, of those asked for: all of them where more moves may make it
    /// better; the mind's 100 for what learns from a memory (lazy Q-learning also 200); none for what does not learn.
    #[must_use]
    pub fn budgets(self, asked: &[u32]) -> Vec<u32> {
        match self {
            Self::Random | Self::Braitenberg | Self::PotentialField | Self::VfhPlus => vec![0],
            Self::QLazy => vec![MOVES, 2 * MOVES],
            _ if self.goes_on_learning() => asked.to_vec(),
            _ => vec![MOVES],
        }
    }
}

/// Random moves of the mind and of the methods with a lazy memory.
pub const MOVES: u32 = 100;

impl FromStr for Method {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        let found = Self::ALL.into_iter().find(|method| method.name() == text);
        found.ok_or_else(|| BadInput::unknown("method", text, &Self::ALL.map(Self::name)))
    }
}

/// The constants of all methods; those of [`Constants::of`] are what the search found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constants {
    /// Of the yardstick.
    pub braitenberg: braitenberg::BraitenbergTuning,
    /// Of the potential field.
    pub potential_field: potential_field::Tuning,
    /// Of VFH+.
    pub vfh_plus: vfh_plus::Tuning,
    /// Of the nearest change, and its far limit in m.
    pub nearest_change: (nearest::Tuning, f64),
    /// Of the nearest pair, and its far limit in m.
    pub nearest_pair: (nearest::Tuning, f64),
    /// Of lazy Q-learning.
    pub q_lazy: (q_lazy::Tuning, Schooling),
    /// Of Q-learning with a table.
    pub q_table: (q_table::Tuning, Schooling),
    /// Of Q-learning with one map.
    pub q_som: (q_som::Tuning, Schooling),
    /// Of Q-learning between two maps.
    pub q_two_soms: (q_two_soms::Tuning, Schooling),
}

impl Constants {
    /// Those for robots with the mind's shield, or without one.
    #[must_use]
    pub fn of(shield: bool) -> Self {
        Self {
            braitenberg: braitenberg::BraitenbergTuning::default(),
            potential_field: potential_field::Tuning::default(),
            vfh_plus: vfh_plus::Tuning::of(shield),
            nearest_change: (nearest::Tuning::CHANGE, nearest::FAR_M),
            nearest_pair: (nearest::Tuning::PAIR, nearest::FAR_M),
            q_lazy: (q_lazy::Tuning::default(), q_lazy::SCHOOLING),
            q_table: (q_table::Tuning::default(), q_table::SCHOOLING),
            q_som: (q_som::Tuning::default(), q_som::SCHOOLING),
            q_two_soms: (q_two_soms::Tuning::default(), q_two_soms::SCHOOLING),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_taken_back_and_the_nearest_is_suggested() {
        for method in Method::ALL {
            assert_eq!(method.name().parse(), Ok(method));
        }
        let error = "q-tabel".parse::<Method>().expect_err("no such method");
        assert!(error.to_string().contains("did you mean \"q-table\"?"));
    }
}
