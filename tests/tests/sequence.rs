//! Sequences recalled by a pair of associative memories, and patrols that go by them.

use tests::host_sim;

const FLAGS: &str = "sequence --seeds 2 --cues 2 --corrected-bits 0 --threads 2";

#[test]
fn figures_are_what_they_always_were() {
    let text = host_sim!().ok(&format!("{FLAGS} --json"));
    let lines: Vec<_> = text.lines().collect();
    // Two kinds of elements: three methods in four sizes, and seven in 2·9 + 6 + 2 conditions.
    assert_eq!(lines.len(), 2 * (3 * 4 + 7 * 26));
    for golden in GOLDEN {
        assert!(lines.contains(&golden), "{golden} is not in\n{text}");
    }
}

const GOLDEN: [&str; 3] = [
    r#"{"elements":"random","measure":"longest","method":"pair","at":512,"mean":34.5,"interval":[31.0,38.0]}"#,
    r#"{"elements":"situations","measure":"steps","method":"pair-corrected","at":25,"mean":0.5,"interval":[0.0,1.0]}"#,
    r#"{"elements":"situations","measure":"shared","method":"pair-corrected","at":1,"mean":0.25,"interval":[0.0,0.5]}"#,
];

#[test]
fn the_tables_are_whole_and_the_pictures_are_drawn() {
    let program = host_sim!();
    let text = program.ok(&format!("{FLAGS} --markdown --out drawn"));
    let heads = text
        .lines()
        .filter(|line| line.starts_with("| elements | method |"));
    assert_eq!(heads.count(), 5, "{text}");
    assert!(text.contains("2 draws, 2 cues for each share of noise"));
    for name in ["longest", "noise-random", "noise-situations", "recalled"] {
        assert!(
            text.contains(&format!("Picture: drawn/{name}.svg")),
            "{text}"
        );
        assert!(program.folder().join(format!("drawn/{name}.png")).exists());
    }
}

#[test]
fn a_patrol_goes_round_from_any_station() {
    let flags = "patrol --world room --station 1,1 --station -1,1 --station 0,-1";
    let rounds = host_sim!().ok(&format!("{flags} --json --threads 1"));
    assert_eq!(
        rounds,
        host_sim!().ok(&format!("{flags} --json --threads 2"))
    );
    let rounds: Vec<serde_json::Value> = rounds
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    let names: Vec<_> = rounds.iter().map(|round| &round["namer"]).collect();
    assert_eq!(names, ["pair", "table", "list"]);
    for round in &rounds {
        assert_eq!(
            (&round["reached"], &round["stations"]),
            (&3.into(), &3.into())
        );
        assert!(round["error_m"].as_f64().is_some_and(|error| error < 0.3));
    }
}
