//! Tables, JSON and pictures of the controls.

use super::super::{CliError, table};
use super::{Axis, Case, Part};
use experiments::controls::{ControlMeasure, Results, better};
use plots::{CurveKey, Curves, DotPanel, DotSection, curves, dot_plot, save_picture};
use serde_json::json;
use sim::statistics::Mean;
use std::io::Write;
use std::path::Path;

/// Panels of the dot plot side by side.
const PANELS: usize = 4;

/// What was measured.
pub(super) struct ControlTables<'a> {
    pub(super) axis: Axis,
    pub(super) parts: &'a [Part],
    /// The first one is what the others are compared with.
    pub(super) cases: &'a [Case],
}

/// One cell.
struct Cell<'a> {
    measure: &'a ControlMeasure,
    results: &'a Results,
    /// Of the first row.
    first: &'a Results,
}

impl Cell<'_> {
    fn text(&self) -> String {
        let mean = self.results.mean();
        let text = if self.measure.is_error {
            format!("{mean:.3}")
        } else {
            format!("{mean:.1}")
        };
        let mark = match better(self.measure, self.results.less(self.first)) {
            1 => " +",
            -1 => " −",
            _ => "",
        };
        format!("{text}{mark}")
    }
}

impl ControlTables<'_> {
    /// The cells of a row in one set of worlds.
    fn cells<'a>(&'a self, part: usize, case: &'a Case) -> impl Iterator<Item = Cell<'a>> {
        let of = |case: &'a Case| case.results.get(part).map_or(&[][..], Vec::as_slice);
        let measures = self.parts.get(part).map_or(&[][..], |part| &part.measures);
        let first = self.cases.first().map_or(&[][..], of);
        let pairs = measures.iter().zip(of(case)).zip(first);
        pairs.map(|((measure, results), first)| Cell {
            measure,
            results,
            first,
        })
    }

    /// One table per set of worlds.
    pub(super) fn text(&self, markdown: bool) -> String {
        let format = if markdown {
            table::markdown
        } else {
            table::plain
        };
        let one = |(index, part): (usize, &Part)| {
            let names = part.measures.iter().map(|measure| measure.name);
            let heads: Vec<_> = ["predictor", "online"]
                .into_iter()
                .chain(self.axis.head())
                .chain(names)
                .collect();
            let rows: Vec<Vec<String>> = self
                .cases
                .iter()
                .map(|case| {
                    let switch = if case.row.online { "on" } else { "off" };
                    let fixed = [case.row.name.to_owned(), switch.to_owned()];
                    let cells = self.cells(index, case).map(|cell| cell.text());
                    let fixed = fixed.into_iter().chain(self.axis.value(case));
                    fixed.chain(cells).collect()
                })
                .collect();
            let right: Vec<_> = (2..heads.len()).collect();
            let title = part.set.name();
            let title = if markdown {
                format!("**In {title}**\n")
            } else {
                format!("In {title}:")
            };
            format!("{title}\n{}\n", format(&heads, &rows, &right))
        };
        self.parts.iter().enumerate().map(one).collect()
    }

    /// One object per measure and row.
    pub(super) fn write_json(&self, out: &mut impl Write) -> Result<(), CliError> {
        for (index, part) in self.parts.iter().enumerate() {
            for case in self.cases {
                for cell in self.cells(index, case) {
                    let line = json!({
                        "worlds": part.set.name(),
                        "sonar": part.trial.sonar.name(),
                        "preset": part.trial.preset,
                        "predictor": case.row.name,
                        "online": case.row.online,
                        "neurons": case.neurons,
                        "moves": case.moves,
                        "measure": cell.measure.name,
                        "episodes": part.trial.worlds * part.trial.seeds,
                        "value": numbers(cell.results.mean()),
                        "minus_first": numbers(cell.results.less(cell.first)),
                    });
                    writeln!(out, "{line}")?;
                }
            }
        }
        Ok(())
    }

    /// Writes the picture and, unless JSON was printed, its path.
    pub(super) fn picture(
        &self,
        dir: &Path,
        about: &str,
        is_json: bool,
        out: &mut impl Write,
    ) -> Result<(), CliError> {
        let (name, svg) = match self.axis {
            Axis::Predictors => ("controls", self.dots(about)),
            Axis::Neurons => ("controls-neurons", self.curves("neurons of each map")),
            Axis::Moves => ("controls-moves", self.curves("random moves")),
        };
        let [picture, _] = save_picture(dir, name, &svg)?;
        if !is_json {
            writeln!(out, "Picture: {}", picture.display())?;
        }
        Ok(())
    }

    /// The first row, and every predictor that does not learn online.
    fn dots(&self, about: &str) -> String {
        let is_shown = |(index, case): &(usize, &Case)| *index == 0 || !case.row.online;
        let cases = self.cases.iter().enumerate().filter(is_shown);
        let cases: Vec<_> = cases.map(|(_, case)| case).collect();
        let mut sections = Vec::new();
        for (index, part) in self.parts.iter().enumerate() {
            let episodes = (part.trial.worlds * part.trial.seeds) as usize;
            let labels = cases.iter().map(|case| (label(case), episodes));
            let labels: Vec<_> = labels.collect();
            let panel = |(column, measure): (usize, &ControlMeasure)| DotPanel {
                name: measure.name.to_owned(),
                within: within(measure),
                means: cases
                    .iter()
                    .map(|case| self.mean(index, column, case))
                    .collect(),
            };
            let panels: Vec<_> = part.measures.iter().enumerate().map(panel).collect();
            sections.extend(panels.chunks(PANELS).map(|panels| DotSection {
                title: format!("In {}", part.set.name()),
                labels: labels.clone(),
                panels: panels.to_vec(),
            }));
        }
        let subtitle = about.split(". ").next().unwrap_or_default();
        let subtitle = format!("{subtitle}; dot: mean, line: 95 % interval");
        dot_plot("Is it the maps?", &subtitle, &sections)
    }

    fn mean(&self, part: usize, column: usize, case: &Case) -> Option<Mean> {
        let cell = self.cells(part, case).nth(column);
        cell.map(|cell| cell.results.mean())
    }

    fn curves(&self, along: &str) -> String {
        let lines: Vec<_> = self.cases.chunk_by(|a, b| a.row == b.row).collect();
        let values = lines.first().copied().unwrap_or_default().iter();
        let labels = values.filter_map(|case| self.axis.value(case));
        let mut panels = Vec::new();
        for (index, part) in self.parts.iter().enumerate() {
            for (column, measure) in part.measures.iter().enumerate() {
                let mean = |case: &Case| self.mean(index, column, case);
                let line = |cases: &&[Case]| cases.iter().filter_map(mean).collect();
                panels.push(Curves {
                    title: format!("In {}", part.set.name()),
                    measure: measure.name.to_owned(),
                    within: within(measure),
                    lines: lines.iter().map(line).collect(),
                });
            }
        }
        let firsts = lines.iter().filter_map(|line| line.first());
        let key = CurveKey {
            subtitle: "Mean and 95 % interval, without the shield".to_owned(),
            along: along.to_owned(),
            ticks: labels.enumerate().collect(),
            names: firsts.map(|case| (label(case), false)).collect(),
        };
        curves("Is it the maps?", &key, &panels)
    }
}

/// Predictor, and whether it learns online.
fn label(case: &Case) -> String {
    let online = if case.row.online { " + online" } else { "" };
    format!("{}{online}", case.row.name)
}

impl Axis {
    /// The column of what changes, beside the predictor.
    fn head(self) -> Option<&'static str> {
        match self {
            Self::Predictors => None,
            Self::Neurons => Some("neurons"),
            Self::Moves => Some("moves"),
        }
    }

    fn value(self, case: &Case) -> Option<String> {
        match self {
            Self::Predictors => None,
            Self::Neurons => Some(case.neurons.to_string()),
            Self::Moves => Some(case.moves.to_string()),
        }
    }
}

fn within(measure: &ControlMeasure) -> [f64; 2] {
    let most = if measure.is_share {
        100.0
    } else {
        f64::INFINITY
    };
    [0.0, most]
}

fn numbers(mean: Mean) -> serde_json::Value {
    let [low, high] = mean.interval;
    json!({ "mean": mean.mean, "low": low, "high": high })
}
