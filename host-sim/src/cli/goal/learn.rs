//! `host-sim goal learn`: finds the goal that a demonstration pursued.

use crate::cli::CliError;
use crate::cli::output::bar;
use amp::fixed::Mask;
use amp::goal::{Component, Goal};
use amp::scan::{Encoding, Situation};
use clap::Args;
use files::error::BadInput;
use remote::log::{self, LoggedDemonstration};
use sim::demonstration::{DemonstrationError, goal_of_demonstrations, goal_of_situations};
use sim::goal_file::{self, GoalFile};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Most steps of all demonstrations together.
const MAX_STEPS: usize = 2_000;

/// Flags of the `goal learn` command.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  host-sim run --world office --behavior wall-right --steps 50 --log wall.mcap
  host-sim goal learn --from wall.mcap -o shown.toml
  host-sim run --world room --behavior wall-right --goal shown.toml
  host-sim goal learn --from door1.toml --from door2.toml -o door.toml
      what two captured situations have in common")]
pub struct GoalLearnArgs {
    /// Logged drives (FILE.mcap of `run`, `view` or `bridge`), or captured situations (goal files
    /// of `capture`); may be given several times
    #[arg(long, value_name = "FILE", required = true)]
    from: Vec<PathBuf>,
    /// File to write
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
}

/// Learns the goal and writes the file, completely or not at all.
///
/// # Errors
/// A bad file, logs and situations together, too few moves, a file that cannot be written, a
/// closed pipe.
pub fn learn(args: &GoalLearnArgs, out: &mut impl Write) -> Result<(), CliError> {
    let is_log = |path: &PathBuf| path.extension().is_some_and(|end| end == "mcap");
    let (goal, from, scale) = match args.from.iter().filter(|path| is_log(path)).count() {
        0 => of_situations(&args.from)?,
        logs if logs == args.from.len() => of_logs(&args.from)?,
        _ => {
            let what = "--from: give either logs (.mcap) or captured situations";
            return Err(BadInput::new(what).into());
        }
    };
    let name = format!("learned from {from}");
    let text = goal_file::whole_text(&goal, &name, &scale);
    goal_file::write(&args.out, &text)?;
    let file = args.out.display();
    Ok(writeln!(
        out,
        "{file}: the goal of {from}\nPursue it: host-sim run --behavior seek:{file}"
    )?)
}

/// The goal, what it was learned from, and the scale of its values.
type Learned = (Goal<16>, String, String);

fn of_logs(paths: &[PathBuf]) -> Result<Learned, BadInput> {
    let mut demonstrations = Vec::new();
    for path in paths {
        let log = log::read(path)?;
        if let Some(robot) = &log.setup().robot {
            return Err(BadInput::file(
                path,
                format!(
                    "its robot is {}; a goal is learned from the ring of nomad200",
                    robot.name
                ),
            ));
        }
        demonstrations.push((path, LoggedDemonstration::of(&log)?));
    }
    let scale = goal_file::scale(same_encoding(&demonstrations)?);
    let steps: usize = demonstrations
        .iter()
        .map(|(_, one)| one.shown().len())
        .sum();
    if steps > MAX_STEPS {
        let what = format!("--from: {steps} steps are more than {MAX_STEPS}: log shorter drives");
        return Err(BadInput::new(what));
    }
    let all: Vec<_> = demonstrations
        .iter()
        .map(|(_, one)| one.demonstration())
        .collect();
    let progress = bar(0, "learns");
    let goal = goal_of_demonstrations(&all, |done, all| {
        progress.set_length(all.into());
        progress.set_position(done.into());
    });
    progress.finish_and_clear();
    let goal = goal.map_err(|why| refusal(paths, why))?;
    Ok((goal, format!("{steps} demonstrated steps"), scale))
}

/// The encoding of the situations, which all demonstrations must share.
fn same_encoding(demonstrations: &[(&PathBuf, LoggedDemonstration)]) -> Result<Encoding, BadInput> {
    let mut encodings = demonstrations
        .iter()
        .map(|(path, one)| (path, one.controller().config().encoding));
    let Some((_, first)) = encodings.next() else {
        return Err(BadInput::new("--from: no log"));
    };
    for (path, encoding) in encodings {
        if encoding != first {
            let [other, own] = [first, encoding].map(goal_file::scale);
            let what = format!("its situations are {own}, those of the first log {other}");
            return Err(BadInput::file(path, what));
        }
    }
    Ok(first)
}

fn of_situations(paths: &[PathBuf]) -> Result<Learned, BadInput> {
    let situations: Vec<_> = paths
        .iter()
        .map(|path| situation(path))
        .collect::<Result<_, _>>()?;
    let goal = goal_of_situations(&situations).map_err(|why| refusal(paths, why))?;
    let from = match paths.len() {
        1 => "a situation".to_owned(),
        count => format!("{count} situations"),
    };
    // The files say on which scale, in words only.
    Ok((goal, from, "on their scale".to_owned()))
}

/// The situation that a goal file asks for.
fn situation(path: &Path) -> Result<(Situation<16>, Mask), BadInput> {
    let goal = GoalFile::load(path)?.goal;
    let mut known = Mask::ALL;
    for (sensor, component) in goal.components.iter().enumerate() {
        if component.low != component.high {
            if *component != Component::ANY {
                let what = format!("it asks sonar {sensor} for an interval, not for a value");
                return Err(BadInput::file(path, what));
            }
            known = known.without(sensor);
        }
    }
    Ok((goal.components.map(|component| component.low), known))
}

fn refusal(paths: &[PathBuf], why: DemonstrationError) -> BadInput {
    match paths {
        [path] => BadInput::file(path, why.to_string()),
        _ => BadInput::new(format!("--from: {why}")),
    }
}
