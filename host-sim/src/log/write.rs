//! Writing a log: channels, chunks, and what to do when the disk is full.

use super::channel;
use super::read::max_message_bytes;
use super::record::{Answer, EventRecord, Setup};
use super::scene;
use crate::error::BadInput;
use crate::world::{Point, Pose, World};
use amp::units::Millis;
use mcap::records::MessageHeader;
use mcap::{Compression, McapError, WriteOptions, Writer};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Seek, Write};
use std::path::Path;

/// Uncompressed bytes per chunk: an interrupted log lacks less than this, a minute or so of the robot's life.
pub const CHUNK_BYTES: u64 = 128 * 1_024;

/// Names of the schemas with their text, by channel.
const CHANNELS: [(&str, &str, &str); 7] = [
    (
        channel::SETUP,
        "amp.Setup",
        include_str!("schemas/setup.json"),
    ),
    (
        channel::EVENT,
        "amp.Event",
        include_str!("schemas/event.json"),
    ),
    (channel::PLAN, "amp.Plan", include_str!("schemas/plan.json")),
    (
        channel::SONAR,
        "foxglove.LaserScan",
        include_str!("schemas/laser_scan.json"),
    ),
    (
        channel::POSE,
        "foxglove.PoseInFrame",
        include_str!("schemas/pose_in_frame.json"),
    ),
    (
        channel::TRANSFORM,
        "foxglove.FrameTransform",
        include_str!("schemas/frame_transform.json"),
    ),
    (
        channel::SCENE,
        "foxglove.SceneUpdate",
        include_str!("schemas/scene_update.json"),
    ),
];

/// A log being written. What goes wrong is kept until somebody asks ([`failure`](Self::failure)): the robot does not wait
/// for its log.
pub struct Log<W: Write + Seek> {
    writer: Writer<W>,
    channels: [u16; CHANNELS.len()],
    sequence: u32,
    contacts: usize,
    name: String,
    failure: Option<String>,
    finished: bool,
    /// When the present start began, and the latest time written, nanoseconds.
    began: u64,
    latest: u64,
    starts: u32,
}

impl Log<File> {
    /// Begins a log in a new file.
    ///
    /// # Errors
    /// When there is a file of this name already, or it cannot be written.
    pub fn create(path: &Path) -> Result<Self, BadInput> {
        let file = File::create_new(path).map_err(|error| match error.kind() {
            std::io::ErrorKind::AlreadyExists => BadInput::file(
                path,
                "is there already: a log is not overwritten, give another name",
            ),
            _ => BadInput::file(path, format!("cannot be written: {error}")),
        })?;
        Self::begin(file, &path.display().to_string()).map_err(BadInput::new)
    }
}

impl<W: Write + Seek> Log<W> {
    /// Begins a log that is called `name` when something goes wrong.
    ///
    /// # Errors
    /// When nothing can be written.
    pub fn begin(to: W, name: &str) -> Result<Self, String> {
        Self::try_begin(to, name).map_err(|error| said(name, &error))
    }

    fn try_begin(to: W, name: &str) -> Result<Self, McapError> {
        let options = WriteOptions::new()
            .compression(Some(Compression::Lz4))
            .chunk_size(Some(CHUNK_BYTES))
            // Each chunk is written at once, with its length before it.
            .disable_seeking(true);
        let mut writer = options.create(to)?;
        let mut channels = [0; CHANNELS.len()];
        for (id, (topic, schema, text)) in channels.iter_mut().zip(CHANNELS) {
            let schema = writer.add_schema(schema, "jsonschema", text.as_bytes())?;
            *id = writer.add_channel(schema, topic, "json", &BTreeMap::new())?;
        }
        Ok(Self {
            writer,
            channels,
            sequence: 0,
            contacts: 0,
            name: name.to_owned(),
            failure: None,
            finished: false,
            began: 0,
            latest: 0,
            starts: 0,
        })
    }

    /// A mind that knows nothing starts, under these conditions, in this world if it is known. The mind's clock begins
    /// anew with each start, the log's goes on.
    pub fn setup(&mut self, setup: &Setup, world: Option<&World>) {
        self.began = self.latest;
        self.put(channel::SETUP, self.began, setup);
        let scene = scene::begin(self.began, world, self.starts > 0);
        self.put(channel::SCENE, self.began, &scene);
        self.starts += 1;
    }

    /// The world is another one from now on.
    pub fn world(&mut self, at: Millis, world: &World) {
        let time = self.time(at.as_ms());
        self.put(channel::SCENE, time, &scene::changed(time, world));
    }

    /// Something the mind was told.
    pub fn event(&mut self, event: &EventRecord) {
        self.put(channel::EVENT, self.time(event.at_ms), event);
    }

    /// Something it answered.
    pub fn answer(&mut self, answer: &Answer) {
        self.put(channel::PLAN, self.time(answer.at_ms), answer);
    }

    /// The latest ranges by transducer, metres from its face.
    pub fn sonar(&mut self, at: Millis, ranges_m: &[Option<f64>; 16]) {
        let time = self.time(at.as_ms());
        self.put(channel::SONAR, time, &scene::laser_scan(time, ranges_m));
    }

    /// Where the robot and the one it follows are.
    pub fn pose(&mut self, at: Millis, pose: Pose, leader: Option<Point>) {
        let time = self.time(at.as_ms());
        self.put(channel::POSE, time, &scene::pose_in_frame(time, pose));
        self.put(
            channel::TRANSFORM,
            time,
            &scene::frame_transform(time, pose),
        );
        if let Some(leader) = leader {
            self.put(channel::SCENE, time, &scene::leader(time, leader));
        }
    }

    /// The robot touched something here.
    pub fn contact(&mut self, at: Millis, place: Point) {
        let time = self.time(at.as_ms());
        self.contacts += 1;
        self.put(
            channel::SCENE,
            time,
            &scene::contact(time, place, self.contacts),
        );
    }

    /// What went wrong, if anything: from then on nothing is written.
    #[must_use]
    pub fn failure(&self) -> Option<&str> {
        self.failure.as_deref()
    }

    /// Ends the log: the last chunk, the index. Whatever is written later is dropped.
    ///
    /// # Errors
    /// What went wrong, now or before.
    pub fn finish(&mut self) -> Result<(), String> {
        if let Some(failure) = &self.failure {
            return Err(failure.clone());
        }
        if std::mem::replace(&mut self.finished, true) {
            return Ok(());
        }
        let finished = self.writer.finish();
        finished.map(drop).map_err(|error| said(&self.name, &error))
    }

    /// What was written on.
    #[must_use]
    pub fn into_inner(self) -> W {
        self.writer.into_inner()
    }

    /// A time of the mind's clock by the log's, nanoseconds.
    fn time(&self, ms: u32) -> u64 {
        self.began + u64::from(ms) * 1_000_000
    }

    fn put(&mut self, topic: &str, time: u64, message: &impl Serialize) {
        if self.failure.is_some() || self.finished {
            return;
        }
        self.latest = self.latest.max(time);
        if let Err(error) = self.try_put(topic, time, message) {
            self.failure = Some(said(&self.name, &error));
        }
    }

    fn try_put(
        &mut self,
        topic: &str,
        time: u64,
        message: &impl Serialize,
    ) -> Result<(), McapError> {
        let mut ids = CHANNELS.iter().zip(self.channels);
        let Some((_, channel_id)) = ids.find(|((name, ..), _)| *name == topic) else {
            return Ok(());
        };
        let data = serde_json::to_vec(message).map_err(std::io::Error::from)?;
        // What is written can be read.
        if data.len() as u64 > max_message_bytes(topic) {
            let sentence = format!("a message of {topic} has {} bytes", data.len());
            return Err(std::io::Error::other(sentence).into());
        }
        self.sequence = self.sequence.wrapping_add(1);
        let header = MessageHeader {
            channel_id,
            sequence: self.sequence,
            log_time: time,
            publish_time: time,
        };
        self.writer.write_to_known_channel(&header, &data)
    }
}

/// The crate's own words leave out what the system said.
fn said(name: &str, error: &McapError) -> String {
    match error {
        McapError::Io(error) => format!("{name}: cannot be written: {error}"),
        _ => format!("{name}: cannot be written: {error}"),
    }
}
