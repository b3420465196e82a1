//! The training and held-out samples of a log: situations, changes of situation, and actions.

use super::log::{Actions, Log};
use crate::som::scale::Scale;
use files::error::BadInput;
use files::table::Table;
use tinysom::fixed::Weight32;

/// Options for making a [`Dataset`] from a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DatasetOptions {
    /// Range up to which a situation's value is 1, in the log's unit.
    pub near: f64,
    /// Range from which the value is 0; `None` = the log's greatest finite range.
    pub far: Option<f64>,
    /// Share of the rows held out at the end of the run, above 0 and below 1.
    pub held_out: f64,
    /// Rows over which a change of situation is measured.
    pub stride: usize,
}

/// Inputs, each with its action.
#[derive(Debug, Clone, PartialEq)]
pub struct InputActionPairs {
    /// Components of an input.
    pub dims: usize,
    /// The inputs, concatenated: situations in [0, 1] or their changes in [−1, 1].
    pub inputs: Vec<Weight32>,
    /// By input: the class as a one-hot vector, or velocities.
    pub actions: Vec<Vec<f64>>,
}

/// Part of the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Split {
    /// The beginning; the maps learn from it.
    Training,
    /// The end; the maps are tested on it.
    HeldOut,
}

/// Situations and actions of a log, split in time.
#[derive(Debug, Clone, PartialEq)]
pub struct Dataset {
    /// Names of the classes; `None` for velocities.
    pub classes: Option<Vec<String>>,
    /// Range up to which a situation's value is 1, in the log's unit.
    pub near: f64,
    /// Range from which the value is 0.
    pub far: f64,
    situations: InputActionPairs,
    training_rows: usize,
    stride: usize,
}

impl Dataset {
    /// Makes the dataset of a log.
    ///
    /// # Errors
    /// `near` not below `far`, or a part of the run not longer than the stride.
    pub fn from_log(log: &Log, options: &DatasetOptions) -> Result<Self, BadInput> {
        let rows = log.ranges.len();
        let far = options.far.unwrap_or_else(|| greatest_range(log));
        let near = options.near;
        let in_order = far.is_finite() && near >= 0.0 && near < far;
        if !in_order {
            return Err(BadInput::new(format!(
                "--near {near} must not be negative and lie below --far {far} (left out: the greatest range in {})",
                log.source
            )));
        }
        let training_rows = libm::rint(rows as f64 * (1.0 - options.held_out)) as usize;
        if training_rows <= options.stride || rows - training_rows <= options.stride {
            return Err(BadInput::new(format!(
                "{}: of {rows} rows {training_rows} are to be learned and {} held out; both must be more than --stride {}",
                log.source,
                rows - training_rows,
                options.stride
            )));
        }
        Ok(Self {
            classes: classes(log),
            near,
            far,
            situations: InputActionPairs {
                dims: log.names.len(),
                inputs: situations(log, near, far)?,
                actions: actions(log),
            },
            training_rows,
            stride: options.stride,
        })
    }

    /// Number of rows of a part.
    #[must_use]
    pub fn rows(&self, split: Split) -> usize {
        match split {
            Split::Training => self.training_rows,
            Split::HeldOut => self.situations.actions.len() - self.training_rows,
        }
    }

    /// The situations of a part, each with the robot's action.
    #[must_use]
    pub fn situations(&self, split: Split) -> InputActionPairs {
        let InputActionPairs {
            dims,
            inputs,
            actions,
        } = &self.situations;
        let (inputs, actions) = match split {
            Split::Training => (
                &inputs[..self.training_rows * dims],
                &actions[..self.training_rows],
            ),
            Split::HeldOut => (
                &inputs[self.training_rows * dims..],
                &actions[self.training_rows..],
            ),
        };
        InputActionPairs {
            dims: *dims,
            inputs: inputs.to_vec(),
            actions: actions.to_vec(),
        }
    }

    /// The changes of situation within a part, each with the action at its beginning.
    #[must_use]
    pub fn changes(&self, split: Split) -> InputActionPairs {
        let InputActionPairs {
            dims,
            inputs,
            actions,
        } = self.situations(split);
        let later = inputs.get(self.stride * dims..).unwrap_or_default();
        let change = |(after, before): (&Weight32, &Weight32)| {
            Weight32::from_bits(after.to_bits() - before.to_bits())
        };
        InputActionPairs {
            dims,
            actions: actions[..later.len() / dims].to_vec(),
            inputs: later.iter().zip(&inputs).map(change).collect(),
        }
    }
}

/// The greatest finite range.
fn greatest_range(log: &Log) -> f64 {
    let ranges = log.ranges.iter().flatten().copied();
    ranges.filter(|range| range.is_finite()).fold(0.0, f64::max)
}

fn classes(log: &Log) -> Option<Vec<String>> {
    match &log.actions {
        Actions::Labels { names, .. } => Some(names.clone()),
        Actions::Velocities { .. } => None,
    }
}

fn actions(log: &Log) -> Vec<Vec<f64>> {
    match &log.actions {
        Actions::Labels { names, by_row } => {
            let one_hot = |&class: &usize| {
                let component = |other| f64::from(u8::from(other == class));
                (0..names.len()).map(component).collect()
            };
            by_row.iter().map(one_hot).collect()
        }
        Actions::Velocities { by_row, .. } => by_row.clone(),
    }
}

/// Situations of all rows: nearness, linear from 1 at `near` to 0 at `far`, clamped outside.
fn situations(log: &Log, near: f64, far: f64) -> Result<Vec<Weight32>, BadInput> {
    let nearness = |&range: &f64| ((far - range) / (far - near)).clamp(0.0, 1.0);
    let rows = log.ranges.iter();
    let table = Table {
        source: log.source.clone(),
        names: Vec::new(),
        rows: rows.map(|row| row.iter().map(nearness).collect()).collect(),
        lines: vec![0; log.ranges.len()],
    };
    let unit_scale = Scale::between(0.0, 1.0).map_err(BadInput::new)?;
    unit_scale.samples(&table)
}
