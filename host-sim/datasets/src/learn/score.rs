//! Measures how well a memory recalls actions.

use super::associative_memory::AssociativeMemory;
use super::dataset::InputActionPairs;
use sim::statistics::{Mean, bootstrap};

/// Rows of a block in the bootstrap of the accuracy's confidence interval. Consecutive rows are
/// correlated, so single rows would make the interval too narrow.
const BLOCK: usize = 50;

/// Recalled actions compared with the true ones.
#[derive(Debug, Clone, PartialEq)]
pub enum Score {
    /// Named actions.
    Classes {
        /// Confusion matrix: counts by true class (row) and recalled class (column).
        confusion: Vec<Vec<u32>>,
        /// By pair, in order: whether the recalled class is correct.
        correct: Vec<bool>,
    },
    /// Velocities.
    Velocities {
        /// Root-mean-square error of each velocity, in the units of the log.
        rms: Vec<f64>,
    },
}

impl Score {
    /// Recalls the action of each input and compares it with the true one. `is_named`: the actions
    /// are classes, not velocities.
    pub fn new(memory: &AssociativeMemory, pairs: &InputActionPairs, is_named: bool) -> Self {
        let samples = pairs.inputs.chunks_exact(pairs.dims).zip(&pairs.actions);
        if is_named {
            let classes = pairs.actions.first().map_or(0, Vec::len);
            let mut confusion = vec![vec![0; classes]; classes];
            let mut correct = Vec::new();
            for (input, action) in samples {
                let (actual, recalled) = (class(action), class(memory.recall(input)));
                correct.push(actual == recalled);
                if let Some(count) = confusion
                    .get_mut(actual)
                    .and_then(|row| row.get_mut(recalled))
                {
                    *count += 1;
                }
            }
            return Self::Classes { confusion, correct };
        }
        let mut sums = vec![0.0; pairs.actions.first().map_or(0, Vec::len)];
        for (input, action) in samples {
            let recalled = memory.recall(input);
            for (sum, (actual, recalled)) in sums.iter_mut().zip(action.iter().zip(recalled)) {
                *sum += (actual - recalled) * (actual - recalled);
            }
        }
        let count = pairs.actions.len().max(1) as f64;
        let rms = sums.iter().map(|sum| (sum / count).sqrt()).collect();
        Self::Velocities { rms }
    }

    /// Share of the pairs recalled correctly, with its 95 % block-bootstrap interval; `None` for
    /// velocities.
    #[must_use]
    pub fn accuracy(&self) -> Option<Mean> {
        let Self::Classes { correct, .. } = self else {
            return None;
        };
        let block = |rows: &[bool]| {
            rows.iter()
                .map(|&is_correct| f64::from(u8::from(is_correct)))
                .collect()
        };
        let blocks: Vec<Vec<f64>> = correct.chunks(BLOCK).map(block).collect();
        Some(bootstrap(&blocks))
    }

    /// Recall of each class: share of its pairs recalled as that class. `None` for a class that
    /// does not occur; empty for velocities.
    #[must_use]
    pub fn by_class(&self) -> Vec<Option<f64>> {
        let Self::Classes { confusion, .. } = self else {
            return Vec::new();
        };
        let share = |(class, row): (usize, &Vec<u32>)| {
            let total: u32 = row.iter().sum();
            let correct = row.get(class).copied().unwrap_or(0);
            (total > 0).then(|| f64::from(correct) / f64::from(total))
        };
        confusion.iter().enumerate().map(share).collect()
    }

    /// Balanced accuracy: the mean of [`by_class`](Self::by_class).
    #[must_use]
    pub fn balanced_accuracy(&self) -> f64 {
        let shares: Vec<f64> = self.by_class().into_iter().flatten().collect();
        shares.iter().sum::<f64>() / shares.len().max(1) as f64
    }

    /// Mean over the velocities of the error divided by that of another score; `None` for classes.
    #[must_use]
    pub fn relative_error(&self, other: &Self) -> Option<f64> {
        let (Self::Velocities { rms }, Self::Velocities { rms: others }) = (self, other) else {
            return None;
        };
        let ratios: f64 = rms
            .iter()
            .zip(others)
            .map(|(a, b)| if *b > 0.0 { a / b } else { 1.0 })
            .sum();
        Some(ratios / rms.len().max(1) as f64)
    }
}

/// Class of an action: index of the greatest component, the first on ties.
#[must_use]
pub fn class(action: &[f64]) -> usize {
    let best = action
        .iter()
        .enumerate()
        .reduce(|best, other| if other.1 > best.1 { other } else { best });
    best.map_or(0, |(class, _)| class)
}
