//! Situations of a simulated robot's drive, as elements of sequences.

use amp::config::Config;
use amp::fixed::Weight;
use amp::scan::Situation;
use amp::sequence::Pattern;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::World;
use files::error::BadInput;
use sim::behavior::Behavior;
use sim::episode::{Setup, run};

/// Decisions of a drive.
const STEPS: u32 = 1_000;
/// Every so many of them is tried as an element: the robot has gone about a meter.
const EVERY: usize = 4;
/// An element differs from all before by one in so many bits at least: what hardly differs is no
/// other element.
const APART: usize = 16;
/// A drive has so many elements of 128 bits at least.
const LEAST: usize = 32;
/// Worlds that are tried for one seed, and how far apart their seeds are.
const TRIES: u64 = 20;
const NEXT: u64 = 1_000;

/// What a robot perceived while it drove around in a world of another kind than plain rooms.
pub(super) struct Drive(Vec<Situation<16>>);

impl Drive {
    /// The seed is that of the world and of the episode. Where a robot perceives little, as in wide
    /// halls, another world is tried.
    pub(super) fn of_seed(seed: u64) -> Result<Self, BadInput> {
        for number in 0..TRIES {
            let drive = Self::around(seed.wrapping_add(number.wrapping_mul(NEXT)))?;
            if drive.elements::<128>(LEAST).len() == LEAST {
                return Ok(drive);
            }
        }
        Err(BadInput::new(format!(
            "--seed {seed}: in {TRIES} worlds no drive had {LEAST} different situations"
        )))
    }

    fn around(seed: u64) -> Result<Self, BadInput> {
        let setup = Setup {
            config: Config::recommended(),
            preset: "default".to_owned(),
            behavior: Behavior::Avoid,
            goal: None,
            explore_moves: 100,
            steps: STEPS,
            seed,
            sonar: SonarModel::Ideal,
            faults: Vec::new(),
            second_robot: false,
            turret: TurretMode::Held,
            robot: None,
            set_down: None,
            record: true,
        };
        let episode = run(&World::random2(seed), &setup, |_, _, _| {});
        let episode = episode.map_err(|error| BadInput::new(error.to_string()))?;
        let steps = episode.recording.map_or(Vec::new(), |it| it.seeking);
        let situation = |values: &Vec<f64>| -> Option<Situation<16>> {
            let values = values.iter().map(|value| Weight::from_num(*value));
            values.collect::<Vec<_>>().try_into().ok()
        };
        let every = steps.iter().step_by(EVERY);
        let situations = every.filter_map(|step| situation(&step.situation));
        Ok(Self(situations.collect()))
    }

    /// At most so many elements, each apart from all before.
    pub(super) fn elements<const N: usize>(&self, count: usize) -> Vec<Pattern<N>> {
        let mut elements: Vec<Pattern<N>> = Vec::new();
        for situation in &self.0 {
            let element = Pattern::of_situation(situation);
            let mut before = elements.iter();
            let is_apart = before.all(|other| other.distance(&element) * APART >= N);
            if elements.len() < count && is_apart {
                elements.push(element);
            }
        }
        elements
    }
}
