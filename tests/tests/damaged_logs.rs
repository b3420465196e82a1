//! Damaged logs: refused with a sentence that names the place, or played up to the damage.
//!
//! Never a wrong verdict, a crash, or a large amount of memory.

use rand_core::{Rng as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;
use remote::log::{Ending, LogFile, LogMessage, replay};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use tests::{Program, host_sim, hostile, root};

/// Damaged files read in this process.
const CASES: u64 = 10_000;

/// Number of them that the program reads as well.
const PROCESSES: u64 = 300;

/// Logs with valid checksums and invalid content.
const HOSTILE: u64 = 3_000;

/// Memory limit of a reader, KiB.
const MAX_KIB: u64 = 262_144;

/// Time limit per file.
const MAX_TIME: Duration = Duration::from_secs(2);

/// A log to damage.
struct Good {
    bytes: Vec<u8>,
    messages: Vec<LogMessage>,
    ending: Ending,
}

impl Good {
    fn of(bytes: Vec<u8>) -> Self {
        let log = read(&bytes).expect("a good log");
        Self {
            messages: log.messages().collect(),
            ending: log.ending(),
            bytes,
        }
    }
}

fn read(bytes: &[u8]) -> Result<LogFile, String> {
    let log = LogFile::of(Path::new("damaged.mcap"), bytes.to_vec());
    log.map_err(|refusal| refusal.to_string())
}

/// Two finished logs with several chunks, and an unfinished one.
fn good(program: &Program) -> [Good; 3] {
    let run = |flags: &str| {
        let _ = fs::remove_file(program.folder().join("good.mcap"));
        let line = format!("run --world random:3 --json --log good.mcap {flags}");
        assert!(program.ok(&line).contains("random:3"));
        fs::read(program.folder().join("good.mcap")).expect("a log")
    };
    let nomad = run("--sonar nomad --explore 5 --steps 4");
    let ideal = run("--explore 10 --steps 40");
    let cut = nomad[..nomad.len() * 7 / 10].to_vec();
    [nomad, ideal, cut].map(Good::of)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LogDamage {
    Flipped,
    Truncated,
    Duplicated,
}

fn below(random: &mut Xoshiro256PlusPlus, bound: usize) -> usize {
    ((u128::from(random.next_u64()) * bound as u128) >> 64) as usize
}

/// The log with a damage that depends on the number alone.
fn damaged(good: &[Good; 3], number: u64) -> (&Good, LogDamage, Vec<u8>) {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(number);
    let good = &good[below(&mut random, 3)];
    let mut bytes = good.bytes.clone();
    let damage = match below(&mut random, 10) {
        0..6 => LogDamage::Flipped,
        6..8 => LogDamage::Truncated,
        _ => LogDamage::Duplicated,
    };
    match damage {
        LogDamage::Flipped => {
            let flips: BTreeSet<_> = (0..1 + below(&mut random, 3))
                .map(|_| below(&mut random, 8 * good.bytes.len()))
                .collect();
            for bit in flips {
                bytes[bit / 8] ^= 1 << (bit % 8);
            }
        }
        LogDamage::Truncated => bytes.truncate(below(&mut random, good.bytes.len())),
        LogDamage::Duplicated => {
            let start = below(&mut random, bytes.len());
            let length = 1 + below(&mut random, (bytes.len() - start).min(40_000));
            let piece = bytes[start..start + length].to_vec();
            bytes.splice(start..start, piece);
        }
    }
    (good, damage, bytes)
}

/// Whether a damaged log must be refused; `None` if both are correct.
fn must_be_refused(good: &Good, damage: LogDamage) -> Option<bool> {
    match (damage, good.ending) {
        // In a finished log every bit counts.
        (LogDamage::Flipped | LogDamage::Duplicated, Ending::Complete) => Some(true),
        // In an unfinished log, bits after the last whole chunk do not count.
        (LogDamage::Flipped | LogDamage::Duplicated, Ending::Interrupted) => None,
        (LogDamage::Truncated, _) => Some(false),
    }
}

/// Checks the sentence about what cannot be played: damage with its place, or no whole part.
fn check_sentence(sentence: &str, damage: LogDamage, length: usize) {
    assert_eq!(sentence.lines().count(), 1, "{sentence}");
    let (_, what) = sentence.split_once("damaged.mcap: ").expect(sentence);
    let place = what.strip_prefix("is damaged at byte ");
    let place = place.and_then(|rest| rest.split_once(": "));
    match place {
        Some((at, _)) => {
            assert_ne!(damage, LogDamage::Truncated, "{sentence}");
            assert!(at.parse::<usize>().expect(sentence) <= length, "{sentence}");
        }
        None => {
            let known = ["holds no whole chunk", "is not a log in the MCAP format"];
            assert!(
                known.iter().any(|known| what.starts_with(known)),
                "{sentence}"
            );
        }
    }
}

/// Peak memory of this process, KiB.
fn peak_kib() -> u64 {
    let status = fs::read_to_string("/proc/self/status").expect("Linux");
    let line = status.lines().find_map(|line| line.strip_prefix("VmPeak:"));
    let number = line.and_then(|line| line.trim().strip_suffix(" kB"));
    number.and_then(|number| number.parse().ok()).expect("KiB")
}

#[test]
fn ten_thousand_damaged_logs_are_refused_or_played_as_far_as_they_are_whole() {
    let good = good(&host_sim!());
    let before_kib = peak_kib();
    let (mut refused, mut played) = (0, 0);
    let mut lengths = BTreeSet::new();
    for number in 0..CASES {
        let (good, damage, bytes) = damaged(&good, number);
        let must_be_refused = must_be_refused(good, damage);
        let began = Instant::now();
        match read(&bytes) {
            Err(sentence) => {
                check_sentence(&sentence, damage, bytes.len());
                if sentence.contains("is damaged") {
                    refused += 1;
                    assert_ne!(must_be_refused, Some(false), "{number}: {sentence}");
                }
            }
            Ok(log) => {
                played += 1;
                assert_ne!(must_be_refused, Some(true), "{number}: {damage:?}");
                assert_eq!(log.ending(), Ending::Interrupted, "{number}");
                // The played part is the start of the good log, to the byte.
                let messages: Vec<_> = log.messages().collect();
                assert!(good.messages.starts_with(&messages), "{number}");
                lengths.insert(messages.len());
                let done = replay(&log, |_| {}).expect("its messages are whole");
                assert_eq!(done.difference, None, "{number}");
                assert_eq!(done.ending, Ending::Interrupted, "{number}");
            }
        }
        let took = began.elapsed();
        assert!(took <= MAX_TIME, "{number}: {damage:?}: {took:?}");
    }
    let took_kib = peak_kib() - before_kib;
    println!("{refused} refused, {played} played, {took_kib} KiB");
    assert!(refused > 6_000 && played > 1_500, "{refused} {played}");
    assert!(lengths.len() > 4, "{lengths:?}");
    assert!(took_kib <= MAX_KIB, "{took_kib} KiB");
}

/// Exit code and output of the program with two seconds of CPU time and 256 MiB of memory.
fn limited(program: &Program, verb: &[&str], file: &str) -> (Option<i32>, String, String) {
    let script = format!("ulimit -v {MAX_KIB}; ulimit -t 2; exec timeout 60 \"$0\" \"$@\"");
    let path = env!("CARGO_BIN_EXE_host-sim-under-test");
    let mut command = Command::new("sh");
    command.args(["-c", &script, path]).args(verb).arg(file);
    command.current_dir(program.folder()).stdin(Stdio::null());
    let done = command.output().expect("it starts");
    let [out, error] =
        [done.stdout, done.stderr].map(|bytes| String::from_utf8(bytes).expect("UTF-8"));
    (done.status.code(), out, error)
}

#[test]
fn the_program_exits_with_0_or_2_within_two_seconds_and_256_mebibytes() {
    let program = host_sim!();
    let good = good(&program);
    let mut codes = BTreeSet::new();
    for number in 0..PROCESSES {
        let (good, damage, bytes) = damaged(&good, number);
        program.put("damaged.mcap", &bytes);
        let must_be_refused = must_be_refused(good, damage);
        // The page of a playable log is served until the process is ended.
        let verbs: &[&[&str]] = match (must_be_refused, number % 2) {
            (Some(true), _) => &[&["log"], &["replay"], &["view", "--replay"]],
            (_, 0) => &[&["replay"]],
            _ => &[&["log"]],
        };
        for verb in verbs {
            let (code, said, sentence) = limited(&program, verb, "damaged.mcap");
            codes.insert(code);
            match code {
                Some(0) => {
                    assert_ne!(must_be_refused, Some(true), "{number}: {said}");
                    assert!(said.contains("cut off: its writer was"), "{number}: {said}");
                    let is_replay = *verb == ["replay"];
                    assert_eq!(is_replay, said.contains("every one identical"), "{said}");
                }
                Some(2) => check_sentence(sentence.trim_end(), damage, bytes.len()),
                code => panic!("{number}: {verb:?} {damage:?}: {code:?}: {sentence}"),
            }
        }
    }
    assert_eq!(codes, BTreeSet::from([Some(0), Some(2)]));
}

#[test]
fn what_is_no_file_is_refused_without_being_read() {
    let program = host_sim!();
    let fifo = program.folder().join("fifo");
    let made = Command::new("mkfifo").arg(fifo).status();
    assert!(made.expect("mkfifo starts").success());
    for name in ["fifo", ".", "/dev/zero"] {
        for verb in [&["log"][..], &["replay"], &["view", "--replay"]] {
            let (code, _, sentence) = limited(&program, verb, name);
            assert_eq!(code, Some(2), "{verb:?} {name}: {sentence}");
            let expected = format!("host-sim: {name}: is not a regular file\n");
            assert_eq!(sentence, expected);
        }
    }
}

/// Every number and text of a message, by its path.
fn leaves(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Array(items) => {
            for (index, item) in items.iter().enumerate() {
                leaves(item, &format!("{path}/{index}"), found);
            }
        }
        Value::Object(fields) => {
            for (key, item) in fields {
                leaves(item, &format!("{path}/{key}"), found);
            }
        }
        _ => found.push(path.to_owned()),
    }
}

/// A message with one changed value.
fn altered(line: &str, random: &mut Xoshiro256PlusPlus) -> Option<String> {
    let values = [
        json!(0),
        json!(1),
        json!(-1),
        json!(16),
        json!(255),
        json!(32_767),
        json!(-32_768),
        json!(65_535),
        json!(4_294_967_295_u32),
        json!(-2_147_483_648),
        json!(2_147_483_647),
        json!(u64::MAX),
        json!(1e300),
        json!(-1e300),
        json!(0.5),
        json!(null),
        json!(true),
        json!(""),
        json!([]),
    ];
    let mut fields = line.splitn(3, ' ');
    let (topic, time, content) = (fields.next()?, fields.next()?, fields.next()?);
    let mut content: Value = serde_json::from_str(content).ok()?;
    let mut paths = Vec::new();
    leaves(&content, "", &mut paths);
    let path = paths.get(below(random, paths.len()))?;
    *content.pointer_mut(path)? = values[below(random, values.len())].clone();
    // Sometimes the time instead.
    match below(random, 20) {
        0 => Some(format!("{topic} {} {content}", u64::MAX)),
        _ => Some(format!("{topic} {time} {content}")),
    }
}

#[test]
fn logs_with_hostile_content_and_right_checksums_break_nothing() {
    let folder = root().join("tests/fuzz/corpus/messages");
    let texts = ["episode", "places"]
        .map(|name| fs::read_to_string(folder.join(name)).expect("a log's messages"));
    let logs = texts
        .each_ref()
        .map(|text| text.lines().collect::<Vec<_>>());
    let before_kib = peak_kib();
    for number in 0..HOSTILE {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(number);
        let log = &logs[number as usize % logs.len()];
        let mut lines: Vec<_> = log.iter().map(|line| (*line).to_owned()).collect();
        for _ in 0..1 + below(&mut random, 2) {
            // Often the setup: everything depends on it.
            let line = match below(&mut random, 3) {
                0 => 0,
                _ => below(&mut random, lines.len()),
            };
            if let Some(altered) = altered(&lines[line], &mut random) {
                lines[line] = altered;
            }
        }
        let began = Instant::now();
        hostile::messages(lines.join("\n").as_bytes());
        let took = began.elapsed();
        assert!(took <= MAX_TIME, "{number}: {took:?}");
    }
    let took_kib = peak_kib() - before_kib;
    assert!(took_kib <= MAX_KIB, "{took_kib} KiB");
}
