//! A mind, here or elsewhere, whose dealings go into a log if there is one.

use super::record::{Happening, Setup};
use super::tap::Tap;
use super::write::LogOutput;
use crate::link::{AnyMind, Knowledge, LinkError};
use amp::config::Config;
use amp::units::Millis;
use arena::world::World;
use files::hex::hex;

/// Such a mind.
pub type LoggedMind = Tap<AnyMind, LogOutput>;

impl LoggedMind {
    /// Tells it other open choices.
    ///
    /// # Errors
    /// When it is elsewhere and moves, or cannot be reached.
    pub fn configure(&mut self, at: Millis, config: &Config<16>) -> Result<(), LinkError> {
        self.pilot().configure(config)?;
        self.note(at, Happening::Configure(Box::new(config.clone())));
        Ok(())
    }

    /// Makes it one that knows nothing, under these conditions, in this world if it is known.
    ///
    /// # Errors
    /// When it is elsewhere and cannot be reached.
    pub fn afresh(&mut self, setup: &Setup, world: Option<&World>) -> Result<(), LinkError> {
        self.pilot().afresh(&setup.config)?;
        self.begin(setup, world);
        Ok(())
    }

    /// Replaces what it knows; only in this process.
    pub fn know(&mut self, at: Millis, knowledge: &Knowledge) {
        if self.inner().is_here() {
            self.pilot().replace(knowledge);
            self.note(at, Happening::Know(hex(&knowledge.to_bytes())));
        }
    }
}
