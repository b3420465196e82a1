//! The episodes of a sweep by number.

use super::CHOICE_PREFIX;
use super::description::Description;
use super::identity::Hasher;
use super::points::Assignment;
use super::results::Header;
use arena::world::WorldSource;
use files::error::BadInput;
use sim::episode::{EpisodeReport, Setup};

/// What a point's keys mean. The command line knows its flags; a sweep only hands them on.
#[derive(Debug, Clone)]
pub struct Vocabulary {
    /// Keys beside those of [`settings`](sim::settings).
    pub flags: Vec<String>,
    /// Whether a key takes a value.
    pub check: fn(&str, &str) -> Result<(), BadInput>,
    /// An episode's setup from keys and values, with behavior `avoid` and seed 1.
    pub setup: fn(&[Assignment]) -> Result<Setup, BadInput>,
}

/// What an episode is, by the places of its parts in the description.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Point.
    pub point: u64,
    /// Behavior.
    pub behavior: usize,
    /// World.
    pub world: usize,
    /// Seed.
    pub seed: usize,
}

/// A sweep that is known to be sound: every point makes a setup, every world file loads.
#[derive(Debug, Clone)]
pub struct Plan {
    description: Description,
    vocabulary: Vocabulary,
    header: Header,
}

impl Plan {
    /// Looks at every point, and at every world that comes from a file.
    ///
    /// # Errors
    /// The first point whose choices do not go together, the first world that cannot be loaded, too many episodes.
    pub fn new(description: Description, vocabulary: Vocabulary) -> Result<Self, BadInput> {
        let Description {
            name,
            worlds,
            behaviors,
            seeds,
            points,
        } = &description;
        let lengths = [behaviors.len(), worlds.len(), seeds.len()].map(|length| length as u64);
        let episodes = lengths
            .into_iter()
            .try_fold(points.count().unwrap_or(u64::MAX), u64::checked_mul)
            .ok_or_else(|| {
                BadInput::new(format!("sweep {name}: it has more than 2^64 episodes"))
            })?;

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
        let keys = points
            .keys()
            .iter()
            .map(|key| format!("{CHOICE_PREFIX}{key}"));
        let header = Header::new(
            name,
            &hash.finish(),
            episodes,
            keys.chain(EpisodeReport::FIELDS.map(str::to_owned)),
        );
        Ok(Self {
            description,
            vocabulary,
            header,
        })
    }

    /// What the sweep's file says.
    #[must_use]
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// The head of its results.
    #[must_use]
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Number of its episodes.
    #[must_use]
    pub fn episodes(&self) -> u64 {
        self.header.episodes()
    }

    /// What episode `number` is.
    #[must_use]
    pub fn place(&self, number: u64) -> Place {
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
        Place {
            point: rest,
            behavior,
            world,
            seed,
        }
    }

    /// The setup of the episodes at a place, but for their seed.
    ///
    /// # Errors
    /// None for a place of this plan: they were all looked at.
    pub fn setup(&self, place: Place) -> Result<Setup, BadInput> {
        let setup = (self.vocabulary.setup)(&self.description.points.choices(place.point))?;
        let behavior = self.description.behaviors.get(place.behavior).cloned();
        Ok(setup.pursuing(behavior.unwrap_or(sim::behavior::Behavior::Avoid)))
    }
}
