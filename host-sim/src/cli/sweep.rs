//! `host-sim sweep` and `host-sim merge`: many episodes, optionally in shards.

use super::CliError;
use super::output::{bar, pool};
use super::run::RunArgs;
use super::setup::{SetupArgs, parsed};
use amp::config::Config;
use clap::{Args, Parser};
use experiments::sweep::{self, Description, Shard, SweepPlan, SweepProgress, Vocabulary};
use files::error::BadInput;
use sim::episode::Setup;
use sim::settings;
use std::io::{IsTerminal as _, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Flags of the `sweep` command.
#[derive(Debug, Clone, Args)]
pub struct SweepArgs {
    /// A TOML file with worlds, behaviors, seeds and the options to vary (docs/sweep.md)
    #[arg(value_name = "SWEEP.toml")]
    file: PathBuf,
    /// Results file; an interrupted sweep resumes at its end [default: out/sweep/NAME.csv, for a
    /// shard out/sweep/NAME.I-of-N.csv]
    #[arg(long, value_name = "FILE.csv")]
    out: Option<PathBuf>,
    /// Run only the episodes whose number modulo N is I [default: SLURM_ARRAY_TASK_ID of
    /// SLURM_ARRAY_TASK_COUNT, or JOB_COMPLETION_INDEX of SWEEP_SHARDS; else all]
    #[arg(long, value_name = "I/N", value_parser = parsed::<Shard>)]
    shard: Option<Shard>,
    /// Check everything and print the number of episodes, without running them
    #[arg(long)]
    dry_run: bool,
    /// Worker threads [default: one per core]; they do not affect the results
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

/// Flags of the `merge` command.
#[derive(Debug, Clone, Args)]
pub struct MergeArgs {
    /// Results of all shards of one sweep, in any order
    #[arg(value_name = "FILE.csv", required = true)]
    files: Vec<PathBuf>,
}

/// Parses a point's options with the flags of `run`, so that both mean the same.
#[derive(Debug, Parser)]
#[command(no_binary_name = true)]
struct PointArgs {
    #[command(flatten)]
    run: RunArgs,
}

fn vocabulary() -> Vocabulary {
    // The description has its own lists for these; settings are given by their keys.
    let elsewhere = ["behavior", "seed", "set"];
    let setup = SetupArgs::augment_args(clap::Command::new("point"));
    let flags = setup.get_arguments().filter_map(|flag| flag.get_long());
    let flags = flags
        .filter(|flag| !elsewhere.contains(flag))
        .chain(["steps"]);
    Vocabulary {
        flags: flags.map(str::to_owned).collect(),
        check,
        setup: of_point,
    }
}

fn is_setting(key: &str) -> bool {
    settings::is_key(key)
}

fn check(key: &str, value: &str) -> Result<(), BadInput> {
    if is_setting(key) {
        return settings::set(&mut Config::recommended(), key, value);
    }
    of_point(&[(key.to_owned(), value.to_owned())]).map(|_| ())
}

fn of_point(choices: &[(String, String)]) -> Result<Setup, BadInput> {
    let flag = |(key, value): &(String, String)| {
        if is_setting(key) {
            format!("--set={key}={value}")
        } else {
            format!("--{key}={value}")
        }
    };
    let parsed = PointArgs::try_parse_from(choices.iter().map(flag));
    parsed.map_err(|error| sentence(&error))?.run.setup()
}

/// clap's message about a flag, in one line.
fn sentence(error: &clap::Error) -> BadInput {
    let text = error.to_string();
    let lines = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.is_empty());
    let text = lines.collect::<Vec<_>>().join(" ");
    BadInput::new(text.trim_start_matches("error: "))
}

/// Runs the missing episodes of the sweep.
///
/// # Errors
/// An invalid description, a results file that belongs to another sweep or cannot be written, an
/// episode that fails.
pub fn sweep(args: &SweepArgs, out: &mut impl Write) -> Result<(), CliError> {
    let from = Shard::from_environment(|name| std::env::var(name).ok());
    let (shard, source) = match args.shard {
        Some(shard) => (shard, None),
        None => from?.map_or((Shard::WHOLE, None), |(shard, from)| (shard, Some(from))),
    };
    let vocabulary = vocabulary();
    let plan = SweepPlan::new(Description::load(&args.file, &vocabulary)?, vocabulary)?;
    if args.dry_run {
        return Ok(writeln!(out, "{}", about(&plan, shard))?);
    }
    let path = args
        .out
        .clone()
        .unwrap_or_else(|| default_path(&plan, shard));
    let pool = pool(args.threads)?;
    let began = Instant::now();
    let mut report = Reporter::new(source.map(|source| format!("shard {shard} ({source})")));
    let done = sweep::run(&plan, shard, &path, &pool, |progress| report.tell(progress))?;
    report.end();
    eprintln!(
        "{} episodes in {:.1} s, {} already done",
        done.done - done.before,
        began.elapsed().as_secs_f64(),
        done.before
    );
    Ok(writeln!(out, "{}: {} episodes", path.display(), done.all)?)
}

fn default_path(plan: &SweepPlan, shard: Shard) -> PathBuf {
    let name = &plan.description().name;
    let part = if shard.is_whole() {
        String::new()
    } else {
        format!(".{}", shard.to_string().replace('/', "-of-"))
    };
    PathBuf::from(format!("out/sweep/{name}{part}.csv"))
}

fn about(plan: &SweepPlan, shard: Shard) -> String {
    let description = plan.description();
    format!(
        "{}\n{} points × {} behaviors × {} worlds × {} seeds; shard {shard} has {} episodes",
        plan.header().identity(),
        description.points.count().unwrap_or(0),
        description.behaviors.len(),
        description.worlds.len(),
        description.seeds.len(),
        shard.len(plan.episodes())
    )
}

/// Progress on standard error: a bar in a terminal, a line per minute in a log.
struct Reporter {
    bar: Option<indicatif::ProgressBar>,
    prefix: Option<String>,
    began: Instant,
    last_report: Instant,
}

impl Reporter {
    const EVERY: Duration = Duration::from_secs(60);

    fn new(prefix: Option<String>) -> Self {
        let now = Instant::now();
        Self {
            bar: None,
            prefix,
            began: now,
            last_report: now,
        }
    }

    fn tell(&mut self, progress: SweepProgress) {
        if std::io::stderr().is_terminal() {
            let bar = self.bar.get_or_insert_with(|| {
                let bar = bar(progress.all, "episodes").with_position(progress.done);
                bar.reset_eta();
                bar
            });
            bar.set_position(progress.done);
        } else if self.last_report.elapsed() >= Self::EVERY {
            self.last_report = Instant::now();
            let new = progress.done.saturating_sub(progress.before).max(1);
            let each = self.began.elapsed().as_secs_f64() / new as f64;
            let left = each * progress.all.saturating_sub(progress.done) as f64;
            eprintln!(
                "{} of {} episodes, {left:.0} s left",
                progress.done, progress.all
            );
        }
    }

    fn end(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
        if let Some(prefix) = self.prefix {
            eprint!("{prefix}: ");
        }
    }
}

/// Prints the results of the whole sweep.
///
/// # Errors
/// Files that do not form one whole sweep; standard output that cannot be written.
pub fn merge(args: &MergeArgs, out: &mut impl Write) -> Result<(), CliError> {
    let mut merged = sweep::merge(&args.files)?;
    out.write_all(merged.header().text().as_bytes())?;
    merged.rows(&mut |row| Ok::<_, CliError>(out.write_all(row)?))
}
