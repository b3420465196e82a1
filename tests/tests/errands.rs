//! A robot that is sent from place to place while its world changes.

use tests::host_sim;

const FLAGS: &str = "errands --robot p3dx --ranges nomad --world random:3 --world random:4 \
                     --places 2 --rounds 2 --change-every 1 --steps 200";

#[test]
fn the_table_does_not_depend_on_the_threads() {
    let with = |threads| host_sim!().ok(&format!("{FLAGS} --markdown --threads {threads}"));
    assert_eq!(with(1), with(2));
}

#[test]
fn each_drive_is_a_line_of_json() {
    let text = host_sim!().ok(&format!("{FLAGS} --json --out errands"));
    let drives: Vec<serde_json::Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    // Two worlds, two rounds, two places and home.
    assert_eq!(drives.len(), 12);
    for drive in &drives {
        let is_obstructed = drive["is_obstructed"] == true;
        assert!(is_obstructed || drive["is_there"] == true, "{drive}");
        assert!(drive["period"] == 1 || !is_obstructed, "{drive}");
    }
    assert!(drives.iter().any(|drive| drive["is_obstructed"] == true));
}

#[test]
fn the_table_has_a_row_for_each_round_and_the_picture_is_drawn() {
    let text = host_sim!().ok(&format!("{FLAGS} --out errands"));
    let rows: Vec<_> = text.lines().collect();
    assert!(rows[0].starts_with("round  drives"), "{text}");
    for (row, start) in [
        (2, "    1       6           0  100.0"),
        (3, "    2       6 "),
    ] {
        assert!(rows[row].starts_with(start), "{text}");
    }
    assert!(text.contains("2 worlds, 2 places and home, robot p3dx; an obstacle"));
    assert!(text.contains("Picture: errands/errands.svg"));
}
