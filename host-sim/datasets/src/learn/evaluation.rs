//! Trains both maps on the first part of a log and tests recall on the rest.

use super::associative_memory::{AssociativeMemory, NeuronLabels};
use super::dataset::{Dataset, Split};
use super::score::Score;
use crate::som::args::{DEFAULT_RATE, default_radius, parse_rate};
use crate::som::init::init_from_samples;
use crate::som::map_quality::MapQuality;
use arena::noise::Noise;
use files::error::BadInput;
use rayon::prelude::*;
use tinysom::{DynSom, Grid, Neighborhood, SampleOrder, TrainConfig};

/// Method of recalling an action.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecallMethod {
    /// The most frequent class, or the mean velocities.
    Mean,
    /// The action of the nearest training change.
    NearestChange,
    /// The action of the nearest training situation.
    NearestSituation,
    /// The paper's action map: (change, action) pairs, probed with the change.
    ActionByChange,
    /// The same map with (situation, action) pairs, probed with the situation.
    ActionBySituation,
    /// The situation map, each neuron labeled with the mean action of the situations it wins.
    SituationMap,
}

impl RecallMethod {
    /// Name of the method and of its probe, for tables and pictures.
    #[must_use]
    pub fn descriptions(self, is_named: bool) -> [&'static str; 2] {
        match self {
            Self::Mean if is_named => ["most frequent class", "nothing"],
            Self::Mean => ["mean", "nothing"],
            Self::NearestChange => ["1-nearest neighbor", "change"],
            Self::NearestSituation => ["1-nearest neighbor", "situation"],
            Self::ActionByChange => ["action map (the paper's)", "change"],
            Self::ActionBySituation => ["action map", "situation"],
            Self::SituationMap => ["situation map, labeled", "situation"],
        }
    }

    /// Key in JSON and in file names.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::NearestChange => "nearest_change",
            Self::NearestSituation => "nearest_situation",
            Self::ActionByChange => "action_map_by_change",
            Self::ActionBySituation => "action_map_by_situation",
            Self::SituationMap => "situation_map",
        }
    }
}

/// Score of a method on the held-out part.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodScore {
    /// The method.
    pub method: RecallMethod,
    /// Its score.
    pub score: Score,
}

/// Results for one map size.
#[derive(Debug, Clone)]
pub struct MapResult {
    /// Grid of both maps.
    pub grid: Grid,
    /// The situation map.
    pub situations: DynSom,
    /// Its quality on the training part.
    pub training: MapQuality,
    /// Its quality on the held-out part.
    pub held_out: MapQuality,
    /// Labels of its neurons.
    pub labels: NeuronLabels,
    /// Scores of the action map by the change, by the situation, and of the labeled situation map.
    pub scores: Vec<MethodScore>,
}

/// Results of all methods and map sizes.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// Scores of the methods without maps.
    pub baselines: Vec<MethodScore>,
    /// By map size, in the given order.
    pub maps: Vec<MapResult>,
}

/// Options for training the maps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrainOptions {
    /// Presentations of every sample.
    pub epochs: u32,
    /// Seed of the initial code vectors and of the sample order; the same for every map.
    pub seed: u64,
    /// Weight of an action relative to a component of the input, above 0, at most 1.
    pub action_weight: f64,
}

/// Trains maps of all sizes on the training part and tests them on the held-out part. Calls `done`
/// after each map size.
///
/// # Errors
/// More than `u32::MAX` presentations.
pub fn evaluate(
    dataset: &Dataset,
    grids: &[Grid],
    options: &TrainOptions,
    done: &(impl Fn() + Sync),
) -> Result<Evaluation, BadInput> {
    let presentations = dataset.rows(Split::Training) as u64 * u64::from(options.epochs);
    if presentations > u64::from(u32::MAX) {
        return Err(BadInput::new(format!(
            "--epochs {}: {presentations} presentations are more than {}",
            options.epochs,
            u32::MAX
        )));
    }
    let maps = grids.par_iter().map(|&grid| {
        let map = train_and_evaluate(dataset, grid, options);
        done();
        map
    });
    Ok(Evaluation {
        baselines: baselines(dataset)?,
        maps: maps.collect::<Result<_, _>>()?,
    })
}

/// Scores of the methods without maps.
fn baselines(dataset: &Dataset) -> Result<Vec<MethodScore>, BadInput> {
    let is_named = dataset.classes.is_some();
    let evaluate = |(method, memory, by_change): (_, Result<_, BadInput>, _)| {
        let pairs = if by_change {
            dataset.changes(Split::HeldOut)
        } else {
            dataset.situations(Split::HeldOut)
        };
        let score = Score::new(&memory?, &pairs, is_named);
        Ok(MethodScore { method, score })
    };
    let (situations, changes) = (
        dataset.situations(Split::Training),
        dataset.changes(Split::Training),
    );
    [
        (
            RecallMethod::Mean,
            AssociativeMemory::from_mean(&situations),
            false,
        ),
        (
            RecallMethod::NearestChange,
            AssociativeMemory::from_samples(&changes),
            true,
        ),
        (
            RecallMethod::NearestSituation,
            AssociativeMemory::from_samples(&situations),
            false,
        ),
    ]
    .into_par_iter()
    .map(evaluate)
    .collect()
}

/// Trains both maps of one size and scores them on the held-out part.
fn train_and_evaluate(
    dataset: &Dataset,
    grid: Grid,
    options: &TrainOptions,
) -> Result<MapResult, BadInput> {
    let neighborhood = Neighborhood::Gaussian;
    let config = TrainConfig {
        neighborhood,
        rate: parse_rate(DEFAULT_RATE)?,
        radius: default_radius(neighborhood, grid)?,
        epochs: options.epochs,
        order: SampleOrder::Shuffled,
    };
    let (training, held_out) = (
        dataset.situations(Split::Training),
        dataset.situations(Split::HeldOut),
    );
    let noise = || Noise::new(options.seed);
    let mut random = noise();
    let mut map = init_from_samples(grid, training.dims, &training.inputs, &mut random)?;
    map.train(&mut training.inputs.clone(), &config, |below| {
        random.index(below)
    });
    let (labeled_map, labels) = AssociativeMemory::from_labeled_map(&map, &training)?;
    let action_map = |pairs| {
        AssociativeMemory::train_action_map(
            pairs,
            grid,
            &config,
            options.action_weight,
            &mut noise(),
        )
    };
    let is_named = dataset.classes.is_some();
    let methods = [
        (
            RecallMethod::ActionByChange,
            action_map(&dataset.changes(Split::Training))?,
            &dataset.changes(Split::HeldOut),
        ),
        (
            RecallMethod::ActionBySituation,
            action_map(&training)?,
            &held_out,
        ),
        (RecallMethod::SituationMap, labeled_map, &held_out),
    ];
    let evaluate = |(method, memory, pairs): (RecallMethod, AssociativeMemory, _)| MethodScore {
        method,
        score: Score::new(&memory, pairs, is_named),
    };
    Ok(MapResult {
        grid,
        training: MapQuality::measure(&map, &training.inputs),
        held_out: MapQuality::measure(&map, &held_out.inputs),
        scores: methods.into_iter().map(evaluate).collect(),
        situations: map,
        labels,
    })
}
