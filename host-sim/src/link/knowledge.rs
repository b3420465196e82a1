//! All a mind was told and has learnt, as one file.
//!
//! | bytes | |
//! |---|---|
//! | 8 | `AMPMIND` and a zero |
//! | 2 | version of this layout |
//! | 4 | checksum of the messages' grammar, which the parts depend on |
//! | 5 × (4 + length) | length and bytes of configuration, situations, changes, actions, memory, as on the wire |
//! | 4 | CRC-32 of everything before |
//!
//! Numbers are little-endian.

use super::{Fingerprint, LinkError, Session, next_number};
use crate::error::BadInput;
use crate::pilot::SimState;
use crate::plot::demo::save;
use amp::config::Config;
use amp::controller::Part as StatePart;
use amp::node::MOST_CONFIG;
use amp::som::Grid;
use amp::wire::message::{Clock, ModeReport, Part, Refusal};
use amp::wire::{CRC, SCHEMA};
use std::path::Path;

const MAGIC: &[u8; 8] = b"AMPMIND\0";
const VERSION: u16 = 1;

/// The parts in the file's order.
const PARTS: [Part; 5] = [
    Part::Config,
    Part::Situations,
    Part::Changes,
    Part::Actions,
    Part::Memory,
];

/// What a mind was told and has learnt: the bytes of each part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Knowledge {
    parts: [Vec<u8>; 5],
}

impl Knowledge {
    /// Reads everything from a mind with an open session that stands still.
    ///
    /// # Errors
    /// [`LinkError`]; a refusal while the robot explores, learns or seeks.
    pub fn pull(session: &mut Session) -> Result<Self, LinkError> {
        refuse_moving(session)?;
        Self::read(session)
    }

    /// Reads everything, whatever the mind does meanwhile.
    pub(crate) fn read(session: &mut Session) -> Result<Self, LinkError> {
        let mut parts = [const { Vec::new() }; 5];
        for (bytes, part) in parts.iter_mut().zip(PARTS) {
            *bytes = session.read_part(part)?;
        }
        Ok(Self { parts })
    }

    /// Writes everything to a mind that stands still, and makes sure of it by opening the next session.
    ///
    /// # Errors
    /// [`LinkError`]; a refusal while the robot explores, learns or seeks.
    pub fn push(&self, session: &mut Session) -> Result<(), LinkError> {
        refuse_moving(session)?;
        // The configuration comes last: a mind that is cut off before has its old one with maps that are read the same.
        for (bytes, part) in self.parts.iter().zip(PARTS).rev() {
            session.write_part(part, bytes)?;
        }
        let hello = session.open(next_number(session.number()), Clock::Device)?;
        match Fingerprint::from(&hello)
            .differences(&self.fingerprint())
            .first()
        {
            Some(what) => Err(LinkError::Unlike { what }),
            None => Ok(()),
        }
    }

    /// What a mind in this process was told and has learnt.
    ///
    /// # Errors
    /// When the configuration is none a mind can send.
    pub fn of(config: &Config<16>, state: &SimState) -> Result<Self, LinkError> {
        let part = |part: StatePart| {
            let mut bytes = vec![0; state.part_len(part)];
            state.read_part(part, 0, &mut bytes);
            bytes
        };
        Ok(Self {
            parts: [
                Self::of_config(config)?,
                part(StatePart::Situations),
                part(StatePart::Changes),
                part(StatePart::Actions),
                part(StatePart::Memory),
            ],
        })
    }

    /// A configuration as on the wire.
    pub(super) fn of_config(config: &Config<16>) -> Result<Vec<u8>, LinkError> {
        let mut buffer = [0; MOST_CONFIG];
        match postcard::to_slice(config, &mut buffer) {
            Ok(bytes) => Ok(bytes.to_vec()),
            Err(_) => Err(LinkError::Refused(Refusal::Config)),
        }
    }

    /// Its checksums as a mind says them.
    #[must_use]
    pub fn fingerprint(&self) -> Fingerprint {
        let [config, situations, changes, actions, memory] = &self.parts;
        let mut maps = CRC.digest();
        for map in [situations, changes, actions] {
            maps.update(map);
        }
        Fingerprint {
            config_crc: CRC.checksum(config),
            maps_crc: maps.finalize(),
            memory_crc: CRC.checksum(memory),
        }
    }

    /// The configuration.
    #[must_use]
    pub fn config(&self) -> Option<Config<16>> {
        postcard::from_bytes(&self.parts[0]).ok()
    }

    /// Maps and memory as a state.
    ///
    /// # Errors
    /// A refusal when a part has no length it may have.
    pub fn state(&self) -> Result<SimState, LinkError> {
        let mut state = SimState::new(Grid::rectangle(4, 4));
        let parts = [
            StatePart::Situations,
            StatePart::Changes,
            StatePart::Actions,
            StatePart::Memory,
        ];
        for (part, bytes) in parts.into_iter().zip(&self.parts[1..]) {
            let written = state.write_part(part, 0, bytes);
            written.map_err(|why| LinkError::Refused(Refusal::Piece(why)))?;
            if state.part_len(part) != bytes.len() {
                return Err(LinkError::Unlike { what: "maps" });
            }
        }
        Ok(state)
    }

    /// Samples in the memory.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.parts[4].len() / SimState::SAMPLE_BYTES
    }

    /// The file's bytes.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut file = MAGIC.to_vec();
        file.extend(VERSION.to_le_bytes());
        file.extend(SCHEMA.to_le_bytes());
        for part in &self.parts {
            file.extend((part.len() as u32).to_le_bytes());
            file.extend(part);
        }
        let crc = CRC.checksum(&file);
        file.extend(crc.to_le_bytes());
        file
    }

    /// Reads a file's bytes.
    ///
    /// # Errors
    /// Half a sentence that says why they are no such file.
    pub fn from_bytes(file: &[u8]) -> Result<Self, &'static str> {
        const CUT: &str = "it is cut off or damaged";
        let rest = file.strip_prefix(MAGIC);
        let rest = rest.ok_or("it holds no mind (see `host-sim link --help`, pull)")?;
        let (version, rest) = rest.split_first_chunk().ok_or(CUT)?;
        let (schema, _) = rest.split_first_chunk().ok_or(CUT)?;
        if u16::from_le_bytes(*version) != VERSION || u32::from_le_bytes(*schema) != SCHEMA {
            return Err("it was written by another version of this program");
        }
        let (text, crc) = file.split_last_chunk().ok_or(CUT)?;
        if CRC.checksum(text) != u32::from_le_bytes(*crc) {
            return Err(CUT);
        }
        let mut rest = text.get(MAGIC.len() + 6..).ok_or(CUT)?;
        let mut parts = [const { Vec::new() }; 5];
        for part in &mut parts {
            let (length, bytes) = rest.split_first_chunk().ok_or(CUT)?;
            let length = u32::from_le_bytes(*length) as usize;
            let (bytes, after) = bytes.split_at_checked(length).ok_or(CUT)?;
            *part = bytes.to_vec();
            rest = after;
        }
        let knowledge = Self { parts };
        match (rest, knowledge.config(), knowledge.state()) {
            ([], Some(_), Ok(_)) => Ok(knowledge),
            _ => Err("its parts are not those of a mind with 16 sonars and 16 neurons to a map"),
        }
    }

    /// Writes the file: whole or not at all.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), BadInput> {
        let name = path.file_name().and_then(|name| name.to_str());
        let name = name.ok_or_else(|| BadInput::file(path, "is no name of a file"))?;
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        save(folder, name, &self.to_bytes())?;
        Ok(())
    }

    /// Reads a file.
    ///
    /// # Errors
    /// When it cannot be read or holds no mind.
    pub fn load(path: &Path) -> Result<Self, BadInput> {
        let file = std::fs::read(path).map_err(|error| BadInput::file(path, error))?;
        Self::from_bytes(&file).map_err(|why| BadInput::file(path, why))
    }
}

/// Refuses when parts may not be written, before anything is.
fn refuse_moving(session: &mut Session) -> Result<(), LinkError> {
    match session.mode()? {
        ModeReport::Idle | ModeReport::Stopped(_) => Ok(()),
        ModeReport::Explore { .. } | ModeReport::Learn | ModeReport::Seek => {
            Err(LinkError::Refused(Refusal::Moving))
        }
    }
}
