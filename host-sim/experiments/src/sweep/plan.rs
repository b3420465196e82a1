//! The numbered episodes of a sweep.

use super::CHOICE_PREFIX;
use super::description::Description;
use super::identity::Hasher;
use super::points::Assignment;
use super::results::ResultsHeader;
use arena::loaders::WorldSource;
use files::error::BadInput;
use sim::episode::{EpisodeReport, Setup};

/// Meaning of a point's keys. The command line defines its flags; a sweep only passes them on.
#[derive(Debug, Clone)]
pub struct Vocabulary {
    /// Keys other than those of [`settings`](sim::settings).
    pub flags: Vec<String>,
    /// Checks that a key accepts a value.
    pub check: fn(&str, &str) -> Result<(), BadInput>,
    /// Builds an episode's setup from keys and values, with behavior `avoid` and seed 1.
    pub setup: fn(&[Assignment]) -> Result<Setup, BadInput>,
}

/// An episode as indices into the description.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EpisodeIndex {
    /// Index of the point.
    pub point: u64,
    /// Index of the behavior.
    pub behavior: usize,
    /// Index of the world.
    pub world: usize,
    /// Index of the seed.
    pub seed: usize,
}

/// A checked sweep: every point makes a setup, every world file loads.
#[derive(Debug, Clone)]
pub struct SweepPlan {
    description: Description,
    vocabulary: Vocabulary,
    header: ResultsHeader,
}

impl SweepPlan {
    /// Checks every point, and every world that is a file.
    ///
    /// # Errors
    /// The first invalid point, the first world that cannot be loaded, or too many episodes.
    pub fn new(description: Description, vocabulary: Vocabulary) -> Result<Self, BadInput> {
        let episodes = episode_count(&description)?;
        let identity = identity(&description, &vocabulary)?;
        let keys = description
            .points
            .keys()
            .iter()
            .map(|key| format!("{CHOICE_PREFIX}{key}"));
        let header = ResultsHeader::new(
            &description.name,
            &identity,
            episodes,
            keys.chain(EpisodeReport::FIELDS.map(str::to_owned)),
        );
        Ok(Self {
            description,
            vocabulary,
            header,
        })
    }

    /// The sweep's description.
    #[must_use]
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// The header of its results.
    #[must_use]
    pub fn header(&self) -> &ResultsHeader {
        &self.header
    }

    /// Number of episodes.
    #[must_use]
    pub fn episodes(&self) -> u64 {
        self.header.episodes()
    }

    /// The indices of episode `number`.
    #[must_use]
    pub fn place(&self, number: u64) -> EpisodeIndex {
        let mut rest = number;
        let mut next = |count: usize| {
            let count = count.max(1) as u64;
            let place = (rest % count) as usize;
            rest /= count;
            place
        };
        let seed = next(self.description.seeds.len());
        let world = next(self.description.worlds.len());
        let behavior = next(self.description.behaviors.len());
        EpisodeIndex {
            point: rest,
            behavior,
            world,
            seed,
        }
    }

    /// The setup of the episodes at these indices, apart from the seed.
    ///
    /// # Errors
    /// None for indices of this plan: they are all checked.
    pub fn setup(&self, place: EpisodeIndex) -> Result<Setup, BadInput> {
        let setup = (self.vocabulary.setup)(&self.description.points.choices(place.point))?;
        let behavior = self.description.behaviors.get(place.behavior).cloned();
        Ok(setup.pursuing(behavior.unwrap_or(sim::behavior::Behavior::Avoid)))
    }
}

/// Number of episodes of a sweep.
fn episode_count(description: &Description) -> Result<u64, BadInput> {
    let Description {
        name,
        worlds,
        behaviors,
        seeds,
        points,
    } = description;
    let lengths = [behaviors.len(), worlds.len(), seeds.len()].map(|length| length as u64);
    lengths
        .into_iter()
        .try_fold(points.count().unwrap_or(u64::MAX), u64::checked_mul)
        .ok_or_else(|| BadInput::new(format!("sweep {name}: it has more than 2^64 episodes")))
}

/// Checks every point and every world file, and hashes all that determines the results.
fn identity(description: &Description, vocabulary: &Vocabulary) -> Result<String, BadInput> {
    let Description {
        name,
        worlds,
        behaviors,
        seeds,
        points,
    } = description;
    let mut hash = Hasher::new();
    hash.part(format_args!("{}", env!("CARGO_PKG_VERSION")));
    for point in 0..points.count().unwrap_or(0) {
        let choices = points.choices(point);
        let setup = (vocabulary.setup)(&choices).map_err(|error| {
            let choices: Vec<_> = choices
                .iter()
                .map(|(key, value)| format!("{key}={value}"))
                .collect();
            BadInput::new(format!(
                "sweep {name}, point {point} ({}): {error}",
                choices.join(" ")
            ))
        })?;
        hash.part(format_args!("{:?} {setup:?}", points.cells(point)));
    }
    hash.part(format_args!("{behaviors:?} {seeds:?}"));
    for source in worlds {
        hash.part(format_args!("{source}"));
        if matches!(source, WorldSource::File(_) | WorldSource::Barn(_)) {
            hash.world(&source.load()?);
        }
    }
    Ok(hash.finish())
}
