//! Preset `graph`: several steps over what was traversed, here and not on a device.

use tests::host_sim;

/// A row of the table: its cells.
fn row(table: &str, preset: &str) -> Vec<String> {
    let line = table
        .lines()
        .find(|line| line.starts_with(&format!("| {preset} |")));
    let line = line.unwrap_or_else(|| panic!("no {preset} in {table}"));
    line.split('|').map(|cell| cell.trim().to_owned()).collect()
}

#[test]
fn the_neuron_aimed_at_follows_in_half_of_the_aims_and_more() {
    let program = host_sim!();
    let table = program.ok("graph --worlds 12 --first 1 --markdown");
    let reached = |preset| -> f64 { row(&table, preset)[7].parse().expect("percent") };
    assert!(reached("graph") >= 50.0, "{table}");
    assert!(
        reached("probe") < 50.0 && reached("touzet") < 50.0,
        "{table}"
    );
    assert_eq!(
        row(&table, "default")[6],
        "0",
        "one step aims at no neuron: {table}"
    );
    let threads = "graph --worlds 12 --first 1 --markdown --threads 1";
    assert_eq!(program.ok(threads), table);
}

#[test]
fn where_one_step_leads_nearer_it_is_the_default() {
    let line = |preset: &str| {
        let flags = "run --json --steps 300 --world random:3";
        let text = host_sim!().ok(&format!("{flags} --behavior avoid --preset {preset}"));
        text.replace(&format!("\"{preset}\""), "")
    };
    assert_eq!(line("graph"), line("default"));
}

#[test]
fn devices_and_kinds_of_rooms_are_refused() {
    let program = host_sim!();
    for (flags, words) in [
        (
            "run --preset graph --mind tcp:127.0.0.1:1",
            "only with --mind host",
        ),
        ("graph --kinds --generator random", "--kinds: only"),
        ("graph --generator mazes", "mazes"),
    ] {
        let output = program.run(&tests::words(flags));
        assert_eq!(output.code, Some(2), "{flags}: {}", output.stderr);
        assert!(output.stderr.contains(words), "{flags}: {}", output.stderr);
    }
}
