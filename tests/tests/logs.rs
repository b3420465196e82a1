//! Logs as a user meets them: written by `run --log`, replayed, summarised, cut off by a kill.

use std::fs;
use std::thread;
use std::time::{Duration, Instant};
use tests::host_sim;

#[test]
fn every_behaviour_and_sonar_replays_bit_for_bit() {
    let program = host_sim!();
    for (number, flags) in [
        "--world random:3",
        "--world office --sonar nomad --behavior wall-right",
        "--world room --behavior avoid-right,nest --preset probe",
        "--world random:4 --behavior follow --shield off --turret follow",
    ]
    .iter()
    .enumerate()
    {
        let run = format!("run {flags} --steps 80 --json");
        let logged = program.ok(&format!("{run} --log {number}.mcap"));
        assert_eq!(logged, program.ok(&run), "a log changes nothing");
        let said = program.ok(&format!("replay {number}.mcap"));
        assert!(said.contains("every one identical"), "{flags}: {said}");
        assert!(said.ends_with("complete\n"), "{flags}: {said}");
    }
}

#[test]
fn ten_thousand_steps_replay_bit_for_bit() {
    let program = host_sim!();
    let line = program.ok("run --world random:7 --steps 10000 --json --log long.mcap");
    assert!(line.contains("\"steps\":10000"), "{line}");
    let said = program.ok("replay long.mcap");
    assert!(said.starts_with("long.mcap: 10101 decisions"), "{said}");
    assert!(said.contains("every one identical"), "{said}");
}

#[test]
fn the_same_seed_writes_the_same_log() {
    let program = host_sim!();
    for name in ["a", "b"] {
        let line = program.ok(&format!(
            "run --world random:3 --steps 50 --sonar nomad --json --log {name}.mcap"
        ));
        assert!(line.contains("random:3"), "{line}");
    }
    let bytes = |name: &str| fs::read(program.folder().join(name)).expect("a log");
    assert_eq!(bytes("a.mcap"), bytes("b.mcap"));
    let said = program.ok("log a.mcap");
    for word in ["random:3", "explore at 0.0 s", "/sonar", "complete"] {
        assert!(said.contains(word), "{word}: {said}");
    }
}

#[test]
fn a_killed_run_leaves_a_log_up_to_its_last_chunk() {
    let program = host_sim!();
    let run = [
        "run", "--world", "room", "--steps", "10000000", "--log", "cut.mcap",
    ];
    let mut child = program.command(&run).spawn().expect("the program starts");
    let path = program.folder().join("cut.mcap");
    let began = Instant::now();
    while fs::metadata(&path).map_or(0, |file| file.len()) < 200_000 {
        assert!(began.elapsed() < Duration::from_secs(60), "it writes");
        thread::sleep(Duration::from_millis(5));
    }
    child.kill().expect("it runs");
    child.wait().expect("it ends");
    let said = program.ok("replay cut.mcap");
    assert!(said.contains("every one identical"), "{said}");
    let summary = program.ok("log cut.mcap");
    assert!(summary.contains("told to"), "{summary}");
}

#[test]
fn what_is_no_log_is_refused_in_one_sentence() {
    let program = host_sim!();
    program.put("text.mcap", "not a log");
    program.put(
        "short.mcap",
        [0x89, b'M', b'C', b'A', b'P', 0x30, b'\r', b'\n'],
    );
    let refused = |args: &[&str], words: &[&str]| {
        let output = program.run(args);
        assert_eq!(output.code, Some(2), "{args:?}");
        assert!(output.stdout.is_empty());
        assert_eq!(output.stderr.lines().count(), 1, "{}", output.stderr);
        for word in words {
            assert!(output.stderr.contains(word), "{word}: {}", output.stderr);
        }
    };
    refused(&["replay", "text.mcap"], &["text.mcap", "MCAP"]);
    refused(&["log", "short.mcap"], &["short.mcap", "no whole chunk"]);
    refused(&["log", "none.mcap"], &["none.mcap", "cannot be read"]);
    refused(
        &["run", "--log", "text.mcap"],
        &["text.mcap", "there already"],
    );
    refused(
        &["run", "--world", "random:1..=2", "--log", "new.mcap"],
        &["new.mcap", "one episode", "2 worlds"],
    );
    assert!(!program.folder().join("new.mcap").exists());
    let kept = fs::read(program.folder().join("text.mcap")).expect("it stays");
    assert_eq!(kept, b"not a log");
}
