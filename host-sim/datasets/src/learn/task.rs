//! What is to be learned from a log: situations, changes of situation, and the action that went
//! with each.

use super::log::{Actions, Log};
use crate::som::scale::Scale;
use files::error::BadInput;
use files::table::Table;
use tinysom::fixed::Weight32;

/// How a log is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// At this range and nearer the situation's value is 1; the log's unit.
    pub near: f64,
    /// From this range on the value is 0; `None` = the log's greatest finite range.
    pub far: Option<f64>,
    /// Share of the rows held out at the end, above 0 and below 1.
    pub held_out: f64,
    /// A change of situation is that over so many rows.
    pub stride: usize,
}

/// Inputs and the actions that went with them.
#[derive(Debug, Clone, PartialEq)]
pub struct Pairs {
    /// Components of an input.
    pub dims: usize,
    /// The inputs one after another: situations in [0, 1] or their changes in [−1, 1].
    pub inputs: Vec<Weight32>,
    /// The actions: 1 for the class and 0 for the others, or velocities.
    pub actions: Vec<Vec<f64>>,
}

/// A part of the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The beginning, which is learned.
    Learned,
    /// The end, which is not.
    HeldOut,
}

/// A log as situations and actions.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// Names of the classes; `None` for velocities.
    pub classes: Option<Vec<String>>,
    /// Range at which the value is 1, the log's unit.
    pub near: f64,
    /// Range from which on the value is 0.
    pub far: f64,
    situations: Pairs,
    cut: usize,
    stride: usize,
}

impl Task {
    /// Takes the log as situations and actions.
    ///
    /// # Errors
    /// Limits in the wrong order, a log all of whose ranges are the same, or too short for a part
    /// to hold a change.
    pub fn of(log: &Log, options: &Options) -> Result<Self, BadInput> {
        let rows = log.ranges.len();
        let far = options.far.unwrap_or_else(|| greatest(log));
        let near = options.near;
        let in_order = far.is_finite() && near >= 0.0 && near < far;
        if !in_order {
            return Err(BadInput::new(format!(
                "--near {near} must not be negative and lie below --far {far} (left out: the greatest range in {})",
                log.source
            )));
        }
        let cut = libm::rint(rows as f64 * (1.0 - options.held_out)) as usize;
        if cut <= options.stride || rows - cut <= options.stride {
            return Err(BadInput::new(format!(
                "{}: of {rows} rows {cut} are to be learned and {} held out; both must be more than --stride {}",
                log.source,
                rows - cut,
                options.stride
            )));
        }
        Ok(Self {
            classes: classes(log),
            near,
            far,
            situations: Pairs {
                dims: log.names.len(),
                inputs: situations(log, near, far)?,
                actions: actions(log),
            },
            cut,
            stride: options.stride,
        })
    }

    /// Rows of a part.
    #[must_use]
    pub fn rows(&self, part: Part) -> usize {
        match part {
            Part::Learned => self.cut,
            Part::HeldOut => self.situations.actions.len() - self.cut,
        }
    }

    /// The situations of a part, and what the robot did in each.
    #[must_use]
    pub fn situations(&self, part: Part) -> Pairs {
        let Pairs {
            dims,
            inputs,
            actions,
        } = &self.situations;
        let (inputs, actions) = match part {
            Part::Learned => (&inputs[..self.cut * dims], &actions[..self.cut]),
            Part::HeldOut => (&inputs[self.cut * dims..], &actions[self.cut..]),
        };
        Pairs {
            dims: *dims,
            inputs: inputs.to_vec(),
            actions: actions.to_vec(),
        }
    }

    /// The changes of situation within a part, and what the robot did when each began.
    #[must_use]
    pub fn changes(&self, part: Part) -> Pairs {
        let Pairs {
            dims,
            inputs,
            actions,
        } = self.situations(part);
        let later = inputs.get(self.stride * dims..).unwrap_or_default();
        let change = |(after, before): (&Weight32, &Weight32)| {
            Weight32::from_bits(after.to_bits() - before.to_bits())
        };
        Pairs {
            dims,
            actions: actions[..later.len() / dims].to_vec(),
            inputs: later.iter().zip(&inputs).map(change).collect(),
        }
    }
}

/// The greatest range at which something was heard.
fn greatest(log: &Log) -> f64 {
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
        Actions::Labels { names, of } => {
            let one_of = |&class: &usize| {
                let is = |other| f64::from(u8::from(other == class));
                (0..names.len()).map(is).collect()
            };
            of.iter().map(one_of).collect()
        }
        Actions::Velocities { of, .. } => of.clone(),
    }
}

/// Nearness, linear between the limits: 1 at `near` or nearer, 0 from `far` on.
fn situations(log: &Log, near: f64, far: f64) -> Result<Vec<Weight32>, BadInput> {
    let nearness = |&range: &f64| ((far - range) / (far - near)).clamp(0.0, 1.0);
    let rows = log.ranges.iter();
    let table = Table {
        source: log.source.clone(),
        names: Vec::new(),
        rows: rows.map(|row| row.iter().map(nearness).collect()).collect(),
        lines: vec![0; log.ranges.len()],
    };
    let unit = Scale::between(0.0, 1.0).map_err(BadInput::new)?;
    unit.samples(&table)
}
