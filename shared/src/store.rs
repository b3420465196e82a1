//! The saved image: all a mind was told and has learnt, as bytes that outlive a loss of power. The chip keeps it in its
//! flash, a desktop machine in a file; both hold the same bytes.
//!
//! ```text
//! image  = "AMPS" record…
//! record = length:u8 body zeros          body in postcard's form, zeros up to a multiple of 4 bytes
//! body   = 0 layout:u16 grammar:u32 generation:u32 sensors:u8 neurons:u8 samples:u16      the first
//!        | 1 part:Part offset:u16 bytes:vec<u8>      a piece, as on the wire; maps that were never learnt are left out
//!        | 2 seed:u64                                of the mind's randomness from here on
//!        | 3 name:Name goal:Goal                     a goal that is kept; without a name the present one
//!        | 4 crc:[u8; 4]                             the last: CRC-32 of everything before it, lowest byte first
//! ```
//!
//! An image is written piece by piece and is one only with its last record: whatever is cut short, torn or damaged before is
//! none. Framing, first and last record stay as they are for good, so that any version of a program finds its way through
//! any other's images; *layout* and *grammar* (the CRC-32 of the grammar's part that is kept) say whether it can read them.
//! Not kept: what is under way (motions, rings, a search for a place), counters, the link.
//!
//! Cost: writing takes a record's bytes of memory, reading and checking as much; an image of the Nomad's mind has at most
//! [`MOST_NOMAD`] bytes.

use crate::config::Config;
use crate::controller::{Part as StatePart, State};
use crate::goal::{Goal, KeptGoal, KeptGoals, Name};
use crate::node::MOST_CONFIG;
use crate::wire::CRC;
use crate::wire::message::{MOST_PIECE, Part};
use heapless::Vec;
use serde::{Deserialize, Serialize};

mod read;
mod write;

pub use read::{Fault, Found, check};

/// Records begin and end at multiples of so many bytes.
pub const WORD: usize = 4;

/// Most bytes of an image of a mind with 16 transducers, 16 neurons to a map and 100 samples; a test fills one.
pub const MOST_NOMAD: usize = 8_256;

/// How an image begins.
const MAGIC: [u8; WORD] = *b"AMPS";

/// Version of the records.
const LAYOUT: u16 = 1;

/// Most bytes of a record, length and zeros included.
const MOST_RECORD: usize = 256;

/// First byte of the last record's body.
const END: u8 = 4;

/// CRC-32 of the grammar of what is kept: everything from the configuration on.
pub const GRAMMAR: u32 = CRC.checksum(kept(include_bytes!("wire/schema.txt")));

/// The grammar from the line of `Config` on.
const fn kept(mut text: &[u8]) -> &[u8] {
    while let [_, rest @ ..] = text {
        if matches!(text, [b'\n', b'C', b'o', b'n', b'f', b'i', b'g', b' ', ..]) {
            return text;
        }
        text = rest;
    }
    text
}

/// The first record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct Head {
    layout: u16,
    grammar: u32,
    generation: u32,
    sensors: u8,
    neurons: u8,
    samples: u16,
}

/// A record; see the module's head.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
enum Record<'a, const SENSORS: usize> {
    Head(Head),
    Piece {
        part: Part,
        offset: u16,
        bytes: &'a [u8],
    },
    Random {
        seed: u64,
    },
    Goal(KeptGoal<SENSORS>),
    End {
        crc: [u8; 4],
    },
}

/// The parts of a state.
const STATE_PARTS: [(Part, StatePart); 4] = [
    (Part::Situations, StatePart::Situations),
    (Part::Changes, StatePart::Changes),
    (Part::Actions, StatePart::Actions),
    (Part::Memory, StatePart::Memory),
];

/// What is saved of a mind.
#[derive(Debug)]
pub struct Contents<'m, const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize> {
    /// What it was told.
    pub config: &'m Config<SENSORS>,
    /// What it has learnt.
    pub state: &'m State<SENSORS, NEURONS, SAMPLES>,
    /// What it is to pursue.
    pub goal: &'m Goal<SENSORS>,
    /// What it may be told to pursue.
    pub kept: &'m KeptGoals<SENSORS>,
}

/// A mind to read an image into.
#[derive(Debug)]
pub struct ContentsMut<'m, const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize> {
    /// What it was told.
    pub config: &'m mut Config<SENSORS>,
    /// What it has learnt.
    pub state: &'m mut State<SENSORS, NEURONS, SAMPLES>,
    /// What it is to pursue.
    pub goal: &'m mut Goal<SENSORS>,
    /// What it may be told to pursue.
    pub kept: &'m mut KeptGoals<SENSORS>,
}

#[cfg(test)]
mod tests;
