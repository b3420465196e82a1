//! Encodes and decodes packets on the line: `01 LEN LEN TYPE payload CK 5C`.
//!
//! LEN (low byte first) counts type, payload and check byte; CK is the sum of all bytes before it,
//! modulo 256. A [`Decoder`] resynchronizes at the next valid packet. A byte 01 in noise may start
//! a packet that never ends; [`Decoder::idle`] discards it.

use super::Kind;

const BEGIN: u8 = 1;
const END: u8 = 0x5c;
/// Bytes in front of the type.
const HEAD: usize = 3;
/// Bytes that LEN does not count: the first byte, LEN and the last byte.
const UNCOUNTED: usize = 4;

/// Largest LEN of a packet to the robot: the client library writes only its low byte.
pub const MAX_TO_ROBOT: usize = 255;

/// Largest accepted LEN of a packet from the robot: the size of the client library's buffer.
pub const MAX_FROM_ROBOT: usize = 4_096;

/// A packet without its frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Packet {
    /// Its type, known or not.
    pub kind: u8,
    /// Its payload.
    pub payload: Vec<u8>,
}

impl Packet {
    /// A packet of a known type.
    #[must_use]
    pub fn new(kind: Kind, payload: Vec<u8>) -> Self {
        Self {
            kind: kind as u8,
            payload,
        }
    }

    /// Encodes the packet; a payload is cut off at 65 533 bytes.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let max = usize::from(u16::MAX) - 2;
        let payload = self.payload.get(..max).unwrap_or(&self.payload);
        // Limited two lines above.
        let length = (payload.len() + 2) as u16;
        let mut bytes = Vec::with_capacity(payload.len() + HEAD + 3);
        bytes.push(BEGIN);
        bytes.extend_from_slice(&length.to_le_bytes());
        bytes.push(self.kind);
        bytes.extend_from_slice(payload);
        bytes.push(sum(&bytes));
        bytes.push(END);
        bytes
    }
}

fn sum(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |sum, &byte| sum.wrapping_add(byte))
}

/// Finds packets in a stream of bytes. It buffers at most one incomplete packet; the cost per byte
/// is bounded by the longest packet.
#[derive(Debug, Clone)]
pub struct Decoder {
    max_length: usize,
    buffer: Vec<u8>,
    /// Bytes outside any packet.
    skipped: u64,
}

/// Beginning of the buffer.
enum Prefix {
    /// No packet.
    Invalid,
    /// An incomplete packet.
    Incomplete,
    /// A complete packet of this length.
    Complete(usize),
}

impl Decoder {
    /// A decoder that accepts packets with a LEN of at most `max_length`.
    #[must_use]
    pub fn new(max_length: usize) -> Self {
        Self {
            max_length,
            buffer: Vec::new(),
            skipped: 0,
        }
    }

    /// Decodes bytes; appends complete packets to `found`.
    pub fn push(&mut self, bytes: &[u8], found: &mut Vec<Packet>) {
        for &byte in bytes {
            self.buffer.push(byte);
            self.search(found, false);
        }
    }

    /// Discards an incomplete packet after a silence, and decodes the packets that it hid.
    pub fn idle(&mut self, found: &mut Vec<Packet>) {
        self.search(found, true);
    }

    /// Whether an incomplete packet is buffered.
    #[must_use]
    pub fn is_waiting(&self) -> bool {
        !self.buffer.is_empty()
    }

    /// Number of bytes outside any packet.
    #[must_use]
    pub fn skipped(&self) -> u64 {
        self.skipped
    }

    /// Takes complete packets from the front and skips other bytes; with `give_up` also incomplete
    /// packets.
    fn search(&mut self, found: &mut Vec<Packet>, give_up: bool) {
        let mut from = 0;
        while let Some(buffer) = self.buffer.get(from..).filter(|buffer| !buffer.is_empty()) {
            match self.prefix(buffer) {
                Prefix::Complete(length) => {
                    found.push(Packet {
                        kind: buffer.get(HEAD).copied().unwrap_or(0),
                        payload: buffer.get(HEAD + 1..length - 2).unwrap_or(&[]).to_vec(),
                    });
                    from += length;
                }
                Prefix::Incomplete if !give_up => break,
                Prefix::Incomplete | Prefix::Invalid => {
                    self.skipped += 1;
                    from += 1;
                }
            }
        }
        self.buffer.drain(..from);
    }

    fn prefix(&self, buffer: &[u8]) -> Prefix {
        let length = match *buffer {
            [BEGIN, low, high, ..] => usize::from(u16::from_le_bytes([low, high])),
            [BEGIN] | [BEGIN, _] => return Prefix::Incomplete,
            _ => return Prefix::Invalid,
        };
        // At least type and check byte.
        if length < 2 || length > self.max_length {
            return Prefix::Invalid;
        }
        let Some(packet) = buffer.get(..length + UNCOUNTED) else {
            return Prefix::Incomplete;
        };
        match packet {
            [summed @ .., check, END] if sum(summed) == *check => Prefix::Complete(packet.len()),
            _ => Prefix::Invalid,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn decoded(bytes: &[u8]) -> Vec<Packet> {
        let (mut decoder, mut found) = (Decoder::new(MAX_TO_ROBOT), Vec::new());
        decoder.push(bytes, &mut found);
        found
    }

    /// Derived by hand from the reference.
    #[test]
    fn packets_have_the_librarys_bytes() {
        let cases: [(Kind, &[u8], &[u8]); 4] = [
            (Kind::Gs, &[], &[1, 2, 0, 7, 0x0a, 0x5c]),
            (Kind::St, &[], &[1, 2, 0, 9, 0x0c, 0x5c]),
            (Kind::GetSn, &[], &[1, 2, 0, 0x14, 0x17, 0x5c]),
            (Kind::ConfTm, &[5], &[1, 3, 0, 0x12, 5, 0x1b, 0x5c]),
        ];
        for (kind, payload, bytes) in cases {
            let packet = Packet::new(kind, payload.to_vec());
            assert_eq!(packet.to_bytes(), bytes);
            assert_eq!(decoded(bytes), [packet]);
        }
    }

    #[test]
    fn what_is_damaged_is_no_packet_and_the_next_one_is_found() {
        let good = Packet::new(Kind::ConfTm, vec![5]);
        let bytes = good.to_bytes();
        for place in 0..bytes.len() {
            let mut stream = bytes.clone();
            stream[place] ^= 0x10;
            stream.extend_from_slice(&bytes);
            let (mut decoder, mut found) = (Decoder::new(MAX_TO_ROBOT), Vec::new());
            decoder.push(&stream, &mut found);
            // A longer LEN hides the next packet until the line is silent.
            decoder.idle(&mut found);
            assert_eq!(found, std::slice::from_ref(&good), "byte {place}");
            assert!(!decoder.is_waiting());
        }
    }

    #[test]
    fn a_false_beginning_hides_a_packet_only_for_a_while() {
        let good = Packet::new(Kind::Gs, Vec::new());
        let stream = [&[BEGIN, 200, 0, 7], &good.to_bytes()[..]].concat();
        let (mut decoder, mut found) = (Decoder::new(MAX_TO_ROBOT), Vec::new());
        decoder.push(&stream, &mut found);
        assert!(found.is_empty() && decoder.is_waiting());
        decoder.idle(&mut found);
        assert_eq!(found, [good]);
        assert_eq!(decoder.skipped(), 4);
    }

    #[test]
    fn a_decoder_keeps_no_more_than_one_packet() {
        let mut decoder = Decoder::new(MAX_TO_ROBOT);
        let mut found = Vec::new();
        for round in 0..20_000_u32 {
            decoder.push(&[BEGIN, (round % 256) as u8, 0], &mut found);
            assert!(decoder.buffer.len() <= MAX_TO_ROBOT + UNCOUNTED);
        }
    }

    proptest! {
        #[test]
        fn any_packet_comes_back_byte_by_byte(kind: u8, payload in prop::collection::vec(any::<u8>(), 0..253)) {
            let packet = Packet { kind, payload };
            let (mut decoder, mut found) = (Decoder::new(MAX_TO_ROBOT), Vec::new());
            for byte in packet.to_bytes() {
                prop_assert!(found.is_empty());
                decoder.push(&[byte], &mut found);
            }
            prop_assert_eq!(found, vec![packet]);
            prop_assert_eq!(decoder.skipped(), 0);
        }

        #[test]
        fn after_any_garbage_and_a_pause_the_next_packet_is_found(garbage in prop::collection::vec(any::<u8>(), 0..600)) {
            let good = Packet::new(Kind::St, Vec::new());
            let (mut decoder, mut found) = (Decoder::new(MAX_TO_ROBOT), Vec::new());
            decoder.push(&garbage, &mut found);
            decoder.idle(&mut found);
            decoder.push(&good.to_bytes(), &mut found);
            prop_assert_eq!(found.last(), Some(&good));
            // The same without a pause, once the line is silent.
            let mut stream = garbage;
            stream.extend(good.to_bytes());
            let (mut decoder, mut found) = (Decoder::new(MAX_TO_ROBOT), Vec::new());
            decoder.push(&stream, &mut found);
            decoder.idle(&mut found);
            prop_assert_eq!(found.last(), Some(&good));
        }
    }
}
