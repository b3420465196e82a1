//! Output of `host-sim barn`: table, JSON objects and picture.

use super::{BarnArgs, WorldRuns};
use crate::cli::{CliError, table};
use arena::route;
use experiments::barn::{BarnMethod, CHALLENGE_M_S, RoutePanel, Run, RunEnd, routes, score};
use serde_json::json;
use sim::statistics::{bootstrap, mean};
use std::io::Write;
use std::path::Path;

/// Largest number of worlds in a picture.
const SHOWN: usize = 8;

/// Prints the summary and the table.
pub(super) fn print(
    args: &BarnArgs,
    results: &[WorldRuns],
    methods: &[BarnMethod],
    out: &mut impl Write,
) -> Result<(), CliError> {
    print_worlds(args, results, out)?;
    writeln!(out)?;
    let speed = nomad_speed_m_s();
    let heads = [
        "method".to_owned(),
        "reached % [95 %]".to_owned(),
        "touched %".to_owned(),
        "timed out %".to_owned(),
        "mean time to the goal s".to_owned(),
        format!("score at {speed} m/s"),
        format!("score at {CHALLENGE_M_S} m/s"),
    ];
    let rows: Vec<_> = methods
        .iter()
        .enumerate()
        .map(|(index, method)| row(results, index, *method))
        .collect();
    let text = if args.markdown {
        table::markdown
    } else {
        table::plain
    };
    let heads = heads.each_ref().map(String::as_str);
    Ok(out.write_all(text(&heads, &rows, &[1, 2, 3, 4, 5, 6]).as_bytes())?)
}

/// Prints how many worlds are passable, and the lengths of their paths.
fn print_worlds(
    args: &BarnArgs,
    results: &[WorldRuns],
    out: &mut impl Write,
) -> Result<(), CliError> {
    let count = results.len();
    let passable = results
        .iter()
        .filter(|result| result.shortest_path.is_some())
        .count();
    let with_margin = results.iter().filter(|result| result.with_margin).count();
    let path_lengths: Vec<f64> = results
        .iter()
        .filter_map(|result| Some(route::length(result.shortest_path.as_deref()?)))
        .collect();
    writeln!(out, "worlds                                       {count}")?;
    writeln!(
        out,
        "passable for a disc of 0.269 m               {passable}"
    )?;
    writeln!(
        out,
        "passable with the shield's margin of {:.2} m  {with_margin}",
        args.margin
    )?;
    writeln!(
        out,
        "mean length of the shortest path, m          {:.3}",
        mean(path_lengths)
    )?;
    if args.lengths.is_some() {
        let given: Vec<f64> = results.iter().map(|result| result.length_m).collect();
        writeln!(
            out,
            "mean length to score by (--lengths), m       {:.3}",
            mean(given)
        )?;
    }
    Ok(())
}

/// The Nomad's highest speed, m/s.
fn nomad_speed_m_s() -> f64 {
    f64::from(amp::robot::RobotSpec::nomad200().speed_mm_s) / 1e3
}

fn row(results: &[WorldRuns], index: usize, method: BarnMethod) -> Vec<String> {
    let runs: Vec<_> = results
        .iter()
        .filter_map(|result| Some((result, result.runs.get(index)?)))
        .collect();
    let share = |end: RunEnd| {
        let ended: Vec<Vec<f64>> = runs
            .iter()
            .map(|(_, run)| vec![100.0 * f64::from(u8::from(run.end == end))])
            .collect();
        bootstrap(&ended)
    };
    let times: Vec<f64> = runs.iter().filter_map(|(_, run)| run.success_s()).collect();
    let scores = |speed: f64| {
        let one =
            |(result, run): &(&WorldRuns, &Run)| score(run.success_s(), result.length_m, speed);
        mean(runs.iter().map(one))
    };
    let reached = share(RunEnd::Reached);
    let [low, high] = reached.interval;
    vec![
        method.name().to_owned(),
        format!("{:.1} [{low:.1}, {high:.1}]", reached.mean),
        format!("{:.1}", share(RunEnd::Touched).mean),
        format!("{:.1}", share(RunEnd::TimedOut).mean),
        if times.is_empty() {
            "–".to_owned()
        } else {
            format!("{:.1}", mean(times.iter().copied()))
        },
        format!("{:.4}", scores(nomad_speed_m_s())),
        format!("{:.4}", scores(CHALLENGE_M_S)),
    ]
}

/// One JSON object per method.
pub(super) fn objects(result: &WorldRuns, methods: &[BarnMethod]) -> Vec<serde_json::Value> {
    let one = |(method, run): (&BarnMethod, &Run)| {
        json!({
            "world": result.number,
            "method": method.name(),
            "end": match run.end {
                RunEnd::Reached => "reached",
                RunEnd::Touched => "touched",
                RunEnd::TimedOut => "timed out",
            },
            "time_s": (run.time_s * 1e3 + 0.5).floor() / 1e3,
            "way_m": (route::length(&run.places) * 1e3 + 0.5).floor() / 1e3,
            "shortest_m": result.shortest_path.as_deref().map(|shortest_path| (route::length(shortest_path) * 1e4 + 0.5).floor() / 1e4),
            "score_own_speed": score(run.success_s(), result.length_m, nomad_speed_m_s()),
            "score": score(run.success_s(), result.length_m, CHALLENGE_M_S),
        })
    };
    methods.iter().zip(&result.runs).map(one).collect()
}

/// Writes a picture of some worlds with the driven paths.
pub(super) fn picture(
    dir: &Path,
    results: &[WorldRuns],
    methods: &[BarnMethod],
    quiet: bool,
    out: &mut impl Write,
) -> Result<(), CliError> {
    // Spread over all worlds: the later ones are harder.
    let count = results.len().min(SHOWN);
    let spread = |place: usize| {
        results.get(place * results.len().saturating_sub(1) / count.saturating_sub(1).max(1))
    };
    let panel = |result: &'_ WorldRuns| RoutePanel {
        world: result.world.clone(),
        shortest: result.shortest_path.clone().unwrap_or_default(),
        paths: result.runs.iter().map(|run| run.places.clone()).collect(),
        marks: result.runs.iter().map(|run| run.end).collect(),
    };
    let panels: Vec<_> = (0..count).filter_map(spread).map(panel).collect();
    let names: Vec<_> = methods.iter().map(|method| method.name()).collect();
    let svg = routes("Paths through the BARN worlds", &names, &panels);
    let [path, _] = plots::save_picture(dir, "barn", &svg)?;
    if !quiet {
        writeln!(out, "\nPicture: {}", path.display())?;
    }
    Ok(())
}
