//! Logs: written by `run --log`, replayed, summarized, cut off by a kill.

use amp::config::Config;
use remote::link::NodeServer;
use serde_json::json;
use std::fs;
use std::thread;
use std::time::{Duration, Instant};
use tests::viewed::Viewed;
use tests::{Program, host_sim};

#[test]
fn every_behavior_and_sonar_replays_bit_for_bit() {
    let program = host_sim!();
    for (number, flags) in [
        "--world random:3",
        "--world office --sonar nomad --behavior wall-right",
        "--world room --behavior avoid-right,nest --preset probe",
        "--world random:4 --behavior follow --shield off --turret follow",
        "--world random:5 --robot p3dx --geometry learned --sonar nomad --behavior wall-right,home",
        "--world random2:3 --robot lidar16 --behavior scent:strongest --tour 40",
        "--world random:6 --places on --behavior nest --tour 40",
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

/// A chunk has 128 KiB before it is compressed.
fn until_it_holds_a_chunk(program: &Program, name: &str) {
    let path = program.folder().join(name);
    let began = Instant::now();
    while fs::metadata(&path).map_or(0, |file| file.len()) < 200_000 {
        assert!(began.elapsed() < Duration::from_secs(60), "it writes");
        thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn a_killed_run_leaves_a_log_up_to_its_last_chunk() {
    let program = host_sim!();
    let run = [
        "run", "--world", "room", "--steps", "10000000", "--log", "cut.mcap",
    ];
    let mut child = program.command(&run).spawn().expect("the program starts");
    until_it_holds_a_chunk(&program, "cut.mcap");
    child.kill().expect("it runs");
    child.wait().expect("it ends");
    let said = program.ok("replay cut.mcap");
    assert!(said.contains("every one identical"), "{said}");
    let summary = program.ok("log cut.mcap");
    assert!(
        summary.contains("cut off: its writer was interrupted"),
        "{summary}"
    );
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

/// A log with every command of a user.
fn steered(viewed: &Viewed) {
    let mut steerer = viewed.steerer();
    let mut order = |order: serde_json::Value| {
        let done = steerer.order(order.clone());
        done.unwrap_or_else(|why| panic!("{order}: {why}"))
    };
    order(json!({"do": "sonar", "number": 3, "on": false}));
    steerer.explore_and_learn(12);
    let mut seek = |more: &[serde_json::Value]| {
        let moment = steerer.moment();
        for order in more {
            let done = steerer.order(order.clone());
            done.unwrap_or_else(|why| panic!("{order}: {why}"));
        }
        steerer.wait_after(moment, "now", |_| true);
        let now = steerer.latest("now");
        let steps = now["counts"]["steps"].as_u64().expect("steps");
        steerer.decided(steps + 4);
    };
    seek(&[json!({"do": "seek"})]);
    seek(&[json!({"do": "goal_neuron", "neuron": 5})]);
    seek(&[
        json!({"do": "shield", "on": false}),
        json!({"do": "online", "on": false}),
        json!({"do": "sonar", "number": 3, "on": true}),
    ]);
    seek(&[json!({"do": "stop"}), json!({"do": "resume"})]);
    seek(&[json!({"do": "move_robot", "x": 0.5, "y": 0.0})]);
    let mut order = |order: serde_json::Value| {
        let done = steerer.order(order.clone());
        done.unwrap_or_else(|why| panic!("{order}: {why}"))
    };
    order(json!({"do": "behavior", "name": "avoid-right,avoid,nest"}));
    let mind = order(json!({"do": "save_mind"}))["file"]["hex"].clone();
    order(json!({"do": "reset", "seed": 7, "preset": "touzet", "world": "random:4"}));
    steerer.explore_and_learn(12);
    steerer
        .order(json!({"do": "load_mind", "hex": mind}))
        .expect("a mind");
    steerer.order(json!({"do": "seek"})).expect("it seeks");
    let moment = steerer.moment();
    steerer.wait_after(moment, "now", |now| {
        now["counts"]["steps"].as_u64() >= Some(5)
    });
}

fn replays(program: &Program, name: &str, ending: &str) {
    let said = program.ok(&format!("replay {name}"));
    assert!(said.contains("every one identical"), "{said}");
    assert!(said.contains(ending), "{said}");
}

#[test]
fn a_view_that_is_steered_leaves_a_log_that_replays_bit_for_bit() {
    let program = host_sim!();
    for (name, flags) in [("a.mcap", ""), ("b.mcap", "--sonar nomad --turret follow")] {
        let flags = format!("--world room --explore 12 --speed max --log {name} {flags}");
        let viewed = Viewed::start(&program, &flags);
        steered(&viewed);
        assert_eq!(viewed.end(), Some(0));
        replays(&program, name, "complete");
        let said = program.ok(&format!("log {name}"));
        for word in [
            "stop",
            "resume",
            "other choices",
            "knowledge from a file",
            "complete",
        ] {
            assert!(said.contains(word), "{word}: {said}");
        }
        let starts = said.matches("explore at").count();
        assert_eq!(starts, 2, "{said}");
    }
}

/// It seeks a scent that is moved, goes to a place, and is carried.
#[test]
fn a_view_of_a_robot_with_places_leaves_a_log_that_replays_bit_for_bit() {
    let program = host_sim!();
    let flags = "--world office --robot p3dx --ranges nomad --behavior scent:strongest --tour 20 --explore 12";
    let viewed = Viewed::start(&program, &format!("{flags} --speed max --log a.mcap"));
    let mut steerer = viewed.steerer();
    steerer.explore_and_learn(12);
    for order in [
        json!({"do": "seek"}),
        json!({"do": "move_source", "source": 0, "x": 1.0, "y": 0.5}),
        json!({"do": "goal_position", "x": -1.5, "y": 0.5}),
        json!({"do": "move_robot", "x": 0.5, "y": 0.5}),
    ] {
        // It may have reached its goal meanwhile, and have stopped.
        for order in [order, json!({"do": "seek"})] {
            let done = steerer.order(order.clone());
            done.unwrap_or_else(|why| panic!("{order}: {why}"));
        }
        let steps = steerer.latest("now")["counts"]["steps"].as_u64();
        steerer.decided(steps.expect("steps") + 4);
    }
    steerer.order(json!({"do": "stop"})).expect("it stops");
    assert_eq!(viewed.end(), Some(0));
    replays(&program, "a.mcap", "complete");
    let said = program.ok("log a.mcap");
    for word in [
        "p3dx",
        "scent:strongest",
        "seek in another modality",
        "stop",
    ] {
        assert!(said.contains(word), "{word}: {said}");
    }
}

#[test]
fn a_view_that_is_killed_leaves_a_log_up_to_its_last_chunk() {
    let program = host_sim!();
    let viewed = Viewed::start(
        &program,
        "--world room --explore 1000 --speed max --log cut.mcap",
    );
    let mut steerer = viewed.steerer();
    steerer
        .order(json!({"do": "explore"}))
        .expect("it explores");
    until_it_holds_a_chunk(&program, "cut.mcap");
    viewed.kill();
    replays(&program, "cut.mcap", "interrupted");
}

#[test]
fn the_log_of_a_mind_at_a_link_replays_here() {
    let served = NodeServer::start(Config::recommended()).expect("a mind behind a socket");
    let program = host_sim!();
    let flags = format!(
        "--world room --explore 6 --speed max --log far.mcap --mind tcp:{}",
        served.host()
    );
    let viewed = Viewed::start(&program, &flags);
    let mut steerer = viewed.steerer();
    steerer.explore_and_learn(6);
    for (order, steps) in [("seek", 4), ("resume", 8)] {
        steerer.order(json!({"do": order})).expect(order);
        steerer.decided(steps);
        steerer.order(json!({"do": "stop"})).expect("it stops");
        let off = json!({"do": "shield", "on": false});
        steerer.order(off).expect("it stands and is told");
    }
    // The effect of the last events is unknown.
    drop(served);
    let _ = steerer.order(json!({"do": "seek"}));
    assert_eq!(viewed.end(), Some(0));
    replays(&program, "far.mcap", "complete");
}

/// The controller of a ring on a held turret has none, as firmware without the feature `places`.
#[test]
fn a_device_without_places_is_neither_logged_behind_points_nor_sent_to_a_scent() {
    let program = host_sim!();
    let served = NodeServer::start(Config::recommended()).expect("a mind behind a socket");
    let host = served.host();
    for (command, named) in [
        ("run --robot p3dx --log a.mcap", "--log a.mcap"),
        ("run --behavior scent:strongest", "scent:strongest"),
        ("view --robot p3dx --log a.mcap", "--log a.mcap"),
        ("view --robot p3dx --behavior home", "--behavior home"),
    ] {
        let line = format!("{command} --mind tcp:{host}");
        let args: Vec<&str> = line.split(' ').collect();
        let output = program.run(&args);
        assert_eq!(output.code, Some(2), "{line}");
        for word in [named, "memory of places"] {
            assert!(output.stderr.contains(word), "{word}: {}", output.stderr);
        }
        assert!(!program.folder().join("a.mcap").exists(), "{line}");
    }
}
