//! Episodes with maps of other sizes than the paper's 16 neurons.

use super::drive::{Episode, Phase, run_with};
use super::setup::Setup;
use crate::error::EpisodeError;
use crate::pilot::LocalController;
use amp::som::Grid;
use arena::world::World;

/// Numbers of neurons that maps may have here: squares, so that the grid has no preferred side.
pub const NEURON_COUNTS: [u8; 7] = [4, 9, 16, 25, 36, 49, 64];

/// A square grid with this many places.
#[must_use]
pub const fn square_grid(neurons: usize) -> Grid {
    let side = neurons.isqrt() as u16;
    Grid::rectangle(side, side)
}

/// As [`run`](super::run), with maps of this many neurons, one of [`NEURON_COUNTS`]; only the Nomad
/// with its ring, and no recording.
///
/// # Errors
/// As [`run`](super::run), and for another number, another robot or a recording.
pub fn run_sized(
    neurons: u8,
    world: &World,
    setup: &Setup,
    progress: impl FnMut(Phase, u32, u32),
) -> Result<Episode, EpisodeError> {
    if setup.robot.is_some() {
        return Err(EpisodeError::OtherNeurons);
    }
    match neurons {
        4 => run_with_neurons::<4>(world, setup, progress),
        9 => run_with_neurons::<9>(world, setup, progress),
        16 => run_with_neurons::<16>(world, setup, progress),
        25 => run_with_neurons::<25>(world, setup, progress),
        36 => run_with_neurons::<36>(world, setup, progress),
        49 => run_with_neurons::<49>(world, setup, progress),
        64 => run_with_neurons::<64>(world, setup, progress),
        _ => Err(EpisodeError::OtherNeurons),
    }
}

fn run_with_neurons<const NEURONS: usize>(
    world: &World,
    setup: &Setup,
    progress: impl FnMut(Phase, u32, u32),
) -> Result<Episode, EpisodeError> {
    let config = setup.config.clone();
    let mut controller = LocalController::<NEURONS>::sized(config, square_grid(NEURONS));
    run_with(world, setup, &mut controller, progress)
}
