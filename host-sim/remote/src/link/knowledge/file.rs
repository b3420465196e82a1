//! A controller's file: the image of [`amp::store`], and what its robot perceived beside ranges.
//!
//! ```text
//! file   = image senses?
//! senses = "AMPM" records crc:u32     SavedSenses in postcard's form; CRC-32 of all before it from "AMPM" on
//! ```
//!
//! A device has no senses: its host perceives what it senses.

use super::Knowledge;
use amp::config::Config;
use amp::som::Grid;
use amp::store::{Contents, ContentsMut};
use amp::wire::CRC;
use files::error::BadInput;
use sim::pilot::SimState;
use sim::senses::SavedSenses;
use std::path::Path;

/// Maximum file size, bytes; an image has at most 132 KiB.
const MAX_FILE_BYTES: u64 = 1 << 20;

/// How the senses begin.
const SENSES: &[u8] = b"AMPM";

/// Generation of an image in a file.
const GENERATION: u32 = 1;

impl Knowledge {
    /// The file's bytes.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let contents = Contents {
            body: &*self.body,
            config: &self.config,
            state: &self.state,
            goal: &self.goal,
            goals: &self.named_goals,
        };
        let mut file = Vec::new();
        let Ok(()) = contents.write(GENERATION, &mut |bytes| {
            file.extend_from_slice(bytes);
            Ok::<_, std::convert::Infallible>(())
        });
        if self.senses != SavedSenses::default() {
            // Records of numbers can always be encoded.
            let section = postcard::to_extend(&self.senses, SENSES.to_vec()).unwrap_or_default();
            file.extend_from_slice(&section);
            file.extend_from_slice(&CRC.checksum(&section).to_le_bytes());
        }
        file
    }

    /// Decodes a file.
    ///
    /// # Errors
    /// A clause that says what is wrong.
    pub fn from_bytes(file: &[u8]) -> Result<Self, String> {
        if !file.starts_with(b"AMPS") {
            return Err("it holds no controller (see `host-sim link --help`, download)".into());
        }
        let fresh = SimState::new(Grid::rectangle(4, 4));
        let mut knowledge = Self::new(Config::recommended(), fresh);
        let mut contents = ContentsMut {
            body: &mut *knowledge.body,
            config: &mut knowledge.config,
            state: &mut knowledge.state,
            goal: &mut knowledge.goal,
            goals: &mut knowledge.named_goals,
        };
        let mut read = |at: usize, out: &mut [u8]| {
            let bytes = file.get(at..at + out.len());
            bytes.map(|bytes| out.copy_from_slice(bytes)).is_some()
        };
        let found = contents.read(&mut read, file.len());
        let found = found.map_err(|fault| fault.to_string())?;
        knowledge.senses = decode_senses(file.get(found.bytes..).unwrap_or(&[]))?;
        Ok(knowledge)
    }

    /// Writes the file, completely or not at all.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), BadInput> {
        let written = files::write(path, &self.to_bytes());
        written.map_err(|error| BadInput::file(path, format!("cannot be written: {error}")))
    }

    /// Reads a file.
    ///
    /// # Errors
    /// When it cannot be read or holds no controller.
    pub fn load(path: &Path) -> Result<Self, BadInput> {
        let file = files::read(path, MAX_FILE_BYTES)?;
        Self::from_bytes(&file).map_err(|why| BadInput::file(path, why))
    }
}

/// Decodes what follows the image.
fn decode_senses(section: &[u8]) -> Result<SavedSenses, String> {
    if section.is_empty() {
        return Ok(SavedSenses::default());
    }
    if !section.starts_with(SENSES) {
        return Err("there are bytes after its end".into());
    }
    let whole = section.split_last_chunk::<4>();
    let sound = whole.filter(|(data, crc)| CRC.checksum(data) == u32::from_le_bytes(**crc));
    let records = sound.and_then(|(data, _)| data.strip_prefix(SENSES));
    let read = records.and_then(|records| postcard::take_from_bytes(records).ok());
    let read = read.filter(|(_, rest)| rest.is_empty());
    read.map(|(senses, _)| senses)
        .ok_or_else(|| "what it perceived beside ranges is damaged".into())
}
