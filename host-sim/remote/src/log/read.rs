//! Reading a log, whole or cut off.

use super::channel;
use super::check::{self, Chunk, Damage, Defect};
use super::fields::Fields;
use super::record::{FORMAT, Setup};
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

/// Largest file that is read, bytes.
const MAX_FILE_BYTES: u64 = 4 << 30;

/// Longest name of a channel, bytes.
const MAX_TOPIC_BYTES: usize = 256;

/// Most characters of a JSON error that are repeated: it may quote the message.
const MAX_QUOTED: usize = 200;

/// A log in memory, checked.
#[derive(Debug, Clone)]
pub struct LogFile {
    path: PathBuf,
    bytes: Vec<u8>,
    chunks: Vec<Chunk>,
    ending: Ending,
    setup: Setup,
}

/// How a log ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// As it should.
    Complete,
    /// In the middle: its writer was interrupted. All chunks before the last one are there.
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
pub struct Message {
    /// Time since the episode began, nanoseconds.
    pub time_ns: u64,
    /// Its channel.
    pub topic: String,
    data: Vec<u8>,
    number: u32,
}

impl Message {
    /// What it says.
    ///
    /// # Errors
    /// When it is not what its channel should hold.
    pub fn content<T: DeserializeOwned>(&self) -> Result<T, String> {
        serde_json::from_slice(&self.data).map_err(|error| {
            // The error may quote the message: one line, and not all of a long one.
            let words = error.to_string();
            let words = words.chars().filter(|c| !c.is_control());
            let words: String = words.take(MAX_QUOTED).collect();
            format!("message {} of {}: {words}", self.number, self.topic)
        })
    }
}

/// Reads a log and checks all of it.
///
/// # Errors
/// When the file cannot be read, is not in MCAP, is damaged, or was not written by this program.
pub fn read(path: &Path) -> Result<LogFile, BadInput> {
    let unreadable =
        |error: std::io::Error| BadInput::file(path, format!("cannot be read: {error}"));
    let about = fs::metadata(path).map_err(unreadable)?;
    // A pipe or a device may never end.
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
    /// Checks the bytes of a file; `path` is its name in sentences.
    ///
    /// # Errors
    /// As [`read`].
    pub fn of(path: &Path, bytes: Vec<u8>) -> Result<Self, BadInput> {
        refuse_other_formats(path, &bytes)?;
        let damaged = |damage: Damage| BadInput::file(path, damage);
        let (chunks, ending) = check::check(&bytes).map_err(damaged)?;
        let first = Reading::of(&bytes, &chunks).find_setup().map_err(damaged)?;
        let setup = setup(first, ending).map_err(|why| BadInput::file(path, why))?;
        Reading::of(&bytes, &chunks)
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

    /// Where it came from.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The episode's conditions.
    #[must_use]
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// How it ends.
    #[must_use]
    pub fn ending(&self) -> Ending {
        self.ending
    }

    /// All messages, in the order in which they were written.
    #[must_use]
    pub fn messages(&self) -> Reading<'_> {
        Reading::of(&self.bytes, &self.chunks)
    }
}

/// The version alone: what it is of may not be readable any more.
#[derive(Deserialize)]
struct Version {
    format: Option<u64>,
}

fn setup(first: Option<Message>, ending: Ending) -> Result<Setup, String> {
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
        Some(format) if format == u64::from(FORMAT) => first.content(),
        Some(format) => Err(format!(
            "is of format {format}; this program reads format {FORMAT}"
        )),
        None => Err("is a log of another program: its setup names no format".into()),
    }
}

/// The messages of a log.
pub struct Reading<'a> {
    file: &'a [u8],
    chunks: slice::Iter<'a, Chunk>,
    /// The present chunk: its offset in the file, its records, and how far they are read.
    chunk_at: usize,
    records: Vec<u8>,
    read: usize,
    topics: BTreeMap<u16, String>,
}

impl<'a> Reading<'a> {
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

    fn find_setup(mut self) -> Result<Option<Message>, Damage> {
        while let Some(message) = self.try_next()? {
            if message.topic == channel::SETUP {
                return Ok(Some(message));
            }
        }
        Ok(None)
    }

    /// Messages are numbered without a gap: in a file that was cut off nothing else tells a chunk that is missing or is
    /// there twice.
    fn check_numbers(mut self) -> Result<(), Damage> {
        let mut expected = 1_u32;
        while let Some(message) = self.try_next()? {
            let found = message.number;
            if found != expected {
                return Err(self.damage(Defect::Number { expected, found }));
            }
            expected = expected.wrapping_add(1);
        }
        Ok(())
    }

    fn damage(&self, defect: Defect) -> Damage {
        Damage {
            at: self.chunk_at,
            defect,
        }
    }

    fn try_next(&mut self) -> Result<Option<Message>, Damage> {
        loop {
            while self.read == self.records.len() {
                let Some(chunk) = self.chunks.next() else {
                    return Ok(None);
                };
                self.records = Vec::new();
                (self.chunk_at, self.read) = (chunk.at, 0);
                self.records = chunk.records(self.file)?;
            }
            let rest = self.records.get(self.read..).unwrap_or(&[]);
            let mut fields = Fields::of(rest);
            let record = record(&mut fields).map_err(|defect| self.damage(defect))?;
            self.read += rest.len() - fields.rest().len();
            match record {
                Record::Schema => {}
                Record::Channel { id, topic } => {
                    let known = self.topics.entry(id).or_insert_with(|| topic.clone());
                    if *known != topic {
                        return Err(self.damage(Defect::Channel));
                    }
                }
                Record::Message {
                    channel,
                    number,
                    time_ns,
                    data,
                } => {
                    let topic = self.topics.get(&channel);
                    let topic = topic.ok_or_else(|| self.damage(Defect::Channel))?;
                    if data.len() as u64 > max_message_bytes(topic) {
                        return Err(self.damage(Defect::TooLong(data.len() as u64)));
                    }
                    return Ok(Some(Message {
                        time_ns,
                        topic: topic.clone(),
                        data: data.to_vec(),
                        number,
                    }));
                }
            }
        }
    }
}

impl Iterator for Reading<'_> {
    type Item = Message;

    fn next(&mut self) -> Option<Message> {
        // All was read once before, when the file was checked.
        self.try_next().ok().flatten()
    }
}

/// A record of a chunk.
enum Record<'a> {
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
fn record<'a>(fields: &mut Fields<'a>) -> Result<Record<'a>, Defect> {
    let kind = fields.u8().ok_or(Defect::Length)?;
    let body = fields.u64().and_then(|length| fields.bytes(length));
    let mut body = Fields::of(body.ok_or(Defect::Length)?);
    let record = match kind {
        op::SCHEMA => Some(Record::Schema),
        op::CHANNEL => channel_record(&mut body),
        op::MESSAGE => message_record(&mut body),
        _ => return Err(Defect::Kind(kind)),
    };
    record.ok_or(Defect::Length)
}

fn channel_record(body: &mut Fields<'_>) -> Option<Record<'static>> {
    let (id, _schema) = (body.u16()?, body.u16()?);
    let topic = body.string()?;
    if topic.len() > MAX_TOPIC_BYTES {
        return None;
    }
    let topic = std::str::from_utf8(topic).ok()?.to_owned();
    Some(Record::Channel { id, topic })
}

fn message_record<'a>(body: &mut Fields<'a>) -> Option<Record<'a>> {
    let (channel, number, time_ns) = (body.u16()?, body.u32()?, body.u64()?);
    let _published_ns = body.u64()?;
    Some(Record::Message {
        channel,
        number,
        time_ns,
        data: body.rest(),
    })
}

/// Longest message of a channel, bytes. A scene has as many shapes as its world; all others are short, the bytes of a
/// mind's file being the longest.
pub(super) fn max_message_bytes(topic: &str) -> u64 {
    match topic {
        channel::SCENE => 32 << 20,
        _ => 1 << 20,
    }
}
