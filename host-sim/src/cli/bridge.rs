//! `host-sim bridge`: a mind drives a Nomad 200 over the robot's own line.

use super::Failure;
use super::output::bar;
use super::remote::{MindArgs, MindChoice, named};
use super::run::Preset;
use super::setup::{TaskArgs, parsed};
use super::table::plain;
use amp::config::Config;
use arena::robot::TurretMode;
use clap::Args;
use files::error::BadInput;
use nomad200::Host;
use nomad200::bridge::{BridgeError, BridgePlan, BridgeReport, drive};
use remote::link::{Address, AnyController, Serial, Tcp};
use remote::log::{self, LogWriter, LoggedController, SharedLog};
use std::fmt;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Speed of the robot's serial port unless another is asked for, baud.
const BAUD: u32 = 38_400;

/// Sonars in one answer over a serial line: with the position of each reading, 16 would take it a sixth of a second.
const SERIAL_SONARS: u32 = 4;

/// Longest time of a real robot in one chunk of its log. With the second that a silent robot is waited for, a crash takes at
/// most 2 s.
const CHUNK_DURATION: Duration = Duration::from_secs(1);

const EXAMPLES: &str = "\
Examples:
  host-sim bridge --nomad tcp:127.0.0.1:65001                       the simulated robot of `host-sim nomad serve`
  host-sim bridge --nomad serial:/dev/ttyS0@38400 --mind qemu       a robot, and the firmware in an emulated chip
  host-sim bridge --nomad tcp:robot:65001 --mind serial:/dev/ttyUSB0   a robot and a chip

The robot drives! It stops at Ctrl-C, at a bumper, when the mind or the line falls silent, and one second after this \
program is gone.";

/// The `bridge` command's flags.
#[derive(Debug, Clone, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct BridgeArgs {
    /// The robot: tcp:HOST:PORT or serial:PORT[@BAUD] (38400 unless said otherwise)
    #[arg(long, value_name = "WHERE", value_parser = parsed::<Robot>)]
    nomad: Robot,
    #[command(flatten)]
    mind: MindArgs,
    #[command(flatten)]
    task: TaskArgs,
    /// Decisions towards the goal
    #[arg(long, value_name = "STEPS", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
    /// Write everything the mind is told and answers into a new FILE in the MCAP format, for `replay`, `view`, `log`
    /// and other tools
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
}

/// Where a robot is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Robot(Address);

impl fmt::Display for Robot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl FromStr for Robot {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        let refused = || {
            BadInput::new(format!(
                "\"{text}\" is no address of a robot: it must be tcp:HOST:PORT or serial:PORT[@BAUD]"
            ))
        };
        match text.parse().map_err(|_| refused())? {
            Address::Qemu => Err(refused()),
            Address::Serial { path, baud } if text.contains('@') => {
                Ok(Self(Address::Serial { path, baud }))
            }
            Address::Serial { path, .. } => Ok(Self(Address::Serial { path, baud: BAUD })),
            tcp @ Address::Tcp(_) => Ok(Self(tcp)),
        }
    }
}

impl Robot {
    /// Opens the way to it.
    ///
    /// # Errors
    /// When it cannot be reached or does not greet.
    pub(super) fn open(&self) -> Result<Host, BadInput> {
        let at = |error| named(&self.0, &error);
        match &self.0 {
            Address::Serial { path, baud } => Ok(Host::new(Serial::open(path, *baud).map_err(at)?)),
            Address::Tcp(host) => {
                let line = Tcp::open(host).map_err(at)?;
                Host::with_greeting(line)
                    .map_err(|error| BadInput::new(format!("{}: {error}", self.0)))
            }
            Address::Qemu => Err(BadInput::new("an emulated chip is no robot")),
        }
    }

    /// Sonars to be asked for at once.
    pub(super) fn sonars_at_once(&self) -> u32 {
        match self.0 {
            Address::Serial { .. } => SERIAL_SONARS,
            _ => 16,
        }
    }
}

/// Drives, and prints what came of it, also when it ended early.
///
/// # Errors
/// A robot or a mind that cannot be reached or falls silent, an interruption, a closed pipe.
pub(super) fn bridge(args: &BridgeArgs, out: &mut impl Write) -> Result<(), Failure> {
    let task = &args.task;
    let plan = BridgePlan {
        config: held(task)?,
        explore_moves: task.explore,
        steps: args.steps,
        behavior: task.behavior.clone(),
        seed: task.seed,
        sonars_at_once: args.nomad.sonars_at_once(),
    };
    let interrupted = watch()?;
    let host = args.nomad.open()?;
    let mind = mind(&args.nomad, task, &args.mind, args.log.as_deref())?;
    let log = mind.log().cloned();
    let progress = bar(
        u64::from(plan.explore_moves) + u64::from(plan.steps),
        "steps",
    );
    let show = |done: u32| progress.set_position(u64::from(done));
    let (driven, result) = drive(host, mind, &plan, &interrupted, show);
    progress.finish_and_clear();
    print(args, &driven, out)?;
    let written = log.map_or(Ok(()), |log| log.finish());
    result.map_err(|trouble| explain(args, &trouble))?;
    Ok(written.map_err(BadInput::new)?)
}

/// The open choices for a robot whose turret is held.
///
/// # Errors
/// A preset whose ring turns with the heading; a setting that is unknown.
pub(super) fn held(task: &TaskArgs) -> Result<Config<16>, BadInput> {
    if task.preset == Preset::Touzet {
        return Err(BadInput::new(
            "--preset touzet: its ring turns with the heading; the bridge holds the turret",
        ));
    }
    task.config()
}

/// The mind of a robot, at its beginning.
///
/// # Errors
/// When it cannot be reached.
pub(super) fn mind(
    robot: &Robot,
    task: &TaskArgs,
    args: &MindArgs,
    log: Option<&Path>,
) -> Result<LoggedController, BadInput> {
    let config = held(task)?;
    let mind = AnyController::new(&config, args.place(task.explore)?)?;
    if let (replaced @ [_, ..], name) = (&*mind.replaced(), mind.name()) {
        eprintln!(
            "{name}: the mind came with another {}: replaced for this run",
            replaced.join(", another ")
        );
    }
    let mut log = log.map(LogWriter::create).transpose()?;
    if let Some(log) = &mut log {
        log.set_chunk_duration(CHUNK_DURATION);
    }
    let mut mind = LoggedController::new(mind, log.map(SharedLog::new));
    let setup = log::SetupRecord {
        format: log::FORMAT,
        program: env!("CARGO_PKG_VERSION").to_owned(),
        world: format!("Nomad at {}", robot.0),
        behavior: task.behavior.name(),
        preset: task.preset.name().to_owned(),
        seed: task.seed,
        sonar: "the robot's own".to_owned(),
        turret: TurretMode::Held.name().to_owned(),
        explore_moves: task.explore,
        config,
    };
    mind.begin(&setup, None);
    Ok(mind)
}

fn explain(args: &BridgeArgs, trouble: &BridgeError) -> BadInput {
    match (trouble, &args.mind.choice) {
        (BridgeError::Robot(error), _) => BadInput::new(format!("{}: {error}", args.nomad.0)),
        (BridgeError::Controller(failure), MindChoice::At(address)) => {
            BadInput::new(format!("{address}: {failure}; the robot was stopped"))
        }
        _ => BadInput::new(trouble.to_string()),
    }
}

/// A flag that Ctrl-C, a hang-up or a request to end raises.
pub(super) fn watch() -> Result<Arc<AtomicBool>, BadInput> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&flag);
    ctrlc::set_handler(move || raised.store(true, Ordering::Relaxed))
        .map_err(|error| BadInput::new(format!("Ctrl-C cannot be watched for: {error}")))?;
    Ok(flag)
}

fn print(args: &BridgeArgs, driven: &BridgeReport, out: &mut impl Write) -> Result<(), Failure> {
    if args.json {
        serde_json::to_writer(&mut *out, driven).map_err(std::io::Error::from)?;
        return Ok(out.write_all(b"\n")?);
    }
    let rows = [
        (
            "random moves",
            format!(
                "{} (a bumper was pressed in {})",
                driven.explore_moves, driven.explore_contacts
            ),
        ),
        ("steps", driven.steps.to_string()),
        ("steps with a bumper pressed", driven.contacts.to_string()),
        ("distance", format!("{:.1} m", driven.distance_m)),
        ("goal held", format!("{} steps", driven.goal_steps)),
        (
            "shortened by the shield",
            format!("{} steps", driven.shield_stops),
        ),
        ("motions cut off, mind too slow", driven.expired.to_string()),
        ("robot's time", format!("{:.0} s", driven.time_s)),
    ];
    let rows: Vec<_> = rows
        .into_iter()
        .map(|(label, value)| vec![label.to_owned(), value])
        .collect();
    Ok(out.write_all(plain(&["", args.task.behavior.name().as_str()], &rows, &[]).as_bytes())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robots_serial_port_has_its_own_speed() {
        let baud = |text: &str| match text.parse::<Robot>().map(|robot| robot.0) {
            Ok(Address::Serial { baud, .. }) => Some(baud),
            _ => None,
        };
        assert_eq!(baud("serial:/dev/ttyS0"), Some(38_400));
        assert_eq!(baud("serial:/dev/ttyS0@9600"), Some(9_600));
        for text in ["qemu", "tcp:robot", "serial:", "robot:65001"] {
            let error = text.parse::<Robot>().unwrap_err().to_string();
            assert!(error.contains("no address of a robot"), "{error}");
        }
    }
}
