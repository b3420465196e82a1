//! `--mind`: selects where the controller runs, and drives episodes by a remote one.

use super::run::drive;
use super::setup::parsed;
use amp::config::Config;
use amp::wire::message::Clock;
use arena::world::World;
use clap::Args;
use files::error::BadInput;
use remote::link::{
    self, Address, ControllerPlace, Emulation, LinkError, Program, RemoteController, Session,
};
use sim::episode::{Episode, Setup};
use sim::error::EpisodeError;
use sim::robot::{AnyRobot, ToldRobot};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Where the controller runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MindChoice {
    /// In this process.
    Host,
    /// At the other end of a link.
    At(Address),
}

impl FromStr for MindChoice {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        if text == "host" {
            return Ok(Self::Host);
        }
        let address = text.parse().map(Self::At);
        address.map_err(|error: BadInput| BadInput::new(format!("{error} (or host)")))
    }
}

/// Flags for the place of the controller.
#[derive(Debug, Clone, Args)]
pub struct MindArgs {
    /// Where the controller runs: host (in this process), qemu (the firmware in an emulated chip),
    /// serial:PORT[@BAUD] or tcp:HOST:PORT (a chip); its decisions are the same
    #[arg(long = "mind", value_name = "WHERE", default_value = "host", value_parser = parsed::<MindChoice>)]
    pub(super) choice: MindChoice,
    /// Image for --mind qemu [default: built from the project's sources]
    #[arg(long, value_name = "ELF")]
    firmware: Option<PathBuf>,
    /// Show the emulator's output
    #[arg(long)]
    verbose: bool,
}

impl MindArgs {
    /// How to start the emulator with a program.
    pub(super) fn emulation(&self, program: Program) -> Emulation {
        Emulation {
            firmware: self.firmware.clone(),
            program,
            verbose: self.verbose,
        }
    }

    /// Connects to a controller with a memory for `moves` random moves of this robot.
    ///
    /// # Errors
    /// When it cannot be reached, is incompatible, or has too small a memory.
    pub(super) fn place(
        &self,
        moves: u16,
        robot: Option<&AnyRobot>,
    ) -> Result<ControllerPlace, BadInput> {
        Ok(match Remote::connect(self, moves, robot)? {
            None => ControllerPlace::Host,
            Some(remote) => {
                ControllerPlace::Link(Box::new(remote.session), remote.address.to_string())
            }
        })
    }
}

/// A remote controller, for several episodes in sequence.
pub(super) struct Remote {
    address: Address,
    session: Session,
    first: bool,
}

impl Remote {
    /// Connects to a controller with a memory for `moves` random moves of this robot (`None` = the
    /// Nomad with its own ring); `None` for the controller in this process.
    ///
    /// # Errors
    /// When it cannot be reached, is incompatible, or has too small a memory.
    pub(super) fn connect(
        args: &MindArgs,
        moves: u16,
        robot: Option<&AnyRobot>,
    ) -> Result<Option<Self>, BadInput> {
        let emulation = args.emulation(Program::of(robot));
        let qemu = matches!(args.choice, MindChoice::At(Address::Qemu));
        only_for_qemu(qemu, &emulation)?;
        let MindChoice::At(address) = &args.choice else {
            return Ok(None);
        };
        let session = open(address, &emulation, Clock::Host)?;
        let holds = session.hello().map_or(0, |hello| hello.samples);
        if moves > holds {
            return Err(BadInput::new(format!(
                "--explore {moves}: the memory of the controller at {address} holds {holds} moves"
            )));
        }
        Ok(Some(Self {
            address: address.clone(),
            session,
            first: true,
        }))
    }

    /// Where it is.
    pub(super) fn address(&self) -> &Address {
        &self.address
    }

    /// Whether it has a memory of places.
    ///
    /// # Errors
    /// When it cannot be reached.
    pub(super) fn has_places(&mut self) -> Result<bool, BadInput> {
        let has_places = self.session.has_places();
        has_places.map_err(|error| named(&self.address, &error))
    }

    /// Runs an episode, with a log if one is requested.
    ///
    /// # Errors
    /// When the controller refuses a command, stops answering or cannot be reached.
    pub(super) fn episode(
        &mut self,
        world: &World,
        setup: &Setup,
        log: Option<&Path>,
    ) -> Result<Episode, EpisodeError> {
        let robot = setup.robot.as_ref().map(AnyRobot::told);
        let mind = self.mind(&setup.config, robot.as_ref());
        let mut mind = mind.map_err(EpisodeError::from)?;
        drive(world, setup, &mut mind, log)
    }

    /// The controller with this configuration and robot, and an empty memory.
    ///
    /// # Errors
    /// When it cannot be reached or does not accept the configuration.
    pub(super) fn mind(
        &mut self,
        config: &Config<16>,
        robot: Option<&ToldRobot>,
    ) -> Result<RemoteController<&mut Session>, LinkError> {
        let number = link::next_number(self.session.number());
        let mind = RemoteController::start(&mut self.session, number, config, robot)?;
        let replaced = mind.replaced();
        // From the second episode on it has the state of the previous one.
        if std::mem::take(&mut self.first) && !replaced.is_empty() {
            eprintln!(
                "{}: the controller had another {}: replaced for this run",
                self.address,
                replaced.join(", another ")
            );
        }
        Ok(mind)
    }
}

/// Connects to a controller and opens a session.
pub(super) fn open(
    address: &Address,
    emulation: &Emulation,
    clock: Clock,
) -> Result<Session, BadInput> {
    only_for_qemu(*address == Address::Qemu, emulation)?;
    let transport = link::connect(address, emulation).map_err(|error| named(address, &error))?;
    let mut session = Session::new(transport);
    session
        .open(link::fresh_number(), clock)
        .map_err(|error| named(address, &error))?;
    Ok(session)
}

/// The controller at `address` cannot do this without a memory of places.
pub(super) fn needs_places(what: &str, address: &str) -> BadInput {
    BadInput::new(format!(
        "{what}: the controller at {address} has no memory of places (it is in firmware with the feature places)"
    ))
}

/// An error of the connection to `address`.
pub(super) fn named(address: &Address, error: &LinkError) -> BadInput {
    match error {
        // The reason already names what could not be opened.
        LinkError::Open { why } => BadInput::new(why.clone()),
        _ => BadInput::new(format!("{address}: {error}")),
    }
}

fn only_for_qemu(qemu: bool, emulation: &Emulation) -> Result<(), BadInput> {
    match &emulation.firmware {
        Some(image) if !qemu => Err(BadInput::new(format!(
            "--firmware {}: only qemu takes an image; flash a chip with its own tools",
            image.display()
        ))),
        _ => Ok(()),
    }
}
