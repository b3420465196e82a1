//! `host-sim learn`: learns both maps from a logged run and prints what they recall.

mod pictures;

use super::output::bar;
use super::{CliError, table};
use datasets::learn::{
    Actions, LearnArgs, Log, Map, Recalled, Score, Study, Task, study, task::Part,
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
    let task = Task::of(&log, &args.options())?;
    if let Some(folder) = &args.out {
        write_files(folder, &[])?;
    }
    let progress = bar(args.map.0.len() as u64, "maps");
    let found = study(&task, &args.map.0, &args.lesson(), &|| progress.inc(1))?;
    progress.finish_and_clear();
    let results = LearnResults {
        args,
        log: &log,
        task: &task,
        found: &found,
    };
    if args.json {
        for map in &found.maps {
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
    task: &'a Task,
    found: &'a Study,
}

impl LearnResults<'_> {
    fn named(&self) -> bool {
        self.task.classes.is_some()
    }

    /// The names of an action's components.
    fn components(&self) -> &[String] {
        match &self.log.actions {
            Actions::Labels { names, .. } | Actions::Velocities { names, .. } => names,
        }
    }

    /// Distance between situations in the log's unit that corresponds to 1.
    fn span(&self) -> f64 {
        self.task.far - self.task.near
    }

    fn facts(&self) -> Vec<(String, String)> {
        let unit = self.args.unit.sign();
        let rows = |part| self.task.rows(part).to_string();
        let kind = if self.named() {
            "actions"
        } else {
            "velocities"
        };
        [
            ("log", self.log.source.clone()),
            ("ranges per row", self.log.names.len().to_string()),
            (kind, self.components().join(", ")),
            ("rows learned", rows(Part::Learned)),
            ("rows held out, at the end", rows(Part::HeldOut)),
            (
                "a situation's value",
                format!(
                    "1 at {} {unit}, 0 from {} {unit} on",
                    self.task.near, self.task.far
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
        if let [map] = &self.found.maps[..] {
            writeln!(out, "\nRecall of the actions of the rows held out")?;
            let all = self.found.references.iter().chain(&map.recalls);
            out.write_all(self.recall(all).as_bytes())?;
        } else {
            writeln!(
                out,
                "\nRecall of the actions of the rows held out, by map size"
            )?;
            out.write_all(self.recall_by_size().as_bytes())?;
            writeln!(out, "\nBeside them")?;
            out.write_all(self.recall(self.found.references.iter()).as_bytes())?;
        }
        Ok(())
    }

    fn quality(&self) -> String {
        let unit = self.args.unit.sign();
        let heads = [
            "situation map".to_owned(),
            format!("quantization error {unit}, learned"),
            "held out".to_owned(),
            "topographic error %, learned".to_owned(),
            "held out".to_owned(),
        ];
        let row = |map: &Map| {
            let parts = [&map.learned, &map.held_out];
            let errors = parts.map(|part| format!("{:.3}", part.quantization_error * self.span()));
            let apart = parts.map(|part| format!("{:.1}", 100.0 * part.topographic_error));
            [size(map)].into_iter().chain(errors).chain(apart).collect()
        };
        let rows: Vec<_> = self.found.maps.iter().map(row).collect();
        table::plain(&heads.each_ref().map(String::as_str), &rows, &[1, 2, 3, 4])
    }

    fn recall<'r>(&self, all: impl Iterator<Item = &'r Recalled>) -> String {
        let mut heads = vec!["recalled by", "probed with"];
        if self.named() {
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
        let rows: Vec<_> = all.map(|recalled| self.recall_row(recalled)).collect();
        let right: Vec<_> = (2..heads.len()).collect();
        table::plain(&heads, &rows, &right)
    }

    fn component(&self, name: &str) -> String {
        if self.named() {
            format!("{name} %")
        } else {
            format!("rms error of {name}")
        }
    }

    fn recall_row(&self, recalled: &Recalled) -> Vec<String> {
        let mut row = recalled
            .method
            .words(self.named())
            .map(str::to_owned)
            .to_vec();
        let percent = |share: f64| format!("{:.1}", 100.0 * share);
        if let Some(accuracy) = recalled.score.accuracy() {
            let [low, high] = accuracy.interval.map(percent);
            row.extend([
                percent(accuracy.mean),
                format!("[{low}, {high}]"),
                percent(recalled.score.balanced()),
            ]);
            let by_class = recalled.score.by_class();
            row.extend(
                by_class
                    .into_iter()
                    .map(|share| share.map_or("–".to_owned(), percent)),
            );
        }
        if let Score::Velocities { rms } = &recalled.score {
            row.push(format!("{:.3}", self.beside_the_mean(recalled)));
            row.extend(rms.iter().map(|error| format!("{error:.4}")));
        }
        row
    }

    /// The value of a curve: accuracy, or the error divided by that of the mean.
    fn headline(&self, recalled: &Recalled) -> f64 {
        let accuracy = recalled.score.accuracy().map(|accuracy| accuracy.mean);
        accuracy.unwrap_or_else(|| self.beside_the_mean(recalled))
    }

    fn beside_the_mean(&self, recalled: &Recalled) -> f64 {
        let mean = self.found.references.first();
        mean.and_then(|mean| recalled.score.error_beside(&mean.score))
            .unwrap_or(1.0)
    }

    fn recall_by_size(&self) -> String {
        let named = self.named();
        let title = |recalled: &Recalled| {
            let [by, with] = recalled.method.words(named);
            let unit = if named { "right %" } else { "error" };
            format!("{by}, by {with}: {unit}")
        };
        let recalls = self.found.maps.first().map_or(&[][..], |map| &map.recalls);
        let titles: Vec<_> = recalls.iter().map(title).collect();
        let heads: Vec<_> = ["map"]
            .into_iter()
            .chain(titles.iter().map(String::as_str))
            .collect();
        let cell = |recalled: &Recalled| {
            let value = self.headline(recalled);
            if named {
                format!("{:.1}", 100.0 * value)
            } else {
                format!("{value:.3}")
            }
        };
        let row = |map: &Map| {
            [size(map)]
                .into_iter()
                .chain(map.recalls.iter().map(cell))
                .collect()
        };
        let rows: Vec<_> = self.found.maps.iter().map(row).collect();
        table::plain(&heads, &rows, &[1, 2, 3])
    }

    fn object(&self, map: &Map) -> Value {
        let recalls = self
            .found
            .references
            .iter()
            .chain(&map.recalls)
            .map(|recalled| {
                let value = match &recalled.score {
                    Score::Classes { confusion, .. } => json!({
                        "accuracy": recalled.score.accuracy().map(|accuracy| accuracy.mean),
                        "interval": recalled.score.accuracy().map(|accuracy| accuracy.interval),
                        "by_class": recalled.score.by_class(),
                        "confusion": confusion,
                    }),
                    Score::Velocities { rms } => json!({
                        "rms_error": rms,
                        "error_beside_mean": self.beside_the_mean(recalled),
                    }),
                };
                (recalled.method.key().to_owned(), value)
            });
        json!({
            "log": self.log.source,
            "map": size(map),
            "seed": self.args.seed,
            "epochs": self.args.epochs,
            "rows_learned": self.task.rows(Part::Learned),
            "rows_held_out": self.task.rows(Part::HeldOut),
            "components": self.components(),
            "quantization_error": [map.learned.quantization_error * self.span(), map.held_out.quantization_error * self.span()],
            "topographic_error": [map.learned.topographic_error, map.held_out.topographic_error],
            "recall": recalls.collect::<serde_json::Map<_, _>>(),
        })
    }
}

fn size(map: &Map) -> String {
    format!("{}x{}", map.grid.columns(), map.grid.rows())
}
