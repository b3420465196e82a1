//! Reading a log, whole or cut off.

use super::channel;
use super::record::{FORMAT, Setup};
use crate::error::BadInput;
use mcap::read::Options;
use mcap::{McapError, MessageStream};
use serde::de::DeserializeOwned;
use std::fmt;
use std::path::{Path, PathBuf};

/// A log in memory.
#[derive(Debug, Clone)]
pub struct LogFile {
    path: PathBuf,
    bytes: Vec<u8>,
    setup: Setup,
}

/// How a log ends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ending {
    /// As it should.
    Complete,
    /// In the middle: whatever wrote it was interrupted. All before the last chunk is there.
    Interrupted,
    /// What follows cannot be read, and why.
    Damaged(String),
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Complete => f.write_str("complete"),
            Self::Interrupted => f.write_str("cut off: its writer was interrupted"),
            Self::Damaged(why) => write!(f, "damaged from there on: {why}"),
        }
    }
}

/// A message of a log.
#[derive(Debug, Clone)]
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
        serde_json::from_slice(&self.data)
            .map_err(|error| format!("message {} of {}: {error}", self.number, self.topic))
    }
}

/// Reads a log.
///
/// # Errors
/// When the file cannot be read, is not in MCAP, or was not written by this program.
pub fn read(path: &Path) -> Result<LogFile, BadInput> {
    let bytes = std::fs::read(path)
        .map_err(|error| BadInput::file(path, format!("cannot be read: {error}")))?;
    LogFile::of(path, bytes)
}

fn setup(bytes: &[u8]) -> Result<Setup, String> {
    let mut reading = Reading::of(bytes);
    let Some(first) = reading.find(|message| message.topic == channel::SETUP) else {
        return Err(match reading.ending() {
            Ending::Complete => {
                format!(
                    "is a log of another program: nothing on channel {}",
                    channel::SETUP
                )
            }
            ending => format!("holds no whole chunk of a log ({ending})"),
        });
    };
    // The format first: what it is of may not be readable any more.
    let text: serde_json::Value = first.content()?;
    match text.get("format").and_then(serde_json::Value::as_u64) {
        Some(format) if format == u64::from(FORMAT) => first.content(),
        Some(format) => Err(format!(
            "is of format {format}; this program reads format {FORMAT}"
        )),
        None => Err("is a log of another program: its setup names no format".into()),
    }
}

impl LogFile {
    pub(super) fn of(path: &Path, bytes: Vec<u8>) -> Result<Self, BadInput> {
        if !bytes.starts_with(mcap::MAGIC) {
            return Err(BadInput::file(path, "is not a log in the MCAP format"));
        }
        let setup = setup(&bytes).map_err(|why| BadInput::file(path, why))?;
        Ok(Self {
            path: path.to_owned(),
            bytes,
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

    /// All messages, in the order in which they were written.
    #[must_use]
    pub fn messages(&self) -> Reading<'_> {
        Reading::of(&self.bytes)
    }
}

/// The messages of a log up to where it can be read.
pub struct Reading<'a> {
    stream: Option<MessageStream<'a>>,
    ending: Ending,
}

impl<'a> Reading<'a> {
    fn of(bytes: &'a [u8]) -> Self {
        match MessageStream::new_with_options(bytes, Options::ValidateChunkCrcs.into()) {
            Ok(stream) => Self {
                stream: Some(stream),
                ending: Ending::Complete,
            },
            Err(error) => Self {
                stream: None,
                ending: ending(&error),
            },
        }
    }

    /// How the log ends; known when there is no further message.
    #[must_use]
    pub fn ending(&self) -> Ending {
        self.ending.clone()
    }
}

impl Iterator for Reading<'_> {
    type Item = Message;

    fn next(&mut self) -> Option<Message> {
        match self.stream.as_mut()?.next()? {
            Ok(message) => Some(Message {
                time_ns: message.log_time,
                topic: message.channel.topic.clone(),
                data: message.data.into_owned(),
                number: message.sequence,
            }),
            Err(error) => {
                self.stream = None;
                self.ending = ending(&error);
                None
            }
        }
    }
}

fn ending(error: &McapError) -> Ending {
    match error {
        McapError::UnexpectedEof | McapError::BadMagic | McapError::BadFooter => {
            Ending::Interrupted
        }
        _ => Ending::Damaged(error.to_string()),
    }
}
