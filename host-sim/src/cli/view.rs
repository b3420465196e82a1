//! `host-sim view`: a page that shows the robot think.

use super::Failure;
use super::remote::{MindChoice, only_for_qemu, open};
use super::run::{Preset, sources};
use super::setup::{SetupArgs, parsed};
use crate::error::BadInput;
use crate::link::Emulation;
use crate::view::pace::SPEEDS;
use crate::view::{Door, MindPlace, PresetChoice, Simulator, Start, serve};
use amp::wire::message::Clock;
use clap::{Args, ValueEnum as _};
use std::io::Write;
use std::net::SocketAddr;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Opens no browser by itself: open the printed address. It ends with Ctrl-C.

  host-sim view                              the paper's arena
  host-sim view --world random:7 --speed max
  host-sim view --preset touzet              the paper's four steps, to the letter
  host-sim view --mind qemu                  the mind in an emulated chip

Whoever opens the address with its token may steer, one at a time; others watch. The token is new for each run.";

/// The `view` command's flags.
#[derive(Debug, Clone, Args)]
#[command(after_help = EXAMPLES)]
pub struct ViewArgs {
    /// World: a .toml or ROS .yaml FILE, random:SEED, or a built-in name (see `host-sim worlds`)
    #[arg(long, value_name = "WORLD", default_value = "paper")]
    world: String,
    #[command(flatten)]
    setup: SetupArgs,
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
    /// Simulated seconds per second, 0.05 to 1000, or max
    #[arg(long, value_name = "FACTOR", default_value = "4", value_parser = speed)]
    speed: Speed,
    /// Where to listen; port 0 takes any that is free
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8016")]
    listen: SocketAddr,
    /// Let others reach it: needed for any address but this machine's own
    #[arg(long)]
    allow_remote: bool,
}

/// Simulated seconds per second; `None` = as fast as it goes.
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

/// Serves the view until the process ends.
///
/// # Errors
/// Bad input, an address that cannot be listened at, a mind that cannot be reached, a closed pipe.
pub fn view(args: &ViewArgs, out: &mut impl Write) -> Result<(), Failure> {
    let start = start(args)?;
    let door = Door::open(args.listen, args.allow_remote)?;
    let place = place(args, start.setup.explore_moves)?;
    let simulator = Simulator::new(start, place)?;
    let [watch, steer] = door.addresses();
    writeln!(out, "watch and steer: {steer}\nonly watch:      {watch}")?;
    out.flush()?;
    Ok(serve(door, Box::new(simulator), args.speed.0)?)
}

fn start(args: &ViewArgs) -> Result<Start, BadInput> {
    let sources = sources(std::slice::from_ref(&args.world))?;
    let [source] = sources.as_slice() else {
        return Err(BadInput::new(format!(
            "--world {}: one world can be watched at a time, not {}",
            args.world,
            sources.len()
        )));
    };
    let preset = |preset: &Preset| PresetChoice {
        name: preset.name(),
        config: preset.config(),
        turret: preset.turret(),
    };
    Ok(Start {
        world: source.load()?,
        named: source.to_string(),
        setup: args.setup.setup()?,
        whole: args.setup.config()?,
        presets: Preset::value_variants().iter().map(preset).collect(),
    })
}

fn place(args: &ViewArgs, moves: u16) -> Result<MindPlace, BadInput> {
    let emulation = Emulation {
        firmware: args.firmware.clone(),
        verbose: args.verbose,
    };
    let MindChoice::At(address) = &args.mind else {
        only_for_qemu(false, &emulation)?;
        return Ok(MindPlace::Host);
    };
    let session = open(address, &emulation, Clock::Host)?;
    let holds = session.hello().map_or(0, |hello| hello.samples);
    if moves > holds {
        return Err(BadInput::new(format!(
            "--explore {moves}: the memory of the mind at {address} holds {holds} moves"
        )));
    }
    Ok(MindPlace::Link(Box::new(session), address.to_string()))
}
