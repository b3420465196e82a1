//! Runs the campaigns of [`tests::campaign`] and prints their figures.
//!
//! Progress and times go to standard error. Exit code 0: all requirements met; 1: one was not; 2:
//! bad arguments.

use amp::config::Config;
use arena::sonar::SonarModel;
use clap::{Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use sim::settings;
use std::process::ExitCode;
use std::time::Instant;
use tests::campaign::{CampaignVerdict, chip, clock, drift, frames, link, shield, silence};

/// Divisor of the counts with `--quick`.
const QUICK: u64 = 1_000;

#[derive(Debug, Parser)]
#[command(
    name = "campaign",
    about = "Long random runs that try to break the controller, its link and its clock"
)]
struct CampaignCli {
    #[command(subcommand)]
    verb: CampaignVerb,
    /// Seed of all randomness
    #[arg(long, global = true, default_value_t = 1)]
    seed: u64,
    /// Number of cases [default: see the subcommand]
    #[arg(long, global = true)]
    count: Option<u64>,
    /// A thousandth of the default
    #[arg(long, global = true, conflicts_with = "count")]
    quick: bool,
}

#[derive(Debug, Subcommand)]
enum CampaignVerb {
    /// Damaged frames through the decoder [count: 1000000000]
    Frames,
    /// Frames over a line that loses 30 %, duplicates 10 % and reorders [count: 1000000]
    Link,
    /// Host, line or chip fail while the robot moves [count: 100000 of each]
    Silence,
    /// Episodes across the overflow of the 32-bit milliseconds [count: 1000]
    Clock,
    /// Robots that drive for a day [count: 100]
    Drift {
        /// Hours of a day
        #[arg(long, default_value_t = drift::HOURS, value_parser = clap::value_parser!(u32).range(1..=168))]
        hours: u32,
        /// Exact sonars instead of the Nomad's
        #[arg(long)]
        ideal: bool,
    },
    /// Every behavior, sonar model and turret mode with the shield on [count: 10016]
    Shield {
        /// Built-in worlds and rooms with thin walls instead of random rooms
        #[arg(long)]
        others: bool,
        /// Change one option (see `host-sim settings`); may be given several times
        #[arg(long = "set", value_name = "KEY=VALUE")]
        sets: Vec<String>,
    },
    /// Damaged frames to the firmware in an emulated chip [count: 1000000]
    ChipFrames,
    /// Frames over a bad line to the firmware in an emulated chip [count: 1000]
    ChipLink,
    /// The host of an emulated chip goes silent while the robot moves [count: 100]
    ChipSilence,
}

impl CampaignVerb {
    const fn count(&self) -> u64 {
        match self {
            Self::Frames => frames::COUNT,
            Self::Link => link::COUNT,
            Self::Silence => silence::COUNT,
            Self::Clock => clock::COUNT,
            Self::Drift { .. } => drift::COUNT,
            Self::Shield { .. } => shield::COUNT,
            Self::ChipFrames => frames::COUNT / QUICK,
            Self::ChipLink => link::COUNT / QUICK,
            Self::ChipSilence => silence::COUNT / QUICK,
        }
    }

    /// Number of progress steps for `count`.
    const fn steps(&self, count: u64) -> u64 {
        match self {
            Self::Silence => 4 * count,
            Self::Drift { hours, .. } => *hours as u64 * count,
            _ => count,
        }
    }
}

fn main() -> ExitCode {
    let cli = CampaignCli::parse();
    let whole = cli.verb.count();
    let quick = cli.quick.then_some((whole / QUICK).max(1));
    let count = cli.count.or(quick).unwrap_or(whole);
    let began = Instant::now();
    let bar = ProgressBar::new(cli.verb.steps(count));
    let template = "{wide_bar} {pos}/{len} {elapsed}, {eta} left";
    bar.set_style(
        ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let verdict = run(&cli, count, &|done| bar.inc(done));
    bar.finish_and_clear();
    eprintln!("{:.1} s", began.elapsed().as_secs_f64());
    match verdict {
        Ok(verdict) => tell(&verdict),
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::FAILURE
        }
    }
}

fn run(
    cli: &CampaignCli,
    count: u64,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<CampaignVerdict, String> {
    let seed = cli.seed;
    match &cli.verb {
        CampaignVerb::Frames => Ok(frames::run(seed, count, progress)),
        CampaignVerb::Link => Ok(link::run(seed, count, progress)),
        CampaignVerb::Silence => Ok(silence::run(seed, count, progress)),
        CampaignVerb::Clock => clock::run(seed, count, progress).map_err(|why| why.to_string()),
        CampaignVerb::Drift { hours, ideal } => {
            let sonar = if *ideal {
                SonarModel::Ideal
            } else {
                SonarModel::Nomad
            };
            drift::run(seed, count, *hours, sonar, progress).map_err(|why| why.to_string())
        }
        CampaignVerb::Shield { others, sets } => {
            let worlds = if *others {
                shield::Worlds::Others
            } else {
                shield::Worlds::Random
            };
            let mut config = Config::recommended();
            settings::apply(&mut config, sets).map_err(|why| why.to_string())?;
            shield::run(seed, count, worlds, &config, progress)
        }
        CampaignVerb::ChipFrames => Ok(chip::frames(seed, count, progress)),
        CampaignVerb::ChipLink => Ok(chip::link(seed, count, progress)),
        CampaignVerb::ChipSilence => Ok(chip::silence(seed, count, progress)),
    }
}

fn tell(verdict: &CampaignVerdict) -> ExitCode {
    print!("{}", verdict.text);
    for broken in &verdict.broken {
        eprintln!("error: {broken}");
    }
    if verdict.broken.is_empty() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
