//! Writes a log and stores the first error, such as a full disk.

use super::channel;
use super::read::max_message_bytes;
use super::record::{AnswerRecord, EventRecord};
use super::scene;
use super::setup_record::SetupRecord;
use amp::units::Millis;
use arena::robot::COLLISION_RADIUS_M;
use arena::robot_model::SensorMount;
use arena::world::{Point, Pose, World};
use files::error::BadInput;
use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{Compression, McapError, WriteOptions, Writer};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Seek, Write};
use std::path::Path;
use std::time::Duration;

/// Uncompressed bytes per chunk, about a minute of driving: an interrupted log loses less than
/// this.
pub const CHUNK_BYTES: u64 = 128 * 1_024;

/// Channel, name of the schema and text of the schema.
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

/// A log being written. An error is stored and [queried](Self::failure) later, because the robot
/// does not wait for its log.
pub struct LogWriter<W: Write + Seek> {
    writer: Writer<W>,
    channels: [u16; CHANNELS.len()],
    sequence: u32,
    contacts: usize,
    name: String,
    failure: Option<String>,
    finished: bool,
    /// Begin of the current start and the latest time, nanoseconds.
    began: u64,
    latest: u64,
    starts: u32,
    /// Longest duration of a chunk, and begin of the current chunk, nanoseconds.
    chunk_ns: u64,
    chunk_began: Option<u64>,
}

/// A file, device or FIFO; it is only appended to.
pub type LogOutput = NoSeek<File>;

impl LogWriter<LogOutput> {
    /// Begins a log in a new file.
    ///
    /// # Errors
    /// When the file exists or cannot be written.
    pub fn create(path: &Path) -> Result<Self, BadInput> {
        let file = files::create_new(path).map_err(|error| match error.kind() {
            std::io::ErrorKind::AlreadyExists => BadInput::file(
                path,
                "is there already: a log is not overwritten, give another name",
            ),
            _ => BadInput::file(path, format!("cannot be written: {error}")),
        })?;
        Self::begin(NoSeek::new(file), &path.display().to_string()).map_err(BadInput::new)
    }
}

impl<W: Write + Seek> LogWriter<W> {
    /// Begins a log; `name` is its name in messages.
    ///
    /// # Errors
    /// When nothing can be written.
    pub fn begin(to: W, name: &str) -> Result<Self, String> {
        Self::try_begin(to, name).map_err(|error| error_message(name, &error))
    }

    fn try_begin(to: W, name: &str) -> Result<Self, McapError> {
        let options = WriteOptions::new()
            .compression(Some(Compression::Lz4))
            .chunk_size(Some(CHUNK_BYTES))
            // Each chunk is written at once, with its length in front.
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
            chunk_ns: u64::MAX,
            chunk_began: None,
        })
    }

    /// Limits the duration of a chunk, by the log's time: an interruption loses no more.
    pub fn set_chunk_duration(&mut self, duration: Duration) {
        self.chunk_ns = duration.as_nanos().try_into().unwrap_or(u64::MAX);
    }

    /// Advances the log's time without a message.
    pub fn pass_time(&mut self, at: Millis) {
        self.write_old_chunk(self.time(at.as_ms()));
    }

    /// Writes the current chunk.
    pub fn flush(&mut self) {
        if self.failure.is_some() || self.finished || self.chunk_began.take().is_none() {
            return;
        }
        if let Err(error) = self.writer.flush() {
            self.failure = Some(error_message(&self.name, &error));
        }
    }

    fn write_old_chunk(&mut self, now: u64) {
        let age = self.chunk_began.map(|began| now.saturating_sub(began));
        if age.is_some_and(|age| age >= self.chunk_ns) {
            self.flush();
        }
    }

    /// Writes the start of a controller without knowledge, in this world if it is known. The
    /// controller's clock restarts; the log's continues.
    pub fn setup(&mut self, setup: &SetupRecord, world: Option<&World>) {
        self.began = self.latest;
        self.write(channel::SETUP, self.began, setup);
        let radius_m = setup
            .robot
            .as_ref()
            .map_or(COLLISION_RADIUS_M, |robot| robot.radius_m);
        let scene = scene::begin(self.began, world, radius_m, self.starts > 0);
        self.write(channel::SCENE, self.began, &scene);
        self.starts += 1;
    }

    /// Replaces the world.
    pub fn world(&mut self, at: Millis, world: &World) {
        let time = self.time(at.as_ms());
        self.write(channel::SCENE, time, &scene::changed(time, world));
    }

    /// Writes an event.
    pub fn event(&mut self, event: &EventRecord) {
        self.write(channel::EVENT, self.time(event.at_ms), event);
    }

    /// Writes an answer.
    pub fn answer(&mut self, answer: &AnswerRecord) {
        self.write(channel::PLAN, self.time(answer.at_ms), answer);
    }

    /// Writes the latest ranges by transducer, meters from its face.
    pub fn sonar(&mut self, at: Millis, ranges_m: &[Option<f64>; 16]) {
        let time = self.time(at.as_ms());
        self.write(channel::SONAR, time, &scene::laser_scan(time, ranges_m));
    }

    /// Writes the latest ranges of a body's sensors, meters.
    pub fn beams(&mut self, at: Millis, sensors: &[SensorMount], ranges_m: &[Option<f64>; 16]) {
        let time = self.time(at.as_ms());
        self.write(channel::SCENE, time, &scene::beams(time, sensors, ranges_m));
    }

    /// Writes the poses of the robot and of the leader.
    pub fn pose(&mut self, at: Millis, pose: Pose, leader: Option<Point>) {
        let time = self.time(at.as_ms());
        self.write(channel::POSE, time, &scene::pose_in_frame(time, pose));
        self.write(
            channel::TRANSFORM,
            time,
            &scene::frame_transform(time, pose),
        );
        if let Some(leader) = leader {
            self.write(channel::SCENE, time, &scene::leader(time, leader));
        }
    }

    /// Writes a contact.
    pub fn contact(&mut self, at: Millis, place: Point) {
        let time = self.time(at.as_ms());
        self.contacts += 1;
        self.write(
            channel::SCENE,
            time,
            &scene::contact(time, place, self.contacts),
        );
    }

    /// The first error, if any. Nothing is written after it.
    #[must_use]
    pub fn failure(&self) -> Option<&str> {
        self.failure.as_deref()
    }

    /// Ends the log with the last chunk and the index. Later writes are ignored.
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
        finished
            .map(drop)
            .map_err(|error| error_message(&self.name, &error))
    }

    /// The underlying writer.
    #[must_use]
    pub fn into_inner(self) -> W {
        self.writer.into_inner()
    }

    /// Converts the controller's time to the log's, nanoseconds.
    fn time(&self, ms: u32) -> u64 {
        self.began + u64::from(ms) * 1_000_000
    }

    fn write(&mut self, topic: &str, time: u64, message: &impl Serialize) {
        if self.failure.is_some() || self.finished {
            return;
        }
        self.latest = self.latest.max(time);
        self.chunk_began.get_or_insert(time);
        if let Err(error) = self.try_write(topic, time, message) {
            self.failure = Some(error_message(&self.name, &error));
        }
        self.write_old_chunk(time);
    }

    fn try_write(
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
        // The reader refuses longer messages.
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

/// The text of the `mcap` crate omits the system's message.
fn error_message(name: &str, error: &McapError) -> String {
    match error {
        McapError::Io(error) => format!("{name}: cannot be written: {error}"),
        _ => format!("{name}: cannot be written: {error}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of messages in the complete chunks of a file.
    fn written(path: &Path) -> usize {
        let bytes = std::fs::read(path).unwrap();
        let options = mcap::read::Options::IgnoreEndMagic.into();
        let messages = mcap::MessageStream::new_with_options(&bytes, options).unwrap();
        messages.map_while(Result::ok).count()
    }

    #[test]
    fn a_chunk_is_written_when_it_is_old_and_on_request() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.mcap");
        let mut log = LogWriter::create(&path).unwrap();
        log.set_chunk_duration(Duration::from_secs(1));
        let at = Millis::from_ms;
        let mut log_silence = |at_ms| log.sonar(at(at_ms), &[None; 16]);
        log_silence(0);
        log_silence(999);
        assert_eq!(written(&path), 0);
        log_silence(1_000);
        assert_eq!(written(&path), 3);
        log_silence(1_200);
        // Time advances without a message.
        log.pass_time(at(2_199));
        assert_eq!(written(&path), 3);
        log.pass_time(at(2_200));
        assert_eq!(written(&path), 4);
        log.sonar(at(2_300), &[None; 16]);
        log.flush();
        log.flush();
        assert_eq!(written(&path), 5);
        assert_eq!(log.failure(), None);
        log.finish().unwrap();
        assert_eq!(written(&path), 5);
    }
}
