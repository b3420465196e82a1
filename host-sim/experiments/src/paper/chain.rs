//! Fig. 1: a chain of 32 neurons over points in space, trained by the robot's own map code.
//!
//! Clouds: uniform and two clusters, as in the paper, and an uneven one (three of four points in
//! one half). The paper states no training; here: 40 000 presentations, a Gaussian neighborhood
//! whose radius falls from 8 to 0.5.

use arena::noise::Noise;
use datasets::som::init::init_from_samples;
use datasets::som::map_quality::MapQuality;
use tinysom::{Decay, Grid, Neighborhood, SampleOrder, Schedule, TrainConfig, Weight32};

/// Neurons of the chain.
pub const NEURONS: usize = 32;
/// Points from which the chain learns.
const POINTS: usize = 2_000;
/// Presentations of each.
const EPOCHS: u32 = 20;
/// Fresh points for the evaluation of a chain: 500 per neuron on average.
pub const PROBES: usize = 16_000;
/// Side of a cluster; the two lie in opposite corners of the cube.
const CLUSTER: f64 = 0.35;
/// Share of the uneven cloud's points in the half with small x.
const DENSE_SHARE: f64 = 0.75;

/// A point of the unit cube.
pub type Point3 = [f64; 3];

/// Distribution of the points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cloud {
    /// Anywhere in the unit cube (Fig. 1a).
    Uniform,
    /// In one of two cubes in opposite corners (Fig. 1b).
    Clusters,
    /// Three of four points in the half with x below 0.5.
    Uneven,
}

impl Cloud {
    fn draw(self, noise: &mut Noise) -> Point3 {
        let [x, y, z] = std::array::from_fn(|_| noise.uniform());
        match self {
            Self::Uniform => [x, y, z],
            Self::Clusters => {
                let low = if noise.chance(0.5) {
                    0.0
                } else {
                    1.0 - CLUSTER
                };
                [x, y, z].map(|value| low + CLUSTER * value)
            }
            Self::Uneven => {
                let low = if noise.chance(DENSE_SHARE) { 0.0 } else { 0.5 };
                [low + 0.5 * x, y, z]
            }
        }
    }

    /// Whether the cloud can contain the point.
    fn covers(self, point: &Point3) -> bool {
        let within = |low: f64, high: f64| point.iter().all(|v| (low..=high).contains(v));
        match self {
            Self::Uniform | Self::Uneven => within(0.0, 1.0),
            Self::Clusters => within(0.0, CLUSTER) || within(1.0 - CLUSTER, 1.0),
        }
    }
}

/// A trained chain and its training data.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    /// The cloud.
    pub cloud: Cloud,
    /// The points from which it learned.
    pub points: Vec<Point3>,
    /// Code vectors along the chain.
    pub code: Vec<Point3>,
    /// Fresh points of the same cloud that each neuron wins.
    pub hits: Vec<usize>,
    /// Share of the unit cube that each neuron wins: its receptive field.
    pub volumes: Vec<f64>,
    /// Share of fresh points whose two best neurons are not neighbors in the chain.
    pub topographic_error: f64,
    /// Neurons whose code vector lies outside the cloud.
    pub in_the_void: usize,
}

impl Chain {
    /// Trains a chain on a cloud drawn by `seed`.
    #[must_use]
    pub fn trained(cloud: Cloud, seed: u64) -> Self {
        let mut noise = Noise::new(seed);
        let points: Vec<_> = (0..POINTS).map(|_| cloud.draw(&mut noise)).collect();
        let mut samples = flat(&points);
        let grid = Grid::chain(NEURONS as u16);
        let mut map = init_from_samples(grid, 3, &samples, &mut noise).expect("three components");
        map.train(&mut samples, &train_config(), |below| noise.index(below));
        let mut probes =
            |cloud: Cloud| -> Vec<_> { (0..PROBES).map(|_| cloud.draw(&mut noise)).collect() };
        let measured = MapQuality::measure(&map, &flat(&probes(cloud)));
        let everywhere = MapQuality::measure(&map, &flat(&probes(Cloud::Uniform)));
        let code: Vec<Point3> = map.code_vectors().map(point_of).collect();
        Self {
            in_the_void: code.iter().filter(|point| !cloud.covers(point)).count(),
            cloud,
            points,
            code,
            hits: measured.hits,
            volumes: everywhere
                .hits
                .iter()
                .map(|&hits| hits as f64 / PROBES as f64)
                .collect(),
            topographic_error: measured.topographic_error,
        }
    }

    /// Whether the cloud can contain the point.
    #[must_use]
    pub fn covers(&self, point: &Point3) -> bool {
        self.cloud.covers(point)
    }

    /// Each neuron's hits divided by the mean.
    #[must_use]
    pub fn relative_hits(&self) -> Vec<f64> {
        let mean = self.hits.iter().sum::<usize>() as f64 / NEURONS as f64;
        self.hits.iter().map(|&hits| hits as f64 / mean).collect()
    }

    /// Mean hits (relative to the mean of all) and mean receptive field of the neurons in the half
    /// with small x and in the other half; `None` for a half without neurons.
    #[must_use]
    pub fn halves(&self) -> [Option<[f64; 2]>; 2] {
        let hits = self.relative_hits();
        [false, true].map(|upper| {
            let mut members = Vec::new();
            for (k, point) in self.code.iter().enumerate() {
                if (point[0] >= 0.5) == upper {
                    members.push([hits[k], self.volumes[k]]);
                }
            }
            let count = members.len() as f64;
            let mean = |i: usize| members.iter().map(|member| member[i]).sum::<f64>() / count;
            (!members.is_empty()).then(|| [mean(0), mean(1)])
        })
    }
}

/// Training schedule; the learning rate falls from 0.5 to 0.02.
fn train_config() -> TrainConfig {
    TrainConfig {
        neighborhood: Neighborhood::Gaussian,
        rate: Schedule::from_q16(32_768, 1_311, Decay::Exponential),
        radius: Schedule::from_q16(8 << 16, 32_768, Decay::Exponential),
        epochs: EPOCHS,
        order: SampleOrder::Shuffled,
    }
}

fn flat(points: &[Point3]) -> Vec<Weight32> {
    points
        .iter()
        .flatten()
        .map(|&v| Weight32::from_num(v))
        .collect()
}

fn point_of(code: &[Weight32]) -> Point3 {
    std::array::from_fn(|i| code.get(i).map_or(0.0, |value| value.to_num()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_neuron_of_fig_1a_stands_for_about_its_share() {
        let chain = Chain::trained(Cloud::Uniform, 1);
        assert_eq!(chain.hits.iter().sum::<usize>(), PROBES);
        assert_eq!((chain.code.len(), chain.in_the_void), (NEURONS, 0));
        assert!(
            chain
                .relative_hits()
                .iter()
                .all(|share| (0.3..3.0).contains(share)),
            "{:?}",
            chain.hits
        );
        assert!(chain.topographic_error < 0.9);
        assert_eq!(chain, Chain::trained(Cloud::Uniform, 1));
    }

    #[test]
    fn the_chain_of_fig_1b_crosses_the_void() {
        let chain = Chain::trained(Cloud::Clusters, 1);
        assert!(
            (1..=6).contains(&chain.in_the_void),
            "{}",
            chain.in_the_void
        );
        let corners = [[0.1, 0.2, 0.3], [0.7, 0.8, 0.9], [0.5, 0.5, 0.5]];
        let covered = corners.map(|point| Cloud::Clusters.covers(&point));
        assert_eq!(covered, [true, true, false]);
    }
}
