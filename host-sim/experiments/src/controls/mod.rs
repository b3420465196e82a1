//! Controls: the same robot, planner and goals with something trivial in place of the action map.
//!
//! A control explores and learns as the controller does. Then its action map is replaced, or was
//! never trained, or was trained without a neighborhood. Without the shield.

mod measure;
mod pilot;
mod slot;

#[cfg(test)]
mod tests;

pub use measure::{
    ControlMeasure, ControlTrial, Results, WorldSet, better, episodes_per_row, measure, measures,
};
pub use pilot::ControlPilot;
pub use slot::{MoveSample, Slopes, Slot, coded, cosine, fit, nearest_fit, pool, steepest};

use amp::config::{Config, Initialization, PlannerKind};
use amp::som::Schedule;

/// How the code vectors come about that the slot then uses or replaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Training {
    /// As the preset says.
    Maps,
    /// Vector quantization: from random samples on, only the best-matching unit learns.
    Quantization,
    /// Random samples, not trained.
    RandomSamples,
    /// The preset's initial code vectors, not trained: actions on a grid, no change.
    Initial,
    /// Random code vectors, not trained.
    RandomVectors,
}

impl Training {
    /// The configuration that trains so.
    #[must_use]
    pub const fn of(self, mut config: Config<16>) -> Config<16> {
        let zero = Schedule::constant(0);
        let learning = &mut config.learning;
        match self {
            Self::Maps => {}
            Self::Quantization => {
                learning.start = Initialization::Samples;
                learning.situations.radius = zero;
                learning.actions.radius = zero;
            }
            Self::RandomSamples => learning.start = Initialization::Samples,
            Self::Initial => {}
            Self::RandomVectors => learning.start = Initialization::Random,
        }
        if !self.trains() {
            learning.situations.rate = zero;
            learning.actions.rate = zero;
        }
        config
    }

    /// Whether code vectors move in training.
    const fn trains(self) -> bool {
        matches!(self, Self::Maps | Self::Quantization)
    }
}

/// One row: what predicts, and whether it goes on learning while behaving.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlRow {
    /// What predicts, in words.
    pub name: &'static str,
    /// How the code vectors come about.
    pub training: Training,
    /// What replaces them.
    pub slot: Slot,
    /// The code vectors go on learning from each move of the behavior.
    pub online: bool,
}

impl ControlRow {
    /// The configuration of its controller.
    #[must_use]
    pub fn config(&self, preset: &Config<16>) -> Config<16> {
        let mut config = self.training.of(preset.clone());
        // Saves time where the training moves nothing, or nothing that a decision depends on.
        let is_used = self.slot == Slot::Trained || config.planning.planner == PlannerKind::Recall;
        if !(self.training.trains() && is_used) {
            config.learning.epochs = 1;
        }
        config.shield = None;
        if !self.online {
            config.online = None;
        }
        config
    }

    /// Name and learning in one text.
    #[must_use]
    pub fn title(&self) -> String {
        let learns = if self.online { "on" } else { "off" };
        format!("{}, online {learns}", self.name)
    }
}

/// What predicts in each pair of rows.
const PREDICTORS: [(&str, Training, Slot); 14] = {
    use Slot::{Cosine, LeastSquares, Nearest, Trained};
    const fn nearest(count: usize, turned: bool) -> Slot {
        Nearest { count, turned }
    }
    [
        ("two maps", Training::Maps, Trained),
        ("nothing learned, g", Training::Maps, Cosine { gain: 1.0 }),
        ("nothing learned, g/2", Training::Maps, Cosine { gain: 0.5 }),
        ("nothing learned, 2g", Training::Maps, Cosine { gain: 2.0 }),
        (
            "least squares",
            Training::Maps,
            LeastSquares { turned: false },
        ),
        (
            "turned least squares",
            Training::Maps,
            LeastSquares { turned: true },
        ),
        ("8 nearest", Training::Maps, nearest(8, false)),
        ("8 nearest, turned", Training::Maps, nearest(8, true)),
        ("32 nearest", Training::Maps, nearest(32, false)),
        ("32 nearest, turned", Training::Maps, nearest(32, true)),
        ("vector quantization", Training::Quantization, Trained),
        ("random samples", Training::RandomSamples, Trained),
        ("initial code vectors", Training::Initial, Trained),
        ("random code vectors", Training::RandomVectors, Trained),
    ]
};

/// All rows, the two maps first. The nearest samples are fitted anew before each decision, so they
/// do not learn online.
#[must_use]
pub fn rows() -> Vec<ControlRow> {
    let pairs = PREDICTORS.iter().flat_map(|&(name, training, slot)| {
        let row = move |online| ControlRow {
            name,
            training,
            slot,
            online,
        };
        [row(true), row(false)]
    });
    let is_local = |row: &ControlRow| matches!(row.slot, Slot::Nearest { .. });
    pairs.filter(|row| !(row.online && is_local(row))).collect()
}
