//! The tables and the picture of `host-sim arm --experiment reach`.

use super::{ArmArgs, CliError, bar};
use crate::cli::table;
use experiments::arm::body::{ArmBody, View};
use experiments::arm::pictures;
use experiments::arm::reach::{
    ArmMethod, MAX_MOVES, Obstruction, ReachRow, ReachTrial, TOLERANCE, reaches, row, trajectories,
};
use plots::save_picture;
use rayon::ThreadPool;
use serde_json::json;
use std::io::Write;

/// Methods of the tables about a region.
const AROUND: [ArmMethod; 4] = [
    ArmMethod::Maps,
    ArmMethod::LocalOnline,
    ArmMethod::ExactModel,
    ArmMethod::Analytic,
];

/// The part of a table: an arm, what is seen of it, and what is in its way.
struct Part {
    title: &'static str,
    body: ArmBody,
    obstruction: Obstruction,
    methods: Vec<ArmMethod>,
}

fn parts() -> Vec<Part> {
    let image = View::Image(ArmBody::camera());
    let part = |title, body, obstruction, methods: &[ArmMethod]| Part {
        title,
        body,
        obstruction,
        methods: methods.to_vec(),
    };
    let all = &ArmMethod::ALL;
    let coiton = ArmBody::coiton;
    vec![
        part("hand in space", coiton(View::Space), Obstruction::None, all),
        part("hand in an image", coiton(image), Obstruction::None, all),
        part(
            "another arm",
            ArmBody::sideways(View::Space),
            Obstruction::None,
            all,
        ),
        part(
            "region, not told",
            coiton(View::Space),
            Obstruction::Untold,
            &AROUND,
        ),
        part(
            "region avoided",
            coiton(View::Space),
            Obstruction::Told,
            &AROUND,
        ),
        part(
            "another arm, region avoided",
            ArmBody::sideways(View::Space),
            Obstruction::Told,
            &AROUND,
        ),
    ]
}

const HEADS: [&str; 8] = [
    "task",
    "method",
    "reached, %",
    "first tenth, %",
    "error, %",
    "median, %",
    "moves",
    "hand / arm in region, %",
];

/// A row with its part and method.
struct Measured {
    title: &'static str,
    method: ArmMethod,
    has_region: bool,
    row: ReachRow,
}

/// Measures and prints.
pub(super) fn reach(
    args: &ArmArgs,
    pool: &ThreadPool,
    out: &mut impl Write,
) -> Result<(), CliError> {
    let parts = parts();
    let count: usize = parts.iter().map(|part| part.methods.len()).sum();
    let progress = bar(count as u64 * u64::from(args.seeds), "seeds");
    let mut rows = Vec::new();
    for part in &parts {
        for method in &part.methods {
            let trial = trial(args, part.obstruction);
            let done = || progress.inc(1);
            let seeds = pool.install(|| reaches(&part.body, *method, &trial, &done));
            rows.push(Measured {
                title: part.title,
                method: *method,
                has_region: part.obstruction != Obstruction::None,
                row: row(&seeds),
            });
        }
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
    let shown = ReachTrial {
        targets: 60,
        ..trial(args, Obstruction::Told)
    };
    let body = ArmBody::coiton(View::Space);
    let ways = trajectories(&body, &shown, args.first);
    let [picture, _] = save_picture(dir, "arm", &pictures::reaching(&body, &ways))?;
    if !args.json {
        writeln!(out, "Picture: {}", picture.display())?;
    }
    Ok(())
}

fn trial(args: &ArmArgs, obstruction: Obstruction) -> ReachTrial {
    ReachTrial {
        first_seed: args.first,
        seeds: args.seeds,
        explore_moves: args.explore,
        targets: args.targets(),
        obstruction,
    }
}

fn print_table(args: &ArmArgs, rows: &[Measured], out: &mut impl Write) -> Result<(), CliError> {
    let format = if args.markdown {
        table::markdown
    } else {
        table::plain
    };
    let cells: Vec<_> = rows.iter().map(cells).collect();
    out.write_all(format(&HEADS, &cells, &[2, 3, 4, 5, 6, 7]).as_bytes())?;
    writeln!(
        out,
        "\n{} seeds × {} targets after {} random moves; reached: within {:.0} % of the reach (or \
         the image's width) in at most {MAX_MOVES} moves. [95 % interval]",
        args.seeds,
        args.targets(),
        args.explore,
        100.0 * TOLERANCE
    )?;
    Ok(())
}

fn cells(measured: &Measured) -> Vec<String> {
    let row = &measured.row;
    let inside = if measured.has_region {
        let [hand, link] = [row.hand_inside, row.link_inside].map(|share| share.percent());
        format!("{hand:.1} / {:.0}", link.mean)
    } else {
        "–".to_owned()
    };
    vec![
        measured.title.to_owned(),
        measured.method.name().to_owned(),
        format!("{:.1}", row.reached.percent()),
        format!("{:.1}", row.reached_first.percent().mean),
        format!("{:.1}", row.error.percent().mean),
        format!("{:.1}", 100.0 * row.median_error),
        if row.reached.mean > 0.0 {
            format!("{:.1}", row.moves.mean)
        } else {
            "–".to_owned()
        },
        inside,
    ]
}

fn print_json(rows: &[Measured], out: &mut impl Write) -> Result<(), CliError> {
    for measured in rows {
        let row = &measured.row;
        let object = json!({
            "task": measured.title,
            "method": measured.method.name(),
            "targets": row.count,
            "reached": row.reached.mean,
            "reached_interval": row.reached.interval,
            "reached_first_tenth": row.reached_first.mean,
            "error": row.error.mean,
            "median_error": row.median_error,
            "moves": row.moves.mean,
            "hand_inside": row.hand_inside.mean,
            "hand_inside_interval": row.hand_inside.interval,
            "link_inside": row.link_inside.mean,
        });
        writeln!(out, "{object}")?;
    }
    Ok(())
}
