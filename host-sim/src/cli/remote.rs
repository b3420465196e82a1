//! `--mind`: whose mind drives, and an episode driven by one elsewhere.

use super::run::drive;
use crate::episode::{self, Episode, Setup};
use crate::error::BadInput;
use crate::link::{self, Address, Emulation, LinkError, RemoteMind, Session};
use crate::world::World;
use amp::config::Config;
use amp::wire::message::Clock;
use std::path::Path;
use std::str::FromStr;

/// Where the mind runs.
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

/// A mind elsewhere, for one episode after the other.
pub(super) struct Remote {
    address: Address,
    session: Session,
    first: bool,
}

impl Remote {
    /// Opens the way to a mind that takes so many random moves; `None` for the mind in this process.
    ///
    /// # Errors
    /// When it cannot be reached, is of another kind, or has too small a memory.
    pub(super) fn connect(
        choice: &MindChoice,
        emulation: &Emulation,
        moves: u16,
    ) -> Result<Option<Self>, BadInput> {
        only_for_qemu(matches!(choice, MindChoice::At(Address::Qemu)), emulation)?;
        let MindChoice::At(address) = choice else {
            return Ok(None);
        };
        let session = open(address, emulation, Clock::Host)?;
        let holds = session.hello().map_or(0, |hello| hello.samples);
        if moves > holds {
            return Err(BadInput::new(format!(
                "--explore {moves}: the memory of the mind at {address} holds {holds} moves"
            )));
        }
        Ok(Some(Self {
            address: address.clone(),
            session,
            first: true,
        }))
    }

    /// Runs an episode, with a log if there is to be one.
    ///
    /// # Errors
    /// When the mind refuses something, falls silent or cannot be reached.
    pub(super) fn episode(
        &mut self,
        world: &World,
        setup: &Setup,
        log: Option<&Path>,
    ) -> Result<Episode, episode::Failure> {
        let mut mind = self.mind(&setup.config).map_err(episode::Failure::Link)?;
        drive(world, setup, &mut mind, log)
    }

    /// The mind, with this configuration and nothing in its memory.
    ///
    /// # Errors
    /// When it cannot be reached or does not become what it is told to.
    pub(super) fn mind(
        &mut self,
        config: &Config<16>,
    ) -> Result<RemoteMind<&mut Session>, LinkError> {
        let number = link::next_number(self.session.number());
        let mind = RemoteMind::start(&mut self.session, number, config)?;
        let replaced = mind.replaced();
        // From the second episode on it is what the one before left.
        if std::mem::take(&mut self.first) && !replaced.is_empty() {
            eprintln!(
                "{}: the mind came with another {}: replaced for this run",
                self.address,
                replaced.join(", another ")
            );
        }
        Ok(mind)
    }
}

/// Opens the way to a mind, and a session with it.
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

/// What went wrong on the way to `address`.
pub(super) fn named(address: &Address, error: &LinkError) -> BadInput {
    match error {
        // It names what could not be opened.
        LinkError::Open { why } => BadInput::new(why.clone()),
        _ => BadInput::new(format!("{address}: {error}")),
    }
}

pub(super) fn only_for_qemu(qemu: bool, emulation: &Emulation) -> Result<(), BadInput> {
    match &emulation.firmware {
        Some(image) if !qemu => Err(BadInput::new(format!(
            "--firmware {}: only qemu takes an image; flash a chip with its own tools",
            image.display()
        ))),
        _ => Ok(()),
    }
}
