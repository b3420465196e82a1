//! `host-sim view`: a web page that shows a running robot.

use super::CliError;
use super::bridge::{RobotAddress, held_turret_config, interrupt_flag, mind};
use super::remote::{MindArgs, named, needs_places, open};
use super::run::{Preset, sources};
use super::setup::{SetupArgs, parsed};
use amp::config::Config;
use amp::wire::message::Clock;
use clap::{Args, ValueEnum as _};
use files::error::BadInput;
use remote::link::{Address, ControllerPlace, Program};
use remote::log;
use sim::behavior::Behavior;
use sim::robot::AnyRobot;
use std::io::Write;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;
use view::playback_clock::SPEEDS;
use view::{
    BoundServer, NomadStart, PresetChoice, ServeOptions, Simulator, SimulatorStart, ViewSource,
    WatchedBoard, WatchedLog, WatchedNomad, serve,
};

const EXAMPLES: &str = "\
Open the printed address in a browser. Ctrl-C ends the program.

  host-sim view                              the paper's arena
  host-sim view --world random:7 --speed max
  host-sim view --preset touzet              the literal reading of the paper
  host-sim view --mind qemu                  the controller in an emulated chip
  host-sim view --robot p3dx --geometry learned --scramble 1
                                             a robot that finds its sensors
  host-sim view --places on --behavior home  a memory of places leads the robot home
  host-sim view --replay wall.mcap           a log
  host-sim view --nomad tcp:robot:65001      a Nomad 200
  host-sim view --board serial:/dev/ttyUSB0  a board with its own ring and base

The address with its token permits to steer, one page at a time; others watch. The token is new for each run.";

/// Why a robot without places has no such goal.
fn no_places(behavior: &Behavior) -> BadInput {
    BadInput::new(format!(
        "--behavior {}: only in the simulator, with a memory of places (not with --places off, \
         --nomad, --board or a controller at --mind that has none)",
        behavior.name()
    ))
}

/// Flags of the `view` command.
#[derive(Debug, Clone, Args)]
#[command(after_help = EXAMPLES)]
pub struct ViewArgs {
    /// World: a .toml or ROS .yaml FILE, random:SEED, random2:SEED, or a built-in name (see
    /// `host-sim worlds`)
    #[arg(long, value_name = "WORLD", default_value = "paper")]
    world: String,
    /// Show a log instead of a simulation: a file that `run`, `view` or `bridge` wrote with --log
    #[arg(long, value_name = "FILE", conflicts_with_all = ["nomad", "world", "behavior", "explore", "seed", "shield",
        "online", "sonar", "turret", "preset", "sets", "choice", "firmware", "log"])]
    replay: Option<PathBuf>,
    /// Show a Nomad 200 instead of a simulation, over its own protocol: tcp:HOST:PORT or
    /// serial:PORT[@BAUD] (see `bridge`)
    #[arg(long, value_name = "WHERE", value_parser = parsed::<RobotAddress>,
        conflicts_with_all = ["world", "sonar", "turret", "speed"])]
    nomad: Option<RobotAddress>,
    /// Show a board with its own ring and base instead of a simulation: serial:PORT[@BAUD],
    /// tcp:HOST:PORT or qemu
    #[arg(long, value_name = "WHERE", value_parser = parsed::<Address>, conflicts_with_all = ["replay", "nomad", "world",
        "shield", "online", "sonar", "turret", "preset", "sets", "choice", "log", "speed"])]
    board: Option<Address>,
    #[command(flatten)]
    setup: SetupArgs,
    #[command(flatten)]
    mind: MindArgs,
    /// Simulated seconds per second, 0.05 to 1000, or max
    #[arg(long, value_name = "FACTOR", default_value = "4", value_parser = speed)]
    speed: Speed,
    /// Address to listen on; port 0 takes any free one
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8016")]
    listen: SocketAddr,
    /// Accept other machines: required for any address but this machine's own
    #[arg(long)]
    allow_remote: bool,
    /// Stop a real robot or board when no page has steered for this long: 1 to 3600 seconds, or off
    #[arg(long, value_name = "SECONDS", default_value = "2", value_parser = steering_timeout)]
    steering_timeout: SteeringTimeout,
    /// Write all events and answers of the controller into a new FILE in the MCAP format, for
    /// `replay`, `view`, `log` and other tools
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
}

/// Simulated seconds per second; `None` = unlimited.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Speed(Option<f64>);

fn speed(text: &str) -> Result<Speed, String> {
    let [slow, fast] = SPEEDS;
    let number = text.parse().ok();
    match number.filter(|factor| (slow..=fast).contains(factor)) {
        Some(factor) => Ok(Speed(Some(factor))),
        None if text == "max" => Ok(Speed(None)),
        None => Err(format!("it must be {slow} to {fast}, or max")),
    }
}

/// Longest time without a steering page; `None` = unlimited.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SteeringTimeout(Option<Duration>);

fn steering_timeout(text: &str) -> Result<SteeringTimeout, String> {
    if text == "off" {
        return Ok(SteeringTimeout(None));
    }
    let seconds = text.parse().ok();
    match seconds.filter(|seconds| (1.0..=3_600.0).contains(seconds)) {
        Some(seconds) => Ok(SteeringTimeout(Some(Duration::from_secs_f64(seconds)))),
        None => Err("it must be 1 to 3600 seconds, or off".to_owned()),
    }
}

/// Serves the view until the process ends.
///
/// # Errors
/// Bad input, an address that cannot be bound, a controller that cannot be reached, a closed pipe.
pub fn view(args: &ViewArgs, out: &mut impl Write) -> Result<(), CliError> {
    let door = BoundServer::open(args.listen, args.allow_remote)?;
    let source = source(args)?;
    let ended = interrupt_flag()?;
    let [watch, steer] = door.addresses();
    writeln!(out, "watch and steer: {steer}\nonly watch:      {watch}")?;
    out.flush()?;
    let options = ServeOptions {
        speed: args.speed.0,
        steering_timeout: args.steering_timeout.0,
    };
    Ok(serve(door, source, options, ended)?)
}

fn source(args: &ViewArgs) -> Result<Box<dyn ViewSource>, BadInput> {
    if let Some(path) = &args.replay {
        return Ok(Box::new(WatchedLog::new(&log::read(path)?)?));
    }
    let is_device = args.nomad.is_some() || args.board.is_some();
    if is_device && args.setup.task().behavior.needs_places() {
        return Err(no_places(&args.setup.task().behavior));
    }
    match (&args.nomad, &args.board) {
        (Some(robot), _) => nomad(args, robot),
        (None, Some(address)) => board(args, address),
        (None, None) => simulator(args),
    }
}

fn board(args: &ViewArgs, address: &Address) -> Result<Box<dyn ViewSource>, BadInput> {
    let task = args.setup.task();
    let session = open(address, &args.mind.emulation(Program::Ring), Clock::Device)?;
    let name = address.to_string();
    let board = WatchedBoard::new(session, name, task.explore, task.seed, &task.behavior);
    Ok(Box::new(board.map_err(|error| named(address, &error))?))
}

fn nomad(args: &ViewArgs, robot: &RobotAddress) -> Result<Box<dyn ViewSource>, BadInput> {
    let task = args.setup.task();
    let config = held_turret_config(task)?;
    let host = robot.open()?;
    let mind = mind(robot, task, &args.mind, args.log.as_deref())?;
    let start = NomadStart {
        name: robot.to_string(),
        config,
        whole: task.whole()?,
        preset: task.preset.name().to_owned(),
        behavior: task.behavior.clone(),
        explore_moves: task.explore,
        seed: task.seed,
        sonars_at_once: robot.sonars_at_once(),
    };
    let watched = WatchedNomad::new(start, host, mind);
    Ok(Box::new(watched.map_err(|trouble| {
        BadInput::new(format!("{robot}: {trouble}"))
    })?))
}

fn simulator(args: &ViewArgs) -> Result<Box<dyn ViewSource>, BadInput> {
    let start = start(args)?;
    let robot = start.setup.robot.as_ref();
    let mut place = args.mind.place(start.setup.explore_moves, robot)?;
    let placeless = match &mut place {
        ControllerPlace::Link(session, name) if robot.is_some() => {
            let has_places = session.has_places();
            let has_places =
                has_places.map_err(|error| BadInput::new(format!("{name}: {error}")))?;
            (!has_places).then(|| name.clone())
        }
        _ => None,
    };
    let is_led = placeless.is_none() && robot.is_some_and(AnyRobot::is_led);
    if start.setup.behavior.needs_places() && !is_led {
        return Err(no_places(&start.setup.behavior));
    }
    let log = args.log.as_deref();
    if let (Some(path), Some(address)) = (log, placeless) {
        return Err(needs_places(&format!("--log {}", path.display()), &address));
    }
    Ok(Box::new(Simulator::new(start, place, log)?))
}

fn start(args: &ViewArgs) -> Result<SimulatorStart, BadInput> {
    let sources = sources(std::slice::from_ref(&args.world))?;
    let [source] = sources.as_slice() else {
        return Err(BadInput::new(format!(
            "--world {}: one world can be shown at a time, not {}",
            args.world,
            sources.len()
        )));
    };
    let setup = args.setup.setup()?;
    let of_robot = |config: Config<16>| match &setup.robot {
        None => config,
        Some(robot) => robot.config(config),
    };
    let preset = |preset: &Preset| PresetChoice {
        name: preset.name(),
        config: of_robot(preset.config()),
        turret: preset.turret(),
    };
    Ok(SimulatorStart {
        world: source.load()?,
        named: source.to_string(),
        whole: of_robot(args.setup.whole()?),
        presets: Preset::value_variants().iter().map(preset).collect(),
        setup,
    })
}
