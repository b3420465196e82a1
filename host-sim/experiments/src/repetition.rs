//! Improvement by repetition: repeats one behavior with the same memory, with learning or frozen
//! maps.

use super::behaviors::{BehaviorTrial, BySeed, run_all};
use super::scenes::BehaviorScene;
use sim::episode::repeat;
use sim::error::EpisodeError;
use sim::statistics::{Mean, bootstrap, mean};

/// Repetitions of one behavior.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// The measure at each repetition, with online learning.
    pub learning: Vec<Mean>,
    /// The same with frozen maps.
    pub frozen: Vec<Mean>,
    /// Learning minus frozen over the last half, paired by episode.
    pub difference: Mean,
    /// Last half minus first repetition with online learning, paired by episode.
    pub gain: Mean,
}

/// Measures `times` repetitions of a scene; `done` is called after each series.
///
/// # Errors
/// When an episode fails.
pub fn measure(
    scene: &BehaviorScene,
    trial: &BehaviorTrial,
    times: u32,
    done: &(impl Fn() + Sync),
) -> Result<Curve, EpisodeError> {
    let mut frozen = trial.clone();
    frozen.config.online = None;
    let learning = values(scene, trial, times, done)?;
    let frozen = values(scene, &frozen, times, done)?;
    let pairs = learning.iter().zip(&frozen).map(|(a, b)| {
        let difference = |(a, b): (&Vec<f64>, &Vec<f64>)| late(a) - late(b);
        a.iter().zip(b).map(difference).collect()
    });
    let since_first = |curve: &Vec<f64>| late(curve) - curve.first().copied().unwrap_or(0.0);
    let gains = learning
        .iter()
        .map(|world| world.iter().map(since_first).collect());
    let all = 0..times as usize;
    Ok(Curve {
        learning: all.clone().map(|i| at(&learning, i)).collect(),
        frozen: all.map(|i| at(&frozen, i)).collect(),
        difference: bootstrap(&pairs.collect::<Vec<_>>()),
        gain: bootstrap(&gains.collect::<Vec<_>>()),
    })
}

/// The measure by world, seed and repetition.
fn values(
    scene: &BehaviorScene,
    trial: &BehaviorTrial,
    times: u32,
    done: &(impl Fn() + Sync),
) -> Result<BySeed<Vec<f64>>, EpisodeError> {
    run_all(scene, trial, |world, setup| {
        let reports = repeat(world, setup, times)?;
        done();
        Ok(reports.iter().map(|report| scene.value(report)).collect())
    })
}

/// The mean of one repetition.
fn at(worlds: &BySeed<Vec<f64>>, repetition: usize) -> Mean {
    let one = |curve: &Vec<f64>| curve.get(repetition).copied().unwrap_or(0.0);
    let of_world = |world: &Vec<Vec<f64>>| world.iter().map(one).collect();
    bootstrap(&worlds.iter().map(of_world).collect::<Vec<_>>())
}

/// The mean over the last half of the repetitions.
fn late(curve: &[f64]) -> f64 {
    let half = curve.get(curve.len() / 2..).unwrap_or_default();
    mean(half.iter().copied())
}
