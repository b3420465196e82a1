//! The same seed gives the same bytes, with any number of threads.

use tests::host_sim;

#[test]
fn the_number_of_threads_does_not_matter() {
    for flags in [
        "--sonar ideal",
        "--sonar nomad",
        "--behavior nest",
        "--behavior follow",
    ] {
        let batch = |threads| {
            host_sim!().ok(&format!(
                "run --world random:1..=10 {flags} --steps 60 --json --threads {threads}"
            ))
        };
        let alone = batch(1);
        assert_eq!(alone.lines().count(), 10);
        assert_eq!(alone, batch(2), "{flags}");
        assert_eq!(alone, batch(5), "{flags}");
    }
}

#[test]
fn a_world_alone_is_as_in_a_batch() {
    let flags = "--sonar harsh --steps 60 --json";
    let batch = host_sim!().ok(&format!("run --world random:1..=6 {flags}"));
    for (seed, line) in (1..).zip(batch.lines()) {
        let alone = host_sim!().ok(&format!("run --world random:{seed} {flags}"));
        assert_eq!(alone.trim_end(), line);
    }
}

#[test]
fn pictures_do_not_change_the_figures() {
    let flags = "run --world random:4 --steps 60 --json";
    let plain = host_sim!().ok(flags);
    assert_eq!(host_sim!().ok(&format!("{flags} --out pictures")), plain);
}

#[test]
fn other_seeds_are_other_runs() {
    let figures = |flags: &str| {
        let line = host_sim!().ok(&format!("run --world room --steps 60 --json {flags}"));
        let (_, figures) = line.split_once("\"explore_moves\"").expect("the figures");
        figures.to_owned()
    };
    assert_ne!(figures("--seed 1"), figures("--seed 2"));
    assert_ne!(
        figures("--sonar nomad --seed 1"),
        figures("--sonar nomad --seed 2")
    );
}

#[test]
fn the_demo_draws_the_same_pictures_twice() {
    let demo = |flags: &str| {
        let program = host_sim!();
        let stdout = program.ok(&format!("demo --out pictures {flags}"));
        (stdout, program.files("pictures"))
    };
    let (text, files) = demo("");
    let kind = |ending: &str| {
        files
            .iter()
            .filter(|(name, _)| name.ends_with(ending))
            .count()
    };
    assert!(kind(".svg") >= 4 && kind(".png") == kind(".svg"));
    assert_eq!(kind("index.html"), 1);
    assert!(files.iter().all(|(name, _)| !name.starts_with('.')));
    let (again, twice) = demo("");
    assert_eq!(text, again);
    for (one, other) in files.iter().zip(&twice) {
        assert!(one == other, "{} differs", one.0);
    }
    assert_eq!(files.len(), twice.len());
    assert!(files != demo("--seed 2").1);
}
