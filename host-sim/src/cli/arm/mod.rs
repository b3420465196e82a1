//! `host-sim arm`: arms instead of a mobile base, with the same couple of maps.

mod joints;
mod pointing;
mod reach;

use super::CliError;
use super::output::{bar, pool, prepare};
use clap::{Args, ValueEnum};
use std::io::Write;
use std::path::PathBuf;

/// Flags of the `arm` command.
#[derive(Debug, Clone, Args)]
pub struct ArmArgs {
    /// What is measured
    #[arg(long, value_name = "NAME", default_value = "reach", value_enum)]
    experiment: Experiment,
    /// Number of seeds
    #[arg(long, value_name = "SEEDS", default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    seeds: u32,
    /// First seed: from 1 000 on for reporting, below for tuning
    #[arg(long, value_name = "SEED", default_value_t = 1_000, value_parser = clap::value_parser!(u64).range(0..=1_000_000_000))]
    first: u64,
    /// Targets of each seed, one after the other [default: reach 50, joints 6, pointing 100]
    #[arg(long, value_name = "TARGETS", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    targets: Option<u32>,
    /// Random moves before the first target, at most 1 000; not for joints
    #[arg(long, value_name = "MOVES", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=1_000))]
    explore: u32,
    /// Print Markdown
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
    /// Print one JSON object per row instead of the tables
    #[arg(long)]
    json: bool,
    /// Write pictures into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Worker threads [default: one per core]; they do not affect the results
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

/// Experiments as named on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Experiment {
    /// An arm of three joints reaches for targets, and goes around a region
    Reach,
    /// Arms of 2 to 20 joints in the plane reach for targets, after 30 to 1 000 random moves
    Joints,
    /// An eye looks at targets, and an arm points at what is looked at
    Pointing,
}

impl ArmArgs {
    /// Targets of each seed.
    fn targets(&self) -> u32 {
        let default = match self.experiment {
            Experiment::Reach => 50,
            Experiment::Joints => 6,
            Experiment::Pointing => 100,
        };
        self.targets.unwrap_or(default)
    }
}

/// Measures and prints the tables.
///
/// # Errors
/// An output that cannot be written.
pub fn arm(args: &ArmArgs, out: &mut impl Write) -> Result<(), CliError> {
    if let Some(dir) = &args.out {
        prepare(dir)?;
    }
    let pool = pool(args.threads)?;
    match args.experiment {
        Experiment::Reach => reach::reach(args, &pool, out),
        Experiment::Joints => joints::joints(args, &pool, out),
        Experiment::Pointing => pointing::pointing(args, &pool, out),
    }
}
