//! Both maps learned from the first part of a log, asked about the rest.

use super::memory::Memory;
use super::score::Score;
use super::task::{Part, Task};
use crate::som::args::{DEFAULT_RATE, default_radius, rate};
use crate::som::measures::Measures;
use crate::som::start::start_at_samples;
use arena::noise::Noise;
use files::error::BadInput;
use rayon::prelude::*;
use tinysom::{DynSom, Grid, Neighborhood, SampleOrder, TrainConfig};

/// A way to recall an action.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// The most frequent class, or the mean velocities.
    Mean,
    /// What was done at the learned change most like this one.
    NearestChange,
    /// What was done in the learned situation most like this one.
    NearestSituation,
    /// The paper's action map, (change, action) pairs, probed with the change.
    ActionByChange,
    /// The same map of (situation, action) pairs, probed with the situation.
    ActionBySituation,
    /// The situation map, each neuron with what was done in the situations it won.
    SituationMap,
}

impl Method {
    /// What it is and what it is asked with.
    #[must_use]
    pub fn words(self, named: bool) -> [&'static str; 2] {
        match self {
            Self::Mean if named => ["most frequent class", "nothing"],
            Self::Mean => ["mean", "nothing"],
            Self::NearestChange => ["1-nearest neighbor", "change"],
            Self::NearestSituation => ["1-nearest neighbor", "situation"],
            Self::ActionByChange => ["action map (the paper's)", "change"],
            Self::ActionBySituation => ["action map", "situation"],
            Self::SituationMap => ["situation map, labeled", "situation"],
        }
    }

    /// A key for machines.
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

/// What a method recalled of the part held out.
#[derive(Debug, Clone, PartialEq)]
pub struct Recalled {
    /// How.
    pub method: Method,
    /// How well.
    pub score: Score,
}

/// What maps of one size learned.
#[derive(Debug, Clone)]
pub struct Map {
    /// Their grid.
    pub grid: Grid,
    /// The situation map.
    pub situations: DynSom,
    /// Its quality on the part learned.
    pub learned: Measures,
    /// Its quality on the part held out.
    pub held_out: Measures,
    /// By neuron: what was done in the situations it won; `None` where it won none.
    pub labels: Vec<Option<Vec<f64>>>,
    /// Recall by the change, by the situation, and by the situation map's labels.
    pub recalls: Vec<Recalled>,
}

/// All that was found.
#[derive(Debug, Clone)]
pub struct Study {
    /// What the maps are compared with.
    pub references: Vec<Recalled>,
    /// By map size, as asked.
    pub maps: Vec<Map>,
}

/// How maps are trained.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lesson {
    /// Presentations of every sample.
    pub epochs: u32,
    /// Seed of the starting code vectors and of the order; the same for every map.
    pub seed: u64,
    /// Weight of an action beside an input's component, above 0, at most 1.
    pub action_weight: f64,
}

/// Learns maps of all the sizes from the part of the log to be learned and asks them about the
/// rest.
///
/// # Errors
/// More presentations than can be counted.
pub fn study(
    task: &Task,
    grids: &[Grid],
    lesson: &Lesson,
    done: &(impl Fn() + Sync),
) -> Result<Study, BadInput> {
    let presentations = task.rows(Part::Learned) as u64 * u64::from(lesson.epochs);
    if presentations > u64::from(u32::MAX) {
        return Err(BadInput::new(format!(
            "--epochs {}: {presentations} presentations are more than {}",
            lesson.epochs,
            u32::MAX
        )));
    }
    let maps = grids.par_iter().map(|&grid| {
        let map = learn(task, grid, lesson);
        done();
        map
    });
    Ok(Study {
        references: references(task)?,
        maps: maps.collect::<Result<_, _>>()?,
    })
}

fn references(task: &Task) -> Result<Vec<Recalled>, BadInput> {
    let named = task.classes.is_some();
    let ask = |(method, memory, changes): (Method, Result<Memory, BadInput>, bool)| {
        let asked = if changes {
            task.changes(Part::HeldOut)
        } else {
            task.situations(Part::HeldOut)
        };
        let score = Score::of(&memory?, &asked, named);
        Ok(Recalled { method, score })
    };
    let (situations, changes) = (task.situations(Part::Learned), task.changes(Part::Learned));
    [
        (Method::Mean, Memory::of_the_mean(&situations), false),
        (Method::NearestChange, Memory::of_samples(&changes), true),
        (
            Method::NearestSituation,
            Memory::of_samples(&situations),
            false,
        ),
    ]
    .into_par_iter()
    .map(ask)
    .collect()
}

fn learn(task: &Task, grid: Grid, lesson: &Lesson) -> Result<Map, BadInput> {
    let neighborhood = Neighborhood::Gaussian;
    let config = TrainConfig {
        neighborhood,
        rate: rate(DEFAULT_RATE)?,
        radius: default_radius(neighborhood, grid)?,
        epochs: lesson.epochs,
        order: SampleOrder::Shuffled,
    };
    let (learned, held_out) = (
        task.situations(Part::Learned),
        task.situations(Part::HeldOut),
    );
    let noise = || Noise::new(lesson.seed);
    let mut random = noise();
    let mut map = start_at_samples(grid, learned.dims, &learned.inputs, &mut random)?;
    map.train(&mut learned.inputs.clone(), &config, |below| {
        random.index(below)
    });
    let (by_label, labels) = Memory::of_map(&map, &learned)?;
    let of_pairs =
        |pairs| Memory::of_pairs(pairs, grid, &config, lesson.action_weight, &mut noise());
    let named = task.classes.is_some();
    let asked = [
        (
            Method::ActionByChange,
            of_pairs(&task.changes(Part::Learned))?,
            &task.changes(Part::HeldOut),
        ),
        (Method::ActionBySituation, of_pairs(&learned)?, &held_out),
        (Method::SituationMap, by_label, &held_out),
    ];
    let ask = |(method, memory, pairs): (Method, Memory, _)| Recalled {
        method,
        score: Score::of(&memory, pairs, named),
    };
    Ok(Map {
        grid,
        learned: Measures::of(&map, &learned.inputs),
        held_out: Measures::of(&map, &held_out.inputs),
        recalls: asked.into_iter().map(ask).collect(),
        situations: map,
        labels,
    })
}
