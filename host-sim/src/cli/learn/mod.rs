//! `host-sim learn`: learns both maps from a logged run and prints what they recall.

mod pictures;

use super::output::bar;
use super::{CliError, table};
use datasets::learn::{
    Actions, Dataset, Evaluation, LearnArgs, Log, MapResult, MethodScore, Score, dataset::Split,
    evaluate,
};
use datasets::som::report::write_files;
use serde_json::{Value, json};
use std::io::Write;

/// Learns the maps and prints what they recall.
///
/// # Errors
/// An invalid flag, log or output folder; a closed pipe.
pub fn learn(args: &LearnArgs, out: &mut impl Write) -> Result<(), CliError> {
    let log = Log::load(&args.log, &args.columns())?;
    let dataset = Dataset::from_log(&log, &args.dataset_options())?;
    if let Some(folder) = &args.out {
        write_files(folder, &[])?;
    }
    let progress = bar(args.map.0.len() as u64, "maps");
    let evaluation = evaluate(&dataset, &args.map.0, &args.train_options(), &|| {
        progress.inc(1)
    })?;
    progress.finish_and_clear();
    let results = LearnResults {
        args,
        log: &log,
        dataset: &dataset,
        evaluation: &evaluation,
    };
    if args.json {
        for map in &evaluation.maps {
            writeln!(out, "{}", results.object(map))?;
        }
    } else {
        results.tables(out)?;
    }
    if let Some(folder) = &args.out {
        results.pictures(folder)?;
        if !args.json {
            writeln!(
                out,
                "\nPage with all pictures: {}",
                folder.join("index.html").display()
            )?;
        }
    }
    Ok(())
}

/// All results of the command.
struct LearnResults<'a> {
    args: &'a LearnArgs,
    log: &'a Log,
    dataset: &'a Dataset,
    evaluation: &'a Evaluation,
}

impl LearnResults<'_> {
    fn is_named(&self) -> bool {
        self.dataset.classes.is_some()
    }

    /// The names of an action's components.
    fn components(&self) -> &[String] {
        match &self.log.actions {
            Actions::Labels { names, .. } | Actions::Velocities { names, .. } => names,
        }
    }

    /// Distance between situations in the log's unit that corresponds to 1.
    fn span(&self) -> f64 {
        self.dataset.far - self.dataset.near
    }

    fn facts(&self) -> Vec<(String, String)> {
        let unit = self.args.unit.symbol();
        let rows = |split| self.dataset.rows(split).to_string();
        let kind = if self.is_named() {
            "actions"
        } else {
            "velocities"
        };
        [
            ("log", self.log.source.clone()),
            ("ranges per row", self.log.names.len().to_string()),
            (kind, self.components().join(", ")),
            ("rows learned", rows(Split::Training)),
            ("rows held out, at the end", rows(Split::HeldOut)),
            (
                "a situation's value",
                format!(
                    "1 at {} {unit}, 0 from {} {unit} on",
                    self.dataset.near, self.dataset.far
                ),
            ),
            (
                "seed, epochs",
                format!("{}, {}", self.args.seed, self.args.epochs),
            ),
        ]
        .map(|(name, value)| (name.to_owned(), value))
        .to_vec()
    }

    fn tables(&self, out: &mut impl Write) -> Result<(), CliError> {
        for (name, value) in self.facts() {
            writeln!(out, "{name:<26}  {value}")?;
        }
        writeln!(out)?;
        out.write_all(self.quality().as_bytes())?;
        if let [map] = &self.evaluation.maps[..] {
            writeln!(out, "\nRecall of the actions of the rows held out")?;
            let methods = self.evaluation.baselines.iter().chain(&map.scores);
            out.write_all(self.recall_table(methods).as_bytes())?;
        } else {
            writeln!(
                out,
                "\nRecall of the actions of the rows held out, by map size"
            )?;
            out.write_all(self.recall_by_size().as_bytes())?;
            writeln!(out, "\nBeside them")?;
            out.write_all(
                self.recall_table(self.evaluation.baselines.iter())
                    .as_bytes(),
            )?;
        }
        Ok(())
    }

    fn quality(&self) -> String {
        let unit = self.args.unit.symbol();
        let heads = [
            "situation map".to_owned(),
            format!("quantization error {unit}, learned"),
            "held out".to_owned(),
            "topographic error %, learned".to_owned(),
            "held out".to_owned(),
        ];
        let row = |map: &MapResult| {
            let parts = [&map.training, &map.held_out];
            let errors = parts.map(|part| format!("{:.3}", part.quantization_error * self.span()));
            let apart = parts.map(|part| format!("{:.1}", 100.0 * part.topographic_error));
            [size(map)].into_iter().chain(errors).chain(apart).collect()
        };
        let rows: Vec<_> = self.evaluation.maps.iter().map(row).collect();
        table::plain(&heads.each_ref().map(String::as_str), &rows, &[1, 2, 3, 4])
    }

    fn recall_table<'r>(&self, methods: impl Iterator<Item = &'r MethodScore>) -> String {
        let mut heads = vec!["recalled by", "probed with"];
        if self.is_named() {
            heads.extend(["right %", "[95 %]", "mean of classes %"]);
        } else {
            heads.push("error relative to the mean's");
        }
        let classes: Vec<_> = self
            .components()
            .iter()
            .map(|name| self.component(name))
            .collect();
        heads.extend(classes.iter().map(String::as_str));
        let rows: Vec<_> = methods.map(|result| self.recall_row(result)).collect();
        let right: Vec<_> = (2..heads.len()).collect();
        table::plain(&heads, &rows, &right)
    }

    fn component(&self, name: &str) -> String {
        if self.is_named() {
            format!("{name} %")
        } else {
            format!("rms error of {name}")
        }
    }

    fn recall_row(&self, result: &MethodScore) -> Vec<String> {
        let mut row = result
            .method
            .descriptions(self.is_named())
            .map(str::to_owned)
            .to_vec();
        let percent = |share: f64| format!("{:.1}", 100.0 * share);
        if let Some(accuracy) = result.score.accuracy() {
            let [low, high] = accuracy.interval.map(percent);
            row.extend([
                percent(accuracy.mean),
                format!("[{low}, {high}]"),
                percent(result.score.balanced_accuracy()),
            ]);
            let by_class = result.score.by_class();
            row.extend(
                by_class
                    .into_iter()
                    .map(|share| share.map_or("–".to_owned(), percent)),
            );
        }
        if let Score::Velocities { rms } = &result.score {
            row.push(format!("{:.3}", self.error_relative_to_mean(result)));
            row.extend(rms.iter().map(|error| format!("{error:.4}")));
        }
        row
    }

    /// The value of a curve: accuracy, or the error divided by that of the mean.
    fn headline(&self, result: &MethodScore) -> f64 {
        let accuracy = result.score.accuracy().map(|accuracy| accuracy.mean);
        accuracy.unwrap_or_else(|| self.error_relative_to_mean(result))
    }

    fn error_relative_to_mean(&self, result: &MethodScore) -> f64 {
        let mean = self.evaluation.baselines.first();
        mean.and_then(|mean| result.score.relative_error(&mean.score))
            .unwrap_or(1.0)
    }

    fn recall_by_size(&self) -> String {
        let is_named = self.is_named();
        let title = |result: &MethodScore| {
            let [by, with] = result.method.descriptions(is_named);
            let unit = if is_named { "right %" } else { "error" };
            format!("{by}, by {with}: {unit}")
        };
        let scores = self
            .evaluation
            .maps
            .first()
            .map_or(&[][..], |map| &map.scores);
        let titles: Vec<_> = scores.iter().map(title).collect();
        let heads: Vec<_> = ["map"]
            .into_iter()
            .chain(titles.iter().map(String::as_str))
            .collect();
        let cell = |result: &MethodScore| {
            let value = self.headline(result);
            if is_named {
                format!("{:.1}", 100.0 * value)
            } else {
                format!("{value:.3}")
            }
        };
        let row = |map: &MapResult| {
            [size(map)]
                .into_iter()
                .chain(map.scores.iter().map(cell))
                .collect()
        };
        let rows: Vec<_> = self.evaluation.maps.iter().map(row).collect();
        table::plain(&heads, &rows, &[1, 2, 3])
    }

    fn object(&self, map: &MapResult) -> Value {
        let scores = self
            .evaluation
            .baselines
            .iter()
            .chain(&map.scores)
            .map(|result| {
                let value = match &result.score {
                    Score::Classes { confusion, .. } => json!({
                        "accuracy": result.score.accuracy().map(|accuracy| accuracy.mean),
                        "interval": result.score.accuracy().map(|accuracy| accuracy.interval),
                        "by_class": result.score.by_class(),
                        "confusion": confusion,
                    }),
                    Score::Velocities { rms } => json!({
                        "rms_error": rms,
                        "error_beside_mean": self.error_relative_to_mean(result),
                    }),
                };
                (result.method.key().to_owned(), value)
            });
        json!({
            "log": self.log.source,
            "map": size(map),
            "seed": self.args.seed,
            "epochs": self.args.epochs,
            "rows_learned": self.dataset.rows(Split::Training),
            "rows_held_out": self.dataset.rows(Split::HeldOut),
            "components": self.components(),
            "quantization_error": [map.training.quantization_error * self.span(), map.held_out.quantization_error * self.span()],
            "topographic_error": [map.training.topographic_error, map.held_out.topographic_error],
            "recall": scores.collect::<serde_json::Map<_, _>>(),
        })
    }
}

fn size(map: &MapResult) -> String {
    format!("{}x{}", map.grid.columns(), map.grid.rows())
}
