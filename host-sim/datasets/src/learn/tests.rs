//! Logs with known rules: what can be recalled is, what cannot be is not.

use super::log::{Actions, Columns, Log, MAX_LABELS};
use super::score::{Score, class};
use super::study::{Lesson, Map, Method, Recalled, Study, study};
use super::task::{Options, Part, Task};
use arena::noise::Noise;
use arena::sonar::{Ring, SonarModel};
use arena::world::{Point, Pose, Shape, World};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};
use tinysom::Grid;

const OPTIONS: Options = Options {
    near: 0.0,
    far: Some(4.5),
    held_out: 0.3,
    stride: 1,
};

const LESSON: Lesson = Lesson {
    epochs: 20,
    seed: 1,
    action_weight: 1.0,
};

/// Ranges of the simulated ring in m, and the quarter of the step that followed: 0 along x, 1 along
/// y, ….
type Row = ([f64; 16], usize);

/// A random walk of steps along the axes in an empty room of 4 m × 5 m; the ring keeps its bearing.
fn walk(rows: usize) -> Vec<Row> {
    let corners = [
        (-2.0, -2.5),
        (2.0, -2.5),
        (2.0, 2.5),
        (-2.0, 2.5),
        (-2.0, -2.5),
    ];
    let points = corners.map(|(x, y)| Point::new(x, y)).to_vec();
    let world = World::new("room", Pose::default(), vec![Shape::Wall { points }]).unwrap();
    let mut noise = Noise::new(9);
    let mut ring = Ring::new(SonarModel::Ideal, &mut noise);
    let mut at = Point::default();
    let mut log = Vec::new();
    while log.len() < rows {
        let quarter = noise.index(4);
        let next = at + Point::unit(quarter as f64 * FRAC_PI_2) * 0.25;
        if world.is_inside(next) || world.clearance(next) < 0.3 {
            continue;
        }
        let mut ranges = [None; 16];
        ring.scan(&world, &Pose::new(at, 0.0), &mut ranges);
        log.push((ranges.map(|range| range.unwrap_or(4.5)), quarter));
        at = next;
    }
    log
}

/// The quarter of the ring in which something is nearest.
fn nearest_quarter(ranges: &[f64; 16]) -> usize {
    let nearest = (0..16).min_by(|&a, &b| ranges[a].total_cmp(&ranges[b]));
    let bearing = nearest.unwrap_or(0) as f64 * TAU / 16.0;
    ((bearing + FRAC_PI_4) / FRAC_PI_2) as usize % 4
}

fn text(rows: &[Row], label: impl Fn(usize, &Row) -> String) -> String {
    let row = |(index, row): (usize, &Row)| {
        let ranges: Vec<_> = row.0.iter().map(|range| format!("{range:.3}")).collect();
        format!("{},{}\n", ranges.join(","), label(index, row))
    };
    rows.iter().enumerate().map(row).collect()
}

fn found(text: &str, columns: &Columns, side: u16) -> Study {
    let log = Log::parse("log.csv", text, columns).unwrap();
    let task = Task::of(&log, &OPTIONS).unwrap();
    study(&task, &[Grid::rectangle(side, side)], &LESSON, &|| {}).unwrap()
}

fn score(study: &Study, method: Method) -> &Score {
    let mut all = study.references.iter().chain(&study.maps[0].recalls);
    let recalled: &Recalled = all.find(|recalled| recalled.method == method).unwrap();
    &recalled.score
}

fn accuracy(study: &Study, method: Method) -> f64 {
    score(study, method).accuracy().unwrap().mean
}

#[test]
fn a_label_of_the_situation_is_recalled_by_the_situation() {
    let rows = walk(900);
    let by_rule = text(&rows, |_, (ranges, _)| {
        format!("side {}", nearest_quarter(ranges))
    });
    let study = found(&by_rule, &Columns::default(), 8);
    let majority = accuracy(&study, Method::Mean);
    assert!(majority < 0.7, "{majority}");
    for method in [
        Method::ActionBySituation,
        Method::SituationMap,
        Method::NearestSituation,
    ] {
        let right = accuracy(&study, method);
        assert!(
            right > majority + 0.05,
            "{method:?}: {right}, majority {majority}"
        );
    }
    assert!(accuracy(&study, Method::ActionBySituation) > 0.8);
}

#[test]
fn a_label_of_the_move_is_recalled_by_the_change() {
    let rows = walk(900);
    let by_move = text(&rows, |_, (_, quarter)| format!("towards {quarter}"));
    let study = found(&by_move, &Columns::default(), 6);
    let by_change =
        [Method::ActionByChange, Method::NearestChange].map(|method| accuracy(&study, method));
    assert!(by_change.iter().all(|right| *right > 0.8), "{by_change:?}");
    // The next step is chance: the situation says no more of it than where there is no room.
    let by_situation = [Method::ActionBySituation, Method::NearestSituation]
        .map(|method| accuracy(&study, method));
    assert!(
        by_situation.iter().all(|right| *right < 0.5),
        "{by_situation:?}"
    );
}

#[test]
fn shuffled_labels_are_recalled_no_better_than_by_the_most_frequent_one() {
    let rows = walk(900);
    let mut noise = Noise::new(4);
    let mut labels: Vec<_> = rows
        .iter()
        .map(|(ranges, _)| nearest_quarter(ranges))
        .collect();
    for last in (1..labels.len()).rev() {
        labels.swap(last, noise.index(last + 1));
    }
    let shuffled = text(&rows, |index, _| format!("side {}", labels[index]));
    let study = found(&shuffled, &Columns::default(), 8);
    let majority = accuracy(&study, Method::Mean);
    for method in [
        Method::ActionBySituation,
        Method::SituationMap,
        Method::ActionByChange,
        Method::NearestSituation,
    ] {
        let right = accuracy(&study, method);
        assert!(
            right < majority + 0.05,
            "{method:?}: {right}, majority {majority}"
        );
    }
}

#[test]
fn velocities_are_recalled_by_the_change_they_brought() {
    let rows = walk(900);
    let velocity = |_, row: &Row| {
        let way = Point::unit(row.1 as f64 * FRAC_PI_2) * 0.25;
        format!("{:.3},{:.3}", way.x, way.y)
    };
    let columns = Columns {
        velocities: Some("17,18".to_owned()),
        ..Columns::default()
    };
    let study = found(&text(&rows, velocity), &columns, 6);
    let mean = score(&study, Method::Mean);
    let beside = |method| score(&study, method).error_beside(mean).unwrap();
    assert!((beside(Method::Mean) - 1.0).abs() < 1e-12);
    assert!(
        beside(Method::ActionByChange) < 0.6,
        "{}",
        beside(Method::ActionByChange)
    );
    assert!(beside(Method::ActionBySituation) > 0.9);
}

#[test]
fn larger_maps_fit_better_and_a_seed_is_a_seed() {
    let rows = walk(400);
    let log = text(&rows, |_, (ranges, _)| nearest_quarter(ranges).to_string());
    let log = Log::parse("log.csv", &log, &Columns::default()).unwrap();
    let task = Task::of(&log, &OPTIONS).unwrap();
    let grids = [4, 10].map(|side| Grid::rectangle(side, side));
    let [first, second] = [(); 2].map(|()| study(&task, &grids, &LESSON, &|| {}).unwrap());
    let error = |map: &Map| map.learned.quantization_error;
    assert!(error(&first.maps[1]) < 0.8 * error(&first.maps[0]));
    for (a, b) in first.maps.iter().zip(&second.maps) {
        assert_eq!((&a.situations, &a.recalls), (&b.situations, &b.recalls));
    }
    assert_eq!(
        first.maps[0].learned.hits.iter().sum::<usize>(),
        task.rows(Part::Learned)
    );
}

#[test]
fn a_task_is_what_the_log_says() {
    let text = "a;b;do\n1;inf;left\n3;2;right\n5;4;right\n5;4;left\n";
    let log = Log::parse("log.csv", text, &Columns::default()).unwrap();
    assert_eq!(log.names, ["a", "b"]);
    assert_eq!(
        log.actions,
        Actions::Labels {
            names: vec!["left".into(), "right".into()],
            of: vec![0, 1, 1, 0]
        }
    );
    let options = Options {
        near: 1.0,
        far: None,
        held_out: 0.5,
        ..OPTIONS
    };
    let task = Task::of(&log, &options).unwrap();
    assert_eq!(
        (task.near, task.far, task.rows(Part::Learned)),
        (1.0, 5.0, 2)
    );
    let values = |pairs: super::task::Pairs| -> Vec<f64> {
        pairs.inputs.iter().map(|value| value.to_num()).collect()
    };
    assert_eq!(
        values(task.situations(Part::Learned)),
        [1.0, 0.0, 0.5, 0.75]
    );
    let change = task.changes(Part::Learned);
    assert_eq!(change.actions, [[1.0, 0.0]]);
    assert_eq!(values(change), [-0.5, 0.75]);
}

#[test]
fn columns_are_named_or_counted() {
    let text = "t,front,left,v,w,do\nx,1,2,0.1,-0.2,go\ny,3,4,0.2,0.3,stop\n";
    let log = |ranges: Option<&str>, label: Option<&str>, velocities: Option<&str>| {
        let columns = Columns {
            ranges: ranges.map(str::to_owned),
            label: label.map(str::to_owned),
            velocities: velocities.map(str::to_owned),
            headed: None,
        };
        Log::parse("log.csv", text, &columns).map_err(|error| error.to_string())
    };
    let velocities = log(None, None, Some("v,w")).unwrap();
    assert_eq!(velocities.names, ["front", "left"]);
    assert_eq!(
        velocities.actions,
        Actions::Velocities {
            names: vec!["v".into(), "w".into()],
            of: vec![vec![0.1, -0.2], vec![0.2, 0.3]]
        }
    );
    assert_eq!(
        log(Some("2-3"), Some("do"), None).unwrap().ranges,
        [[1.0, 2.0], [3.0, 4.0]]
    );
    assert_eq!(
        log(Some("left,2"), None, None).unwrap().names,
        ["left", "front"]
    );
    for (ranges, label, velocities, why) in [
        (
            Some("font"),
            None,
            None,
            "no column \"font\", did you mean \"front\"?",
        ),
        (Some("2-9"), None, None, "no column \"2-9\""),
        (Some("0"), None, None, "no column \"0\""),
        (Some("2,front"), None, None, "front is named twice"),
        (
            Some("2,6"),
            None,
            None,
            "column do of log.csv holds the action already",
        ),
        (None, Some("7"), None, "no column \"7\""),
        (
            Some("1"),
            None,
            None,
            "log.csv, line 2, column 1: \"x\" is not a number",
        ),
        (
            Some("5"),
            None,
            None,
            "log.csv, line 2, column 5: \"-0.2\" is no range",
        ),
        (
            None,
            None,
            Some("do"),
            "log.csv, line 2, column 6: \"go\" is not a number",
        ),
    ] {
        let error = log(ranges, label, velocities).expect_err(why);
        assert!(error.contains(why), "{error}");
    }
}

#[test]
fn bad_logs_are_named_with_line_and_column() {
    let say = |text: &str| {
        let log = Log::parse("log.csv", text, &Columns::default());
        let task = log.and_then(|log| Task::of(&log, &OPTIONS));
        task.map(|_| ()).expect_err(text).to_string()
    };
    assert!(say("").contains("log.csv: the file is empty"));
    assert!(say("1,2,go\n1,x,go\n").contains("log.csv, line 2, column 2: \"x\" is not a number"));
    assert!(say("1,2,go\n1,,go\n").contains("line 2, column 2: the field is empty"));
    assert!(say("1,2,go\n1,nan,go\n").contains("line 2, column 2: \"nan\" is no range"));
    assert!(say("1,2,go\n1,2,\n").contains("line 2, column 3: the label is empty"));
    assert!(say("1,2,go\n1,2\n").contains("line 2: 2 fields where line 1 has 3"));
    assert!(say("go\nstop\n").contains("ranges"));
    assert!(say("1,go\n2,go\n").contains("both must be more than --stride 1"));
    let zero = Log::parse("log.csv", "0,go\n0,go\n0,go\n0,go\n", &Columns::default()).unwrap();
    let options = Options {
        far: None,
        ..OPTIONS
    };
    let error = Task::of(&zero, &options).unwrap_err().to_string();
    assert!(error.contains("--near 0 must"), "{error}");
    let many: String = (0..=MAX_LABELS).map(|i| format!("1,{i}\n")).collect();
    assert!(say(&many).contains("column 2 holds 65 different labels"));
}

#[test]
fn scores_are_counted_by_hand() {
    let score = Score::Classes {
        confusion: vec![vec![3, 1, 0], vec![2, 2, 0], vec![0, 0, 0]],
        right: vec![true, true, true, false, false, false, true, true],
    };
    assert_eq!(score.accuracy().unwrap().mean, 5.0 / 8.0);
    assert_eq!(score.by_class(), [Some(0.75), Some(0.5), None]);
    assert_eq!(score.balanced(), 0.625);
    assert_eq!(class(&[0.2, 0.7, 0.7]), 1);
    let [a, b] = [vec![1.0, 1.0], vec![2.0, 4.0]].map(|rms| Score::Velocities { rms });
    assert_eq!(a.error_beside(&b), Some(0.375));
}
