//! How well actions are recalled.

use super::memory::Memory;
use super::task::Pairs;
use sim::statistics::{Mean, bootstrap};

/// Rows that follow each other are alike: the interval of an accuracy is that over blocks of so
/// many.
const BLOCK: usize = 50;

/// What came of recalling the actions of some pairs.
#[derive(Debug, Clone, PartialEq)]
pub enum Score {
    /// Named actions.
    Classes {
        /// How often a class (row) was recalled as a class (column).
        confusion: Vec<Vec<u32>>,
        /// By pair, in order: it was right.
        right: Vec<bool>,
    },
    /// Velocities: the root of the mean squared error of each.
    Velocities {
        /// In the units of the log.
        rms: Vec<f64>,
    },
}

impl Score {
    /// Asks a memory for the action of each input.
    pub fn of(memory: &Memory, pairs: &Pairs, named: bool) -> Self {
        let asked = pairs.inputs.chunks_exact(pairs.dims).zip(&pairs.actions);
        if named {
            let classes = pairs.actions.first().map_or(0, Vec::len);
            let mut confusion = vec![vec![0; classes]; classes];
            let mut right = Vec::new();
            for (input, action) in asked {
                let (is, recalled) = (class(action), class(memory.recall(input)));
                right.push(is == recalled);
                if let Some(count) = confusion.get_mut(is).and_then(|row| row.get_mut(recalled)) {
                    *count += 1;
                }
            }
            return Self::Classes { confusion, right };
        }
        let mut sums = vec![0.0; pairs.actions.first().map_or(0, Vec::len)];
        for (input, action) in asked {
            let recalled = memory.recall(input);
            for (sum, (is, recalled)) in sums.iter_mut().zip(action.iter().zip(recalled)) {
                *sum += (is - recalled) * (is - recalled);
            }
        }
        let count = pairs.actions.len().max(1) as f64;
        let rms = sums.iter().map(|sum| (sum / count).sqrt()).collect();
        Self::Velocities { rms }
    }

    /// Share of the pairs recalled rightly with its 95 % interval over blocks of time; nothing for
    /// velocities.
    #[must_use]
    pub fn accuracy(&self) -> Option<Mean> {
        let Self::Classes { right, .. } = self else {
            return None;
        };
        let block = |rows: &[bool]| {
            rows.iter()
                .map(|&right| f64::from(u8::from(right)))
                .collect()
        };
        let blocks: Vec<Vec<f64>> = right.chunks(BLOCK).map(block).collect();
        Some(bootstrap(&blocks))
    }

    /// By class: share of its pairs recalled as that class; `None` for a class that did not occur.
    /// Empty for velocities.
    #[must_use]
    pub fn by_class(&self) -> Vec<Option<f64>> {
        let Self::Classes { confusion, .. } = self else {
            return Vec::new();
        };
        let share = |(class, row): (usize, &Vec<u32>)| {
            let all: u32 = row.iter().sum();
            let right = row.get(class).copied().unwrap_or(0);
            (all > 0).then(|| f64::from(right) / f64::from(all))
        };
        confusion.iter().enumerate().map(share).collect()
    }

    /// Mean of the shares of [`by_class`](Self::by_class).
    #[must_use]
    pub fn balanced(&self) -> f64 {
        let shares: Vec<f64> = self.by_class().into_iter().flatten().collect();
        shares.iter().sum::<f64>() / shares.len().max(1) as f64
    }

    /// Mean over the velocities of error divided by that of another score.
    #[must_use]
    pub fn error_beside(&self, other: &Self) -> Option<f64> {
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

/// The class an action stands for: the greatest component, the first on ties.
#[must_use]
pub fn class(action: &[f64]) -> usize {
    let best = action
        .iter()
        .enumerate()
        .reduce(|best, other| if other.1 > best.1 { other } else { best });
    best.map_or(0, |(class, _)| class)
}
