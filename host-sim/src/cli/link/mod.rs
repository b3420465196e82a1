//! `host-sim link`: commands a controller on a chip and reads its state.

mod follow;
mod goal;
mod lead;
mod tables;

use super::CliError;
use super::remote::{named, open};
use amp::wire::HostMessage;
use amp::wire::message::{Clock, DeviceMessage, FlashOperation, ModeReport, RobotCommand};
use clap::{Args, Subcommand, ValueEnum};
use files::error::BadInput;
use follow::{FollowError, follow, monitor};
use remote::link::{Address, Emulation, Knowledge, LinkError, Program, Session};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

const EXAMPLES: &str = "\
Examples, each after `host-sim link --to serial:/dev/ttyUSB0`:
  hello                print the controller's version and sizes
  monitor              print its messages until Ctrl-C
  explore 100          make 100 random moves (the robot drives!)
  learn                learn the maps from them
  download robot.mind  save the learned state in a file
  upload robot.mind    load it, to this chip or another
  flash save           save it in flash
  goal wall-right      set the goal ...
  seek                 ... and pursue it (the robot drives!)
  lead home            its places lead it home while it pursues the goal
  params far 1200      change a parameter

Without any hardware, in an emulated chip:
  host-sim link --to qemu hello
  host-sim link --to qemu --program places upload robot.mind

A robot stops when its link goes silent: explore, seek and resume keep it alive until they end. Each command opens a \
new session, and a moving robot stops when another session begins.

A goal FILE holds a captured situation (host-sim capture writes one) or lists values for the sonars (0 ahead, 4 to the left, counter-clockwise), \
from 0 = nothing within the far limit to 1 = an obstacle at the near limit; other sonars may have any value:
  [[sonar]]
  numbers = [4]
  at_least = 0.6
  at_most = 0.8
  [[sonar]]
  numbers = [15, 0, 1]
  at_most = 0.1";

/// Flags of the `link` command.
#[derive(Debug, Clone, Args)]
#[command(after_help = EXAMPLES)]
pub struct LinkArgs {
    /// The controller: serial:PORT[@BAUD] (default 115200 baud), tcp:HOST:PORT, or qemu
    #[arg(long, value_name = "WHERE")]
    to: Address,
    /// What the emulated chip's program is for: ring (on a held turret), any-body, or places (any
    /// body, and a memory of places)
    #[arg(long, value_name = "NAME", default_value = "ring")]
    program: Program,
    /// Image for --to qemu [default: built from the project's sources]
    #[arg(long, value_name = "ELF")]
    firmware: Option<PathBuf>,
    /// Show the emulator's output
    #[arg(long)]
    verbose: bool,
    #[command(subcommand)]
    verb: LinkVerb,
}

#[derive(Debug, Clone, Subcommand)]
enum LinkVerb {
    /// Print the controller's version, sizes and capabilities
    Hello,
    /// Print the controller's messages, one per line, until interrupted
    Monitor(DurationArgs),
    /// Set the goal: perceived (the present situation), a behavior by name, or a goal FILE
    Goal {
        /// perceived, avoid, avoid-right, wall-left, wall-right, follow, saved:NAME, or a TOML file
        goal: String,
    },
    /// Make random moves and store them in the memory
    Explore {
        /// Number of moves
        moves: u16,
        /// Seed of the controller's random numbers
        #[arg(long, default_value_t = 1)]
        seed: u64,
        #[command(flatten)]
        span: DurationArgs,
    },
    /// Learn the maps from the memory
    Learn,
    /// Pursue the goal until interrupted
    Seek(DurationArgs),
    /// Set where its places lead it while it pursues the goal (firmware with the feature places)
    Lead {
        /// home, X,Y (meters from where it began to explore; x is where its front pointed at its
        /// start), frontier or everywhere (to where it has not been), situation (to where the goal
        /// was perceived), or off
        #[arg(allow_hyphen_values = true)]
        to: String,
    },
    /// Tell it that it was carried elsewhere
    SetDown,
    /// Stop moving
    Stop,
    /// Resume after a stop, until interrupted
    Resume(DurationArgs),
    /// Print all parameters, print one of them, or set it
    Params {
        /// Name of the parameter
        name: Option<String>,
        /// Its new value, in its unit
        #[arg(allow_negative_numbers = true)]
        value: Option<i32>,
    },
    /// Save the controller's state in its flash, load the last saved state, or erase all saved
    /// states
    Flash {
        /// Action
        #[arg(value_enum)]
        action: FlashAction,
    },
    /// Save the present goal under a name (then: goal saved:NAME); flash save makes it persistent
    #[command(alias = "keep")]
    Save {
        /// 1 to 12 characters
        name: String,
    },
    /// Delete the goal with a name
    #[command(alias = "drop")]
    Delete {
        /// Name of the goal
        name: String,
    },
    /// Print the names of the saved goals
    Goals,
    /// Print the controller's counters since its start
    Counters,
    /// Download configuration, body, maps, memory, places and goals to a file
    #[command(alias = "pull")]
    Download {
        /// The file
        file: PathBuf,
    },
    /// Upload configuration, body, maps, memory, places and goals from a file
    #[command(alias = "push")]
    Upload {
        /// A file written by download or `host-sim run --save`
        file: PathBuf,
    },
}

/// Action on the flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FlashAction {
    /// Save configuration, body, maps, memory, places and goals for the next start
    Save,
    /// Replace them by the last saved state, as the next start does
    #[value(alias = "recall")]
    Load,
    /// Erase all saved states; the running controller keeps its state until it is switched off
    Erase,
}

impl From<FlashAction> for FlashOperation {
    fn from(action: FlashAction) -> Self {
        match action {
            FlashAction::Save => Self::Save,
            FlashAction::Load => Self::Load,
            FlashAction::Erase => Self::Erase,
        }
    }
}

/// Duration of a command.
#[derive(Debug, Clone, Copy, Args)]
struct DurationArgs {
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

impl DurationArgs {
    fn end(self) -> Option<Instant> {
        self.time.map(|time| Instant::now() + time)
    }
}

/// Runs the subcommand.
///
/// # Errors
/// Invalid arguments, a controller that cannot be reached or refuses, files that cannot be read or
/// written, a closed pipe.
pub(super) fn link(args: &LinkArgs, out: &mut impl Write) -> Result<(), CliError> {
    let emulation = Emulation {
        firmware: args.firmware.clone(),
        program: args.program,
        verbose: args.verbose,
    };
    // Arguments are checked before the controller is contacted.
    let task = CheckedVerb::prepare(&args.verb)?;
    let mut session = open(&args.to, &emulation, Clock::Device)?;
    let done = match &args.verb {
        LinkVerb::Monitor(span) => monitor(&mut session, &args.to, &emulation, span.end(), out),
        verb => perform(&mut session, verb, task, out),
    };
    done.map_err(|trouble| match trouble {
        FollowError::Link(error) => CliError::Bad(named(&args.to, &error)),
        FollowError::Input(error) => CliError::Bad(error),
        FollowError::Output(error) => CliError::Output(error),
    })
}

/// A subcommand with its checked arguments.
enum CheckedVerb {
    Nothing,
    Command(RobotCommand<16>),
    Upload(Box<Knowledge>),
    Parameters(tables::RequestedParameters),
    Ask(HostMessage<16>),
}

impl CheckedVerb {
    fn prepare(verb: &LinkVerb) -> Result<Self, BadInput> {
        Ok(match verb {
            LinkVerb::Goal { goal } => Self::Command(RobotCommand::Goal(goal::spec(goal)?)),
            LinkVerb::Lead { to } => Self::Command(RobotCommand::Lead(lead::aim(to)?)),
            LinkVerb::SetDown => Self::Command(RobotCommand::SetDown),
            LinkVerb::Stop => Self::Command(RobotCommand::Stop),
            LinkVerb::Upload { file } => Self::Upload(Box::new(Knowledge::load(file)?)),
            LinkVerb::Flash { action } => Self::Ask(HostMessage::Flash((*action).into())),
            LinkVerb::Save { name: text } => Self::Ask(HostMessage::SaveGoal {
                name: goal::name(text)?,
            }),
            LinkVerb::Delete { name: text } => Self::Ask(HostMessage::DeleteGoal {
                name: goal::name(text)?,
            }),
            LinkVerb::Goals => Self::Ask(HostMessage::ListGoals),
            LinkVerb::Params { name, value } => {
                Self::Parameters(tables::wanted(name.as_deref(), *value)?)
            }
            _ => Self::Nothing,
        })
    }
}

fn perform(
    session: &mut Session,
    verb: &LinkVerb,
    task: CheckedVerb,
    out: &mut impl Write,
) -> Result<(), FollowError> {
    match (verb, task) {
        (_, CheckedVerb::Command(plain)) => command(session, plain, out),
        (_, CheckedVerb::Parameters(wanted)) => tables::parameters(session, wanted, out),
        (_, CheckedVerb::Ask(message)) => ask(session, &message, out),
        (LinkVerb::Upload { file }, CheckedVerb::Upload(knowledge)) => {
            upload(session, &knowledge, file, out)
        }
        (LinkVerb::Download { file }, _) => download(session, file, out),
        (LinkVerb::Explore { moves, seed, span }, _) => {
            let (moves, seed) = (*moves, *seed);
            drive(session, RobotCommand::Explore { moves, seed }, *span, out)
        }
        (LinkVerb::Seek(span), _) => drive(session, RobotCommand::Seek, *span, out),
        (LinkVerb::Resume(span), _) => drive(session, RobotCommand::Resume, *span, out),
        (LinkVerb::Learn, _) => follow_order(session, RobotCommand::Learn, None, out),
        (LinkVerb::Counters, _) => tables::counters(session, out),
        _ => tables::hello(session, out),
    }
}

fn upload(
    session: &mut Session,
    knowledge: &Knowledge,
    file: &Path,
    out: &mut impl Write,
) -> Result<(), FollowError> {
    knowledge.upload(session)?;
    let samples = knowledge.samples();
    let file = file.display();
    Ok(writeln!(
        out,
        "{file}: configuration, maps and {samples} samples uploaded"
    )?)
}

fn download(session: &mut Session, file: &Path, out: &mut impl Write) -> Result<(), FollowError> {
    let knowledge = Knowledge::download(session)?;
    knowledge.save(file)?;
    let samples = knowledge.samples();
    let file = file.display();
    Ok(writeln!(
        out,
        "{file}: configuration, maps and {samples} samples"
    )?)
}

/// Sends once, without retries: a repeated write wears the flash.
fn ask(
    session: &mut Session,
    message: &HostMessage<16>,
    out: &mut impl Write,
) -> Result<(), FollowError> {
    let answer = session.request(message)?;
    if let Some(why) = answer.refusal {
        return Err(LinkError::Refused(why).into());
    }
    for report in &answer.reports {
        follow::print(report, out)?;
    }
    Ok(writeln!(out, "done")?)
}

fn command(
    session: &mut Session,
    command: RobotCommand<16>,
    out: &mut impl Write,
) -> Result<(), FollowError> {
    let at_ms = session.elapsed_ms();
    for report in session.command(at_ms, command)? {
        follow::print(&report, out)?;
    }
    Ok(writeln!(out, "done")?)
}

/// Sends a command that moves the robot, prints its sonars' messages, and keeps the link alive.
fn drive(
    session: &mut Session,
    command: RobotCommand<16>,
    span: DurationArgs,
    out: &mut impl Write,
) -> Result<(), FollowError> {
    if !session.use_own_ring()? {
        eprintln!(
            "This controller has no sonars of its own and waits for echoes over the link; a simulated robot sends them: host-sim run --mind …"
        );
    }
    follow_order(session, command, span.end(), out)
}

fn follow_order(
    session: &mut Session,
    command: RobotCommand<16>,
    until: Option<Instant>,
    out: &mut impl Write,
) -> Result<(), FollowError> {
    let at_ms = session.elapsed_ms();
    for report in session.command(at_ms, command)? {
        follow::print(&report, out)?;
    }
    let mut ended = None;
    follow(session, until, out, |said| {
        if let DeviceMessage::Mode(mode @ (ModeReport::Idle | ModeReport::Stopped(_))) = said {
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
