//! Any bytes for every reader: it may refuse them, but must not panic, and accepted input must be
//! valid.
//!
//! One function per kind of input. The tests pass damaged files, the fuzzer in `tests/fuzz` passes
//! random ones.

use amp::config::Config;
use amp::controller::Mode;
use amp::node::{FrameSink, Identity, Node};
use amp::parameters::Parameter;
use amp::som::Grid;
use amp::store::{GRAMMAR, WORD, check};
use amp::units::Millis;
use amp::wire::frame::{Header, unpack};
use amp::wire::message::{Clock, DeviceMessage, Dimensions, HostHello, HostMessage, Report};
use amp::wire::{CRC, Frame, PROTOCOL, Receiver, SCHEMA, cobs};
use arena::sonar::SonarModel;
use arena::world::World;
use datasets::learn::{Log, LogColumns};
use files::table::Table;
use mcap::records::MessageHeader;
use mcap::{Compression, McapResult, WriteOptions};
use nomad200::{Protocol, RobotLine, SimulatedNomad};
use remote::link::Knowledge;
use remote::log::{LogFile, Summary, channel, replay};
use sim::goal_file::GoalFile;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;
use view::{StepOutcome, ViewSource as _, WatchedLog};

/// A kind of input and the function that reads it.
pub type FuzzTarget = (&'static str, fn(&[u8]));

/// All readers except [`map`], which takes files.
pub const READERS: [FuzzTarget; 12] = [
    ("frame", frame),
    ("content", content),
    ("session", session),
    ("parameters", parameters),
    ("image", image),
    ("records", records),
    ("world", world),
    ("goal", goal),
    ("csv", csv),
    ("nomad", nomad),
    ("log", log),
    ("messages", messages),
];

/// Steps of a recording that are shown: a log may be long.
const MAX_STEPS: usize = 2_000;

/// Bytes from the line.
///
/// # Panics
/// When an accepted message changes by encoding and decoding.
pub fn frame(bytes: &[u8]) {
    let mut receiver = Receiver::new();
    for &byte in bytes.iter().chain(&[0]) {
        if let Some(piece) = receiver.push(byte) {
            let _ = unpack::<Report<16>>(piece);
            if let Ok((header, message)) = unpack::<HostMessage<16>>(piece) {
                let again = Frame::pack(header, &message).expect("it came in a frame");
                let (_, coded) = again.as_bytes().split_last().expect("its zero");
                assert_eq!(unpack(coded), Ok((header, message)));
            }
        }
    }
}

/// Header and message, with a valid checksum added.
pub fn content(bytes: &[u8]) {
    let bytes = bytes.get(..240).unwrap_or(bytes);
    let mut coded = [&[0][..], bytes, &CRC.checksum(bytes).to_le_bytes()].concat();
    if cobs::encode(&mut coded).is_some() {
        frame(&coded);
    }
}

/// Messages of a node.
#[derive(Default)]
struct SentReports(Vec<Report<16>>);

impl FrameSink for SentReports {
    fn send(&mut self, frame: &[u8]) -> bool {
        let coded = frame.split_last().map_or(frame, |(_, coded)| coded);
        let (_, report) = unpack(coded).expect("a controller sends valid frames");
        self.0.push(report);
        true
    }
}

/// Messages as postcard, each after a byte for the elapsed time, in order in the controller's
/// session.
///
/// # Panics
/// When a stopped or idle robot gets a motion.
pub fn session(bytes: &[u8]) {
    let mut node = Box::new(Node::<16, 16, 20>::new());
    let mut said = SentReports::default();
    let (mut now, mut seq) = (0_u32, 1);
    let grid = Grid::rectangle(4, 4);
    let start = Millis::from_ms(now);
    node.start(
        &Config::recommended(),
        grid,
        Identity::default(),
        start,
        &mut said,
    );
    let clock = match bytes.first() {
        Some(first) if first % 2 == 1 => Clock::Host,
        _ => Clock::Device,
    };
    let dimensions = Dimensions {
        protocol: PROTOCOL,
        schema: SCHEMA,
        sensors: 16,
        neurons: 16,
    };
    let hello = HostMessage::Hello(HostHello {
        dimensions,
        clock,
        open_space: false,
    });
    tell(&mut node, seq, &hello, now, &mut said);
    let mut left = bytes.get(1..).unwrap_or(&[]);
    while let Ok(((passed, message), rest)) =
        postcard::take_from_bytes::<(u8, HostMessage<16>)>(left)
    {
        left = rest;
        seq += 1;
        // Squared: one minute at most.
        now = now.wrapping_add(u32::from(passed).pow(2));
        let time = Millis::from_ms(now);
        node.tick(time, &mut said);
        tell(&mut node, seq, &message, now, &mut said);
        let stands = matches!(node.state().mode(), Mode::Idle | Mode::Stopped(_));
        let moves = said
            .0
            .drain(..)
            .rfind(|report| matches!(report.message, DeviceMessage::Motion(_)));
        if let Some(DeviceMessage::Motion(order)) = moves.map(|report| report.message) {
            let is_stop = (order.dx_mm, order.dy_mm) == (0, 0);
            // During the last random move the mode is already idle.
            assert!(is_stop || !stands || node.state().is_moving());
        }
    }
}

fn tell(
    node: &mut Node<16, 16, 20>,
    seq: u16,
    message: &HostMessage<16>,
    now: u32,
    said: &mut SentReports,
) {
    if let Ok(frame) = Frame::pack(Header { session: 1, seq }, message) {
        let (_, coded) = frame.as_bytes().split_last().expect("its zero");
        node.frame(Millis::from_ms(now), coded, said);
    }
}

/// Parameters to set: one byte for the index, four for the value.
///
/// # Panics
/// When an accepted value is not stored, or near is not below far.
pub fn parameters(bytes: &[u8]) {
    let mut config = Config::recommended();
    for five in bytes.as_chunks::<5>().0 {
        let [which, value @ ..] = *five;
        let parameter = Parameter::ALL[usize::from(which) % Parameter::ALL.len()];
        let value = i32::from_le_bytes(value);
        let before = config.clone();
        match parameter.set(&mut config, value) {
            Ok(()) => assert_eq!(parameter.get(&config), value),
            Err(_) => assert_eq!(config, before),
        }
        assert!(config.encoding.near_mm < config.encoding.far_mm);
    }
}

/// The saved image of a controller.
///
/// # Panics
/// When an accepted image changes by writing and reading.
pub fn image(bytes: &[u8]) {
    let _ = check(&mut reader(bytes), bytes.len());
    if let Ok(knowledge) = Knowledge::from_bytes(bytes) {
        let again = knowledge.to_bytes();
        let read = Knowledge::from_bytes(&again).expect("it was written here");
        let read = read.to_bytes();
        assert_eq!(read.len(), again.len());
        // Only the random state differs: another seed, and so another checksum.
        let different = read.iter().zip(&again).filter(|(one, other)| one != other);
        assert!(different.count() <= 8 + 4);
    }
}

/// Records of an image with a valid first and last one: each a byte for the length of its body, and
/// the body.
pub fn records(bytes: &[u8]) {
    let mut image = Vec::from(*b"AMPS");
    let mut head = vec![0];
    head.extend(1_u16.to_le_bytes());
    head.extend(GRAMMAR.to_le_bytes());
    head.extend(1_u32.to_le_bytes());
    head.extend([16, 16]);
    head.extend(100_u16.to_le_bytes());
    record(&mut image, &head);
    let mut left = bytes;
    while let Some((length, rest)) = left.split_first() {
        let (body, rest) = rest.split_at(usize::from(*length).min(rest.len()));
        record(&mut image, body);
        left = rest;
    }
    let sum = CRC.checksum(&image).to_le_bytes();
    record(&mut image, &[&[4][..], &sum].concat());
    self::image(&image);
}

fn record(image: &mut Vec<u8>, body: &[u8]) {
    image.push(body.len() as u8);
    image.extend_from_slice(body);
    image.resize(image.len().next_multiple_of(WORD), 0);
}

fn reader(bytes: &[u8]) -> impl FnMut(usize, &mut [u8]) -> bool {
    |at, out| {
        let found = at.checked_add(out.len()).and_then(|end| bytes.get(at..end));
        found.map(|found| out.copy_from_slice(found)).is_some()
    }
}

/// A world file.
pub fn world(bytes: &[u8]) {
    if let Ok(text) = std::str::from_utf8(bytes)
        && let Ok(world) = World::from_toml(text, "hostile.toml")
    {
        look_around(&world);
    }
}

/// Ranges can be measured at the start of an accepted world.
fn look_around(world: &World) {
    let start = world.start();
    assert!(world.clearance(start.position).is_finite());
    let (low, high) = world.bounds();
    assert!(low.x <= high.x && low.y <= high.y);
}

/// A map of ROS's map_server: `folder` gets its two files. The bytes up to the first zero are the
/// YAML file, the others the image.
///
/// # Panics
/// When the files cannot be written.
pub fn map(bytes: &[u8], folder: &Path) {
    let end = bytes.iter().position(|byte| *byte == 0);
    let (yaml, image) = bytes.split_at(end.unwrap_or(bytes.len()));
    let path = folder.join("map.yaml");
    std::fs::write(&path, yaml).expect("a file");
    std::fs::write(folder.join("map.pgm"), image.get(1..).unwrap_or(&[])).expect("a file");
    if let Ok(world) = World::load(&path) {
        look_around(&world);
    }
}

/// A goal file.
pub fn goal(bytes: &[u8]) {
    if let Ok(text) = std::str::from_utf8(bytes)
        && let Ok(file) = GoalFile::read(text, "hostile.toml")
    {
        let _ = (file.goal, file.place());
    }
}

/// A table of numbers, and a robot's log.
pub fn csv(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    if let Ok(table) = Table::parse("hostile.csv", text) {
        assert!(table.columns() > 0);
    }
    let velocities = Some("5-6".to_owned());
    for velocities in [None, velocities] {
        let columns = LogColumns {
            velocities,
            ..LogColumns::default()
        };
        let _ = Log::parse("hostile.csv", text, &columns);
    }
}

/// A host's bytes to a simulated Nomad, in both protocols.
pub fn nomad(bytes: &[u8]) {
    let nserver = Protocol::Nserver {
        port: 7_019,
        speed: 1,
    };
    for protocol in [Protocol::Direct, nserver] {
        let robot = SimulatedNomad::new(World::random(1), SonarModel::Ideal, 1);
        let mut line = RobotLine::new(robot, protocol);
        for piece in bytes.chunks(64) {
            line.receive(piece);
            line.advance(5);
            let _ = line.take();
        }
        line.idle();
        line.advance(50);
    }
}

/// The file of a log: its summary, a replay, and the recording of the page.
pub fn log(bytes: &[u8]) {
    let Ok(log) = LogFile::of(Path::new("hostile.mcap"), bytes.to_vec()) else {
        return;
    };
    let _ = Summary::of(&log);
    let _ = replay(&log, |_| {});
    if let Ok(mut recorded) = WatchedLog::new(&log) {
        let mut steps = 0..MAX_STEPS;
        while steps.next().is_some() && recorded.step() != StepOutcome::Idle {}
        let _ = recorded.snapshot();
    }
}

/// Messages of a log with valid checksums.
///
/// # Panics
/// When they cannot be written.
pub fn messages(lines: &[u8]) {
    log(&log_of(lines).expect("a log in memory"));
}

/// A log with these messages, one per line: channel, time in nanoseconds, content. Other lines are
/// skipped.
fn log_of(lines: &[u8]) -> McapResult<Vec<u8>> {
    let options = WriteOptions::new()
        .compression(Some(Compression::Lz4))
        .disable_seeking(true);
    let mut writer = options.create(Cursor::new(Vec::new()))?;
    let mut channels = BTreeMap::new();
    let topics = [
        channel::SETUP,
        channel::EVENT,
        channel::PLAN,
        channel::POSE,
        channel::SCENE,
    ];
    for topic in topics {
        let id = writer.add_channel(0, topic, "json", &BTreeMap::new())?;
        channels.insert(topic.as_bytes(), id);
    }
    let mut sequence = 0;
    for line in lines.split(|byte| *byte == b'\n') {
        let mut fields = line.splitn(3, |byte| *byte == b' ');
        let mut field = || fields.next().unwrap_or(&[]);
        let (topic, time, content) = (field(), field(), field());
        let time = std::str::from_utf8(time)
            .ok()
            .and_then(|time| time.parse().ok());
        let (Some(&channel_id), Some(log_time)) = (channels.get(topic), time) else {
            continue;
        };
        sequence += 1;
        let header = MessageHeader {
            channel_id,
            sequence,
            log_time,
            publish_time: log_time,
        };
        writer.write_to_known_channel(&header, content)?;
    }
    writer.finish()?;
    Ok(writer.into_inner().into_inner())
}
