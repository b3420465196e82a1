//! `host-sim faults`: measures the effect and detection of faulty transducers.

use super::output::bar;
use super::run::{Preset, SonarChoice, Switch};
use super::{CliError, table};
use arena::sonar::{FaultKind, TransducerFault};
use clap::Args;
use experiments::faults::{FAULTS, FaultEpisode, FaultTrial, fault_episodes};
use files::error::BadInput;
use sim::pilot::MAX_MOVES;
use std::io::Write;

/// Flags of the `faults` command.
#[derive(Debug, Clone, Args)]
pub struct FaultsArgs {
    /// Random rooms; in each room the fault affects each of the 16 sonars in turn
    #[arg(long, value_name = "ROOMS", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    rooms: u32,
    /// Seed of the first room; the detector's limits were tuned in rooms below 1001
    #[arg(long, value_name = "SEED", default_value_t = 1_001)]
    first: u64,
    /// Random moves before the behavior
    #[arg(long, value_name = "MOVES", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..=i64::from(MAX_MOVES)))]
    explore: u16,
    /// Steps of obstacle avoidance
    #[arg(long, value_name = "STEPS", default_value_t = 300, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    steps: u32,
    /// Model of the intact sonars
    #[arg(long, value_name = "MODEL", default_value = "nomad", value_enum)]
    sonar: SonarChoice,
    /// Switch fault detection on or off
    #[arg(long, value_name = "ON|OFF", default_value = "on", value_enum)]
    detection: Switch,
    /// Kinds of fault as for `run --fault` without the sonar (swapped:N = with the sonar N places
    /// on), or none; may be given several times [default: none, dead, stuck:2, scaled:0.5,
    /// jumping:1]
    #[arg(long = "kind", value_name = "KIND")]
    kinds: Vec<String>,
    /// Preset of the controller's options
    #[arg(long, value_name = "NAME", default_value = "default", value_enum)]
    preset: Preset,
    /// Change one option (see `host-sim settings`); may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Print Markdown
    #[arg(long)]
    markdown: bool,
}

/// Default kinds of fault.
const KINDS: [&str; 5] = ["none", "dead", "stuck:2", "scaled:0.5", "jumping:1"];

const HEADS: [&str; 12] = [
    "fault",
    "episodes",
    "detected",
    "median, moves",
    "95 %, moves",
    "identified",
    "enabled again",
    "false alarms",
    "never heard",
    "contacts, enabled",
    "contacts, disabled",
    "coverage, m²",
];

/// Measures and prints the table.
///
/// # Errors
/// An unknown kind or setting; an episode that fails.
pub fn faults(args: &FaultsArgs, out: &mut impl Write) -> Result<(), CliError> {
    let trial = trial(args)?;
    let kind_names: Vec<_> = match args.kinds[..] {
        [] => KINDS.map(str::to_owned).to_vec(),
        _ => args.kinds.clone(),
    };
    let kinds = kind_names.iter().map(|text| kind(text));
    let kinds: Vec<_> = kinds.collect::<Result<_, _>>()?;
    let episodes: u64 = kinds
        .iter()
        .map(|kind| if kind.is_some() { 16 } else { 1 })
        .sum();
    let progress = bar(episodes * u64::from(trial.rooms), "episodes");
    let mut rows = Vec::new();
    for (name, kind) in kind_names.iter().zip(kinds) {
        let fault_episodes = fault_episodes(kind, &trial, &|| progress.inc(1))
            .map_err(|failure| BadInput::new(format!("{name}: {failure}")))?;
        rows.push(row(name, kind.is_some(), &fault_episodes));
    }
    progress.finish_and_clear();
    let text = if args.markdown {
        table::markdown
    } else {
        table::plain
    }(&HEADS, &rows, &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]);
    out.write_all(text.as_bytes())?;
    Ok(writeln!(
        out,
        "\n{} random rooms from {} on, {} random moves and {} steps of avoidance in each, sonars {}, preset {}.",
        trial.rooms,
        trial.first,
        trial.explore_moves,
        trial.steps,
        trial.sonar.name(),
        trial.preset,
    )?)
}

fn trial(args: &FaultsArgs) -> Result<FaultTrial, BadInput> {
    let mut config = args.preset.config();
    config.fault_detection = args.detection == Switch::On;
    sim::settings::apply(&mut config, &args.sets)?;
    Ok(FaultTrial {
        rooms: args.rooms,
        first: args.first,
        explore_moves: args.explore,
        steps: args.steps,
        sonar: args.sonar.into(),
        turret: args.preset.turret(),
        config,
        preset: args.preset.name(),
    })
}

/// A fault without its transducer, as `none`, `dead` or `KIND:VALUE`.
fn kind(text: &str) -> Result<Option<FaultKind>, BadInput> {
    if text == "none" {
        return Ok(None);
    }
    let of_any_sensor = match text.split_once(':') {
        Some((name, value)) => format!("{name}:0:{value}"),
        None => format!("{text}:0"),
    };
    let fault: TransducerFault = of_any_sensor.parse()?;
    Ok(Some(fault.kind))
}

fn row(name: &str, faulty: bool, fault_episodes: &[FaultEpisode]) -> Vec<String> {
    let count = fault_episodes.len();
    let sum =
        |value: fn(&FaultEpisode) -> u32| fault_episodes.iter().map(value).sum::<u32>().to_string();
    let mut delays: Vec<_> = fault_episodes
        .iter()
        .filter_map(|course| course.noticed)
        .collect();
    delays.sort_unstable();
    let coverage = fault_episodes
        .iter()
        .map(|course| course.coverage_m2)
        .sum::<f64>();
    let of_faulty = |text: String| if faulty { text } else { "–".to_owned() };
    vec![
        name.to_owned(),
        count.to_string(),
        of_faulty(format!("{}", delays.len())),
        of_faulty(quantile(&delays, count, 50)),
        of_faulty(quantile(&delays, count, 95)),
        of_faulty(sum(|course| course.named.is_some().into())),
        of_faulty(sum(|course| course.returns)),
        alarms(fault_episodes),
        sum(|course| course.unheard),
        sum(|course| course.contacts_before),
        of_faulty(sum(|course| course.contacts_after)),
        format!("{:.2}", coverage / count.max(1) as f64),
    ]
}

/// Number of intact transducers that were disabled, by reported fault.
fn alarms(fault_episodes: &[FaultEpisode]) -> String {
    let mut counts = [0; FAULTS.len()];
    for course in fault_episodes {
        for (count, more) in counts.iter_mut().zip(course.false_alarms) {
            *count += more;
        }
    }
    let kinds: Vec<_> = FAULTS
        .iter()
        .zip(counts)
        .filter(|(_, count)| *count > 0)
        .map(|(fault, count)| format!("{count} {fault:?}").to_lowercase())
        .collect();
    match kinds[..] {
        [] => "0".to_owned(),
        _ => kinds.join(", "),
    }
}

/// The delay within which `percent` percent of the episodes detected the fault; *never* if fewer
/// did.
fn quantile(delays: &[u32], episodes: usize, percent: usize) -> String {
    let rank = (episodes * percent).div_ceil(100).max(1);
    delays
        .get(rank - 1)
        .map_or_else(|| "never".to_owned(), u32::to_string)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_counts_those_that_never_noticed() {
        assert_eq!(quantile(&[3, 5, 9], 4, 50), "5");
        assert_eq!(quantile(&[3, 5, 9], 4, 75), "9");
        assert_eq!(quantile(&[3, 5, 9], 4, 95), "never");
        assert_eq!(quantile(&[], 0, 50), "never");
    }

    #[test]
    fn a_kind_is_a_fault_without_its_transducer() {
        assert_eq!(kind("none").ok(), Some(None));
        assert_eq!(kind("stuck:2").ok(), Some(Some(FaultKind::Stuck(2.0))));
        assert!(kind("dead:3").is_err() && kind("stuck").is_err());
    }
}
