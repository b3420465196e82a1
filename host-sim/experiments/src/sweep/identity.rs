//! A sweep's hash, over everything that affects its results.

use arena::world::World;
use crc::{CRC_64_XZ, Crc, Digest};
use std::fmt::{self, Write};

static CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);

/// A checksum (CRC-64/XZ) over the text written to it.
pub struct Hasher(Digest<'static, u64>);

impl Hasher {
    /// The checksum of an empty text.
    pub fn new() -> Self {
        Self(CRC.digest())
    }

    /// Adds a part. The border between two parts counts as well.
    pub fn part(&mut self, part: fmt::Arguments<'_>) {
        // Writing to a checksum cannot fail.
        let _ = self.write_fmt(part);
        self.0.update(&[0]);
    }

    /// Adds a world: its name, start, goal and shapes.
    pub fn world(&mut self, world: &World) {
        self.part(format_args!(
            "{} {:?} {:?} {:?}",
            world.name(),
            world.start(),
            world.goal(),
            world.shapes()
        ));
    }

    /// The checksum as sixteen hexadecimal digits.
    pub fn finish(self) -> String {
        format!("{:016x}", self.0.finalize())
    }
}

impl Write for Hasher {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}
