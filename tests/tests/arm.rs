//! Arms: the same rows with any number of threads, and the figures of a small run.

use tests::host_sim;

fn rows(flags: &str) -> Vec<serde_json::Value> {
    let text = host_sim!().ok(&format!("arm --json {flags}"));
    let rows = text
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"));
    rows.collect()
}

fn figure(rows: &[serde_json::Value], of: [(&str, &str); 2], key: &str) -> f64 {
    let is_row = |row: &&serde_json::Value| of.iter().all(|(name, value)| row[*name] == *value);
    let row = rows.iter().find(is_row).expect("a row");
    row[key].as_f64().expect("a number")
}

#[test]
fn the_tables_do_not_depend_on_the_threads() {
    for experiment in ["reach", "pointing"] {
        let with = |threads| {
            let flags = format!("--experiment {experiment} --seeds 3 --targets 3 --markdown");
            host_sim!().ok(&format!("arm {flags} --threads {threads}"))
        };
        assert_eq!(with(1), with(2), "{experiment}");
    }
}

#[test]
fn an_arm_reaches_and_goes_around_a_region_with_the_same_maps() {
    let rows = rows("--seeds 4 --targets 40 --out arm");
    let maps = "two maps, 16 neurons";
    let share = |task, method, key| figure(&rows, [("task", task), ("method", method)], key);
    let reached = |method| share("hand in space", method, "reached");
    assert!(reached(maps) >= 0.86, "{}", reached(maps));
    // Neither one linear model nor the nearest sample does.
    assert!(reached("one neuron, learning on") <= 0.70);
    assert!(reached("nearest sample") <= 0.05);
    assert!(reached("known geometry, inverse kinematics") == 1.0);
    let inside = |task| share(task, maps, "hand_inside");
    let (without, with) = (inside("region, not told"), inside("region avoided"));
    assert!(without >= 0.10 && with <= 0.05, "{without} {with}");
}

#[test]
fn an_eye_and_an_arm_point_at_targets() {
    let rows = rows("--experiment pointing --seeds 3 --targets 20 --out arm");
    let maps = "two maps, 16 neurons";
    let mine = rows
        .iter()
        .find(|row| row["method"] == maps)
        .expect("a row");
    assert!(
        mine["pointed"].as_f64().expect("a number") >= 0.97,
        "{mine}"
    );
    assert!(
        mine["median_error_deg"].as_f64().expect("a number") < 0.25,
        "{mine}"
    );
    let nearest = rows.iter().find(|row| row["method"] == "nearest sample");
    let pointed = nearest.expect("a row")["pointed"].as_f64();
    assert!(pointed.expect("a number") < 0.2);
}

#[test]
fn a_row_is_what_it_always_was() {
    let text = host_sim!().ok("arm --seeds 2 --targets 10 --markdown");
    let row = text.lines().nth(2).expect("a row");
    let golden = "| hand in space | two maps, 16 neurons | 90.0 [75.0, 100.0] | 50.0 | 7.8 | 1.1 | 10.4 | – |";
    assert_eq!(row, golden, "{text}");
}
