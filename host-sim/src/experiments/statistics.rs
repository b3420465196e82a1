//! Means and their uncertainty.

use crate::noise::Noise;

/// A mean with its 95 % interval by the bootstrap over worlds and seeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mean {
    /// The mean.
    pub mean: f64,
    /// The interval's ends.
    pub interval: [f64; 2],
}

impl std::fmt::Display for Mean {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [low, high] = self.interval;
        write!(f, "{:.3} [{low:.3}, {high:.3}]", self.mean)
    }
}

/// Draws of the bootstrap.
const DRAWS: usize = 2_000;

/// Mean and percentile interval; both worlds and the seeds within them are drawn anew.
#[must_use]
pub fn bootstrap(worlds: &[Vec<f64>]) -> Mean {
    let all: Vec<f64> = worlds.iter().flatten().copied().collect();
    let mean_of = |sum: f64, count: usize| sum / count.max(1) as f64;
    let mut noise = Noise::new(1);
    let mut means: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let (mut sum, mut count) = (0.0, 0);
            for _ in worlds {
                let Some(world) = worlds.get(noise.index(worlds.len())) else {
                    continue;
                };
                for _ in world {
                    sum += world.get(noise.index(world.len())).copied().unwrap_or(0.0);
                    count += 1;
                }
            }
            mean_of(sum, count)
        })
        .collect();
    means.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let index = (share * (DRAWS - 1) as f64) as usize;
        means.get(index).copied().unwrap_or(0.0)
    };
    Mean {
        mean: mean_of(all.iter().sum(), all.len()),
        interval: [at(0.025), at(0.975)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_holds_the_mean_and_narrows() {
        let worlds = |count: usize| vec![vec![0.0, 1.0, 0.0, 1.0]; count];
        let (few, many) = (bootstrap(&worlds(3)), bootstrap(&worlds(300)));
        for found in [few, many] {
            assert!((found.mean - 0.5).abs() < 1e-12);
            assert!(found.interval[0] < 0.5 && found.interval[1] > 0.5);
        }
        let width = |found: Mean| found.interval[1] - found.interval[0];
        assert!(width(many) < width(few) / 5.0);
        assert_eq!(bootstrap(&[]).mean, 0.0);
    }
}
