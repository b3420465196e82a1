//! What a simulated robot perceives beside its ranges, and goals in those modalities.

use amp::memory::SituationBytes;
use amp::modality::{MAX_VALUE, Modality, Record, Search, Sought};
use amp::places::{Aim, Places};
use amp::units::{Displacement, Millis};
use arena::sources::{self, COLORS, Sensed};
use files::error::BadInput;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

mod saved;

pub use saved::SavedSenses;

/// Records of each modality.
const RECORDS: usize = 256;
/// Of what has one component only.
const STRONGEST: Sought<1> = Sought::Most(0);
/// Readings of sensors that are not exact deviate by this share: standard deviation.
pub const NOISE: f64 = 0.05;

/// What can be sensed beside ranges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sense {
    /// How strong a scent is.
    Scent,
    /// How bright it is.
    Light,
    /// The color of the floor.
    Floor,
}

impl Sense {
    const ALL: [(&str, Self); 3] = [
        ("scent", Self::Scent),
        ("light", Self::Light),
        ("floor", Self::Floor),
    ];

    fn name(self) -> &'static str {
        let known = Self::ALL.iter().find(|(_, sense)| *sense == self);
        known.map_or("", |(name, _)| name)
    }
}

/// A goal in one of these modalities.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SenseGoal {
    /// Where a scent is strongest.
    Scent,
    /// Where it is brightest.
    Light,
    /// Where the floor has a color, by its name.
    Floor(&'static str),
    /// Where the robot was before this became as it is now.
    Before(Sense),
}

impl SenseGoal {
    /// The forms on the command line.
    pub const FORMS: [&str; 4] = [
        "scent:strongest",
        "light:strongest",
        "floor:COLOR",
        "SENSE:before",
    ];

    /// The name on the command line.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Scent => "scent:strongest".to_owned(),
            Self::Light => "light:strongest".to_owned(),
            Self::Floor(color) => format!("floor:{color}"),
            Self::Before(sense) => format!("{}:before", sense.name()),
        }
    }

    /// Whether the name is that of a goal in such a modality, right or wrong.
    #[must_use]
    pub fn is_meant_by(name: &str) -> bool {
        let sense = name.split(':').next().unwrap_or(name);
        Sense::ALL.iter().any(|(known, _)| *known == sense)
    }
}

impl FromStr for SenseGoal {
    type Err = BadInput;

    fn from_str(name: &str) -> Result<Self, BadInput> {
        let (sense, wanted) = name.split_once(':').unwrap_or((name, ""));
        let found = Sense::ALL.iter().find(|(known, _)| *known == sense);
        let Some((_, sense)) = found else {
            let known = Sense::ALL.map(|(known, _)| known);
            return Err(BadInput::unknown("sense", sense, &known));
        };
        let color = COLORS.iter().find(|(known, _)| *known == wanted);
        match (sense, wanted, color) {
            (sense, "before", _) => Ok(Self::Before(*sense)),
            (Sense::Scent, "strongest", _) => Ok(Self::Scent),
            (Sense::Light, "strongest", _) => Ok(Self::Light),
            (Sense::Floor, _, Some((color, _))) => Ok(Self::Floor(color)),
            (Sense::Floor, ..) => {
                let colors = COLORS.iter().map(|(known, _)| *known);
                let known: Vec<_> = colors.chain(["before"]).collect();
                Err(BadInput::unknown("goal floor", wanted, &known))
            }
            (Sense::Scent | Sense::Light, ..) => {
                let what = format!("goal {}", sense.name());
                Err(BadInput::unknown(&what, wanted, &["strongest", "before"]))
            }
        }
    }
}

/// What the sensors read: 0 … 254.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Readings {
    scent: SituationBytes<1>,
    light: SituationBytes<1>,
    floor: SituationBytes<3>,
}

impl Readings {
    /// Readings of what is there, each multiplied by what `factor` draws.
    #[must_use]
    pub fn of(sensed: &Sensed, mut factor: impl FnMut() -> f64) -> Self {
        let mut byte = |value: f64| {
            let reading = value * factor() * f64::from(MAX_VALUE);
            libm::rint(reading).clamp(0.0, f64::from(MAX_VALUE)) as u8
        };
        Self {
            scent: [byte(sensed.scent)],
            light: [byte(sensed.light)],
            floor: sensed.floor.map(byte),
        }
    }
}

/// Memories of all modalities, and what is looked for.
#[derive(Debug, Clone, Default)]
pub struct Senses {
    scent: Modality<1, RECORDS>,
    light: Modality<1, RECORDS>,
    floor: Modality<3, RECORDS>,
    goal: Option<SenseGoal>,
    /// Where the robot was before.
    before: Option<Displacement>,
    search: Search,
    latest: Option<Readings>,
    /// When the sensors were read.
    now: Millis,
}

impl Senses {
    /// Forgets all but the goal.
    pub fn forget(&mut self) {
        self.scent.forget();
        self.light.forget();
        self.floor.forget();
        self.latest = None;
    }

    /// The sensors read this at a position of the frame of places.
    pub fn perceive(&mut self, readings: &Readings, here: Displacement, now: Millis) {
        self.scent.perceive(&readings.scent, here, now);
        self.light.perceive(&readings.light, here, now);
        self.floor.perceive(&readings.floor, here, now);
        (self.latest, self.now) = (Some(*readings), now);
    }

    /// From now on this is looked for.
    pub fn seek(&mut self, goal: Option<SenseGoal>) {
        self.goal = goal;
        self.search = Search::default();
        let now = self.now;
        self.before = match (goal, &self.latest) {
            (Some(SenseGoal::Before(sense)), Some(readings)) => match sense {
                Sense::Scent => before(&self.scent, &readings.scent, now),
                Sense::Light => before(&self.light, &readings.light, now),
                Sense::Floor => before(&self.floor, &readings.floor, now),
            },
            _ => None,
        };
    }

    /// Where what is sought was perceived, and how strongly, 0 … 1; nothing for what was before.
    #[must_use]
    pub fn remembered(&self, goal: SenseGoal) -> Vec<(Displacement, f64)> {
        match goal {
            SenseGoal::Scent => strengths(&self.scent, &STRONGEST),
            SenseGoal::Light => strengths(&self.light, &STRONGEST),
            SenseGoal::Floor(color) => strengths(&self.floor, &colored(color)),
            SenseGoal::Before(_) => Vec::new(),
        }
    }

    /// Where a robot that looks for something is to be led; `None` if it does not.
    #[must_use]
    pub fn aim<const SECTORS: usize, const PLACES: usize>(
        &mut self,
        places: &Places<SECTORS, PLACES>,
        now: Millis,
    ) -> Option<Aim> {
        let search = &mut self.search;
        Some(match self.goal? {
            SenseGoal::Scent => search.aim(&self.scent, &STRONGEST, places, now),
            SenseGoal::Light => search.aim(&self.light, &STRONGEST, places, now),
            SenseGoal::Floor(color) => search.aim(&self.floor, &colored(color), places, now),
            SenseGoal::Before(_) => self.before.map_or(Aim::Everywhere, Aim::Position),
        })
    }
}

/// The color of the floor with this name.
fn colored(name: &str) -> Sought<3> {
    let color = sources::named_color(name).unwrap_or_default();
    Sought::Alike(color.map(|share| libm::rint(share * f64::from(MAX_VALUE)) as u8))
}

fn strengths<const COMPONENTS: usize>(
    modality: &Modality<COMPONENTS, RECORDS>,
    sought: &Sought<COMPONENTS>,
) -> Vec<(Displacement, f64)> {
    let present = modality.records().iter().filter(|record| !record.is_past);
    let strength = |record: &Record<COMPONENTS>| {
        let share = f64::from(sought.deviation(&record.values)) / f64::from(MAX_VALUE);
        (record.at, 1.0 - share)
    };
    present.map(strength).collect()
}

fn before<const COMPONENTS: usize>(
    modality: &Modality<COMPONENTS, RECORDS>,
    values: &SituationBytes<COMPONENTS>,
    now: Millis,
) -> Option<Displacement> {
    let record = modality.recall_before(values, now)?;
    Some(record.at)
}

#[cfg(test)]
mod tests;
