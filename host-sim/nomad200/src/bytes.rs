//! Numbers as the Nomad writes them: little-endian, negative ones as sign and magnitude.
//!
//! The topmost bit is the sign, the others are the magnitude, in 16 and in 32 bits alike; two's complement would be read
//! as another number. A negative zero reads as zero.

use std::fmt;

/// A payload that is shorter or longer than its message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WrongLength {
    /// Bytes the message needs, as far as it was read.
    pub need: usize,
    /// Bytes there are.
    pub got: usize,
}

impl fmt::Display for WrongLength {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} bytes where the message takes {}",
            self.got, self.need
        )
    }
}

impl std::error::Error for WrongLength {}

const SIGN_16: u16 = 1 << 15;
const SIGN_32: u32 = 1 << 31;

/// Takes a payload apart, byte by byte.
#[derive(Debug, Clone)]
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], WrongLength> {
        let end = self.at + N;
        let wrong = WrongLength {
            need: end,
            got: self.bytes.len(),
        };
        let bytes = self.bytes.get(self.at..end).ok_or(wrong)?;
        self.at = end;
        bytes.try_into().map_err(|_| wrong)
    }

    pub(super) fn u8(&mut self) -> Result<u8, WrongLength> {
        let [byte] = self.array()?;
        Ok(byte)
    }

    pub(super) fn bytes<const N: usize>(&mut self) -> Result<[u8; N], WrongLength> {
        self.array()
    }

    pub(super) fn u16(&mut self) -> Result<u16, WrongLength> {
        Ok(u16::from_le_bytes(self.array()?))
    }

    pub(super) fn u32(&mut self) -> Result<u32, WrongLength> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    /// 16 bits with a sign.
    pub(super) fn i16(&mut self) -> Result<i16, WrongLength> {
        let word = self.u16()?;
        // 15 bits always fit.
        let magnitude = (word & !SIGN_16) as i16;
        Ok(if word & SIGN_16 != 0 {
            -magnitude
        } else {
            magnitude
        })
    }

    /// 32 bits with a sign.
    pub(super) fn i32(&mut self) -> Result<i32, WrongLength> {
        let word = self.u32()?;
        // 31 bits always fit.
        let magnitude = (word & !SIGN_32) as i32;
        Ok(if word & SIGN_32 != 0 {
            -magnitude
        } else {
            magnitude
        })
    }

    pub(super) fn i16s<const N: usize>(&mut self) -> Result<[i16; N], WrongLength> {
        let mut numbers = [0; N];
        for number in &mut numbers {
            *number = self.i16()?;
        }
        Ok(numbers)
    }

    pub(super) fn u16s<const N: usize>(&mut self) -> Result<[u16; N], WrongLength> {
        let mut numbers = [0; N];
        for number in &mut numbers {
            *number = self.u16()?;
        }
        Ok(numbers)
    }

    /// Nothing may be left.
    pub(super) fn end(self) -> Result<(), WrongLength> {
        if self.at == self.bytes.len() {
            return Ok(());
        }
        Err(WrongLength {
            need: self.at,
            got: self.bytes.len(),
        })
    }
}

/// Appends a number with a sign; what 15 bits do not hold becomes the nearest that they do.
pub(super) fn put_i16(out: &mut Vec<u8>, number: i32) {
    let magnitude = number.unsigned_abs().min(u32::from(!SIGN_16)) as u16;
    let sign = if number < 0 { SIGN_16 } else { 0 };
    out.extend_from_slice(&(magnitude | sign).to_le_bytes());
}

/// Appends a number with a sign; what 31 bits do not hold becomes the nearest that they do.
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
        let mut reader = Reader::new(&out);
        assert_eq!(reader.i16s(), Ok([-50, 100]));
        assert_eq!(reader.i32(), Ok(-2));
        assert_eq!(reader.end(), Ok(()));
        // A negative zero is zero.
        assert_eq!(Reader::new(&[0, 0x80]).i16(), Ok(0));
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
            assert_eq!(Reader::new(&out).i16(), Ok(back));
        }
        let mut out = Vec::new();
        put_i32(&mut out, i32::MIN);
        assert_eq!(Reader::new(&out).i32(), Ok(-i32::MAX));
    }

    #[test]
    fn too_short_and_too_long_say_by_how_much() {
        let mut reader = Reader::new(&[1, 2, 3]);
        assert_eq!(reader.u16(), Ok(0x0201));
        assert_eq!(reader.u16(), Err(WrongLength { need: 4, got: 3 }));
        assert_eq!(reader.end(), Err(WrongLength { need: 2, got: 3 }));
    }
}
