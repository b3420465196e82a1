//! `host-sim nomad`: a simulated Nomad 200 that speaks the robot's own protocol.

use super::CliError;
use super::run::SonarChoice;
use arena::loaders::parse_worlds;
use arena::world::World;
use clap::{Args, Subcommand, ValueEnum};
use files::error::BadInput;
use nomad200::{Protocol, RobotLine, Server, SimulatedNomad};
use remote::listen::check_reach;
use std::io::Write;
use std::net::{TcpListener, ToSocketAddrs as _};

/// Default address of the robot's own server.
const DIRECT: &str = "127.0.0.1:65001";

/// Default address of the original simulator's server.
const NSERVER: &str = "127.0.0.1:7019";

const EXAMPLES: &str = "\
Examples:
  host-sim nomad serve                               the port of the robot's own server: 65001
  host-sim nomad serve --listen 127.0.0.1:0          any free port; the output names it
  host-sim nomad serve --protocol nserver            the original simulator's server: 7019
  host-sim nomad serve --pty                         a serial port; the output names it
  host-sim nomad serve --speed 20 --world office     twenty times real time, in another world

Any program written for the robot (Nclient.h) can connect. docs/nomad.md has the protocol.";

/// The `nomad` command.
#[derive(Debug, Clone, Args)]
pub(super) struct NomadArgs {
    #[command(subcommand)]
    verb: NomadVerb,
}

#[derive(Debug, Clone, Subcommand)]
enum NomadVerb {
    /// Simulate a Nomad 200 for the programs that connect, until interrupted
    Serve(ServeArgs),
}

/// Flags of `nomad serve`.
#[derive(Debug, Clone, Args)]
#[command(after_help = EXAMPLES)]
struct ServeArgs {
    /// Address to listen on; port 0 takes any free one [default: 127.0.0.1:65001; 127.0.0.1:7019 as
    /// nserver]
    #[arg(long, value_name = "HOST:PORT")]
    listen: Option<String>,
    /// Accept other machines: required for any address but this machine's own
    #[arg(long)]
    allow_remote: bool,
    /// Open a serial port (a pseudo terminal) instead
    #[arg(long, conflicts_with_all = ["listen", "protocol"])]
    pty: bool,
    /// Protocol: the robot's own (programs linked with Ndirect) or the original simulator's (with
    /// Nclient)
    #[arg(long, value_name = "NAME", default_value = "direct", value_enum)]
    protocol: Spoken,
    /// World: a .toml or ROS .yaml FILE, random:SEED, random2:SEED, or a built-in name (see
    /// `host-sim worlds`)
    #[arg(long, value_name = "WORLD", default_value = "paper")]
    world: String,
    /// Sonar model
    #[arg(long, value_name = "MODEL", default_value = "nomad", value_enum)]
    sonar: SonarChoice,
    /// Times real time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000))]
    speed: u32,
    /// Seed of the noise of sonars and wheels
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Block the wheels after this distance, m: tests what stops the robot then
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

/// Runs the subcommand.
///
/// # Errors
/// A world that cannot be loaded, an address that cannot be bound, a closed pipe.
pub(super) fn nomad(args: &NomadArgs, out: &mut impl Write) -> Result<(), CliError> {
    match &args.verb {
        NomadVerb::Serve(args) => serve(args, out),
    }
}

fn serve(args: &ServeArgs, out: &mut impl Write) -> Result<(), CliError> {
    let robot = SimulatedNomad::new(world(&args.world)?, args.sonar.into(), args.seed)
        .with_wheels_blocked_after(args.blocked_after.unwrap_or(f64::INFINITY));
    if args.pty {
        let server = Server::new(RobotLine::new(robot, Protocol::Direct), args.speed);
        serve_pty(server, out)
    } else {
        serve_tcp(robot, args, out)
    }
}

/// Loads the single world of the robot.
fn world(name: &str) -> Result<World, BadInput> {
    match &parse_worlds(name)?[..] {
        [source] => source.load(),
        several => Err(BadInput::new(format!(
            "--world {name}: a robot is in one world, not in {}",
            several.len()
        ))),
    }
}

/// Prints the robot's address on one line and flushes it.
fn announce(out: &mut impl Write, place: impl std::fmt::Display) -> Result<(), CliError> {
    writeln!(out, "listening on {place}")?;
    Ok(out.flush()?)
}

fn serve_tcp(
    robot: SimulatedNomad,
    args: &ServeArgs,
    out: &mut impl Write,
) -> Result<(), CliError> {
    let usual = match args.protocol {
        Spoken::Direct => DIRECT,
        Spoken::Nserver => NSERVER,
    };
    let address = args.listen.as_deref().unwrap_or(usual);
    let refuse = |error: std::io::Error| BadInput::new(format!("--listen {address}: {error}"));
    let addresses: Vec<_> = address.to_socket_addrs().map_err(refuse)?.collect();
    let risk = "any client can drive the robot";
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
        // A client that leaves before the greeting is skipped.
        if let Ok(mut host) = server.accept(&listener) {
            let error = server.serve(&mut host);
            report(&server, &error);
        }
    }
}

#[cfg(unix)]
fn serve_pty(mut server: Server, out: &mut impl Write) -> Result<(), CliError> {
    let refuse = |error: std::io::Error| BadInput::new(format!("--pty: {error}"));
    let mut pty = nomad200::PseudoTerminal::open().map_err(refuse)?;
    announce(out, pty.path().display())?;
    let error = server.serve(&mut pty);
    Err(refuse(error).into())
}

#[cfg(not(unix))]
fn serve_pty(_: Server, _: &mut impl Write) -> Result<(), CliError> {
    Err(BadInput::new("--pty: this system has no pseudo terminals").into())
}

/// Prints statistics of a finished connection.
fn report(server: &Server, error: &std::io::Error) {
    let robot = server.line().robot();
    let ledger = robot.ground_truth();
    eprintln!(
        "host disconnected ({error}): {:.1} m rolled and {} contacts so far, {:.1} s of the robot's time",
        ledger.traveled_m,
        ledger.contacts,
        f64::from(robot.time_ms()) / 1e3
    );
}
