//! A controller, local or remote, with an optional log of its inputs and answers.

use super::logged_pilot::LoggedPilot;
use super::record::EventKind;
use super::setup_record::SetupRecord;
use super::write::LogOutput;
use crate::link::{AnyController, Knowledge, LinkError};
use amp::config::Config;
use amp::units::Millis;
use arena::world::World;
use files::hex::hex;

/// A controller with an optional log.
pub type LoggedController = LoggedPilot<AnyController, LogOutput>;

impl LoggedController {
    /// Replaces the configuration.
    ///
    /// # Errors
    /// When it is remote and moves, or cannot be reached.
    pub fn configure(&mut self, at: Millis, config: &Config<16>) -> Result<(), LinkError> {
        self.pilot().configure(config)?;
        self.log_change(at, EventKind::Configure(Box::new(config.clone())));
        Ok(())
    }

    /// Clears the knowledge and starts with these conditions, in this world if it is known.
    ///
    /// # Errors
    /// When it is remote and cannot be reached.
    pub fn reset(&mut self, setup: &SetupRecord, world: Option<&World>) -> Result<(), LinkError> {
        self.pilot().reset(&setup.config)?;
        self.begin(setup, world);
        Ok(())
    }

    /// Replaces configuration and knowledge; only in this process.
    pub fn load(&mut self, at: Millis, knowledge: &Knowledge) {
        if self.inner().is_local() {
            self.pilot().replace(knowledge, at);
            self.log_change(at, EventKind::Know(hex(&knowledge.to_bytes())));
        }
    }
}
