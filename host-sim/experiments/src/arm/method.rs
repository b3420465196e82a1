//! The methods that move an arm, and their names.

use super::Reacher;
use super::body::ArmBody;
use super::controls::{Analytic, Linear, Model, Nearest, RandomMoves};
use super::maps::Maps;
use super::q_arm::QArm;
use arena::noise::Noise;

/// A method of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ArmMethod {
    /// The couple of maps of 4 × 4 neurons, which goes on learning.
    Maps,
    /// The same with 8 × 8 neurons.
    LargerMaps,
    /// The couple of maps as it was after the random moves.
    FrozenMaps,
    /// A couple of one neuron: a single linear model that goes on learning.
    OneNeuron,
    /// Least squares on the raw samples of the most similar situations.
    LocalLeastSquares,
    /// The same, and every further move is remembered, up to 1 000.
    LocalOnline,
    /// One least-squares model of all raw samples.
    LeastSquares,
    /// Posture of the remembered situation nearest to the target.
    Nearest,
    /// Mean posture of the eight nearest.
    NearestEight,
    /// Random moves.
    Random,
    /// The planner of the maps with the true change of each joint.
    ExactModel,
    /// Analytic inverse kinematics.
    Analytic,
    /// Q-learning between two maps, with so many tries for each random move.
    QTwoMaps(u32),
}

impl ArmMethod {
    /// All methods, in the order of the table.
    pub const ALL: [Self; 12] = [
        Self::Maps,
        Self::LargerMaps,
        Self::FrozenMaps,
        Self::OneNeuron,
        Self::LocalLeastSquares,
        Self::LocalOnline,
        Self::LeastSquares,
        Self::NearestEight,
        Self::Nearest,
        Self::Random,
        Self::ExactModel,
        Self::Analytic,
    ];

    /// Its name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Maps => "two maps, 16 neurons",
            Self::LargerMaps => "two maps, 64 neurons",
            Self::FrozenMaps => "two maps, frozen",
            Self::OneNeuron => "one neuron, learning on",
            Self::LocalLeastSquares => "least squares on 12 samples",
            Self::LocalOnline => "least squares on 12 samples, remembering on",
            Self::LeastSquares => "least squares on all samples",
            Self::Nearest => "nearest sample",
            Self::NearestEight => "8 nearest samples",
            Self::Random => "random moves",
            Self::ExactModel => "known geometry, same planner",
            Self::Analytic => "known geometry, inverse kinematics",
            Self::QTwoMaps(1) => "Q-learning between two maps",
            Self::QTwoMaps(10) => "the same, 10 times as many moves",
            Self::QTwoMaps(_) => "the same, 100 times as many moves",
        }
    }

    pub(super) fn reacher<'b, const V: usize, const A: usize>(
        self,
        body: &'b ArmBody,
        seed: u64,
    ) -> Box<dyn Reacher<V, A> + 'b> {
        let linear = |model| Box::new(Linear::new(body, model));
        match self {
            Self::Maps => Box::new(Maps::<V, A, 16>::new(4, true, seed)),
            Self::LargerMaps => Box::new(Maps::<V, A, 64>::new(8, true, seed)),
            Self::FrozenMaps => Box::new(Maps::<V, A, 16>::new(4, false, seed)),
            Self::OneNeuron => Box::new(Maps::<V, A, 1>::new(1, true, seed)),
            Self::LocalLeastSquares => linear(Model::Local(4 * A)),
            Self::LocalOnline => linear(Model::LocalOn(4 * A)),
            Self::LeastSquares => linear(Model::Global),
            Self::ExactModel => linear(Model::Exact),
            Self::Nearest => Box::new(Nearest::new(body, 1)),
            Self::NearestEight => Box::new(Nearest::new(body, 8)),
            Self::Random => Box::new(RandomMoves(Noise::new(seed))),
            Self::Analytic => Box::new(Analytic { body, goal: None }),
            Self::QTwoMaps(times) => Box::new(QArm::new(body, times, seed)),
        }
    }
}
