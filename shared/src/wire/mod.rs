//! The link's wire format: messages, frames and checksums between a host and the device.
//!
//! A *frame* is `COBS(postcard(header, message) + CRC-32) 0`, at most 256 bytes; `PROTOCOL.md`
//! beside this crate's manifest describes it for a stranger. [`frame`] turns messages into frames
//! and back, [`message`] holds the messages. Enumerations grow at their ends only; [`SCHEMA`]
//! changes whenever a message does.

pub mod cobs;
pub mod frame;
pub mod message;

pub use crate::checksum::{CRC, checksum};
pub use frame::{Frame, FrameError, Header, Receiver};
pub use message::{DeviceMessage, HostMessage, Report};

/// Version of the protocol; another one is refused.
pub const PROTOCOL: u16 = 2;

/// CRC-32 of the messages' grammar: two ends that differ in any message refuse each other.
pub const SCHEMA: u32 = CRC.checksum(include_bytes!("schema.txt"));

#[cfg(test)]
pub(crate) mod tests;
