//! The sample-efficient rivals: other models and other quantizers, from the same random moves.
//!
//! A *model* predicts what a move changes and takes the place of maps and planner: its policy
//! chooses among the same headings by the same costs of the same goals. A *quantizer* finds the
//! code vectors of the action map and takes its place only. All learn from the moves that the
//! controller makes itself, with the ring's symmetry (each move turned by all 16 ring steps) or
//! without it.

pub mod cholesky;
pub mod codebook;
mod controller;
pub mod forest;
pub mod gaussian_process;
pub mod goal_cost;
pub mod graph;
pub mod grow_when_required;
pub mod growing_gas;
pub mod linear_mpc;
mod measure;
pub mod parameterless_som;
pub mod policy;
pub mod transition;

pub use controller::{Learned, RivalController, RivalTimes};
pub use measure::{RivalOutcome, RivalRow, RivalTrial, measure};

use codebook::CodeVector;
use files::error::BadInput;
use forest::Forest;
use gaussian_process::GaussianProcess;
use linear_mpc::{HORIZON, LinearMpc};
use policy::CostModel;
use std::str::FromStr;
use std::sync::Arc;
use transition::Transition;

/// A rival, or the controller itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rival {
    /// The controller with the preset `default`.
    Maps,
    /// The same; the maps do not learn after the random moves.
    FrozenMaps,
    /// Gaussian-process one-step control.
    GaussianProcess,
    /// Random-forest one-step control.
    Forest,
    /// Linear one-step control.
    Linear,
    /// Linear model-predictive control.
    LinearMpc,
    /// Growing neural gas in the action map's slot.
    GrowingGas,
    /// Grow when required in the action map's slot.
    GrowWhenRequired,
    /// The parameterless map in the action map's slot.
    ParameterlessSom,
}

/// How a rival takes part.
enum Part {
    /// As the controller is.
    Whole,
    /// Instead of maps and planner.
    Model(fn(&[Transition], bool, u64) -> Arc<dyn CostModel>),
    /// Instead of the action map.
    Codebook(fn(&[Transition], bool, u64) -> Vec<CodeVector>),
}

impl Rival {
    /// All of them, in the order of the tables.
    pub const ALL: [Self; 9] = [
        Self::Maps,
        Self::FrozenMaps,
        Self::GaussianProcess,
        Self::Forest,
        Self::Linear,
        Self::LinearMpc,
        Self::GrowingGas,
        Self::GrowWhenRequired,
        Self::ParameterlessSom,
    ];

    /// Name on the command line and in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Maps => "default",
            Self::FrozenMaps => "default-frozen",
            Self::GaussianProcess => "gp",
            Self::Forest => "forest",
            Self::Linear => "linear",
            Self::LinearMpc => "linear-mpc",
            Self::GrowingGas => "gng",
            Self::GrowWhenRequired => "gwr",
            Self::ParameterlessSom => "plsom",
        }
    }

    /// Whether it takes the action map's slot; the rest of the controller is unchanged.
    #[must_use]
    pub const fn is_quantizer(self) -> bool {
        matches!(self.part(), Part::Codebook(_))
    }

    /// Whether it takes the place of maps and planner.
    #[must_use]
    pub const fn is_model(self) -> bool {
        matches!(self.part(), Part::Model(_))
    }

    const fn part(self) -> Part {
        match self {
            Self::Maps | Self::FrozenMaps => Part::Whole,
            Self::GaussianProcess => Part::Model(|transitions, symmetric, seed| {
                Arc::new(GaussianProcess::fit(transitions, symmetric, seed))
            }),
            Self::Forest => Part::Model(|transitions, symmetric, seed| {
                Arc::new(Forest::fit(transitions, symmetric, seed))
            }),
            Self::Linear => Part::Model(|transitions, symmetric, _| {
                Arc::new(LinearMpc::fit(transitions, symmetric, 1))
            }),
            Self::LinearMpc => Part::Model(|transitions, symmetric, _| {
                Arc::new(LinearMpc::fit(transitions, symmetric, HORIZON))
            }),
            Self::GrowingGas => Part::Codebook(growing_gas::train),
            Self::GrowWhenRequired => Part::Codebook(grow_when_required::train),
            Self::ParameterlessSom => Part::Codebook(parameterless_som::train),
        }
    }
}

impl FromStr for Rival {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        let found = Self::ALL.into_iter().find(|rival| rival.name() == text);
        found.ok_or_else(|| BadInput::unknown("rival", text, &Self::ALL.map(Self::name)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_taken_back_and_the_nearest_is_suggested() {
        for rival in Rival::ALL {
            assert_eq!(rival.name().parse(), Ok(rival));
        }
        let error = "forset".parse::<Rival>().expect_err("no such rival");
        assert!(
            error.to_string().contains("did you mean \"forest\"?"),
            "{error}"
        );
    }
}
