//! The output of whole episodes equals the goldens.
//!
//! `UPDATE_GOLDEN=1 cargo test -p tests --test all golden::` rewrites the goldens.

use std::fs;
use tests::{host_sim, root};

const BATCHES: [(&str, &str); 16] = [
    ("default", "--world random:1..=8"),
    ("default-unshielded", "--world random:1..=8 --shield off"),
    (
        "default-offline",
        "--world random:1..=8 --shield off --online off",
    ),
    ("touzet", "--world random:1..=8 --preset touzet"),
    (
        "touzet-unshielded",
        "--world random:1..=8 --preset touzet --shield off",
    ),
    ("nomad", "--world random:1..=8 --sonar nomad"),
    ("harsh", "--world random:1..=8 --sonar harsh"),
    ("probe", "--world random:1..=8 --preset probe"),
    (
        "probe-unshielded",
        "--world random:1..=8 --preset probe --shield off",
    ),
    ("avoid-right", "--world random:1..=4 --behavior avoid-right"),
    ("wall-left", "--world random:1..=4 --behavior wall-left"),
    ("wall-right", "--world random:1..=4 --behavior wall-right"),
    ("nest", "--world random:1..=4 --behavior nest --sonar nomad"),
    ("follow", "--world random:1..=4 --behavior follow"),
    (
        "chain",
        "--world random:1..=4 --behavior avoid-right,wall-right,nest",
    ),
    (
        "worlds",
        "--world paper --world room --world corridor --world office --world posts",
    ),
];

#[test]
fn batches_print_what_they_always_printed() {
    let update = std::env::var_os("UPDATE_GOLDEN").is_some_and(|value| value == "1");
    let mut differences = Vec::new();
    for (name, flags) in BATCHES {
        let printed = host_sim!().ok(&format!("run {flags} --steps 200 --json"));
        let path = root().join(format!("tests/goldens/{name}.jsonl"));
        if update {
            fs::write(&path, &printed).expect("the golden file can be written");
        }
        let golden = fs::read_to_string(&path).unwrap_or_default();
        if golden.lines().count() != printed.lines().count() {
            differences.push(format!("{name}: another number of lines"));
        }
        for (was, is) in golden.lines().zip(printed.lines()) {
            if was != is {
                differences.push(format!("{name}:\n  was {was}\n  is  {is}"));
            }
        }
    }
    assert!(differences.is_empty(), "{}", differences.join("\n"));
}
