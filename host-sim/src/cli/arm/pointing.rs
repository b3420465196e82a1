//! The table of `host-sim arm --experiment pointing`.

use super::{ArmArgs, CliError, bar};
use crate::cli::table;
use experiments::arm::pictures;
use experiments::arm::pointing::{
    MAX_MOVES, PointingMethod, PointingRow, PointingTrial, TOLERANCE_DEG, pointings, row,
};
use plots::save_picture;
use rayon::ThreadPool;
use serde_json::json;
use std::io::Write;

const HEADS: [&str; 6] = [
    "method",
    "within 1°, %",
    "error, °",
    "median, °",
    "error of the eye, °",
    "moves",
];

/// Measures and prints.
pub(super) fn pointing(
    args: &ArmArgs,
    pool: &ThreadPool,
    out: &mut impl Write,
) -> Result<(), CliError> {
    let trial = PointingTrial {
        first_seed: args.first,
        seeds: args.seeds,
        explore_moves: args.explore,
        targets: args.targets(),
    };
    let progress = bar(
        PointingMethod::ALL.len() as u64 * u64::from(args.seeds),
        "seeds",
    );
    let mut rows = Vec::new();
    let mut errors_deg = Vec::new();
    for method in PointingMethod::ALL {
        let done = || progress.inc(1);
        let seeds = pool.install(|| pointings(method, &trial, &done));
        let all = seeds.iter().flatten().map(|pointed| pointed.error_deg);
        errors_deg.push((method.name(), all.collect()));
        rows.push((method, row(&seeds)));
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
    let [picture, _] = save_picture(dir, "pointing", &pictures::pointing(&errors_deg))?;
    if !args.json {
        writeln!(out, "Picture: {}", picture.display())?;
    }
    Ok(())
}

fn print_table(
    args: &ArmArgs,
    rows: &[(PointingMethod, PointingRow)],
    out: &mut impl Write,
) -> Result<(), CliError> {
    let format = if args.markdown {
        table::markdown
    } else {
        table::plain
    };
    let cells = |(method, row): &(PointingMethod, PointingRow)| {
        vec![
            method.name().to_owned(),
            format!("{:.1}", row.pointed.percent()),
            format!("{:.2}", row.error_deg),
            format!("{:.2}", row.median_error_deg),
            format!("{:.2}", row.look_error_deg.mean),
            format!("{:.1}", row.moves.mean),
        ]
    };
    let cells: Vec<_> = rows.iter().map(cells).collect();
    out.write_all(format(&HEADS, &cells, &[1, 2, 3, 4, 5]).as_bytes())?;
    writeln!(
        out,
        "\n{} seeds × {} targets after {} random moves of the eye and {} of the arm; at most \
         {MAX_MOVES} moves; the error is the angle at the eye between hand and target, \
         {TOLERANCE_DEG}° counts as pointed at. [95 % interval]",
        args.seeds,
        args.targets(),
        args.explore,
        args.explore
    )?;
    Ok(())
}

fn print_json(
    rows: &[(PointingMethod, PointingRow)],
    out: &mut impl Write,
) -> Result<(), CliError> {
    for (method, row) in rows {
        let object = json!({
            "method": method.name(),
            "targets": row.count,
            "pointed": row.pointed.mean,
            "pointed_interval": row.pointed.interval,
            "error_deg": row.error_deg.mean,
            "median_error_deg": row.median_error_deg,
            "look_error_deg": row.look_error_deg.mean,
            "moves": row.moves.mean,
        });
        writeln!(out, "{object}")?;
    }
    Ok(())
}
