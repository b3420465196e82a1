//! Learning from the memory, in slices.

use super::State;
use crate::action_map::Effect;
use crate::config::{Config, Initialization, LearnFrom, MapTraining, SampleOrder};
use crate::fixed::{Mask, Weight, unit_weight};
use crate::memory::{Sample, turned_change};
use crate::scan::Situation;
use crate::som::Update;
use crate::units::Bearing;

/// Presentations between two steps of the schedules. A slice ends with them at the latest, so that
/// the maps do not depend on the slices' size.
const RENEWAL: u32 = 16;

/// A sample as the maps learn it.
struct Presentation<const SENSORS: usize> {
    after: Situation<SENSORS>,
    effect: Effect<SENSORS>,
}

impl<const SENSORS: usize> Presentation<SENSORS> {
    /// Nothing seen, nothing done.
    const fn empty() -> Self {
        Self {
            after: [Weight::ZERO; SENSORS],
            effect: Effect {
                change: [Weight::ZERO; SENSORS],
                action: [Weight::ZERO; 2],
                mask: Mask::ALL,
            },
        }
    }
}

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    State<SENSORS, NEURONS, SAMPLES>
{
    /// Presentations of the whole training.
    pub(super) fn learning_steps(&self, config: &Config<SENSORS>) -> u32 {
        u32::from(config.learning.epochs) * self.memory.samples().len() as u32
    }

    /// Gives both maps their starting code vectors.
    pub(super) fn start_maps(&mut self, config: &Config<SENSORS>) {
        self.learned = false;
        self.updates = 0;
        self.inhibited = [0; NEURONS];
        let grid = self.situations.grid().with_edges(config.learning.edges);
        self.set_grid(grid);
        for neuron in 0..NEURONS {
            let (situation, mut effect) = match config.learning.start {
                Initialization::Random => self.random_start(),
                Initialization::Samples | Initialization::Plane => {
                    let mut presentation = Presentation::empty();
                    self.presentation(config, None, &mut presentation);
                    (presentation.after, presentation.effect)
                }
            };
            if config.learning.start == Initialization::Plane {
                effect.change = [Weight::ZERO; SENSORS];
                effect.action = on_the_plane(grid, neuron);
            }
            self.situations.set_code_vector(neuron, &situation);
            self.actions
                .changes_mut()
                .set_code_vector(neuron, &effect.change);
            self.actions
                .actions_mut()
                .set_code_vector(neuron, &effect.action);
        }
    }

    fn random_start(&mut self) -> (Situation<SENSORS>, Effect<SENSORS>) {
        // 13 random bits are a value in [0, 1), 14 less one half a value in [-1, 1).
        let mut bits = |count: u32| (self.random() >> (32 - count)) as i32;
        let situation = core::array::from_fn(|_| unit_weight(bits(13)));
        let effect = Effect {
            change: core::array::from_fn(|_| unit_weight(bits(14) - (1 << 13))),
            action: core::array::from_fn(|_| unit_weight(bits(14) - (1 << 13))),
            mask: Mask::ALL,
        };
        (situation, effect)
    }

    /// Teaches both maps the next slice of `steps` presentations; returns how many are done.
    pub(super) fn learn_slice(&mut self, config: &Config<SENSORS>, done: u32, steps: u32) -> u32 {
        let learning = &config.learning;
        let renewed = done - done % RENEWAL;
        // At first code vectors are alike, and many ties are settled in full precision: shorter
        // slices.
        let slice = if renewed == 0 {
            learning.slice / 2
        } else {
            learning.slice
        };
        let end = done
            .saturating_add(u32::from(slice.max(1)))
            .min(renewed.saturating_add(RENEWAL))
            .min(steps);
        let pull = |training: &MapTraining| {
            let (rate, radius) = (
                training.rate.at(renewed, steps),
                training.radius.at(renewed, steps),
            );
            Update::from_q16(training.neighborhood, rate, radius)
        };
        let (for_situations, for_actions) = (pull(&learning.situations), pull(&learning.actions));
        let mut presentation = Presentation::empty();
        self.actions.forget_products();
        for step in done..end {
            self.presentation(config, Some(step), &mut presentation);
            let Presentation { after, effect } = &presentation;
            (self.situations).train_step(after, effect.mask, &for_situations);
            (self.actions).train_step(effect, learning.action_weight_q8, &for_actions);
        }
        end
    }

    /// Writes the sample of a presentation (`None` = any), turned by a random number of ring places
    /// where that is asked for.
    fn presentation(
        &mut self,
        config: &Config<SENSORS>,
        step: Option<u32>,
        presentation: &mut Presentation<SENSORS>,
    ) {
        let count = self.memory.samples().len() as u32;
        let index = match (config.learning.order, step) {
            (SampleOrder::Recorded, Some(step)) => step.checked_rem(count).unwrap_or(0),
            _ => self.below(count),
        };
        let places = if config.learning.augment_rotations && config.robot.symmetric {
            self.below(SENSORS as u32)
        } else {
            0
        };
        if let Some(sample) = self.memory.samples().get(index as usize) {
            let gaps = self.memory.has_gaps();
            write_presentation(config, sample, places as usize, gaps, presentation);
        }
    }
}

fn write_presentation<const SENSORS: usize>(
    config: &Config<SENSORS>,
    sample: &Sample<SENSORS>,
    places: usize,
    gaps: bool,
    presentation: &mut Presentation<SENSORS>,
) {
    let taught = match config.learning.learn_from {
        LearnFrom::Commanded => sample.commanded,
        LearnFrom::Executed => sample.executed,
    };
    let action = if places == 0 {
        taught
    } else {
        taught.rotated(
            config
                .robot
                .directions
                .get(places)
                .copied()
                .unwrap_or_else(|| Bearing::ZERO.direction()),
        )
    };
    let Presentation { after, effect } = presentation;
    effect.action = config.action_code.encode(action, config.robot.step_mm);
    effect.mask = turned_change(sample, places, gaps, after, &mut effect.change);
}

/// The action of a neuron's place: the grid laid over the square [−1, 1]².
fn on_the_plane(grid: crate::som::Grid, neuron: usize) -> [Weight; 2] {
    let (x, y) = grid.position(neuron);
    let place = |at: usize, length: usize| {
        let span = length.saturating_sub(1).max(1) as i32;
        unit_weight(((2 * at as i32 - span) * 8_192) / span)
    };
    [place(x, grid.columns()), place(y, grid.rows())]
}
