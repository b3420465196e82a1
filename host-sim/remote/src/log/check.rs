//! Checks an MCAP file completely before it is used.
//!
//! Every length is compared with the file, a limit and its record before memory is allocated; the
//! `mcap` crate does not do that. A *cut off* file ends inside a record or without an end and is
//! valid up to there. Any other defect is *damage*.

use super::fields::FieldReader;
use super::read::Ending;
use crc::{CRC_32_ISO_HDLC, Crc, Table};
use mcap::MAGIC;
use mcap::records::op;
use std::fmt;
use std::io::Read;
use std::ops::Range;

/// Maximum chunk size, before and after compression, bytes. A chunk has 128 KiB plus one message.
pub(super) const MAX_CHUNK_BYTES: u64 = 64 << 20;

/// Maximum size of any other record, bytes.
const MAX_RECORD_BYTES: u64 = 64 << 20;

/// Size of opcode and length of a record, bytes.
const PREFIX_BYTES: usize = 1 + 8;

/// The CRC-32 of MCAP.
const CRC: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISO_HDLC);

/// Records between the header and the end of the data.
const DATA: &[u8] = &[op::CHUNK, op::MESSAGE_INDEX, op::DATA_END];

/// Records after the end of the data.
const SUMMARY: &[u8] = &[
    op::SCHEMA,
    op::CHANNEL,
    op::STATISTICS,
    op::CHUNK_INDEX,
    op::SUMMARY_OFFSET,
    op::FOOTER,
];

/// Position and kind of damage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LogDamage {
    /// Offset of the record in the file, bytes; of the chunk, if it is inside one.
    pub at: usize,
    /// Kind of damage.
    pub defect: LogDefect,
}

/// Kind of damage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LogDefect {
    /// A record of an unexpected kind.
    Kind(u8),
    /// A record longer than the limit.
    TooLong(u64),
    /// A record that goes beyond the end of a finished file.
    BeyondEnd,
    /// A record whose length contradicts its fields.
    Length,
    /// A chunk that is not compressed with LZ4.
    Compression,
    /// A chunk that does not decompress to its size.
    Decompression,
    /// A checksum mismatch in this part of the file.
    Checksum(&'static str),
    /// A message on an unknown channel, or two different definitions of a channel.
    Channel,
    /// A message out of sequence.
    Number {
        /// Number after that of the message before.
        expected: u32,
        /// Number of the message.
        found: u32,
    },
    /// The file does not end with the magic bytes.
    EndMagic,
}

impl fmt::Display for LogDamage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "is damaged at byte {}: {}", self.at, self.defect)
    }
}

impl fmt::Display for LogDefect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Kind(kind) => write!(f, "a record of kind 0x{kind:02x} has no place there"),
            Self::TooLong(bytes) => write!(f, "a record of {bytes} bytes is too long"),
            Self::BeyondEnd => f.write_str("a record goes beyond the end of the file"),
            Self::Length => f.write_str("a record's length is not that of its fields"),
            Self::Compression => f.write_str("a chunk is not compressed with LZ4"),
            Self::Decompression => f.write_str("a chunk cannot be decompressed"),
            Self::Checksum(part) => write!(f, "{part} does not match its checksum"),
            Self::Channel => f.write_str("a message or channel contradicts the list of channels"),
            Self::Number { expected, found } => {
                write!(f, "message {found} stands where message {expected} belongs")
            }
            Self::EndMagic => f.write_str("the file's last bytes are not those of MCAP"),
        }
    }
}

impl std::error::Error for LogDamage {}

/// A chunk with a matching checksum.
#[derive(Debug, Clone)]
pub(super) struct Chunk {
    /// Offset of its record.
    pub at: usize,
    /// Its compressed records.
    compressed: Range<usize>,
    /// Size of its records, at most [`MAX_CHUNK_BYTES`].
    size: usize,
}

impl Chunk {
    /// Decompresses its records.
    ///
    /// # Errors
    /// Bytes that are not LZ4, or another size.
    pub fn records(&self, file: &[u8]) -> Result<Vec<u8>, LogDamage> {
        let damage = || damage(self.at, LogDefect::Decompression);
        let compressed = file.get(self.compressed.clone()).ok_or_else(damage)?;
        let decoder = lz4::Decoder::new(compressed).map_err(|_| damage())?;
        let mut records = Vec::with_capacity(self.size);
        // One byte more, to detect surplus data.
        let read = decoder.take(self.size as u64 + 1).read_to_end(&mut records);
        match read {
            Ok(size) if size == self.size => Ok(records),
            _ => Err(damage()),
        }
    }
}

/// A record of the file.
struct FileRecord<'a> {
    at: usize,
    kind: u8,
    body: &'a [u8],
}

impl FileRecord<'_> {
    fn end(&self) -> usize {
        self.at + PREFIX_BYTES + self.body.len()
    }

    fn body_at(&self) -> usize {
        self.at + PREFIX_BYTES
    }
}

fn damage(at: usize, defect: LogDefect) -> LogDamage {
    LogDamage { at, defect }
}

/// Checks the chunks and the end of a file that begins with the magic bytes.
///
/// # Errors
/// The first damage.
pub(super) fn check(file: &[u8]) -> Result<(Vec<Chunk>, Ending), LogDamage> {
    let mut chunks = Vec::new();
    let Some(header) = next(file, MAGIC.len(), &[op::HEADER])? else {
        return Ok((chunks, Ending::Interrupted));
    };
    let mut at = header.end();
    loop {
        let Some(record) = next(file, at, DATA)? else {
            return Ok((chunks, Ending::Interrupted));
        };
        at = record.end();
        match record.kind {
            op::CHUNK => chunks.push(chunk(file, &record)?),
            op::DATA_END => {
                compare(file, 0..record.at, record.body, "the data before it")
                    .map_err(|defect| damage(record.at, defect))?;
                return Ok((chunks, summary(file, at)?));
            }
            // Message indexes are for other tools and are not used here.
            _ => {}
        }
    }
}

/// Checks the records after the data.
fn summary(file: &[u8], start: usize) -> Result<Ending, LogDamage> {
    let mut at = start;
    loop {
        let Some(record) = next(file, at, SUMMARY)? else {
            return Ok(Ending::Interrupted);
        };
        at = record.end();
        if record.kind == op::FOOTER {
            // The checksum is the footer's last field and covers everything before it.
            let refuse = |defect| damage(record.at, defect);
            let checksum = record.body.last_chunk::<4>();
            let checksum = checksum.ok_or_else(|| refuse(LogDefect::Length))?;
            let covered = start..at - checksum.len();
            compare(file, covered, checksum, "the summary").map_err(refuse)?;
            break;
        }
    }
    let rest = file.get(at..).unwrap_or(&[]);
    match rest {
        rest if rest == MAGIC => Ok(Ending::Complete),
        rest if MAGIC.starts_with(rest) => Ok(Ending::Interrupted),
        _ => Err(damage(at, LogDefect::EndMagic)),
    }
}

/// The record at an offset; `None` where the file was cut off.
fn next<'a>(file: &'a [u8], at: usize, kinds: &[u8]) -> Result<Option<FileRecord<'a>>, LogDamage> {
    let refuse = |defect| Err(damage(at, defect));
    // In a finished file no record reaches beyond the final magic bytes.
    let is_finished = file.len() > MAGIC.len() && file.ends_with(MAGIC);
    let cut_off = || match is_finished {
        true => refuse(LogDefect::BeyondEnd),
        false => Ok(None),
    };
    let mut fields = FieldReader::of(file.get(at..).unwrap_or(&[]));
    let Some(kind) = fields.u8() else {
        return cut_off();
    };
    if !kinds.contains(&kind) {
        return refuse(LogDefect::Kind(kind));
    }
    let Some(length) = fields.u64() else {
        return cut_off();
    };
    if length > MAX_RECORD_BYTES {
        return refuse(LogDefect::TooLong(length));
    }
    // Distinguishes a damaged length from a record that was cut off.
    let body = fields.rest();
    if length_by_fields(kind, body).is_some_and(|expected| expected != length) {
        return refuse(LogDefect::Length);
    }
    match body.get(..length as usize) {
        Some(body) => Ok(Some(FileRecord { at, kind, body })),
        None => cut_off(),
    }
}

/// Length of a record by its own fields, bytes; `None` if it has none or they are cut off.
fn length_by_fields(kind: u8, body: &[u8]) -> Option<u64> {
    let mut fields = FieldReader::of(body);
    match kind {
        op::HEADER => {
            let profile = fields.string()?;
            let library = fields.u32()?;
            Some(8 + profile.len() as u64 + u64::from(library))
        }
        op::CHUNK => {
            let head = ChunkHead::read(&mut fields)?;
            Some((head.bytes as u64).saturating_add(head.compressed_size))
        }
        // Channel, length of the entries, 16 bytes per entry.
        op::MESSAGE_INDEX => {
            fields.u16()?;
            Some(6 + u64::from(fields.u32()?))
        }
        op::DATA_END => Some(4),
        op::FOOTER => Some(20),
        _ => None,
    }
}

/// The fields of a chunk in front of its records.
struct ChunkHead<'a> {
    /// Size of this head, bytes.
    bytes: usize,
    size: u64,
    checksum: u32,
    compression: &'a [u8],
    compressed_size: u64,
}

impl<'a> ChunkHead<'a> {
    fn read(fields: &mut FieldReader<'a>) -> Option<Self> {
        let before = fields.rest().len();
        // Times of the first and the last message.
        let (_, _) = (fields.u64()?, fields.u64()?);
        let (size, checksum) = (fields.u64()?, fields.u32()?);
        let (compression, compressed_size) = (fields.string()?, fields.u64()?);
        Some(Self {
            bytes: before - fields.rest().len(),
            size,
            checksum,
            compression,
            compressed_size,
        })
    }
}

/// Checks a chunk's size and checksum.
fn chunk(file: &[u8], record: &FileRecord<'_>) -> Result<Chunk, LogDamage> {
    let refuse = |defect| damage(record.at, defect);
    let head = ChunkHead::read(&mut FieldReader::of(record.body));
    let head = head.ok_or_else(|| refuse(LogDefect::Length))?;
    if head.compression != b"lz4" {
        return Err(refuse(LogDefect::Compression));
    }
    if head.size > MAX_CHUNK_BYTES {
        return Err(refuse(LogDefect::TooLong(head.size)));
    }
    let chunk = Chunk {
        at: record.at,
        compressed: record.body_at() + head.bytes..record.end(),
        size: head.size as usize,
    };
    if CRC.checksum(&chunk.records(file)?) != head.checksum {
        return Err(refuse(LogDefect::Checksum("a chunk")));
    }
    Ok(chunk)
}

/// Compares the checksum of a part of the file.
fn compare(
    file: &[u8],
    part: Range<usize>,
    checksum: &[u8],
    name: &'static str,
) -> Result<(), LogDefect> {
    let found = file.get(part).map(|bytes| CRC.checksum(bytes));
    match found.map(u32::to_le_bytes) {
        Some(found) if found == checksum => Ok(()),
        _ => Err(LogDefect::Checksum(name)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::LogFile;
    use crate::log::fixture::logged;
    use arena::sonar::SonarModel;
    use std::path::Path;

    /// A log that was cut off after the third chunk; offsets of its chunks and of its end.
    fn cut_off() -> (Vec<u8>, Vec<usize>) {
        let mut bytes = logged(SonarModel::Nomad);
        let (chunks, ending) = check(&bytes).unwrap();
        assert_eq!(ending, Ending::Complete);
        let places: Vec<_> = chunks.iter().take(4).map(|chunk| chunk.at).collect();
        bytes.truncate(places[3]);
        assert_eq!(check(&bytes).unwrap().1, Ending::Interrupted);
        (bytes, places)
    }

    fn refused(bytes: &[u8]) -> String {
        let log = LogFile::of(Path::new("a.mcap"), bytes.to_vec());
        log.unwrap_err().to_string()
    }

    #[test]
    fn a_missing_or_duplicate_chunk_is_found_in_a_log_that_was_cut_off() {
        let (bytes, at) = cut_off();
        let chunk = |number: usize| &bytes[at[number]..at[number + 1]];
        let begin = &bytes[..at[1]];
        LogFile::of(Path::new("a.mcap"), [begin, chunk(1)].concat()).unwrap();
        let twice = [begin, chunk(1), chunk(1)].concat();
        let missing = [begin, chunk(2)].concat();
        let swapped = [begin, chunk(2), chunk(1)].concat();
        for (bytes, place) in [(twice, at[2]), (missing, at[1]), (swapped, at[1])] {
            let sentence = refused(&bytes);
            let begin = format!("a.mcap: is damaged at byte {place}: message ");
            assert!(sentence.starts_with(&begin), "{sentence}");
        }
    }

    /// A log that was cut off has no checksum of all its data. The chunk's checksum and LZ4's own
    /// have to cover it.
    #[test]
    fn every_byte_of_a_whole_chunk_counts_though_the_log_was_cut_off() {
        let (bytes, at) = cut_off();
        let compressed = check(&bytes).unwrap().0[1].compressed.clone();
        // After opcode, length, two times and the size.
        let checksum = at[1] + 33..at[1] + 37;
        for place in compressed.step_by(97).chain(checksum) {
            let mut bytes = bytes.clone();
            bytes[place] ^= 0x10;
            let damage = check(&bytes).unwrap_err();
            assert_eq!(damage.at, at[1], "byte {place}");
        }
    }

    #[test]
    fn a_damaged_length_is_no_cut() {
        let (bytes, at) = cut_off();
        // In the third chunk's record, which then seems to exceed the file, and in its index.
        let index = check(&bytes).unwrap().0[2].compressed.end;
        for (place, record) in [(at[2] + 1 + 3, at[2]), (index + 1 + 3, index)] {
            let mut bytes = bytes.clone();
            bytes[place] ^= 1;
            let expected = LogDamage {
                at: record,
                defect: LogDefect::Length,
            };
            assert_eq!(check(&bytes).unwrap_err(), expected);
        }
        // A chunk that continues after the end of the file is cut off.
        let mut whole = bytes;
        whole.truncate(at[2] + 1_000);
        let (chunks, ending) = check(&whole).unwrap();
        assert_eq!((chunks.len(), ending), (2, Ending::Interrupted));
    }

    #[test]
    fn sizes_are_bounded_before_memory_is_taken() {
        let (bytes, at) = cut_off();
        // The uncompressed size follows two times.
        let size_at = at[1] + PREFIX_BYTES + 16;
        let defect = |size: u64| {
            let mut bytes = bytes.clone();
            bytes[size_at..size_at + 8].copy_from_slice(&size.to_le_bytes());
            check(&bytes).unwrap_err()
        };
        let at = at[1];
        for (size, defect_found) in [
            (u64::MAX, LogDefect::TooLong(u64::MAX)),
            (67_108_865, LogDefect::TooLong(67_108_865)),
            // More than LZ4 can produce from these bytes.
            (67_108_864, LogDefect::Decompression),
            (131_000, LogDefect::Decompression),
        ] {
            let expected = LogDamage {
                at,
                defect: defect_found,
            };
            assert_eq!(defect(size), expected, "{size}");
        }
        let mut long = bytes;
        long[at + 1..at + 9].copy_from_slice(&67_108_865_u64.to_le_bytes());
        let expected = LogDamage {
            at,
            defect: LogDefect::TooLong(67_108_865),
        };
        assert_eq!(check(&long).unwrap_err(), expected);
    }

    #[test]
    fn every_byte_outside_the_chunks_counts_in_a_finished_log() {
        let bytes = logged(SonarModel::Nomad);
        let chunks = check(&bytes).unwrap().0;
        let outside = |at: &usize| !chunks.iter().any(|chunk| chunk.compressed.contains(at));
        let places: Vec<_> = (0..bytes.len()).filter(outside).step_by(1_999).collect();
        assert!(places.len() > 20, "{}", places.len());
        for at in places.into_iter().chain(bytes.len() - 37..bytes.len()) {
            let mut bytes = bytes.clone();
            bytes[at] ^= 0x10;
            LogFile::of(Path::new("a.mcap"), bytes).unwrap_err();
        }
    }
}
