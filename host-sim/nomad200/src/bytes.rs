//! Encodes and decodes the Nomad's numbers: little-endian, negative ones as sign and magnitude.
//!
//! The topmost bit is the sign, in 16 and in 32 bits. A negative zero decodes as zero.

use std::fmt;

/// A payload of the wrong length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LengthError {
    /// Bytes needed so far.
    pub need: usize,
    /// Bytes present.
    pub got: usize,
}

impl fmt::Display for LengthError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} bytes where the message takes {}",
            self.got, self.need
        )
    }
}

impl std::error::Error for LengthError {}

const SIGN_16: u16 = 1 << 15;
const SIGN_32: u32 = 1 << 31;

/// Reads a payload from the front.
#[derive(Debug, Clone)]
pub(super) struct PayloadReader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> PayloadReader<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], LengthError> {
        let end = self.at + N;
        let wrong = LengthError {
            need: end,
            got: self.bytes.len(),
        };
        let bytes = self.bytes.get(self.at..end).ok_or(wrong)?;
        self.at = end;
        bytes.try_into().map_err(|_| wrong)
    }

    pub(super) fn u8(&mut self) -> Result<u8, LengthError> {
        let [byte] = self.array()?;
        Ok(byte)
    }

    pub(super) fn bytes<const N: usize>(&mut self) -> Result<[u8; N], LengthError> {
        self.array()
    }

    pub(super) fn u16(&mut self) -> Result<u16, LengthError> {
        Ok(u16::from_le_bytes(self.array()?))
    }

    pub(super) fn u32(&mut self) -> Result<u32, LengthError> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    /// A signed 16-bit number.
    pub(super) fn i16(&mut self) -> Result<i16, LengthError> {
        let word = self.u16()?;
        // 15 bits always fit.
        let magnitude = (word & !SIGN_16) as i16;
        Ok(if word & SIGN_16 != 0 {
            -magnitude
        } else {
            magnitude
        })
    }

    /// A signed 32-bit number.
    pub(super) fn i32(&mut self) -> Result<i32, LengthError> {
        let word = self.u32()?;
        // 31 bits always fit.
        let magnitude = (word & !SIGN_32) as i32;
        Ok(if word & SIGN_32 != 0 {
            -magnitude
        } else {
            magnitude
        })
    }

    pub(super) fn i16s<const N: usize>(&mut self) -> Result<[i16; N], LengthError> {
        let mut numbers = [0; N];
        for number in &mut numbers {
            *number = self.i16()?;
        }
        Ok(numbers)
    }

    pub(super) fn u16s<const N: usize>(&mut self) -> Result<[u16; N], LengthError> {
        let mut numbers = [0; N];
        for number in &mut numbers {
            *number = self.u16()?;
        }
        Ok(numbers)
    }

    /// Checks that nothing is left.
    pub(super) fn end(self) -> Result<(), LengthError> {
        if self.at == self.bytes.len() {
            return Ok(());
        }
        Err(LengthError {
            need: self.at,
            got: self.bytes.len(),
        })
    }
}

/// Appends a signed number; saturates at 15 bits of magnitude.
pub(super) fn put_i16(out: &mut Vec<u8>, number: i32) {
    let magnitude = number.unsigned_abs().min(u32::from(!SIGN_16)) as u16;
    let sign = if number < 0 { SIGN_16 } else { 0 };
    out.extend_from_slice(&(magnitude | sign).to_le_bytes());
}

/// Appends a signed number; saturates at 31 bits of magnitude.
pub(super) fn put_i32(out: &mut Vec<u8>, number: i32) {
    let magnitude = number.unsigned_abs().min(!SIGN_32);
    let sign = if number < 0 { SIGN_32 } else { 0 };
    out.extend_from_slice(&(magnitude | sign).to_le_bytes());
}

pub(super) fn put_u16(out: &mut Vec<u8>, number: u16) {
    out.extend_from_slice(&number.to_le_bytes());
}

pub(super) fn put_u32(out: &mut Vec<u8>, number: u32) {
    out.extend_from_slice(&number.to_le_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_numbers_are_sign_and_magnitude() {
        let mut out = Vec::new();
        put_i16(&mut out, -50);
        put_i16(&mut out, 100);
        put_i32(&mut out, -2);
        assert_eq!(out, [0x32, 0x80, 0x64, 0, 2, 0, 0, 0x80]);
        let mut reader = PayloadReader::new(&out);
        assert_eq!(reader.i16s(), Ok([-50, 100]));
        assert_eq!(reader.i32(), Ok(-2));
        assert_eq!(reader.end(), Ok(()));
        // A negative zero is zero.
        assert_eq!(PayloadReader::new(&[0, 0x80]).i16(), Ok(0));
    }

    #[test]
    fn what_does_not_fit_is_the_nearest_that_does() {
        for (number, back) in [
            (40_000, i16::MAX),
            (-40_000, -i16::MAX),
            (-32_768, -i16::MAX),
        ] {
            let mut out = Vec::new();
            put_i16(&mut out, number);
            assert_eq!(PayloadReader::new(&out).i16(), Ok(back));
        }
        let mut out = Vec::new();
        put_i32(&mut out, i32::MIN);
        assert_eq!(PayloadReader::new(&out).i32(), Ok(-i32::MAX));
    }

    #[test]
    fn too_short_and_too_long_say_by_how_much() {
        let mut reader = PayloadReader::new(&[1, 2, 3]);
        assert_eq!(reader.u16(), Ok(0x0201));
        assert_eq!(reader.u16(), Err(LengthError { need: 4, got: 3 }));
        assert_eq!(reader.end(), Err(LengthError { need: 2, got: 3 }));
    }
}
