//! Reads a log, complete or cut off.

use super::channel;
use super::check::{self, Chunk, LogDamage, LogDefect};
use super::fields::FieldReader;
use super::setup_record::{FORMAT, OLDEST_FORMAT, SetupRecord};
use files::error::BadInput;
use mcap::records::op;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::fmt;
use std::fs::{self, File};
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::slice;

/// Maximum file size, bytes.
const MAX_FILE_BYTES: u64 = 4 << 30;

/// Maximum length of a channel's name, bytes.
const MAX_TOPIC_BYTES: usize = 256;

/// Limit for the text of a JSON error, which may quote the message; characters.
const MAX_QUOTED: usize = 200;

/// A checked log in memory.
#[derive(Debug, Clone)]
pub struct LogFile {
    path: PathBuf,
    bytes: Vec<u8>,
    chunks: Vec<Chunk>,
    ending: Ending,
    setup: SetupRecord,
}

/// How a log ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// With a footer.
    Complete,
    /// Cut off, because its writer was interrupted. All chunks before the last one are complete.
    Interrupted,
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Complete => f.write_str("complete"),
            Self::Interrupted => f.write_str("cut off: its writer was interrupted"),
        }
    }
}

/// A message of a log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LogMessage {
    /// Time since the log began, nanoseconds.
    pub time_ns: u64,
    /// Its channel.
    pub topic: String,
    data: Vec<u8>,
    number: u32,
}

impl LogMessage {
    /// Decodes the message.
    ///
    /// # Errors
    /// When it does not match its channel.
    pub fn content<T: DeserializeOwned>(&self) -> Result<T, String> {
        serde_json::from_slice(&self.data).map_err(|error| {
            // The error may quote the message: one line of limited length.
            let words = error.to_string();
            let words = words.chars().filter(|c| !c.is_control());
            let words: String = words.take(MAX_QUOTED).collect();
            format!("message {} of {}: {words}", self.number, self.topic)
        })
    }
}

/// Reads a log and checks it completely.
///
/// # Errors
/// When the file cannot be read, is not MCAP, is damaged or is not a log of this program.
pub fn read(path: &Path) -> Result<LogFile, BadInput> {
    let unreadable =
        |error: std::io::Error| BadInput::file(path, format!("cannot be read: {error}"));
    let about = fs::metadata(path).map_err(unreadable)?;
    // A pipe or a device might never end.
    if !about.is_file() {
        return Err(BadInput::file(path, "is not a regular file"));
    }
    if about.len() > MAX_FILE_BYTES {
        let bytes = about.len();
        let sentence = format!("has {bytes} bytes; a log of at most {MAX_FILE_BYTES} can be read");
        return Err(BadInput::file(path, sentence));
    }
    let file = File::open(path).map_err(unreadable)?;
    let mut file = file.take(MAX_FILE_BYTES);
    let mut bytes = Vec::new();
    let magic = mcap::MAGIC.len() as u64;
    let begin = file.by_ref().take(magic).read_to_end(&mut bytes);
    begin.map_err(unreadable)?;
    refuse_other_formats(path, &bytes)?;
    file.read_to_end(&mut bytes).map_err(unreadable)?;
    LogFile::of(path, bytes)
}

fn refuse_other_formats(path: &Path, bytes: &[u8]) -> Result<(), BadInput> {
    match bytes.starts_with(mcap::MAGIC) {
        true => Ok(()),
        false => Err(BadInput::file(path, "is not a log in the MCAP format")),
    }
}

impl LogFile {
    /// Checks the bytes of a file; `path` is its name in messages.
    ///
    /// # Errors
    /// As [`read`].
    pub fn of(path: &Path, bytes: Vec<u8>) -> Result<Self, BadInput> {
        refuse_other_formats(path, &bytes)?;
        let damaged = |damage: LogDamage| BadInput::file(path, damage);
        let (chunks, ending) = check::check(&bytes).map_err(damaged)?;
        let first = Messages::of(&bytes, &chunks)
            .find_setup()
            .map_err(damaged)?;
        let setup = setup(first, ending).map_err(|why| BadInput::file(path, why))?;
        Messages::of(&bytes, &chunks)
            .check_numbers()
            .map_err(damaged)?;
        Ok(Self {
            path: path.to_owned(),
            bytes,
            chunks,
            ending,
            setup,
        })
    }

    /// Path of the file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Conditions of the first start.
    #[must_use]
    pub fn setup(&self) -> &SetupRecord {
        &self.setup
    }

    /// How it ends.
    #[must_use]
    pub fn ending(&self) -> Ending {
        self.ending
    }

    /// All messages, in the order of writing.
    #[must_use]
    pub fn messages(&self) -> Messages<'_> {
        Messages::of(&self.bytes, &self.chunks)
    }
}

/// Only the version, because another version may not be readable.
#[derive(Deserialize)]
struct Version {
    format: Option<u64>,
}

fn setup(first: Option<LogMessage>, ending: Ending) -> Result<SetupRecord, String> {
    let Some(first) = first else {
        return Err(match ending {
            Ending::Complete => {
                let channel = channel::SETUP;
                format!("is a log of another program: nothing on channel {channel}")
            }
            Ending::Interrupted => format!("holds no whole chunk of a log ({ending})"),
        });
    };
    match first.content::<Version>()?.format {
        Some(format) if (u64::from(OLDEST_FORMAT)..=FORMAT.into()).contains(&format) => {
            first.content()
        }
        Some(format) => Err(format!(
            "is of format {format}; this program reads formats {OLDEST_FORMAT} to {FORMAT}"
        )),
        None => Err("is a log of another program: its setup names no format".into()),
    }
}

/// Iterates over the messages of a log.
pub struct Messages<'a> {
    file: &'a [u8],
    chunks: slice::Iter<'a, Chunk>,
    /// The current chunk: its offset in the file, its records, and the number of bytes read.
    chunk_at: usize,
    records: Vec<u8>,
    read: usize,
    topics: BTreeMap<u16, String>,
}

impl<'a> Messages<'a> {
    fn of(file: &'a [u8], chunks: &'a [Chunk]) -> Self {
        Self {
            file,
            chunks: chunks.iter(),
            chunk_at: 0,
            records: Vec::new(),
            read: 0,
            topics: BTreeMap::new(),
        }
    }

    fn find_setup(mut self) -> Result<Option<LogMessage>, LogDamage> {
        while let Some(message) = self.try_next()? {
            if message.topic == channel::SETUP {
                return Ok(Some(message));
            }
        }
        Ok(None)
    }

    /// Checks that the messages are numbered without a gap. In a log that was cut off nothing else
    /// shows a missing or duplicate chunk.
    fn check_numbers(mut self) -> Result<(), LogDamage> {
        let mut expected = 1_u32;
        while let Some(message) = self.try_next()? {
            let found = message.number;
            if found != expected {
                return Err(self.damage(LogDefect::Number { expected, found }));
            }
            expected = expected.wrapping_add(1);
        }
        Ok(())
    }

    fn damage(&self, defect: LogDefect) -> LogDamage {
        LogDamage {
            at: self.chunk_at,
            defect,
        }
    }

    fn try_next(&mut self) -> Result<Option<LogMessage>, LogDamage> {
        while self.has_record()? {
            if let Some(message) = self.read_record()? {
                return Ok(Some(message));
            }
        }
        Ok(None)
    }

    /// Whether a record is left; decompresses the next chunk after the last record of one.
    fn has_record(&mut self) -> Result<bool, LogDamage> {
        while self.read == self.records.len() {
            let Some(chunk) = self.chunks.next() else {
                return Ok(false);
            };
            self.records = Vec::new();
            (self.chunk_at, self.read) = (chunk.at, 0);
            self.records = chunk.records(self.file)?;
        }
        Ok(true)
    }

    /// Reads the next record; returns it if it is a message.
    fn read_record(&mut self) -> Result<Option<LogMessage>, LogDamage> {
        let rest = self.records.get(self.read..).unwrap_or(&[]);
        let mut fields = FieldReader::of(rest);
        let record = record(&mut fields).map_err(|defect| self.damage(defect))?;
        self.read += rest.len() - fields.rest().len();
        match record {
            ChunkRecord::Schema => Ok(None),
            ChunkRecord::Channel { id, topic } => {
                let known = self.topics.entry(id).or_insert_with(|| topic.clone());
                match *known == topic {
                    true => Ok(None),
                    false => Err(self.damage(LogDefect::Channel)),
                }
            }
            ChunkRecord::Message {
                channel,
                number,
                time_ns,
                data,
            } => {
                let topic = self.topic(channel, data.len() as u64)?;
                Ok(Some(LogMessage {
                    time_ns,
                    topic: topic.to_owned(),
                    data: data.to_vec(),
                    number,
                }))
            }
        }
    }

    /// Name of a channel that may have a message of this size.
    fn topic(&self, channel: u16, bytes: u64) -> Result<&str, LogDamage> {
        let topic = self.topics.get(&channel);
        let topic = topic.ok_or_else(|| self.damage(LogDefect::Channel))?;
        match bytes <= max_message_bytes(topic) {
            true => Ok(topic),
            false => Err(self.damage(LogDefect::TooLong(bytes))),
        }
    }
}

impl Iterator for Messages<'_> {
    type Item = LogMessage;

    fn next(&mut self) -> Option<LogMessage> {
        // Cannot fail: the check has read everything before.
        self.try_next().ok().flatten()
    }
}

/// A record of a chunk.
enum ChunkRecord<'a> {
    Schema,
    Channel {
        id: u16,
        topic: String,
    },
    Message {
        channel: u16,
        number: u32,
        time_ns: u64,
        data: &'a [u8],
    },
}

/// The next record of a chunk.
fn record<'a>(fields: &mut FieldReader<'a>) -> Result<ChunkRecord<'a>, LogDefect> {
    let kind = fields.u8().ok_or(LogDefect::Length)?;
    let body = fields.u64().and_then(|length| fields.bytes(length));
    let mut body = FieldReader::of(body.ok_or(LogDefect::Length)?);
    let record = match kind {
        op::SCHEMA => Some(ChunkRecord::Schema),
        op::CHANNEL => channel_record(&mut body),
        op::MESSAGE => message_record(&mut body),
        _ => return Err(LogDefect::Kind(kind)),
    };
    record.ok_or(LogDefect::Length)
}

fn channel_record(body: &mut FieldReader<'_>) -> Option<ChunkRecord<'static>> {
    let (id, _schema) = (body.u16()?, body.u16()?);
    let topic = body.string()?;
    if topic.len() > MAX_TOPIC_BYTES {
        return None;
    }
    let topic = std::str::from_utf8(topic).ok()?.to_owned();
    Some(ChunkRecord::Channel { id, topic })
}

fn message_record<'a>(body: &mut FieldReader<'a>) -> Option<ChunkRecord<'a>> {
    let (channel, number, time_ns) = (body.u16()?, body.u32()?, body.u64()?);
    let _published_ns = body.u64()?;
    Some(ChunkRecord::Message {
        channel,
        number,
        time_ns,
        data: body.rest(),
    })
}

/// Maximum size of a message, bytes. A scene grows with its world; of the others an uploaded
/// controller is the longest.
pub(super) fn max_message_bytes(topic: &str) -> u64 {
    match topic {
        channel::SCENE => 32 << 20,
        _ => 1 << 20,
    }
}
