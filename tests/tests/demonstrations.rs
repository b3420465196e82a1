//! Goals learned from demonstrations.

use serde_json::Value;
use tests::{Program, host_sim};

fn line(program: &Program, flags: &str) -> Value {
    let text = program.ok(&format!("run --json {flags}"));
    serde_json::from_str(&text).expect("a JSON object")
}

/// A log of a robot that follows walls for 50 steps is enough for another robot in another room.
#[test]
fn a_logged_drive_shows_another_robot_what_to_do() {
    let program = host_sim!();
    let _ = program
        .ok("run --world random:1 --behavior wall-right --steps 50 --seed 1 --log shown.mcap");
    let said = program.ok("goal learn --from shown.mcap -o wall.toml");
    assert!(
        said.contains("wall.toml: the goal of 50 demonstrated steps"),
        "{said}"
    );
    let flags = "--world random:21 --behavior wall-right --steps 500 --shield off";
    let error = |flags: &str| {
        let line = line(&program, flags);
        assert_eq!(line["contacts"], 0, "{line}");
        line["success"].as_f64().expect("a number")
    };
    let learned_m = error(&format!("{flags} --goal wall.toml"));
    assert!(learned_m < 0.15, "{learned_m} m");
    // What the robot does that was shown nothing.
    std::fs::write(
        program.folder().join("avoid.toml"),
        program.ok("goal avoid"),
    )
    .expect("a file");
    let untold_m = error(&format!("{flags} --goal avoid.toml"));
    assert!(untold_m > 0.3, "{untold_m} m");
    // The same log, the same bytes.
    let _ = program.ok("goal learn --from shown.mcap -o again.toml");
    let read = |name: &str| std::fs::read(program.folder().join(name)).expect("a file");
    assert_eq!(read("wall.toml"), read("again.toml"));
}

/// Situations captured near each other ask for what they have in common.
#[test]
fn captured_situations_show_a_place() {
    let program = host_sim!();
    for (name, at) in [("a", "1.5,1"), ("b", "1.6,1.1")] {
        let _ = program.ok(&format!("capture --world room --at {at} --out {name}.toml"));
    }
    let _ = program.ok("goal learn --from a.toml --from b.toml -o both.toml");
    let line = line(
        &program,
        "--world room --behavior seek:both.toml --steps 300",
    );
    let held = line["success"].as_f64().expect("a number");
    assert!(held > 0.9, "{line}");
    // One situation is asked for as it is: only its place is lost.
    let _ = program.ok("goal learn --from a.toml -o one.toml");
    let goal = |name: &str| {
        let text = program.ok(&format!("goal seek:{name}.toml"));
        text.split_once("frame").expect("a frame").1.to_owned()
    };
    assert_eq!(goal("one"), goal("a"));
}

/// One thread or two, the same table.
#[test]
fn the_table_does_not_depend_on_threads() {
    let program = host_sim!();
    let flags = "demonstrations --only dock --worlds 2 --seeds 1 --drives 3 --length 50 --json";
    let table = program.ok(flags);
    let alone = program.ok(&format!("{flags} --threads 1"));
    assert_eq!(table, alone);
    let rows: Vec<Value> = table
        .lines()
        .map(|line| serde_json::from_str(line).expect("a JSON object"))
        .collect();
    assert_eq!(rows.len(), 2, "{table}");
    for row in rows {
        let mean = |part: &str| row[part]["mean"].as_f64().expect("a number");
        assert!(
            mean("by_hand") < 0.05 && mean("demonstrated") < 0.2,
            "{row}"
        );
        assert!(mean("not_told") > 0.4, "{row}");
    }
}
