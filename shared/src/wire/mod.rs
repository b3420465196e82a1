//! The link's wire format: messages, frames and checksums between a host and the device.
//!
//! A *frame* is `COBS(postcard(header, message) + CRC-32) 0`, at most 256 bytes; `PROTOCOL.md`
//! beside this crate's manifest describes it for a stranger. [`frame`] turns messages into frames
//! and back, [`message`] holds the messages. Enumerations grow at their ends only; [`SCHEMA`]
//! changes whenever a message does.

pub mod cobs;
pub mod frame;
pub mod message;

pub use frame::{Frame, FrameError, Header, Receiver};
pub use message::{DeviceMessage, HostMessage, Report};

use crc::{CRC_32_ISO_HDLC, Crc, Digest, Table};

/// Version of the protocol; another one is refused.
pub const PROTOCOL: u16 = 2;

/// CRC-32 of the messages' grammar: two ends that differ in any message refuse each other.
pub const SCHEMA: u32 = CRC.checksum(include_bytes!("schema.txt"));

/// The CRC-32 of Ethernet, zlib and PNG: polynomial 0x04C11DB7 reflected, start and final
/// exclusive-or 0xFFFFFFFF; the check value of "123456789" is 0xCBF43926.
pub const CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// [`CRC`] of bytes that come one piece after the other.
pub(crate) struct Checksum(Digest<'static, u32, Table<1>>);

impl Checksum {
    pub(crate) const fn new() -> Self {
        Self(CRC.digest())
    }

    // One copy of it in a program: the loop is unrolled wherever it stands.
    #[inline(never)]
    pub(crate) fn update(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    pub(crate) const fn finalize(self) -> u32 {
        self.0.finalize()
    }
}

/// [`CRC`] of these bytes.
#[must_use]
pub fn checksum(bytes: &[u8]) -> u32 {
    let mut sum = Checksum::new();
    sum.update(bytes);
    sum.finalize()
}

#[cfg(test)]
pub(crate) mod tests;
