//! From messages to frames and back.

use super::{checksum, cobs};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

/// Longest frame with its zero, bytes.
pub const MAX_FRAME: usize = 256;

/// Longest header and message in postcard's form, bytes: a frame less COBS's byte, the zero and the
/// CRC.
pub(crate) const MAX_BODY: usize = MAX_FRAME - 2 - CRC_BYTES;

const CRC_BYTES: usize = 4;

/// What stands before every message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// Session the frame belongs to, chosen by the host in its hello; 0 = none.
    pub session: u16,
    /// Number of the frame among its sender's in the session, modulo 2¹⁶.
    pub seq: u16,
}

/// Why bytes are no frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameError {
    /// The bytes are not COBS, too short or too long.
    Shape,
    /// The CRC does not match.
    Crc,
    /// Sound, but no message of this protocol.
    Content {
        /// Its header.
        header: Header,
    },
    /// The message does not fit into a frame (sending only).
    TooLong,
}

impl core::fmt::Display for FrameError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Shape => "no frame",
            Self::Crc => "wrong CRC",
            Self::Content { .. } => "an unknown message",
            Self::TooLong => "the message does not fit into a frame",
        })
    }
}

impl core::error::Error for FrameError {}

/// A frame ready to be sent, zero at its end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frame {
    bytes: [u8; MAX_FRAME],
    length: usize,
}

impl Frame {
    /// Nothing.
    pub const EMPTY: Self = Self {
        bytes: [0; MAX_FRAME],
        length: 0,
    };

    /// Packs a message.
    ///
    /// # Errors
    /// [`FrameError::TooLong`].
    pub fn pack<M: Serialize>(header: Header, message: &M) -> Result<Self, FrameError> {
        let mut frame = Self::EMPTY;
        frame.fill(header, message).map(|()| frame)
    }

    /// Packs a message into this frame, where it stays: a frame is much to copy.
    ///
    /// # Errors
    /// [`FrameError::TooLong`]; the frame is empty then.
    pub fn fill<M: Serialize>(&mut self, header: Header, message: &M) -> Result<(), FrameError> {
        self.length = 0;
        let body = self.bytes.get_mut(1..MAX_BODY.wrapping_add(1));
        let body = body.ok_or(FrameError::TooLong)?;
        let used = postcard::to_slice(&(header, message), body)
            .map_err(|_| FrameError::TooLong)?
            .len();
        let end = used.wrapping_add(1);
        let (text, rest) = (self.bytes)
            .split_at_mut_checked(end)
            .ok_or(FrameError::TooLong)?;
        let crc = checksum(text.get(1..).unwrap_or(&[])).to_le_bytes();
        for (place, byte) in rest.iter_mut().zip(crc) {
            *place = byte;
        }
        // The zero at the end stands behind the coded bytes.
        let coded = end.wrapping_add(CRC_BYTES);
        let bytes = self.bytes.get_mut(..=coded).ok_or(FrameError::TooLong)?;
        if let Some((zero, coded)) = bytes.split_last_mut() {
            *zero = 0;
            cobs::encode(coded).ok_or(FrameError::TooLong)?;
        }
        self.length = coded.wrapping_add(1);
        Ok(())
    }

    /// The bytes to send.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&[])
    }
}

/// Unpacks a frame, given without its zero.
///
/// # Errors
/// [`FrameError`]: a damaged frame is never a message (a CRC-32 lets through fewer than one of 10⁹
/// damaged frames).
// Its buffer is to leave the stack before the message is dealt with.
#[inline(never)]
pub fn unpack<M: DeserializeOwned>(frame: &[u8]) -> Result<(Header, M), FrameError> {
    let mut body = [0; cobs::MOST];
    let length = cobs::decode(frame, &mut body).ok_or(FrameError::Shape)?;
    let whole = body.get(..length).ok_or(FrameError::Shape)?;
    let (text, crc) = whole
        .split_last_chunk::<CRC_BYTES>()
        .ok_or(FrameError::Shape)?;
    if checksum(text) != u32::from_le_bytes(*crc) {
        return Err(FrameError::Crc);
    }
    let (header, message) =
        postcard::take_from_bytes::<Header>(text).map_err(|_| FrameError::Shape)?;
    match postcard::take_from_bytes(message) {
        Ok((message, [])) => Ok((header, message)),
        _ => Err(FrameError::Content { header }),
    }
}

/// Collects bytes until a zero ends a frame. Work per byte is constant; bytes beyond the longest
/// frame are dropped with everything up to the next zero.
#[derive(Debug, Clone)]
pub struct Receiver {
    buffer: [u8; MAX_FRAME],
    length: usize,
    ended: bool,
    oversized: u32,
}

impl Default for Receiver {
    fn default() -> Self {
        Self::new()
    }
}

impl Receiver {
    /// Nothing received.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            buffer: [0; MAX_FRAME],
            length: 0,
            ended: false,
            oversized: 0,
        }
    }

    /// Takes a byte; returns the frame it ends, without its zero. Empty frames (a zero after a
    /// zero) are no frames.
    pub fn push(&mut self, byte: u8) -> Option<&[u8]> {
        if self.ended {
            (self.length, self.ended) = (0, false);
        }
        if byte != 0 {
            if let Some(place) = self.buffer.get_mut(self.length) {
                *place = byte;
            }
            // One beyond the buffer marks a frame that is too long.
            self.length = self.length.saturating_add(1).min(MAX_FRAME);
            return None;
        }
        self.ended = true;
        if self.length >= MAX_FRAME {
            self.oversized = self.oversized.saturating_add(1);
            return None;
        }
        self.buffer
            .get(..self.length)
            .filter(|frame| !frame.is_empty())
    }

    /// Frames that were too long so far.
    #[must_use]
    pub const fn oversized(&self) -> u32 {
        self.oversized
    }
}
