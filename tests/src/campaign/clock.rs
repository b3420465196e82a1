//! Overflow of the 32-bit milliseconds after 49.7 days: an episode across it must be bit-identical.
//!
//! It is compared, decision by decision, with an episode that starts at 0.

use super::{CampaignVerdict, ProgressCallback, below, generator, grouped};
use amp::config::Config;
use amp::controller::{Decision, Event, Outputs};
use amp::units::Millis;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::World;
use rayon::prelude::*;
use sim::behavior::Behavior;
use sim::episode::{Setup, run_with};
use sim::error::EpisodeError;
use sim::pilot::{InspectableController, LocalController, Pilot, SimState};

/// Episodes of a full campaign.
pub const COUNT: u64 = 1_000;
/// Decisions toward the goal in each episode.
const STEPS: u32 = 100;
/// Least duration of such an episode, ms.
const SHORTEST_MS: usize = 120_000;

/// A controller whose clock is ahead by `by`.
pub(super) struct Shifted {
    pub(super) mind: LocalController,
    by: u32,
    /// Its decisions, if recorded.
    decisions: Option<Vec<Decision<16>>>,
    /// The latest time by its clock.
    pub(super) latest: Millis,
    /// The clock has overflowed.
    pub(super) wrapped: bool,
}

impl Shifted {
    pub(super) fn new(config: Config<16>, by: u32) -> Self {
        Self {
            mind: LocalController::new(config),
            by,
            decisions: None,
            latest: Millis::from_ms(by),
            wrapped: false,
        }
    }

    fn that_remembers(config: Config<16>, by: u32) -> Self {
        Self {
            decisions: Some(Vec::new()),
            ..Self::new(config, by)
        }
    }
}

impl Pilot for Shifted {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        let at = Millis::from_ms(at.as_ms().wrapping_add(self.by));
        self.wrapped |= at.as_ms() < self.latest.as_ms();
        self.latest = at;
        let outputs = self.mind.handle(at, event);
        if let Some(decisions) = &mut self.decisions {
            decisions.extend(outputs.decision);
        }
        outputs
    }
}

impl InspectableController for Shifted {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        self.mind.knowledge()
    }
}

/// Result of an episode by two clocks.
#[derive(Debug, Clone, Copy)]
struct Compared {
    decisions: u64,
    wrapped: bool,
    same: bool,
}

/// Runs `count` episodes by two clocks each.
///
/// # Errors
/// When a controller does not answer.
pub fn run(
    seed: u64,
    count: u64,
    progress: ProgressCallback<'_>,
) -> Result<CampaignVerdict, EpisodeError> {
    let one = |number| {
        let compared = compare(seed, number);
        progress(1);
        compared
    };
    let all: Result<Vec<_>, _> = (0..count).into_par_iter().map(one).collect();
    Ok(verdict(&all?))
}

/// Setup of an episode: all combinations of behavior and sonar model.
fn setup(seed: u64, number: u64) -> Setup {
    let sonars = [SonarModel::Ideal, SonarModel::Nomad, SonarModel::Harsh];
    let behaviors = [Behavior::Avoid, Behavior::WallLeft, Behavior::NEST];
    let of = |number: u64| number as usize % 3;
    Setup {
        config: Config::recommended(),
        preset: String::new(),
        behavior: behaviors[of(number / 3)].clone(),
        explore_moves: 100,
        steps: STEPS,
        seed: seed.wrapping_add(number),
        sonar: sonars[of(number)],
        turret: TurretMode::Held,
        robot: None,
        set_down: None,
        faults: Vec::new(),
        goal: None,
        second_robot: false,
        record: false,
    }
}

fn compare(seed: u64, number: u64) -> Result<Compared, EpisodeError> {
    let setup = setup(seed, number);
    let world = World::random(setup.seed);
    let before_ms = 1 + below(&mut generator(seed, number), SHORTEST_MS) as u32;
    let mut minds = [0, 0_u32.wrapping_sub(before_ms)]
        .map(|by| Shifted::that_remembers(setup.config.clone(), by));
    let mut reports = Vec::new();
    for mind in &mut minds {
        reports.push(run_with(&world, &setup, mind, |_, _, _| {})?.report);
    }
    let [one, other] = &minds;
    let (here, there) = (one.mind.state(), other.mind.state());
    let same = one.decisions == other.decisions
        && reports.windows(2).all(|pair| pair[0] == pair[1])
        && here.situations() == there.situations()
        && here.actions() == there.actions()
        && here.memory() == there.memory();
    Ok(Compared {
        decisions: one.decisions.as_ref().map_or(0, Vec::len) as u64,
        wrapped: other.wrapped && !one.wrapped,
        same,
    })
}

fn verdict(all: &[Compared]) -> CampaignVerdict {
    let count = |is: fn(&Compared) -> bool| all.iter().filter(|one| is(one)).count() as u64;
    let episodes = all.len() as u64;
    let [same, wrapped] = [count(|one| one.same), count(|one| one.wrapped)];
    let mut verdict = CampaignVerdict::default();
    verdict.say(format_args!(
        "{} episodes, {} decisions; across the clock's overflow: {}; identical, with maps, memory and figures: {}",
        grouped(episodes),
        grouped(all.iter().map(|one| one.decisions).sum()),
        grouped(wrapped),
        grouped(same)
    ));
    verdict.require(same == episodes, "an episode differs by another clock");
    verdict.require(
        wrapped == episodes,
        "an episode ended before the clock's overflow",
    );
    verdict
}
