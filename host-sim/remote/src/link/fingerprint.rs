//! Checksums that identify a controller's configuration and knowledge.

use super::{InProcessNode, LinkError, Session};
use amp::config::Config;
use amp::wire::message::{Clock, DeviceHello};

/// Checksums of a controller's configuration and knowledge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fingerprint {
    /// Of the configuration.
    pub config_crc: u32,
    /// Of the three maps.
    pub maps_crc: u32,
    /// Of the memory.
    pub memory_crc: u32,
}

impl From<&DeviceHello> for Fingerprint {
    fn from(hello: &DeviceHello) -> Self {
        Self {
            config_crc: hello.config_crc,
            maps_crc: hello.maps_crc,
            memory_crc: hello.memory_crc,
        }
    }
}

impl Fingerprint {
    /// That of a controller with this configuration and no knowledge.
    ///
    /// # Errors
    /// When the configuration does not fit a message.
    pub fn fresh(config: &Config<16>) -> Result<Self, LinkError> {
        let mut session = Session::new(InProcessNode::new(config.clone()));
        session.expect_open_space(config.open_space);
        Ok(Self::from(&session.open(1, Clock::Host)?))
    }

    /// Names of the parts that differ.
    #[must_use]
    pub fn differences(&self, other: &Self) -> Vec<&'static str> {
        let pairs = [
            (self.config_crc != other.config_crc, "configuration"),
            (self.maps_crc != other.maps_crc, "maps"),
            (self.memory_crc != other.memory_crc, "memory"),
        ];
        let differing = pairs.into_iter().filter(|(differs, _)| *differs);
        differing.map(|(_, what)| what).collect()
    }
}
