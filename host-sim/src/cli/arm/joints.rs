//! The table and the curves of `host-sim arm --experiment joints`.

use super::{ArmArgs, CliError, bar};
use crate::cli::table;
use experiments::arm::body::ArmBody;
use experiments::arm::reach::{
    ArmMethod, MAX_MOVES, Obstruction, ReachRow, ReachTrial, TOLERANCE, reaches, row,
};
use plots::{CurveKey, Curves, save_picture};
use rayon::ThreadPool;
use serde_json::json;
use std::io::Write;

/// Numbers of joints.
const JOINTS: [usize; 5] = [2, 3, 5, 10, 20];
/// Numbers of random moves.
const MOVES: [u32; 4] = [30, 100, 300, 1_000];
/// Random moves of the methods that are measured with one number only.
const ONLY_MOVES: u32 = 100;
/// Methods, and whether they are measured with all numbers of moves.
const METHODS: [(ArmMethod, bool); 5] = [
    (ArmMethod::Maps, true),
    (ArmMethod::LocalOnline, true),
    (ArmMethod::QTwoMaps(1), false),
    (ArmMethod::QTwoMaps(10), false),
    (ArmMethod::QTwoMaps(100), false),
];

const HEADS: [&str; 7] = [
    "joints",
    "random moves",
    "method",
    "reached, %",
    "error, %",
    "median, %",
    "moves",
];

/// A row of the table.
struct Measured {
    joints: usize,
    moves: u32,
    method: ArmMethod,
    row: ReachRow,
}

impl Measured {
    /// Its name: samples are counted by the number of joints here.
    fn name(&self) -> &'static str {
        match self.method {
            ArmMethod::LocalOnline => "least squares on 4 samples per joint, remembering on",
            method => method.name(),
        }
    }
}

/// Measures and prints.
pub(super) fn joints(
    args: &ArmArgs,
    pool: &ThreadPool,
    out: &mut impl Write,
) -> Result<(), CliError> {
    let planned = planned();
    let progress = bar(planned.len() as u64 * u64::from(args.seeds), "seeds");
    let mut rows = Vec::new();
    for (joints, moves, method) in planned {
        let trial = ReachTrial {
            first_seed: args.first,
            seeds: args.seeds,
            explore_moves: moves,
            targets: args.targets(),
            obstruction: Obstruction::None,
        };
        let (body, done) = (ArmBody::planar(joints), || progress.inc(1));
        let seeds = pool.install(|| reaches(&body, method, &trial, &done));
        rows.push(Measured {
            joints,
            moves,
            method,
            row: row(&seeds),
        });
    }
    progress.finish_and_clear();
    if args.json {
        print_json(&rows, out)?;
    } else {
        print_table(args, &rows, out)?;
    }
    let Some(dir) = &args.out else {
        return Ok(());
    };
    let [picture, _] = save_picture(dir, "arm-joints", &picture(args, &rows))?;
    if !args.json {
        writeln!(out, "Picture: {}", picture.display())?;
    }
    Ok(())
}

fn planned() -> Vec<(usize, u32, ArmMethod)> {
    let mut planned = Vec::new();
    for joints in JOINTS {
        for (method, has_all) in METHODS {
            let moves = MOVES.into_iter().filter(|m| has_all || *m == ONLY_MOVES);
            planned.extend(moves.map(|moves| (joints, moves, method)));
        }
    }
    planned
}

fn print_table(args: &ArmArgs, rows: &[Measured], out: &mut impl Write) -> Result<(), CliError> {
    let format = if args.markdown {
        table::markdown
    } else {
        table::plain
    };
    let cells = |measured: &Measured| {
        let row = &measured.row;
        vec![
            measured.joints.to_string(),
            measured.moves.to_string(),
            measured.name().to_owned(),
            format!("{:.1}", row.reached.percent()),
            format!("{:.1}", row.error.percent()),
            format!("{:.1}", 100.0 * row.median_error),
            format!("{:.1}", row.moves.mean),
        ]
    };
    let cells: Vec<_> = rows.iter().map(cells).collect();
    out.write_all(format(&HEADS, &cells, &[0, 1, 3, 4, 5, 6]).as_bytes())?;
    writeln!(
        out,
        "\n{} seeds × {} targets; reached: within {:.0} % of the reach in at most {MAX_MOVES} \
         moves. [95 % interval]",
        args.seeds,
        args.targets(),
        100.0 * TOLERANCE
    )?;
    Ok(())
}

fn print_json(rows: &[Measured], out: &mut impl Write) -> Result<(), CliError> {
    for measured in rows {
        let row = &measured.row;
        let object = json!({
            "joints": measured.joints,
            "explore_moves": measured.moves,
            "method": measured.name(),
            "targets": row.count,
            "reached": row.reached.mean,
            "reached_interval": row.reached.interval,
            "error": row.error.mean,
            "median_error": row.median_error,
            "moves": row.moves.mean,
        });
        writeln!(out, "{object}")?;
    }
    Ok(())
}

/// Success and error by random moves and by joints.
fn picture(args: &ArmArgs, rows: &[Measured]) -> String {
    let key = CurveKey {
        subtitle: format!(
            "{} seeds × {} targets; within {:.0} % of the reach; mean and 95 % interval",
            args.seeds,
            args.targets(),
            100.0 * TOLERANCE
        ),
        along: "random moves".to_owned(),
        ticks: (0..).zip(MOVES.map(|moves| moves.to_string())).collect(),
        names: vec![
            ("two maps, 16 neurons".to_owned(), false),
            ("local least squares".to_owned(), true),
        ],
    };
    let line = |joints: usize, method: ArmMethod| {
        let mine = rows
            .iter()
            .filter(|m| m.joints == joints && m.method == method);
        mine.map(|measured| measured.row.reached.percent())
            .collect()
    };
    let panel = |joints: usize| Curves {
        title: format!("{joints} joints"),
        measure: "targets reached, %".to_owned(),
        within: [0.0, 100.0],
        lines: vec![
            line(joints, ArmMethod::Maps),
            line(joints, ArmMethod::LocalOnline),
        ],
    };
    plots::curves("Arms in the plane", &key, &JOINTS.map(panel))
}
