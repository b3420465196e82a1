//! Recall on simulated logs whose labels follow known rules.

use super::dataset::{Dataset, DatasetOptions, InputActionPairs, Split};
use super::evaluation::{Evaluation, MapResult, MethodScore, RecallMethod, TrainOptions, evaluate};
use super::log::{Actions, Log, LogColumns, MAX_LABELS};
use super::score::{Score, class};
use arena::noise::Noise;
use arena::sonar::{Ring, SonarModel};
use arena::world::{Point, Pose, Shape, World};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};
use tinysom::Grid;

const DATASET_OPTIONS: DatasetOptions = DatasetOptions {
    near: 0.0,
    far: Some(4.5),
    held_out: 0.3,
    stride: 1,
};

const TRAIN_OPTIONS: TrainOptions = TrainOptions {
    epochs: 20,
    seed: 1,
    action_weight: 1.0,
};

/// Ranges of the simulated ring in m, and the direction of the next step in quarter turns: 0 along
/// x, 1 along y, ….
type LogRow = ([f64; 16], usize);

/// A random walk with steps along the axes in an empty room of 4 m × 5 m; the ring does not turn.
fn random_walk(rows: usize) -> Vec<LogRow> {
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
    let mut position = Point::default();
    let mut log = Vec::new();
    while log.len() < rows {
        let quarter = noise.index(4);
        let next = position + Point::unit(quarter as f64 * FRAC_PI_2) * 0.25;
        if world.is_inside(next) || world.clearance(next) < 0.3 {
            continue;
        }
        let mut ranges = [None; 16];
        ring.scan(&world, &Pose::new(position, 0.0), &mut ranges);
        log.push((ranges.map(|range| range.unwrap_or(4.5)), quarter));
        position = next;
    }
    log
}

/// The quarter of the ring with the smallest range.
fn nearest_quarter(ranges: &[f64; 16]) -> usize {
    let nearest = (0..16).min_by(|&a, &b| ranges[a].total_cmp(&ranges[b]));
    let bearing = nearest.unwrap_or(0) as f64 * TAU / 16.0;
    ((bearing + FRAC_PI_4) / FRAC_PI_2) as usize % 4
}

fn log_text(rows: &[LogRow], label: impl Fn(usize, &LogRow) -> String) -> String {
    let row = |(index, row): (usize, &LogRow)| {
        let ranges: Vec<_> = row.0.iter().map(|range| format!("{range:.3}")).collect();
        format!("{},{}\n", ranges.join(","), label(index, row))
    };
    rows.iter().enumerate().map(row).collect()
}

fn evaluate_log(text: &str, columns: &LogColumns, side: u16) -> Evaluation {
    let log = Log::parse("log.csv", text, columns).unwrap();
    let dataset = Dataset::from_log(&log, &DATASET_OPTIONS).unwrap();
    evaluate(
        &dataset,
        &[Grid::rectangle(side, side)],
        &TRAIN_OPTIONS,
        &|| {},
    )
    .unwrap()
}

fn score(evaluation: &Evaluation, method: RecallMethod) -> &Score {
    let mut all = evaluation
        .baselines
        .iter()
        .chain(&evaluation.maps[0].scores);
    let found: &MethodScore = all.find(|score| score.method == method).unwrap();
    &found.score
}

fn accuracy(evaluation: &Evaluation, method: RecallMethod) -> f64 {
    score(evaluation, method).accuracy().unwrap().mean
}

#[test]
fn labels_that_depend_on_the_situation_are_recalled_by_the_situation() {
    let rows = random_walk(900);
    let by_rule = log_text(&rows, |_, (ranges, _)| {
        format!("side {}", nearest_quarter(ranges))
    });
    let evaluation = evaluate_log(&by_rule, &LogColumns::default(), 8);
    let majority = accuracy(&evaluation, RecallMethod::Mean);
    assert!(majority < 0.7, "{majority}");
    for method in [
        RecallMethod::ActionBySituation,
        RecallMethod::SituationMap,
        RecallMethod::NearestSituation,
    ] {
        let share = accuracy(&evaluation, method);
        assert!(
            share > majority + 0.05,
            "{method:?}: {share}, majority {majority}"
        );
    }
    assert!(accuracy(&evaluation, RecallMethod::ActionBySituation) > 0.8);
}

#[test]
fn labels_that_depend_on_the_move_are_recalled_by_the_change() {
    let rows = random_walk(900);
    let by_move = log_text(&rows, |_, (_, quarter)| format!("towards {quarter}"));
    let evaluation = evaluate_log(&by_move, &LogColumns::default(), 6);
    let by_change = [RecallMethod::ActionByChange, RecallMethod::NearestChange]
        .map(|method| accuracy(&evaluation, method));
    assert!(by_change.iter().all(|share| *share > 0.8), "{by_change:?}");
    // The step is random: the situation only excludes steps into a wall.
    let by_situation = [
        RecallMethod::ActionBySituation,
        RecallMethod::NearestSituation,
    ]
    .map(|method| accuracy(&evaluation, method));
    assert!(
        by_situation.iter().all(|share| *share < 0.5),
        "{by_situation:?}"
    );
}

#[test]
fn shuffled_labels_are_recalled_no_better_than_by_the_most_frequent_label() {
    let rows = random_walk(900);
    let mut noise = Noise::new(4);
    let mut labels: Vec<_> = rows
        .iter()
        .map(|(ranges, _)| nearest_quarter(ranges))
        .collect();
    for last in (1..labels.len()).rev() {
        labels.swap(last, noise.index(last + 1));
    }
    let shuffled = log_text(&rows, |index, _| format!("side {}", labels[index]));
    let evaluation = evaluate_log(&shuffled, &LogColumns::default(), 8);
    let majority = accuracy(&evaluation, RecallMethod::Mean);
    for method in [
        RecallMethod::ActionBySituation,
        RecallMethod::SituationMap,
        RecallMethod::ActionByChange,
        RecallMethod::NearestSituation,
    ] {
        let share = accuracy(&evaluation, method);
        assert!(
            share < majority + 0.05,
            "{method:?}: {share}, majority {majority}"
        );
    }
}

#[test]
fn velocities_are_recalled_by_the_change_they_cause() {
    let rows = random_walk(900);
    let velocity = |_, row: &LogRow| {
        let step = Point::unit(row.1 as f64 * FRAC_PI_2) * 0.25;
        format!("{:.3},{:.3}", step.x, step.y)
    };
    let columns = LogColumns {
        velocities: Some("17,18".to_owned()),
        ..LogColumns::default()
    };
    let evaluation = evaluate_log(&log_text(&rows, velocity), &columns, 6);
    let mean = score(&evaluation, RecallMethod::Mean);
    let relative_error = |method| score(&evaluation, method).relative_error(mean).unwrap();
    assert!((relative_error(RecallMethod::Mean) - 1.0).abs() < 1e-12);
    assert!(
        relative_error(RecallMethod::ActionByChange) < 0.6,
        "{}",
        relative_error(RecallMethod::ActionByChange)
    );
    assert!(relative_error(RecallMethod::ActionBySituation) > 0.9);
}

#[test]
fn larger_maps_fit_better_and_results_are_deterministic() {
    let rows = random_walk(400);
    let log = log_text(&rows, |_, (ranges, _)| nearest_quarter(ranges).to_string());
    let log = Log::parse("log.csv", &log, &LogColumns::default()).unwrap();
    let dataset = Dataset::from_log(&log, &DATASET_OPTIONS).unwrap();
    let grids = [4, 10].map(|side| Grid::rectangle(side, side));
    let [first, second] =
        [(); 2].map(|()| evaluate(&dataset, &grids, &TRAIN_OPTIONS, &|| {}).unwrap());
    let error = |map: &MapResult| map.training.quantization_error;
    assert!(error(&first.maps[1]) < 0.8 * error(&first.maps[0]));
    for (a, b) in first.maps.iter().zip(&second.maps) {
        assert_eq!((&a.situations, &a.scores), (&b.situations, &b.scores));
    }
    assert_eq!(
        first.maps[0].training.hits.iter().sum::<usize>(),
        dataset.rows(Split::Training)
    );
}

#[test]
fn a_dataset_follows_from_the_log() {
    let text = "a;b;do\n1;inf;left\n3;2;right\n5;4;right\n5;4;left\n";
    let log = Log::parse("log.csv", text, &LogColumns::default()).unwrap();
    assert_eq!(log.names, ["a", "b"]);
    assert_eq!(
        log.actions,
        Actions::Labels {
            names: vec!["left".into(), "right".into()],
            by_row: vec![0, 1, 1, 0]
        }
    );
    let options = DatasetOptions {
        near: 1.0,
        far: None,
        held_out: 0.5,
        ..DATASET_OPTIONS
    };
    let dataset = Dataset::from_log(&log, &options).unwrap();
    assert_eq!(
        (dataset.near, dataset.far, dataset.rows(Split::Training)),
        (1.0, 5.0, 2)
    );
    let values = |pairs: InputActionPairs| -> Vec<f64> {
        pairs.inputs.iter().map(|value| value.to_num()).collect()
    };
    assert_eq!(
        values(dataset.situations(Split::Training)),
        [1.0, 0.0, 0.5, 0.75]
    );
    let change = dataset.changes(Split::Training);
    assert_eq!(change.actions, [[1.0, 0.0]]);
    assert_eq!(values(change), [-0.5, 0.75]);
}

#[test]
fn columns_are_given_by_name_or_number() {
    let text = "t,front,left,v,w,do\nx,1,2,0.1,-0.2,go\ny,3,4,0.2,0.3,stop\n";
    let log = |ranges: Option<&str>, label: Option<&str>, velocities: Option<&str>| {
        let columns = LogColumns {
            ranges: ranges.map(str::to_owned),
            label: label.map(str::to_owned),
            velocities: velocities.map(str::to_owned),
            has_heading: None,
        };
        Log::parse("log.csv", text, &columns).map_err(|error| error.to_string())
    };
    let velocities = log(None, None, Some("v,w")).unwrap();
    assert_eq!(velocities.names, ["front", "left"]);
    assert_eq!(
        velocities.actions,
        Actions::Velocities {
            names: vec!["v".into(), "w".into()],
            by_row: vec![vec![0.1, -0.2], vec![0.2, 0.3]]
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
    for (ranges, label, velocities, expected) in [
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
        let error = log(ranges, label, velocities).expect_err(expected);
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn errors_name_line_and_column() {
    let error_of = |text: &str| {
        let log = Log::parse("log.csv", text, &LogColumns::default());
        let dataset = log.and_then(|log| Dataset::from_log(&log, &DATASET_OPTIONS));
        dataset.map(|_| ()).expect_err(text).to_string()
    };
    assert!(error_of("").contains("log.csv: the file is empty"));
    assert!(
        error_of("1,2,go\n1,x,go\n").contains("log.csv, line 2, column 2: \"x\" is not a number")
    );
    assert!(error_of("1,2,go\n1,,go\n").contains("line 2, column 2: the field is empty"));
    assert!(error_of("1,2,go\n1,nan,go\n").contains("line 2, column 2: \"nan\" is no range"));
    assert!(error_of("1,2,go\n1,2,\n").contains("line 2, column 3: the label is empty"));
    assert!(error_of("1,2,go\n1,2\n").contains("line 2: 2 fields where line 1 has 3"));
    assert!(error_of("go\nstop\n").contains("ranges"));
    assert!(error_of("1,go\n2,go\n").contains("both must be more than --stride 1"));
    let zero = Log::parse(
        "log.csv",
        "0,go\n0,go\n0,go\n0,go\n",
        &LogColumns::default(),
    )
    .unwrap();
    let options = DatasetOptions {
        far: None,
        ..DATASET_OPTIONS
    };
    let error = Dataset::from_log(&zero, &options).unwrap_err().to_string();
    assert!(error.contains("--near 0 must"), "{error}");
    let many: String = (0..=MAX_LABELS).map(|i| format!("1,{i}\n")).collect();
    assert!(error_of(&many).contains("column 2 holds 65 different labels"));
}

#[test]
fn scores_match_hand_computed_values() {
    let score = Score::Classes {
        confusion: vec![vec![3, 1, 0], vec![2, 2, 0], vec![0, 0, 0]],
        correct: vec![true, true, true, false, false, false, true, true],
    };
    assert_eq!(score.accuracy().unwrap().mean, 5.0 / 8.0);
    assert_eq!(score.by_class(), [Some(0.75), Some(0.5), None]);
    assert_eq!(score.balanced_accuracy(), 0.625);
    assert_eq!(class(&[0.2, 0.7, 0.7]), 1);
    let [a, b] = [vec![1.0, 1.0], vec![2.0, 4.0]].map(|rms| Score::Velocities { rms });
    assert_eq!(a.relative_error(&b), Some(0.375));
}
