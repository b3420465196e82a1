//! Improvement by mere repetition: the same behaviour again and again from one memory, the maps going on to learn or
//! frozen.

use super::behaviors::{Mean, Scene, Trial, bootstrap};
use crate::episode::{Failure, repeat};
use rayon::prelude::*;

/// Repetitions of one behaviour.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// The measure at each repetition, while the maps learn.
    pub learning: Vec<Mean>,
    /// The same with frozen maps.
    pub frozen: Vec<Mean>,
    /// Learning less frozen over the last half, paired by episode.
    pub difference: Mean,
}

/// Measures `repetitions` of a scene of `steps` decisions each.
///
/// # Errors
/// When an episode fails.
pub fn measure(scene: &Scene, trial: &Trial, repetitions: u32) -> Result<Curve, Failure> {
    let mut frozen = trial.clone();
    frozen.config.online = None;
    let (learning, frozen) = (
        values(scene, trial, repetitions)?,
        values(scene, &frozen, repetitions)?,
    );
    let at = |worlds: &[Vec<Vec<f64>>], repetition: usize| {
        let one = |curve: &Vec<f64>| curve.get(repetition).copied().unwrap_or(0.0);
        let of_world = |world: &Vec<Vec<f64>>| world.iter().map(one).collect();
        bootstrap(&worlds.iter().map(of_world).collect::<Vec<_>>())
    };
    let late = |curve: &Vec<f64>| {
        let half = curve.get(curve.len() / 2..).unwrap_or_default();
        half.iter().sum::<f64>() / half.len().max(1) as f64
    };
    let pairs = learning.iter().zip(&frozen).map(|(a, b)| {
        let difference = |(a, b)| late(a) - late(b);
        a.iter().zip(b).map(difference).collect()
    });
    let all = 0..repetitions as usize;
    Ok(Curve {
        learning: all.clone().map(|i| at(&learning, i)).collect(),
        frozen: all.map(|i| at(&frozen, i)).collect(),
        difference: bootstrap(&pairs.collect::<Vec<_>>()),
    })
}

/// By world, seed and repetition.
fn values(scene: &Scene, trial: &Trial, repetitions: u32) -> Result<Vec<Vec<Vec<f64>>>, Failure> {
    let worlds = (0..u64::from(trial.worlds)).into_par_iter().map(|index| {
        let world = scene.world(index + 1);
        let seeds = (0..u64::from(trial.seeds)).into_par_iter().map(|seed| {
            let setup = scene.setup(trial, &world, 1_000 * (index + 1) + seed);
            let reports = repeat(&world, &setup, repetitions)?;
            Ok(reports.iter().map(|report| scene.value(report)).collect())
        });
        seeds.collect::<Result<Vec<Vec<f64>>, Failure>>()
    });
    worlds.collect()
}
