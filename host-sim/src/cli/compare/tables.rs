//! The tables of the comparison, as text and Markdown.

use super::by_shield;
use crate::cli::table::{markdown, plain};
use experiments::compare::{ComparedMethod, ComparisonRow, Differences, MethodFigures};
use rayon::prelude::*;
use sim::statistics::Mean;

/// A row with all its figures.
pub struct MethodLine {
    /// The row's method.
    pub method: ComparedMethod,
    /// Its learning moves.
    pub moves: u32,
    /// With the shield.
    pub shield: bool,
    /// Its figures.
    pub figures: MethodFigures,
    /// Minus the preset `default` under the same conditions; `None` for that preset, or if it is
    /// not compared.
    pub differences: Option<Differences>,
}

/// All rows of the output.
pub struct ComparisonTables {
    /// The rows, as measured.
    pub lines: Vec<MethodLine>,
}

const HEADS: [&str; 10] = [
    "method",
    "learning moves",
    "contacts while learning",
    "contacts per 100 m",
    "clean rooms %",
    "distance m",
    "coverage m²",
    "least clearance m",
    "to the goal s",
    "bytes",
];

const DIFFERENCE_HEADS: [&str; 6] = [
    "method",
    "learning moves",
    "contacts per 100 m",
    "clean rooms %",
    "distance m",
    "coverage m²",
];

const RIGHT: [usize; 9] = [1, 2, 3, 4, 5, 6, 7, 8, 9];

/// Formats a table: heads, rows, numeric columns.
type Set = fn(&[&str], &[Vec<String>], &[usize]) -> String;

impl ComparisonTables {
    /// Computes all figures, on all cores.
    pub fn of(rows: &[ComparisonRow]) -> Self {
        let conditions: Vec<_> = by_shield(rows).collect();
        let with_base = |rows: &&[ComparisonRow]| {
            let base = rows
                .iter()
                .find(|row| row.method == ComparedMethod::Default);
            let pairs: Vec<_> = rows
                .iter()
                .map(|row| (row.clone(), base.cloned()))
                .collect();
            pairs
        };
        let pairs: Vec<(ComparisonRow, Option<ComparisonRow>)> =
            conditions.iter().flat_map(with_base).collect();
        let line = |(row, base): &(ComparisonRow, Option<ComparisonRow>)| MethodLine {
            method: row.method,
            moves: row.moves,
            shield: row.shield,
            figures: row.figures(),
            differences: base
                .as_ref()
                .filter(|base| base.method != row.method)
                .map(|base| row.less(base)),
        };
        Self {
            lines: pairs.par_iter().map(line).collect(),
        }
    }

    /// The rows by condition.
    pub fn by_shield(&self) -> impl Iterator<Item = &[MethodLine]> {
        self.lines.chunk_by(|a, b| a.shield == b.shield)
    }

    /// The tables for a terminal.
    pub fn text(&self) -> String {
        self.set(plain, |title| format!("{title}\n\n"))
    }

    /// The tables as Markdown.
    pub fn markdown(&self) -> String {
        self.set(markdown, |title| format!("## {title}\n\n"))
    }

    fn set(&self, table: Set, head: impl Fn(&str) -> String) -> String {
        let mut text = String::new();
        for lines in self.by_shield() {
            let shielded = lines.first().is_some_and(|line| line.shield);
            let who = if shielded {
                "With the shield"
            } else {
                "The methods alone"
            };
            let rows: Vec<_> = lines.iter().map(cells).collect();
            text += &head(who);
            text += &format!("{}\n", table(&HEADS, &rows, &RIGHT));
            let rows: Vec<_> = lines.iter().filter_map(difference_cells).collect();
            if !rows.is_empty() {
                text += &head(&format!("{who}: minus the preset `default`, paired"));
                text += &format!("{}\n", table(&DIFFERENCE_HEADS, &rows, &RIGHT[..5]));
            }
        }
        text
    }

    /// Wall time per decision, as a table.
    pub fn times(&self) -> String {
        let cells = |line: &MethodLine| {
            let shield = if line.shield { "on" } else { "off" };
            vec![
                line.method.name().to_owned(),
                line.moves.to_string(),
                shield.to_owned(),
                format!("{:.2}", line.figures.decision_us),
            ]
        };
        let rows: Vec<_> = self.lines.iter().map(cells).collect();
        let heads = ["method", "learning moves", "shield", "µs per decision"];
        plain(&heads, &rows, &[1, 3])
    }
}

/// Mean and interval with `digits` decimals.
pub fn short(mean: &Mean, digits: usize) -> String {
    let [low, high] = mean.interval;
    format!("{:.digits$} [{low:.digits$}, {high:.digits$}]", mean.mean)
}

fn cells(line: &MethodLine) -> Vec<String> {
    let figures = &line.figures;
    let goal = figures.to_goal_s.as_ref();
    vec![
        line.method.name().to_owned(),
        line.moves.to_string(),
        format!("{:.1}", figures.learning_contacts.mean),
        short(&figures.contacts_per_100_m, 2),
        short(&figures.clean_percent, 1),
        format!("{:.1}", figures.distance_m.mean),
        short(&figures.coverage_m2, 1),
        format!("{:.3}", figures.clearance_m.mean),
        goal.map_or("–".to_owned(), |mean| short(mean, 1)),
        format!("{:.0}", figures.bytes),
    ]
}

fn difference_cells(line: &MethodLine) -> Option<Vec<String>> {
    let differences = line.differences.as_ref()?;
    Some(vec![
        line.method.name().to_owned(),
        line.moves.to_string(),
        short(&differences.contacts_per_100_m, 2),
        short(&differences.clean_percent, 1),
        short(&differences.distance_m, 1),
        short(&differences.coverage_m2, 1),
    ])
}

/// The steps of the search for constants, as a table.
pub fn search(lines: &[(String, f64, f64)]) -> String {
    let cells = |(name, value, score): &(String, f64, f64)| {
        let value = if value.is_nan() {
            "–".to_owned()
        } else {
            value.to_string()
        };
        vec![name.clone(), value, format!("{score:.3}")]
    };
    let rows: Vec<_> = lines.iter().map(cells).collect();
    plain(&["constant", "best value", "score"], &rows, &[1, 2])
}
