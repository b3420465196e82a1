//! What goes over the link between the robot's base (or a computer in its place) and the mind.
//!
//! A *frame* is `COBS(postcard(header, message) + CRC-32) 0`, at most 256 bytes; `PROTOCOL.md` beside this crate's manifest
//! describes it for a stranger. [`frame`] turns messages into frames and back, [`message`] says what there is to say.
//! Enumerations grow at their ends only; [`SCHEMA`] changes whenever a message does.

pub mod cobs;
pub mod frame;
pub mod message;

pub use frame::{Frame, FrameError, Header, Receiver};
pub use message::{FromMind, Report, ToMind};

use crc::{CRC_32_ISO_HDLC, Crc, Table};

/// Version of the protocol; another one is refused.
pub const PROTOCOL: u16 = 1;

/// CRC-32 of the messages' grammar: two ends that differ in any message refuse each other.
pub const SCHEMA: u32 = CRC.checksum(include_bytes!("schema.txt"));

/// The CRC-32 of Ethernet, zlib and PNG: polynomial 0x04C11DB7 reflected, start and final exclusive-or 0xFFFFFFFF; the
/// check value of "123456789" is 0xCBF43926.
pub const CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

#[cfg(test)]
mod tests;
