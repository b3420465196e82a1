//! `host-sim log` and `host-sim replay`: prints a log's content, and verifies that it replays.

use super::CliError;
use super::output::bar;
use super::table::plain;
use clap::Args;
use remote::log::{self, LogFile, Summary};
use std::io::Write;
use std::path::PathBuf;

/// Flags of the `log` command.
#[derive(Debug, Clone, Args)]
pub struct LogArgs {
    /// The log, written by `--log FILE.mcap` of `run`, `view` or `bridge`
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

/// Flags of the `replay` command.
#[derive(Debug, Clone, Args)]
pub struct ReplayArgs {
    /// The log, written by `--log FILE.mcap` of `run`, `view` or `bridge`
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

/// Prints the content of a log.
///
/// # Errors
/// A file that is no log, an invalid message, a closed pipe.
pub fn log(args: &LogArgs, out: &mut impl Write) -> Result<(), CliError> {
    let log = log::read(&args.file)?;
    let summary = Summary::of(&log)?;
    out.write_all(plain(&["log", ""], &rows(&log, &summary), &[]).as_bytes())?;
    Ok(())
}

fn rows(log: &LogFile, summary: &Summary) -> Vec<Vec<String>> {
    let setup = log.setup();
    let robot = setup.robot.as_ref();
    let mut rows = vec![
        ("world", setup.world.clone()),
        (
            "robot",
            robot.map_or("nomad200".to_owned(), |robot| robot.name.clone()),
        ),
        ("behavior", setup.behavior.clone()),
        ("preset", setup.preset.clone()),
        ("seed", setup.seed.to_string()),
        ("sonars", setup.sonar.clone()),
        ("written by", format!("host-sim {}", setup.program)),
        (
            "ends",
            format!("at {:.3} s, {}", summary.last_s, summary.ending),
        ),
        ("random moves", summary.random_moves.to_string()),
        (
            "decisions",
            format!(
                "{} ({} with the goal held, {} motions shortened by the shield)",
                summary.decisions, summary.at_goal, summary.shortened
            ),
        ),
        (
            "distance by odometry",
            format!("{:.1} m", summary.distance_m),
        ),
        ("reports of a touch", summary.contacts.to_string()),
    ];
    let commands = summary.commands.iter();
    let commands: Vec<_> = commands
        .map(|(s, what)| format!("{what} at {s:.1} s"))
        .collect();
    rows.push(("commands", commands.join(", ")));
    for (topic, count) in &summary.messages {
        rows.push((topic, format!("{count} messages")));
    }
    let cells = rows.into_iter();
    cells
        .map(|(label, value)| vec![label.to_owned(), value])
        .collect()
}

/// Replays a log's events and compares every answer with the recorded one.
///
/// # Errors
/// As [`log`]; an answer that differs.
pub fn replay(args: &ReplayArgs, out: &mut impl Write) -> Result<(), CliError> {
    let log = log::read(&args.file)?;
    let progress = bar(0, "replay");
    let end_ms = log
        .messages()
        .last()
        .map_or(0, |message| message.time_ns / 1_000_000);
    progress.set_length(end_ms);
    let done = log::replay(&log, |ms| progress.set_position(ms))?;
    progress.finish_and_clear();
    let file = args.file.display();
    if let Some(difference) = &done.difference {
        return Err(CliError::Differs(format!("{file}: {difference}")));
    }
    writeln!(
        out,
        "{file}: {} decisions and {} other answers to {} events, every one identical; the log ends at {:.3} s, {}",
        done.decisions,
        done.answers - done.decisions,
        done.events,
        done.last_ms as f64 / 1e3,
        done.ending
    )?;
    Ok(())
}
