//! The saved image: configuration, body, maps, memory, places and goals as bytes that survive a
//! loss of power. The chip stores it in flash, a desktop machine in a file; the bytes are the same.
//!
//! ```text
//! image  = "AMPS" record…
//! record = length:u8 body zeros          zeros up to a multiple of 4 bytes; numbers little-endian
//! body   = 00 layout:u16 grammar:u32 generation:u32 sensors:u8 neurons:u8 samples:u16      the first
//!        | 01 part:u8 offset:u16 bytes    a chunk of a part, as on the wire; maps without training are left out,
//!        |                                and so are body and places of a robot with a held ring
//!        | 02 seed:u64                    the state of the controller's random generator
//!        | 03 name:[u8; 12] goal          a saved goal, in postcard's form; without a name the present one
//!        | 04 crc:u32                     the last: CRC-32 of everything before it
//! ```
//!
//! An image is written record by record and is valid only with its last record, whose checksum
//! covers all others. Framing, first and last record never change, so every version of the program
//! can check the images of all others; *layout* and *grammar* (the CRC-32 of the grammar from
//! `Config` on) tell whether it can also read them. Not saved: motions and rings under way, a
//! search for a place, counters, the link; where the robot is among its places is not read.
//!
//! Cost: writing takes a record's bytes of memory, reading and checking as much; an image for the
//! Nomad has at most [`MAX_NOMAD`] bytes.

use crate::body::{Body, HeldRing};
use crate::checksum::{CRC, Checksum};
use crate::config::{Config, MAX_CONFIG};
use crate::controller::{State, StatePart};
use crate::goal::{Goal, Name, NamedGoal, NamedGoals};

mod read;
mod write;

pub(crate) use read::RecordFields;
pub use read::{ImageError, ImageInfo, check};

/// Records begin and end at multiples of so many bytes.
pub const WORD: usize = 4;

/// Most bytes of an image with 16 transducers, 16 neurons per map and 100 samples; a test fills
/// one.
pub const MAX_NOMAD: usize = 8_256;

/// Most bytes of an image of a robot with this body, otherwise as [`MAX_NOMAD`].
#[must_use]
pub const fn max_bytes<B: Body<16>>() -> usize {
    let body = bytes_in_records(B::MAX_BYTES, MAX_CHUNK);
    let places = bytes_in_records(B::MAX_PLACES_BYTES, places_piece::<16, B>());
    MAX_NOMAD + body + places
}

/// Most bytes of the records of a part in pieces: each is 5 bytes longer than its piece, and ends
/// with zeros.
const fn bytes_in_records(part: usize, piece: usize) -> usize {
    part.div_ceil(piece) * (piece + 5).next_multiple_of(WORD)
}

/// Bytes of places in one record: whole places.
const fn places_piece<const SENSORS: usize, B: Body<SENSORS>>() -> usize {
    MAX_CHUNK / B::PLACE_BYTES * B::PLACE_BYTES
}

/// How an image begins.
const MAGIC: [u8; WORD] = *b"AMPS";

/// Version of the records, and of the bytes of places.
const LAYOUT: u16 = 1;

/// Most bytes of a part in one record.
const MAX_CHUNK: usize = 160;

/// Most bytes of a record, length and zeros included.
const MAX_RECORD: usize = 256;

/// First byte of each kind of record's body.
mod kind {
    pub(super) const HEAD: u8 = 0;
    pub(super) const CHUNK: u8 = 1;
    pub(super) const RANDOM: u8 = 2;
    pub(super) const GOAL: u8 = 3;
    pub(super) const END: u8 = 4;
}

/// CRC-32 of the grammar of the saved types: everything from the configuration on.
pub const GRAMMAR: u32 = CRC.checksum(saved_grammar(include_bytes!("wire/schema.txt")));

/// The grammar from the line of `Config` on.
const fn saved_grammar(mut text: &[u8]) -> &[u8] {
    while let [_, rest @ ..] = text {
        if matches!(text, [b'\n', b'C', b'o', b'n', b'f', b'i', b'g', b' ', ..]) {
            return text;
        }
        text = rest;
    }
    text
}

/// The first record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Head {
    layout: u16,
    grammar: u32,
    generation: u32,
    sensors: u8,
    neurons: u8,
    samples: u16,
}

/// Numbers of the parts that are read as a whole.
mod whole {
    pub(super) const CONFIG: u8 = 0;
    pub(super) const BODY: u8 = 5;
}

/// Number of the places.
const PLACES: u8 = 6;

/// The other parts in their order, by number from 1 on.
const PARTS: [StatePart; 4] = [
    StatePart::Situations,
    StatePart::Changes,
    StatePart::Actions,
    StatePart::Memory,
];

/// What an image holds, to be written.
#[derive(Debug)]
pub struct Contents<
    'm,
    const SENSORS: usize,
    const NEURONS: usize,
    const SAMPLES: usize,
    B = HeldRing,
> {
    /// The configuration.
    pub config: &'m Config<SENSORS>,
    /// The body.
    pub body: &'m B,
    /// The state: maps and memory.
    pub state: &'m State<SENSORS, NEURONS, SAMPLES>,
    /// The present goal.
    pub goal: &'m Goal<SENSORS>,
    /// The named goals.
    pub goals: &'m NamedGoals<SENSORS>,
}

/// What an image holds, to be read.
#[derive(Debug)]
pub struct ContentsMut<
    'm,
    const SENSORS: usize,
    const NEURONS: usize,
    const SAMPLES: usize,
    B = HeldRing,
> {
    /// The configuration.
    pub config: &'m mut Config<SENSORS>,
    /// The body.
    pub body: &'m mut B,
    /// The state: maps and memory.
    pub state: &'m mut State<SENSORS, NEURONS, SAMPLES>,
    /// The present goal.
    pub goal: &'m mut Goal<SENSORS>,
    /// The named goals.
    pub goals: &'m mut NamedGoals<SENSORS>,
}

#[cfg(test)]
mod tests;
