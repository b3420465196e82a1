//! `host-sim link`: talk to a mind on a chip.

mod follow;
mod tables;

use super::Failure;
use super::remote::{named, open};
use amp::config::Config;
use amp::fixed::Weight;
use amp::goal::{Goal, KeepError, Name};
use amp::wire::ToMind;
use amp::wire::message::{Clock, Flash, FromMind, GoalBy, ModeReport, Order};
use clap::{Args, Subcommand, ValueEnum};
use files::error::BadInput;
use follow::{Trouble, follow, monitor};
use remote::link::{Address, Emulation, Knowledge, LinkError, Session};
use sim::behavior::Behavior;
use sim::goal_file::GoalFile;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

const EXAMPLES: &str = "\
Examples, each after `host-sim link --to serial:/dev/ttyUSB0`:
  hello              who is at the other end?
  monitor            watch it until Ctrl-C
  explore 100        make 100 random moves (the robot drives!)
  learn              make the maps from them
  pull robot.mind    keep what it has learned
  push robot.mind    give it back, to this chip or another
  flash save         let it outlive being switched off
  goal wall-right    set the goal ...
  seek               ... and pursue it (the robot drives!)
  params far 1200    change a parameter

Without any hardware, in an emulated chip:
  host-sim link --to qemu hello

A robot stops when its link falls silent: explore, seek and resume keep it alive until they end. Each command opens a \
session of its own, and a robot that moves stops when another session begins.

A goal FILE holds a captured situation (host-sim capture writes one) or says what the sonars (0 ahead, 4 to the left, counter-clockwise) should perceive, from 0 = nothing within \
the far limit to 1 = something as near as the near limit; sonars it does not name may perceive anything:
  [[sonar]]
  numbers = [4]
  at_least = 0.6
  at_most = 0.8
  [[sonar]]
  numbers = [15, 0, 1]
  at_most = 0.1";

/// The `link` command's flags.
#[derive(Debug, Clone, Args)]
#[command(after_help = EXAMPLES)]
pub struct LinkArgs {
    /// The mind: serial:PORT[@BAUD] (115200 unless said otherwise), tcp:HOST:PORT, or qemu
    #[arg(long, value_name = "WHERE")]
    to: Address,
    /// Image for --to qemu [default: built from the project's sources]
    #[arg(long, value_name = "ELF")]
    firmware: Option<PathBuf>,
    /// Show what the emulator says
    #[arg(long)]
    verbose: bool,
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Clone, Subcommand)]
enum Verb {
    /// Say who the mind is
    Hello,
    /// Watch what the mind says, one line per message, until interrupted
    Monitor(Span),
    /// Set the goal: perceived (what is heard now), a behavior by name, or a goal FILE
    Goal {
        /// perceived, avoid, avoid-right, wall-left, wall-right, follow, kept:NAME, or a TOML file
        goal: String,
    },
    /// Make random moves and remember them
    Explore {
        /// How many
        moves: u16,
        /// Seed of the mind's own randomness
        #[arg(long, default_value_t = 1)]
        seed: u64,
        #[command(flatten)]
        span: Span,
    },
    /// Make the maps from the remembered moves
    Learn,
    /// Pursue the goal until interrupted
    Seek(Span),
    /// Stand still
    Stop,
    /// Go on with what a stop interrupted, until interrupted
    Resume(Span),
    /// Show the parameters, or one of them, or set it
    Params {
        /// Its name
        name: Option<String>,
        /// Its new value, in its unit
        #[arg(allow_negative_numbers = true)]
        value: Option<i32>,
    },
    /// Save what the mind knows in its flash, recall what it saved last, or erase all it saved
    Flash {
        /// What to do
        #[arg(value_enum)]
        action: FlashAction,
    },
    /// Keep the present goal under a name (then: goal kept:NAME); flash save makes it last
    Keep {
        /// 1 to 12 characters
        name: String,
    },
    /// Forget the goal kept under a name
    Drop {
        /// Its name
        name: String,
    },
    /// Show the names of the goals kept
    Goals,
    /// Show what the mind has counted since it started
    Counters,
    /// Save configuration, maps, memory and goals to a file
    Pull {
        /// The file
        file: PathBuf,
    },
    /// Replace configuration, maps, memory and goals by those of a file
    Push {
        /// A file that pull wrote, or `host-sim run --save`
        file: PathBuf,
    },
}

/// What to do with the flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FlashAction {
    /// Configuration, maps, memory and goals, to be there after the next start
    Save,
    /// Replace them by what was saved last, as the next start does
    Recall,
    /// The mind keeps what it knows until it is switched off
    Erase,
}

impl From<FlashAction> for Flash {
    fn from(action: FlashAction) -> Self {
        match action {
            FlashAction::Save => Self::Save,
            FlashAction::Recall => Self::Recall,
            FlashAction::Erase => Self::Erase,
        }
    }
}

/// How long to go on.
#[derive(Debug, Clone, Copy, Args)]
struct Span {
    /// End after this time
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    time: Option<Duration>,
}

fn seconds(text: &str) -> Result<Duration, String> {
    let number = text.parse().ok();
    let time = number.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    // A century fits any clock.
    let sane = time.filter(|time| time.as_secs() < 3_000_000_000);
    sane.ok_or_else(|| "it must be a number of seconds, as in 2.5".into())
}

impl Span {
    fn end(self) -> Option<Instant> {
        self.time.map(|time| Instant::now() + time)
    }
}

/// Carries the verb out.
///
/// # Errors
/// Bad arguments, a mind that cannot be reached or refuses, files that cannot be read or written, a closed pipe.
pub(super) fn link(args: &LinkArgs, out: &mut impl Write) -> Result<(), Failure> {
    let emulation = Emulation {
        firmware: args.firmware.clone(),
        verbose: args.verbose,
    };
    // Whatever can be wrong without the mind is found before it is disturbed.
    let task = Task::prepare(&args.verb)?;
    let mut session = open(&args.to, &emulation, Clock::Device)?;
    let done = match &args.verb {
        Verb::Monitor(span) => monitor(&mut session, &args.to, &emulation, span.end(), out),
        verb => perform(&mut session, verb, task, out),
    };
    done.map_err(|trouble| match trouble {
        Trouble::Link(error) => Failure::Bad(named(&args.to, &error)),
        Trouble::Input(error) => Failure::Bad(error),
        Trouble::Output(error) => Failure::Output(error),
    })
}

/// What a verb needs from this side.
enum Task {
    Nothing,
    Goal(GoalBy<16>),
    Push(Box<Knowledge>),
    Parameters(tables::Wanted),
    Ask(ToMind<16>),
}

impl Task {
    fn prepare(verb: &Verb) -> Result<Self, BadInput> {
        Ok(match verb {
            Verb::Goal { goal } => Self::Goal(match goal.as_str() {
                "avoid" => GoalBy::Avoid,
                "perceived" => GoalBy::Perceived,
                kept if kept.starts_with("kept:") => {
                    GoalBy::Kept(name(kept.trim_start_matches("kept:"))?)
                }
                name => GoalBy::Components(goal_by_name(name)?),
            }),
            Verb::Push { file } => Self::Push(Box::new(Knowledge::load(file)?)),
            Verb::Flash { action } => Self::Ask(ToMind::Flash((*action).into())),
            Verb::Keep { name: text } => Self::Ask(ToMind::Keep { name: name(text)? }),
            Verb::Drop { name: text } => Self::Ask(ToMind::Drop { name: name(text)? }),
            Verb::Goals => Self::Ask(ToMind::Goals),
            Verb::Params { name, value } => {
                Self::Parameters(tables::wanted(name.as_deref(), *value)?)
            }
            _ => Self::Nothing,
        })
    }
}

/// A name to keep a goal under.
fn name(text: &str) -> Result<Name, BadInput> {
    let name = Name::new(text);
    name.ok_or_else(|| BadInput::new(format!("\"{text}\": {}", KeepError::Name)))
}

/// A behavior's goal, for the ranges of the preset `default`, or a file's.
fn goal_by_name(name: &str) -> Result<Goal<16>, BadInput> {
    let is_file = name.contains(['.', '/']) || Path::new(name).exists();
    if is_file {
        return Ok(GoalFile::load(name.as_ref())?.goal());
    }
    match name.parse()? {
        Behavior::Nest | Behavior::Chain(_) => Err(BadInput::new(format!(
            "goal {name}: a mind on a chip takes one goal at a time; at the nest, `goal perceived` captures it"
        ))),
        behavior => Ok(behavior.goal(&Config::recommended(), &[Weight::ZERO; 16])),
    }
}

fn perform(
    session: &mut Session,
    verb: &Verb,
    task: Task,
    out: &mut impl Write,
) -> Result<(), Trouble> {
    match (verb, task) {
        (_, Task::Goal(goal)) => order(session, Order::Goal(goal), out),
        (_, Task::Parameters(wanted)) => tables::parameters(session, wanted, out),
        (_, Task::Ask(message)) => ask(session, &message, out),
        (Verb::Push { file }, Task::Push(knowledge)) => {
            knowledge.upload(session)?;
            let samples = knowledge.samples();
            let file = file.display();
            Ok(writeln!(
                out,
                "{file}: configuration, maps and {samples} samples are in the mind"
            )?)
        }
        (Verb::Pull { file }, _) => {
            let knowledge = Knowledge::download(session)?;
            knowledge.save(file)?;
            let samples = knowledge.samples();
            let file = file.display();
            Ok(writeln!(
                out,
                "{file}: configuration, maps and {samples} samples"
            )?)
        }
        (Verb::Explore { moves, seed, span }, _) => {
            let (moves, seed) = (*moves, *seed);
            drive(session, Order::Explore { moves, seed }, *span, out)
        }
        (Verb::Seek(span), _) => drive(session, Order::Seek, *span, out),
        (Verb::Resume(span), _) => drive(session, Order::Resume, *span, out),
        (Verb::Learn, _) => follow_order(session, Order::Learn, None, out),
        (Verb::Stop, _) => order(session, Order::Stop, out),
        (Verb::Counters, _) => tables::counters(session, out),
        _ => tables::hello(session, out),
    }
}

/// Asks once: what is done twice wears the flash.
fn ask(session: &mut Session, message: &ToMind<16>, out: &mut impl Write) -> Result<(), Trouble> {
    let answer = session.request(message)?;
    if let Some(why) = answer.refusal {
        return Err(LinkError::Refused(why).into());
    }
    for report in &answer.reports {
        follow::print(report, out)?;
    }
    Ok(writeln!(out, "done")?)
}

fn order(session: &mut Session, order: Order<16>, out: &mut impl Write) -> Result<(), Trouble> {
    let at_ms = session.elapsed_ms();
    for report in session.command(at_ms, order)? {
        follow::print(&report, out)?;
    }
    Ok(writeln!(out, "done")?)
}

/// Gives an order that makes the robot move, listening to its own sonars if it has any, and keeps the link alive.
fn drive(
    session: &mut Session,
    order: Order<16>,
    span: Span,
    out: &mut impl Write,
) -> Result<(), Trouble> {
    if !session.use_own_ring()? {
        eprintln!(
            "This mind has no sonars of its own and waits for echoes over the link; a simulated robot sends them: host-sim run --mind …"
        );
    }
    follow_order(session, order, span.end(), out)
}

fn follow_order(
    session: &mut Session,
    order: Order<16>,
    until: Option<Instant>,
    out: &mut impl Write,
) -> Result<(), Trouble> {
    let at_ms = session.elapsed_ms();
    for report in session.command(at_ms, order)? {
        follow::print(&report, out)?;
    }
    let mut ended = None;
    follow(session, until, out, |said| {
        if let FromMind::Mode(mode @ (ModeReport::Idle | ModeReport::Stopped(_))) = said {
            ended = Some(*mode);
        }
        ended.is_some()
    })?;
    match ended {
        Some(ModeReport::Stopped(reason)) => Err(LinkError::Stopped(reason).into()),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
