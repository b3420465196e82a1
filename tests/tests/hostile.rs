//! Hundreds of damaged files and messages for every reader, and inputs of past failures.

use amp::config::Config;
use amp::wire::message::{GoalSpec, HostMessage, RobotCommand, TimedEcho, TransferPart};
use nomad200::{Kind, Packet};
use rand_core::SeedableRng as _;
use rand_xoshiro::Xoshiro256PlusPlus;
use remote::link::Knowledge;
use sim::pilot::LocalController;
use std::fs;
use tests::campaign::mutate::FrameDamage;
use tests::hostile::{self, READERS};
use tests::root;

/// Damaged inputs of each kind.
const DAMAGED: usize = 300;

/// Valid inputs of a kind: those of the fuzzer, and those built here.
fn sound(kind: &str) -> Vec<Vec<u8>> {
    let entries = fs::read_dir(root().join("tests/fuzz/corpus").join(kind));
    let entries = entries.into_iter().flatten();
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("a file").path()).collect();
    paths.sort();
    let mut inputs: Vec<_> = paths
        .iter()
        .map(|path| fs::read(path).expect("a file"))
        .collect();
    match kind {
        "session" => inputs.push(messages()),
        "world" => inputs.extend(worlds()),
        "image" => inputs.push(fresh_mind()),
        "records" => inputs.push(records_of(&fresh_mind())),
        "nomad" => inputs.extend(packets()),
        _ => {}
    }
    inputs
}

/// The built-in worlds' files.
fn worlds() -> Vec<Vec<u8>> {
    ["room", "corridor", "office", "paper", "posts"]
        .map(|name| fs::read(root().join(format!("host-sim/worlds/{name}.toml"))).expect("a world"))
        .into()
}

/// The file of an untrained controller.
fn fresh_mind() -> Vec<u8> {
    let mind = LocalController::new(Config::recommended());
    Knowledge::of(mind.config(), mind.state()).to_bytes()
}

/// Lengths and bodies of an image's records, except the first and the last.
fn records_of(image: &[u8]) -> Vec<u8> {
    let mut all = Vec::new();
    let mut left = &image[4..];
    while let Some((length, rest)) = left.split_first() {
        let length = usize::from(*length);
        all.push(left[..=length].to_vec());
        left = &rest[(1 + length).next_multiple_of(4) - 1..];
    }
    all.pop();
    all[1..].concat()
}

/// Packets of every type, with payloads of the right lengths.
fn packets() -> Vec<Vec<u8>> {
    let lengths = [0, 1, 2, 4, 6, 8, 12, 14, 33];
    let one = |kind: &Kind| {
        let packets = lengths.map(|length| Packet::new(*kind, (0..length).collect()).to_bytes());
        packets.concat()
    };
    Kind::ALL.iter().map(one).collect()
}

/// A host that explores with one move, learns, seeks and reads.
fn messages() -> Vec<u8> {
    let command = |command| HostMessage::Command {
        at_ms: 0,
        ttl_ms: u16::MAX,
        command,
    };
    let scan = || HostMessage::Scan {
        at_ms: 0,
        echoes: (0..16)
            .map(|sensor| TimedEcho {
                sensor,
                range_mm: Some(900 + 20 * u16::from(sensor)),
                age_ms: 0,
            })
            .collect(),
    };
    let read = HostMessage::<16>::Read {
        part: TransferPart::Config,
        offset: 0,
    };
    let all = [
        command(RobotCommand::Explore { moves: 1, seed: 1 }),
        scan(),
        scan(),
        command(RobotCommand::Learn),
        command(RobotCommand::Goal(GoalSpec::Avoid)),
        command(RobotCommand::Seek),
        scan(),
        command(RobotCommand::Stop),
        command(RobotCommand::Resume),
        read,
    ];
    let coded = all.iter().map(|message| postcard_of(&(1_u8, message)));
    [vec![0]].into_iter().chain(coded).flatten().collect()
}

fn postcard_of(message: &(u8, &HostMessage<16>)) -> Vec<u8> {
    let mut room = [0; 512];
    let used = postcard::to_slice(message, &mut room).expect("it fits");
    used.to_vec()
}

#[test]
fn damaged_inputs_are_refused_or_make_sense() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(11);
    for (kind, read) in READERS {
        let inputs = sound(kind);
        assert!(!inputs.is_empty(), "{kind}");
        inputs.iter().for_each(|input| read(input));
        for number in 0..DAMAGED {
            let mut input = inputs[number % inputs.len()].clone();
            let other = &inputs[(number / 7) % inputs.len()];
            for _ in 0..1 + number % 3 {
                if input.len() > 1 {
                    let damage = FrameDamage::ALL[number / 3 % (FrameDamage::ALL.len() - 1)];
                    damage.inflict(&mut input, other, &mut random);
                }
            }
            read(&input);
        }
    }
}

#[test]
fn damaged_maps_are_refused_or_make_sense() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(12);
    let folder = tempfile::tempdir().expect("a folder");
    let yaml = "image: map.pgm\nresolution: 0.05\norigin: [-1.0, -1.0, 0.0]\nnegate: 0\n\
                occupied_thresh: 0.65\nfree_thresh: 0.196\n\0";
    let image: Vec<u8> = (0..40 * 40)
        .map(|cell| if cell % 40 == 3 { 0 } else { 254 })
        .collect();
    let pgm = [yaml.as_bytes(), b"P5\n40 40\n255\n", &image].concat();
    let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"40\" height=\"40\">\
               <rect x=\"4\" width=\"36\" height=\"40\" fill=\"#fefefe\"/></svg>";
    let png = plots::png::render(svg, 1.0).expect("a bitmap");
    let png = [yaml.as_bytes(), &png].concat();
    hostile::map(&pgm, folder.path());
    hostile::map(&png, folder.path());
    for number in 0..DAMAGED {
        let mut input = if (number / FrameDamage::ALL.len()).is_multiple_of(4) {
            &png
        } else {
            &pgm
        }
        .clone();
        let damage = FrameDamage::ALL[number % (FrameDamage::ALL.len() - 1)];
        // In the image's header and the YAML file, where damage matters.
        let mut head: Vec<_> = input.drain(..yaml.len() + 13).collect();
        damage.inflict(&mut head, yaml.as_bytes(), &mut random);
        hostile::map(&[head, input].concat(), folder.path());
    }
}
