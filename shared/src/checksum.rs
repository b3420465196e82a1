//! The CRC-32 of frames and saved images.

use crc::{CRC_32_ISO_HDLC, Crc, Digest, Table};

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
#[cfg(feature = "link")]
#[must_use]
pub fn checksum(bytes: &[u8]) -> u32 {
    let mut sum = Checksum::new();
    sum.update(bytes);
    sum.finalize()
}
