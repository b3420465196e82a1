//! `host-sim bridge`: a controller drives a Nomad 200 over the robot's own protocol.

use super::CliError;
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

/// Default speed of the robot's serial port, baud.
const BAUD: u32 = 38_400;

/// Sonars per answer over a serial line: 16 with their positions would take a sixth of a second.
const SERIAL_SONARS: u32 = 4;

/// Longest time in one chunk of a real robot's log. With the timeout of 1 s for a silent robot, a
/// crash loses at most 2 s.
const CHUNK_DURATION: Duration = Duration::from_secs(1);

const EXAMPLES: &str = "\
Examples:
  host-sim bridge --nomad tcp:127.0.0.1:65001                       the simulated robot of `host-sim nomad serve`
  host-sim bridge --nomad serial:/dev/ttyS0@38400 --mind qemu       a robot, and the firmware in an emulated chip
  host-sim bridge --nomad tcp:robot:65001 --mind serial:/dev/ttyUSB0   a robot and a chip

The robot drives! It stops at Ctrl-C, at a bumper, when the controller or the line goes silent, and one second after \
this program has ended.";

/// Flags of the `bridge` command.
#[derive(Debug, Clone, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct BridgeArgs {
    /// The robot: tcp:HOST:PORT or serial:PORT[@BAUD] (default 38400 baud)
    #[arg(long, value_name = "WHERE", value_parser = parsed::<RobotAddress>)]
    nomad: RobotAddress,
    #[command(flatten)]
    mind: MindArgs,
    #[command(flatten)]
    task: TaskArgs,
    /// Decisions toward the goal
    #[arg(long, value_name = "STEPS", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
    /// Write all events and answers of the controller into a new FILE in the MCAP format, for
    /// `replay`, `view`, `log` and other tools
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
}

/// Address of a robot.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct RobotAddress(Address);

impl fmt::Display for RobotAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl FromStr for RobotAddress {
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

impl RobotAddress {
    /// Opens the connection.
    ///
    /// # Errors
    /// When the robot cannot be reached or sends no greeting.
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

    /// Number of sonars per request.
    pub(super) fn sonars_at_once(&self) -> u32 {
        match self.0 {
            Address::Serial { .. } => SERIAL_SONARS,
            _ => 16,
        }
    }
}

/// Drives, and prints the result, also of an episode that ended early.
///
/// # Errors
/// A robot or controller that cannot be reached or stops answering, an interruption, a closed pipe.
pub(super) fn bridge(args: &BridgeArgs, out: &mut impl Write) -> Result<(), CliError> {
    let task = &args.task;
    let plan = BridgePlan {
        config: held_turret_config(task)?,
        explore_moves: task.explore,
        steps: args.steps,
        behavior: task.behavior.clone(),
        seed: task.seed,
        sonars_at_once: args.nomad.sonars_at_once(),
    };
    let interrupted = interrupt_flag()?;
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

/// The configuration for a robot with a held turret.
///
/// # Errors
/// A preset whose ring turns with the heading; an unknown setting.
pub(super) fn held_turret_config(task: &TaskArgs) -> Result<Config<16>, BadInput> {
    if task.preset == Preset::Touzet {
        return Err(BadInput::new(
            "--preset touzet: its ring turns with the heading; the bridge holds the turret",
        ));
    }
    task.config()
}

/// A robot's controller in its initial state.
///
/// # Errors
/// When it cannot be reached.
pub(super) fn mind(
    robot: &RobotAddress,
    task: &TaskArgs,
    args: &MindArgs,
    log: Option<&Path>,
) -> Result<LoggedController, BadInput> {
    let config = held_turret_config(task)?;
    let mind = AnyController::new(&config, None, args.place(task.explore, None)?)?;
    if let (replaced @ [_, ..], name) = (&*mind.replaced(), mind.name()) {
        eprintln!(
            "{name}: the controller had another {}: replaced for this run",
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
        robot: None,
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

/// A flag that Ctrl-C, a hang-up or a termination signal sets.
pub(super) fn interrupt_flag() -> Result<Arc<AtomicBool>, BadInput> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&flag);
    ctrlc::set_handler(move || raised.store(true, Ordering::Relaxed))
        .map_err(|error| BadInput::new(format!("cannot handle Ctrl-C: {error}")))?;
    Ok(flag)
}

fn print(args: &BridgeArgs, driven: &BridgeReport, out: &mut impl Write) -> Result<(), CliError> {
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
        (
            "motions cut off, controller too slow",
            driven.expired.to_string(),
        ),
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
        let baud = |text: &str| match text.parse::<RobotAddress>().map(|robot| robot.0) {
            Ok(Address::Serial { baud, .. }) => Some(baud),
            _ => None,
        };
        assert_eq!(baud("serial:/dev/ttyS0"), Some(38_400));
        assert_eq!(baud("serial:/dev/ttyS0@9600"), Some(9_600));
        for text in ["qemu", "tcp:robot", "serial:", "robot:65001"] {
            let error = text.parse::<RobotAddress>().unwrap_err().to_string();
            assert!(error.contains("no address of a robot"), "{error}");
        }
    }
}
