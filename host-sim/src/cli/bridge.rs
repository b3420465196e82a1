//! `host-sim bridge`: a mind drives a Nomad 200 over the robot's own line.

use super::Failure;
use super::output::bar;
use super::remote::{MindChoice, Remote, named};
use super::run::{Preset, Switch};
use super::setup::{configured, parsed};
use super::table::plain;
use crate::error::BadInput;
use crate::link::{Address, Emulation, Serial, Tcp};
use crate::nomad::Host;
use crate::nomad::bridge::{Driven, Plan, Trouble, drive};
use crate::pilot::{MOST_MOVES, Mind};
use crate::scenes::Behavior;
use clap::Args;
use std::io::Write;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Speed of the robot's serial port unless another is asked for, baud.
const BAUD: u32 = 38_400;

/// Sonars in one answer over a serial line: with the position of each reading, 16 would take it a sixth of a second.
const SERIAL_SONARS: u32 = 4;

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
    /// Where the mind runs: host (in this process), qemu (the firmware in an emulated chip), serial:PORT[@BAUD]
    /// or tcp:HOST:PORT (a chip)
    #[arg(long, value_name = "WHERE", default_value = "host", value_parser = parsed::<MindChoice>)]
    mind: MindChoice,
    /// Image for --mind qemu [default: built from the project's sources]
    #[arg(long, value_name = "ELF")]
    firmware: Option<PathBuf>,
    /// Show what the emulator says
    #[arg(long)]
    verbose: bool,
    /// What to do after exploring (see `host-sim behaviors`)
    #[arg(long, value_name = "NAME", default_value = "avoid", value_parser = parsed::<Behavior>)]
    behavior: Behavior,
    /// Random moves before it
    #[arg(long, value_name = "MOVES", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..=i64::from(MOST_MOVES)))]
    explore: u16,
    /// Decisions towards the goal
    #[arg(long, value_name = "STEPS", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
    /// Seed of the random moves
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Let the sonars limit motion: what the robot does (on) or what the maps alone do (off)
    #[arg(long, value_name = "ON|OFF", default_value = "on", value_enum)]
    shield: Switch,
    /// Let both maps go on learning from every move
    #[arg(long, value_name = "ON|OFF", default_value = "on", value_enum)]
    online: Switch,
    /// The open choices of the method (the turret is held, as `default` and `probe` have it)
    #[arg(long, value_name = "NAME", default_value = "default", value_enum)]
    preset: Preset,
    /// Change one open choice, e.g. --set far=1.2 (see `host-sim settings`); may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

/// Where a robot is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Robot(Address);

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
    fn open(&self) -> Result<Host, BadInput> {
        let at = |error| named(&self.0, &error);
        match &self.0 {
            Address::Serial { path, baud } => Ok(Host::new(Serial::open(path, *baud).map_err(at)?)),
            Address::Tcp(host) => {
                let line = Tcp::open(host).map_err(at)?;
                Host::greeted(line).map_err(|error| BadInput::new(format!("{}: {error}", self.0)))
            }
            Address::Qemu => Err(BadInput::new("an emulated chip is no robot")),
        }
    }

    fn sonars_at_once(&self) -> u32 {
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
    let config = configured(args.preset, &args.sets, args.shield, args.online)?;
    if args.preset == Preset::Touzet {
        return Err(BadInput::new(
            "--preset touzet: its ring turns with the heading; the bridge holds the turret",
        )
        .into());
    }
    let plan = Plan {
        config: args.behavior.adapted(config),
        explore_moves: args.explore,
        steps: args.steps,
        behavior: args.behavior.clone(),
        seed: args.seed,
        sonars_at_once: args.nomad.sonars_at_once(),
    };
    let interrupted = watch()?;
    let host = args.nomad.open()?;
    let emulation = Emulation {
        firmware: args.firmware.clone(),
        verbose: args.verbose,
    };
    let remote = Remote::connect(&args.mind, &emulation, plan.explore_moves)?;
    let progress = bar(
        u64::from(plan.explore_moves) + u64::from(plan.steps),
        "steps",
    );
    let show = |done: u32| progress.set_position(u64::from(done));
    let (driven, result) = match remote {
        None => {
            let mut mind = Mind::new(plan.config.clone());
            drive(host, &mut mind, &plan, &interrupted, show)
        }
        Some(mut remote) => {
            let mind = remote.mind(&plan.config);
            let mut mind = mind.map_err(|error| named_mind(&args.mind, &error))?;
            drive(host, &mut mind, &plan, &interrupted, show)
        }
    };
    progress.finish_and_clear();
    print(args, &driven, out)?;
    result.map_err(|trouble| explain(args, &trouble).into())
}

fn named_mind(choice: &MindChoice, error: &crate::link::LinkError) -> BadInput {
    match choice {
        MindChoice::At(address) => named(address, error),
        MindChoice::Host => BadInput::new(error.to_string()),
    }
}

fn explain(args: &BridgeArgs, trouble: &Trouble) -> BadInput {
    match (trouble, &args.mind) {
        (Trouble::Robot(error), _) => BadInput::new(format!("{}: {error}", args.nomad.0)),
        (Trouble::Mind(failure), MindChoice::At(address)) => {
            BadInput::new(format!("{address}: {failure}; the robot was told to stand"))
        }
        _ => BadInput::new(trouble.to_string()),
    }
}

/// A flag that Ctrl-C, a hang-up or a request to end raises.
fn watch() -> Result<Arc<AtomicBool>, BadInput> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&flag);
    ctrlc::set_handler(move || raised.store(true, Ordering::Relaxed))
        .map_err(|error| BadInput::new(format!("Ctrl-C cannot be watched for: {error}")))?;
    Ok(flag)
}

fn print(args: &BridgeArgs, driven: &Driven, out: &mut impl Write) -> Result<(), Failure> {
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
    Ok(out.write_all(plain(&["", args.behavior.name().as_str()], &rows, &[]).as_bytes())?)
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
