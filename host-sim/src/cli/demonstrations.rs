//! `host-sim demonstrations`: goals learned from demonstrations, beside goals and rules written by
//! hand.

use super::output::{bar, pool};
use super::run::SonarChoice;
use super::{CliError, table};
use amp::config::Config;
use clap::Args;
use experiments::demonstrations::{
    DemonstrationTrial, Pursuit, TASKS, Task, TaskOutcome, TaskWorlds, demonstrated_goals, measure,
};
use files::error::BadInput;
use std::io::Write;

/// Flags of the `demonstrations` command.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  host-sim demonstrations --only dock        # a few seconds
  host-sim demonstrations --drives 1         # with less to learn from")]
pub struct DemonstrationsArgs {
    /// Worlds of each kind; each has a demonstration of its own
    #[arg(long, value_name = "WORLDS", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=1_000))]
    worlds: u32,
    /// Robots in each world, each with its own 100 random moves
    #[arg(long, value_name = "SEEDS", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=999))]
    seeds: u32,
    /// Number of the first world; the demonstrations are in worlds from 1000 numbers later on
    #[arg(long, value_name = "NUMBER", default_value_t = 10_000, value_parser = clap::value_parser!(u64).range(..=u64::from(u32::MAX)))]
    first: u64,
    /// Drives of a demonstration
    #[arg(long, value_name = "DRIVES", default_value_t = 6, value_parser = clap::value_parser!(u32).range(1..=20))]
    drives: u32,
    /// Situations of a drive
    #[arg(long, value_name = "SITUATIONS", default_value_t = 50, value_parser = clap::value_parser!(u32).range(20..=100))]
    length: u32,
    /// Sonar model, of the demonstrations as well
    #[arg(long, value_name = "MODEL", default_value = "ideal", value_enum)]
    sonar: SonarChoice,
    /// Only tasks whose name contains this text
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Worker threads [default: one per core]; they do not affect the results
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Print Markdown
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
    /// Print one JSON object per task and kind of worlds
    #[arg(long)]
    json: bool,
}

const HEADS: [&str; 8] = [
    "task",
    "where",
    "measure",
    "by hand",
    "demonstrated",
    "contact steps %",
    "spread alone",
    "not told",
];

/// Measures and prints the table.
///
/// # Errors
/// When no task matches `--only`, an episode fails, or the output is closed.
pub fn demonstrations(args: &DemonstrationsArgs, out: &mut impl Write) -> Result<(), CliError> {
    let tasks = chosen(args.only.as_deref())?;
    let trial = DemonstrationTrial {
        first: args.first,
        worlds: args.worlds,
        seeds: args.seeds,
        drives: args.drives,
        length: args.length,
        sonar: args.sonar.into(),
        config: Config {
            shield: None,
            ..Config::recommended()
        },
    };
    let episodes = u64::from(args.worlds) * u64::from(args.seeds);
    let each = 8 * episodes + u64::from(args.worlds);
    let progress = bar(each * tasks.len() as u64, "episodes");
    let rows = pool(args.threads)?.install(|| {
        let rows = tasks
            .iter()
            .map(|task| rows_of(task, &trial, &|| progress.inc(1)));
        rows.collect::<Result<Vec<_>, _>>()
    })?;
    progress.finish_and_clear();
    let rows = rows.iter().flatten();
    if args.json {
        for row in rows {
            writeln!(out, "{}", row.object())?;
        }
        return Ok(());
    }
    let format = if args.markdown {
        table::markdown
    } else {
        table::plain
    };
    let cells: Vec<_> = rows.map(Row::cells).collect();
    out.write_all(format(&HEADS, &cells, &[3, 4, 5, 6, 7]).as_bytes())?;
    Ok(writeln!(
        out,
        "\nMean [95 % interval] of {} worlds × {} robots, without the shield; {} drives of {} situations demonstrate each world's goal.",
        args.worlds, args.seeds, args.drives, args.length
    )?)
}

/// One line: a task in one kind of worlds.
struct Row {
    task: &'static Task,
    worlds: TaskWorlds,
    by_hand: TaskOutcome,
    demonstrated: TaskOutcome,
    spread_alone: TaskOutcome,
    not_told: TaskOutcome,
}

/// Measures a task in both kinds of worlds.
fn rows_of(
    task: &'static Task,
    trial: &DemonstrationTrial,
    done: &(impl Fn() + Sync),
) -> Result<[Row; 2], BadInput> {
    let refuse = |failure| BadInput::new(format!("{}: {failure}", task.name));
    let goals = demonstrated_goals(task, trial, done).map_err(refuse)?;
    let row = |worlds| {
        let measured = |pursuit| measure(task, worlds, pursuit, trial, done).map_err(refuse);
        Ok(Row {
            task,
            worlds,
            by_hand: measured(Pursuit::HandWritten)?,
            demonstrated: measured(Pursuit::Demonstrated(&goals))?,
            spread_alone: measured(Pursuit::SpreadAlone(&goals))?,
            not_told: measured(Pursuit::Avoiding)?,
        })
    };
    Ok([row(TaskWorlds::Usual)?, row(TaskWorlds::Other)?])
}

fn chosen(only: Option<&str>) -> Result<Vec<&'static Task>, BadInput> {
    let named = |task: &&Task| only.is_none_or(|text| task.name.contains(text));
    let tasks: Vec<_> = TASKS.iter().filter(named).collect();
    match (tasks.is_empty(), only) {
        (true, Some(text)) => Err(BadInput::new(format!(
            "--only \"{text}\": no task has this in its name"
        ))),
        _ => Ok(tasks),
    }
}

impl Row {
    fn cells(&self) -> Vec<String> {
        let value = |outcome: &TaskOutcome| {
            let [low, high] = outcome.value.interval;
            format!("{:.3} [{low:.3}, {high:.3}]", outcome.value.mean)
        };
        let contacts = |outcome: &TaskOutcome| format!("{:.2}", outcome.contacts_percent);
        let better = if self.task.less_is_better {
            "↓"
        } else {
            "↑"
        };
        vec![
            self.task.name.to_owned(),
            self.task.place(self.worlds).to_owned(),
            format!("{} {better}", self.task.unit),
            value(&self.by_hand),
            value(&self.demonstrated),
            contacts(&self.demonstrated),
            value(&self.spread_alone),
            value(&self.not_told),
        ]
    }

    fn object(&self) -> serde_json::Value {
        let part = |outcome: &TaskOutcome| {
            serde_json::json!({
                "mean": outcome.value.mean,
                "interval": outcome.value.interval,
                "contacts_percent": outcome.contacts_percent,
            })
        };
        serde_json::json!({
            "task": self.task.name,
            "place": self.task.place(self.worlds),
            "measure": self.task.unit,
            "less_is_better": self.task.less_is_better,
            "by_hand": part(&self.by_hand),
            "demonstrated": part(&self.demonstrated),
            "spread_alone": part(&self.spread_alone),
            "not_told": part(&self.not_told),
        })
    }
}
