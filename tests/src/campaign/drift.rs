//! A robot drives for a day: do its behavior or its maps drift?
//!
//! Routes drift even with frozen maps. So the end-of-day maps drive from the start for one hour,
//! which must match hour 1. Each hour: distance, area, decisions, contacts, bounds of the state.

use super::clock::Shifted;
use super::{CampaignVerdict, ProgressCallback, grouped};
use amp::config::Config;
use amp::controller::{Command, Event, Mode};
use amp::fixed::Weight;
use amp::goal::Goal;
use amp::units::Millis;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::World;
use rayon::prelude::*;
use sim::behavior::Behavior;
use sim::episode::{Body, Metrics, Seeds, Setup, explore_and_learn};
use sim::error::EpisodeError;
use sim::pilot::{Pilot as _, SimState};
use sim::statistics::{Mean, bootstrap};

/// Seeds of a full campaign.
pub const COUNT: u64 = 100;
/// Hours of a day.
pub const HOURS: u32 = 24;
/// The hours in the table, from 1; the clock overflows between hours 12 and 13 of 24.
const SHOWN: [usize; 8] = [1, 2, 3, 6, 12, 13, 18, 24];
/// Largest relative difference of the distance between the hour after the day and the first hour.
const MAX_DRIFT: f64 = 0.05;
/// Least distance of every robot in every hour, m: a tenth of the mean. A shorter one means a
/// standstill.
const MIN_DISTANCE_M: f64 = 36.0;

/// The hours of a robot, and one more from its start.
struct Day {
    seed: u64,
    hours: Vec<Hour>,
    again: Hour,
}

/// Figures of an hour.
#[derive(Debug, Clone, Copy, Default)]
struct Hour {
    decisions: u64,
    contacts: u64,
    distance_m: f64,
    area_m2: f64,
    in_bounds: bool,
}

/// Lets `count` robots drive for `hours` hours.
///
/// # Errors
/// When a controller refuses to learn or makes no decision.
pub fn run(
    seed: u64,
    count: u64,
    hours: u32,
    sonar: SonarModel,
    progress: ProgressCallback<'_>,
) -> Result<CampaignVerdict, EpisodeError> {
    let one = |number| day(seed.wrapping_add(number), hours, sonar, progress);
    let days: Result<Vec<_>, _> = (0..count).into_par_iter().map(one).collect();
    Ok(verdict(&days?, sonar))
}

fn day(
    seed: u64,
    hours: u32,
    sonar: SonarModel,
    progress: ProgressCallback<'_>,
) -> Result<Day, EpisodeError> {
    let world = World::random(seed);
    let setup = setup(seed, sonar);
    let half_ms = hours * 1_800_000;
    let mut mind = Shifted::new(setup.config.clone(), 0_u32.wrapping_sub(half_ms));
    let begin = mind.latest;
    explore_and_learn(&world, &setup, &mut mind)?;
    let samples = mind.mind.state().memory().clone();
    let mut body = set_down(&world, &setup, &mut mind, begin)?;
    let began_s = body.time_s();
    let driven: Result<Vec<_>, EpisodeError> = (1..=hours)
        .map(|hour| {
            let until_s = began_s + 3_600.0 * f64::from(hour);
            let mut driven = drive(&world, &mut mind, &mut body, until_s)?;
            let state = mind.mind.state();
            driven.in_bounds = is_in_bounds(state) && *state.memory() == samples;
            progress(1);
            Ok(driven)
        })
        .collect();
    let mut body = set_down(&world, &setup, &mut mind, begin)?;
    let until_s = body.time_s() + 3_600.0;
    Ok(Day {
        seed,
        hours: driven?,
        again: drive(&world, &mut mind, &mut body, until_s)?,
    })
}

fn setup(seed: u64, sonar: SonarModel) -> Setup {
    Setup {
        config: Config::recommended(),
        preset: String::new(),
        behavior: Behavior::Avoid,
        explore_moves: 100,
        steps: 1,
        seed,
        sonar,
        turret: TurretMode::Held,
        robot: None,
        set_down: None,
        faults: Vec::new(),
        goal: None,
        second_robot: false,
        record: false,
    }
}

/// The robot at its start, by the controller's time, with avoidance as its goal.
fn set_down<'w>(
    world: &'w World,
    setup: &Setup,
    mind: &mut Shifted,
    begin: Millis,
) -> Result<Body<'w>, EpisodeError> {
    let mut body = Body::new(
        world,
        setup.sonar,
        setup.turret,
        Seeds::of(setup.seed).noise,
    );
    body.wait(f64::from(mind.latest.since(begin)) / 1e3);
    for command in [Command::Stop, Command::Seek(Goal::avoiding(&setup.config))] {
        let refusal = mind.handle(body.now(), Event::Command(command)).refusal;
        refusal.map(EpisodeError::Refused).map_or(Ok(()), Err)?;
    }
    Ok(body)
}

fn drive(
    world: &World,
    mind: &mut Shifted,
    body: &mut Body<'_>,
    until_s: f64,
) -> Result<Hour, EpisodeError> {
    let mut hour = Hour::default();
    let mut metrics = Metrics::new(world, body.radius_m());
    let mut touched = false;
    while body.time_s() < until_s {
        let result = body.advance(mind);
        // The monitor of the ring, as on the chip.
        let _ = mind.handle(body.now(), Event::Tick);
        if result.decision.is_some() {
            hour.decisions += 1;
            hour.contacts += u64::from(std::mem::take(&mut touched));
        }
        if let Some(moved) = &result.moved {
            metrics.moved(moved.from, moved.to, moved.traveled_m, moved.clearance_m);
            touched |= moved.touched;
        }
    }
    hour.contacts += u64::from(touched);
    hour.distance_m = metrics.distance_m;
    hour.area_m2 = metrics.coverage_m2();
    let seeks = matches!(mind.mind.state().mode(), Mode::Seek { .. });
    if seeks && hour.decisions > 0 {
        Ok(hour)
    } else {
        Err(EpisodeError::Silent)
    }
}

fn is_in_bounds(state: &SimState) -> bool {
    let all = |values: [Weight; 16], low: Weight| {
        values
            .iter()
            .all(|value| (low..=Weight::ONE).contains(value))
    };
    (0..16).all(|neuron| {
        all(state.situations().code_vector(neuron), Weight::ZERO)
            && all(
                state.actions().changes().code_vector(neuron),
                Weight::NEG_ONE,
            )
    })
}

fn verdict(days: &[Day], sonar: SonarModel) -> CampaignVerdict {
    let mut verdict = CampaignVerdict::default();
    let hours = days.first().map_or(0, |day| day.hours.len());
    verdict.say(format_args!(
        "{} robots, {hours} simulated hours each, sonars {}\n",
        days.len(),
        sonar.name()
    ));
    hours_table(&mut verdict, days, hours);
    let every = || {
        days.iter()
            .flat_map(|day| day.hours.iter().chain([&day.again]))
    };
    let total = |value: fn(&Hour) -> u64| every().map(value).sum::<u64>();
    verdict.say(format_args!(
        "\nall hours: {} decisions, {} steps with a contact",
        grouped(total(|hour| hour.decisions)),
        grouped(total(|hour| hour.contacts))
    ));
    let way = change(days, |hour| hour.distance_m);
    let area = change(days, |hour| hour.area_m2);
    verdict.say(format_args!(
        "the hour after the day relative to the first, minus 1: distance {way}, area {area} (95 % intervals)"
    ));
    let [low, high] = way.interval;
    let stays = low > -MAX_DRIFT && high < MAX_DRIFT;
    verdict.require(
        stays,
        "the distance of the hour after the day differs from that of the first",
    );
    require_motion(&mut verdict, days);
    let in_bounds = days
        .iter()
        .flat_map(|day| &day.hours)
        .all(|hour| hour.in_bounds);
    verdict.require(in_bounds, "the state left its bounds");
    verdict
}

fn hours_table(verdict: &mut CampaignVerdict, days: &[Day], hours: usize) {
    let rows: Vec<_> = SHOWN
        .iter()
        .copied()
        .filter(|hour| *hour <= hours)
        .map(|hour| row(days, &hour.to_string(), |day| day.hours.get(hour - 1)))
        .chain([row(days, "after the day, from the start", |day| {
            Some(&day.again)
        })])
        .collect();
    let heads = [
        "hour",
        "decisions",
        "distance m, mean",
        "distance m, least",
        "area m², mean",
        "steps with a contact",
    ];
    verdict.table(heads, &rows);
}

/// Every robot moves in every hour.
fn require_motion(verdict: &mut CampaignVerdict, days: &[Day]) {
    for day in days {
        let mut hours = day.hours.iter().chain([&day.again]);
        if let Some(hour) = hours.position(|hour| hour.distance_m < MIN_DISTANCE_M) {
            let what = format!(
                "the robot of seed {} stands still in hour {}",
                day.seed,
                hour + 1
            );
            verdict.broken.push(what);
        }
    }
}

fn row(days: &[Day], name: &str, of: impl Fn(&Day) -> Option<&Hour>) -> [String; 6] {
    let of = |day| of(day).copied().unwrap_or_default();
    let mean = |value: fn(Hour) -> f64| {
        days.iter().map(|day| value(of(day))).sum::<f64>() / days.len() as f64
    };
    let ways = days.iter().map(|day| of(day).distance_m);
    let least_m = ways.reduce(f64::min).unwrap_or_default();
    [
        name.to_owned(),
        grouped(days.iter().map(|day| of(day).decisions).sum()),
        format!("{:.1}", mean(|hour| hour.distance_m)),
        format!("{:.1}", least_m),
        format!("{:.1}", mean(|hour| hour.area_m2)),
        grouped(days.iter().map(|day| of(day).contacts).sum()),
    ]
}

/// Relative change from the first hour to the hour after the day, over robots.
fn change(days: &[Day], of: fn(&Hour) -> f64) -> Mean {
    let changes = days.iter().filter_map(|day| {
        let first = day.hours.first()?;
        Some(vec![of(&day.again) / of(first) - 1.0])
    });
    bootstrap(&changes.collect::<Vec<_>>())
}
