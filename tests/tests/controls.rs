//! Controls in the place of the action map, and maps of other sizes: the same bytes with any number
//! of threads, and the same as `run` where nothing is replaced.

use std::collections::BTreeSet;
use tests::{host_sim, words};

const SMALL: &str = "controls --worlds 1 --seeds 2 --others 1 --only g/2";

fn with_threads(threads: &str, flags: &str) -> String {
    let program = host_sim!();
    let mut command = program.command(&words(&format!("{SMALL} {flags}")));
    let output = command.env("RAYON_NUM_THREADS", threads).output();
    let output = output.expect("the program starts");
    assert_eq!(output.status.code(), Some(0), "{flags}");
    String::from_utf8(output.stdout).expect("text")
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let json = with_threads("1", "--json");
    assert_eq!(json, with_threads("3", "--json"));
    // The maps, and nothing learned with and without online learning; 7 and 4 measures.
    let lines: Vec<serde_json::Value> = json
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    assert_eq!(lines.len(), 3 * (7 + 4));
    let measures: BTreeSet<_> = lines
        .iter()
        .map(|line| line["measure"].to_string() + &line["worlds"].to_string())
        .collect();
    assert_eq!(measures.len(), 11);
    for line in &lines {
        let is_first = line["predictor"] == "two maps";
        let difference = line["minus_first"]["mean"].as_f64().expect("a number");
        assert!(!is_first || difference == 0.0, "{line}");
        assert_eq!(
            (&line["neurons"], &line["moves"]),
            (&16.into(), &100.into())
        );
    }
}

#[test]
fn maps_of_other_sizes_drive_and_16_is_the_default() {
    let line = |flags: &str| {
        host_sim!().ok(&format!(
            "run --json --shield off --steps 300 --world random:7 {flags}"
        ))
    };
    let default = line("");
    assert_eq!(line("--neurons 16"), default);
    for neurons in [4, 64] {
        let other = line(&format!("--neurons {neurons}"));
        assert_ne!(other, default);
        assert!(other.contains("\"steps\":300"), "{other}");
    }
}
