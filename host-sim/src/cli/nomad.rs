//! `host-sim nomad`: the Nomad 200's own protocol.

use super::Failure;
use super::run::SonarChoice;
use arena::world::{World, parse_worlds};
use clap::{Args, Subcommand, ValueEnum};
use files::error::BadInput;
use nomad200::{Protocol, RobotLine, Server, SimulatedNomad};
use remote::listen::check_reach;
use std::io::Write;
use std::net::{TcpListener, ToSocketAddrs as _};

/// Where the robot's own server listens.
const DIRECT: &str = "127.0.0.1:65001";

/// Where the original simulator's server listens.
const NSERVER: &str = "127.0.0.1:7019";

const EXAMPLES: &str = "\
Examples:
  host-sim nomad serve                               the port of the robot's own server: 65001
  host-sim nomad serve --listen 127.0.0.1:0          any free port; the line printed says which
  host-sim nomad serve --protocol nserver            the original simulator's server: 7019
  host-sim nomad serve --pty                         a serial port; the line printed says which
  host-sim nomad serve --speed 20 --world office     twenty times real time, elsewhere

Any program written for the robot (Nclient.h) finds a Nomad 200 there. docs/nomad.md has the protocol.";

/// The `nomad` command's verbs.
#[derive(Debug, Clone, Args)]
pub(super) struct NomadArgs {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Clone, Subcommand)]
enum Verb {
    /// Be a simulated Nomad 200 to whoever connects, until interrupted
    Serve(ServeArgs),
}

/// The flags of `nomad serve`.
#[derive(Debug, Clone, Args)]
#[command(after_help = EXAMPLES)]
struct ServeArgs {
    /// Address to listen at; port 0 takes any free one [default: 127.0.0.1:65001; 127.0.0.1:7019 as nserver]
    #[arg(long, value_name = "HOST:PORT")]
    listen: Option<String>,
    /// Let others reach it: needed for any address but this machine's own
    #[arg(long)]
    allow_remote: bool,
    /// Be at a serial port (a pseudo terminal) instead
    #[arg(long, conflicts_with_all = ["listen", "protocol"])]
    pty: bool,
    /// How to speak: as the robot (programs linked with Ndirect) or as the original simulator's server (with Nclient)
    #[arg(long, value_name = "NAME", default_value = "direct", value_enum)]
    protocol: Spoken,
    /// World: a .toml or ROS .yaml FILE, random:SEED, or a built-in name (see `host-sim worlds`)
    #[arg(long, value_name = "WORLD", default_value = "paper")]
    world: String,
    /// What the sonars return
    #[arg(long, value_name = "MODEL", default_value = "nomad", value_enum)]
    sonar: SonarChoice,
    /// Times real time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000))]
    speed: u32,
    /// Seed of the noise of sonars and wheels
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Block the wheels when they have rolled so far, m: to try what stops the robot then
    #[arg(long, value_name = "WAY", hide = true)]
    blocked_after: Option<f64>,
}

/// Protocols as named on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Spoken {
    /// The robot's own
    Direct,
    /// That of the original simulator's server
    Nserver,
}

/// Carries the verb out.
///
/// # Errors
/// A world that cannot be loaded, an address that cannot be listened at, a closed pipe.
pub(super) fn nomad(args: &NomadArgs, out: &mut impl Write) -> Result<(), Failure> {
    match &args.verb {
        Verb::Serve(args) => serve(args, out),
    }
}

fn serve(args: &ServeArgs, out: &mut impl Write) -> Result<(), Failure> {
    let robot = SimulatedNomad::new(world(&args.world)?, args.sonar.into(), args.seed)
        .with_wheels_blocked_after(args.blocked_after.unwrap_or(f64::INFINITY));
    if args.pty {
        let server = Server::new(RobotLine::new(robot, Protocol::Direct), args.speed);
        serve_pty(server, out)
    } else {
        serve_tcp(robot, args, out)
    }
}

/// The one world a robot can be in.
fn world(name: &str) -> Result<World, BadInput> {
    match &parse_worlds(name)?[..] {
        [source] => source.load(),
        several => Err(BadInput::new(format!(
            "--world {name}: a robot is in one world, not in {}",
            several.len()
        ))),
    }
}

/// Says where the robot is, on one line, at once.
fn announce(out: &mut impl Write, place: impl std::fmt::Display) -> Result<(), Failure> {
    writeln!(out, "listening on {place}")?;
    Ok(out.flush()?)
}

fn serve_tcp(robot: SimulatedNomad, args: &ServeArgs, out: &mut impl Write) -> Result<(), Failure> {
    let usual = match args.protocol {
        Spoken::Direct => DIRECT,
        Spoken::Nserver => NSERVER,
    };
    let address = args.listen.as_deref().unwrap_or(usual);
    let refuse = |error: std::io::Error| BadInput::new(format!("--listen {address}: {error}"));
    let addresses: Vec<_> = address.to_socket_addrs().map_err(refuse)?.collect();
    let risk = "whoever connects drives";
    check_reach(address, &addresses, args.allow_remote, risk)?;
    let listener = TcpListener::bind(&addresses[..]).map_err(refuse)?;
    let place = listener.local_addr().map_err(refuse)?;
    let protocol = match args.protocol {
        Spoken::Direct => Protocol::Direct,
        Spoken::Nserver => Protocol::Nserver {
            port: place.port(),
            speed: args.speed,
        },
    };
    let mut server = Server::new(RobotLine::new(robot, protocol), args.speed);
    announce(out, place)?;
    loop {
        // Whoever is gone before the greeting is replaced by the next one.
        if let Ok(mut host) = server.accept(&listener) {
            let error = server.serve(&mut host);
            report(&server, &error);
        }
    }
}

#[cfg(unix)]
fn serve_pty(mut server: Server, out: &mut impl Write) -> Result<(), Failure> {
    let refuse = |error: std::io::Error| BadInput::new(format!("--pty: {error}"));
    let mut pty = nomad200::PseudoTerminal::open().map_err(refuse)?;
    announce(out, pty.path().display())?;
    let error = server.serve(&mut pty);
    Err(refuse(error).into())
}

#[cfg(not(unix))]
fn serve_pty(_: Server, _: &mut impl Write) -> Result<(), Failure> {
    Err(BadInput::new("--pty: this system has no pseudo terminals").into())
}

/// What a host leaves behind.
fn report(server: &Server, error: &std::io::Error) {
    let robot = server.line().robot();
    let ledger = robot.ground_truth();
    eprintln!(
        "host gone ({error}): {:.1} m rolled and {} contacts so far, {:.1} s of the robot's time",
        ledger.traveled_m,
        ledger.contacts,
        f64::from(robot.time_ms()) / 1e3
    );
}
