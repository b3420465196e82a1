//! The description of a sweep: a TOML file with fixed options, a grid and a list of points.

mod choice_value;

use super::plan::Vocabulary;
use super::points::{PointOptions, SweepPoints};
use arena::loaders::{WorldSource, parse_worlds};
use choice_value::{ChoiceTable, ChoiceValue};
use files::error::{BadInput, suggestion};
use files::read_text;
use files::toml_reader::TomlText;
use serde::Deserialize;
use sim::behavior::Behavior;
use sim::settings::{SETTINGS, is_key};
use std::ops::Range;
use std::path::Path;
use toml::Spanned;

/// Largest accepted file, bytes.
const MAX_FILE_BYTES: u64 = 16 << 20;
/// Largest number of seeds.
const MAX_SEEDS: u64 = 1_000_000;
/// Largest number of points: each is checked before the first run.
const MAX_POINTS: u64 = 100_000;

/// Content of a sweep's file.
///
/// ```toml
/// name = "range-and-shield"            # [default: the file's]
/// worlds = ["random:1..=20", "paper"]  # as for `run --world` [default: paper]
/// behaviors = ["avoid", "nest"]        # as for `run --behavior` [default: avoid]
/// seeds = "1..=10"                     # or a number, or a list of numbers [default: 1]
///
/// [fixed]                              # for every episode
/// steps = 500
/// shield = false                       # true and false are on and off
///
/// [grid]                               # points: every combination, the last key fastest
/// far = [1.5, 3.0, 4.5]
/// explore = [50, 100]
///
/// [[list]]                             # one more point
/// preset = "probe"
/// far = 2.0
/// ```
///
/// Keys are the flags of `run` that define an episode, and the keys of `--set`. Points are numbered
/// in this order: the grid, then the list. Without both there is one point. An unknown key is an
/// error that names its line.
#[derive(Debug, Clone)]
pub struct Description {
    /// The sweep's name: letters, digits, `-`, `_` and `.`.
    pub name: String,
    /// Its worlds.
    pub worlds: Vec<WorldSource>,
    /// Its behaviors.
    pub behaviors: Vec<Behavior>,
    /// Its seeds.
    pub seeds: Vec<u64>,
    /// Its points: sets of options.
    pub points: SweepPoints,
}

impl Description {
    /// Reads a sweep's file; `vocabulary` defines the keys.
    ///
    /// # Errors
    /// A sentence that names the file, the line and the fault.
    pub fn load(path: &Path, vocabulary: &Vocabulary) -> Result<Self, BadInput> {
        let text = read_text(path, MAX_FILE_BYTES)?;
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        Self::read(
            &text,
            &path.display().to_string(),
            &safe_name(&stem),
            vocabulary,
        )
    }

    /// Reads the text of a sweep's file. `source` names it in errors; `default_name` is the sweep's
    /// name if the text has none.
    ///
    /// # Errors
    /// As [`Description::load`].
    pub fn read(
        text: &str,
        source: &str,
        default_name: &str,
        vocabulary: &Vocabulary,
    ) -> Result<Self, BadInput> {
        let file = DescriptionReader {
            toml: TomlText { text, source },
            vocabulary,
        };
        let written: SweepFile = file.toml.read()?;
        let name = match &written.name {
            Some(name) => file.name(name)?,
            None => default_name.to_owned(),
        };
        Ok(Self {
            name,
            worlds: file
                .each("worlds", written.worlds, "paper", parse_worlds)?
                .concat(),
            behaviors: file.each("behaviors", written.behaviors, "avoid", str::parse)?,
            seeds: written
                .seeds
                .map_or(Ok(vec![1]), |seeds| file.seeds(&seeds))?,
            points: file.points(&written.fixed, &written.grid, &written.list)?,
        })
    }
}

/// Turns a file's name into a valid name of a sweep.
fn safe_name(name: &str) -> String {
    let safe_name = |c: char| if is_plain(c) { c } else { '-' };
    name.chars().map(safe_name).collect()
}

fn is_plain(c: char) -> bool {
    c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.')
}

/// The file as serde reads it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SweepFile {
    name: Option<Spanned<String>>,
    worlds: Option<Spanned<Vec<Spanned<String>>>>,
    behaviors: Option<Spanned<Vec<Spanned<String>>>>,
    seeds: Option<Spanned<ChoiceValue>>,
    #[serde(default)]
    fixed: ChoiceTable,
    #[serde(default)]
    grid: ChoiceTable,
    #[serde(default)]
    list: Vec<ChoiceTable>,
}

/// An option of the file: its key, the key's position, and its value.
type Choice<'t> = (String, Range<usize>, &'t Spanned<ChoiceValue>);

struct DescriptionReader<'a> {
    toml: TomlText<'a>,
    vocabulary: &'a Vocabulary,
}

impl DescriptionReader<'_> {
    fn name(&self, name: &Spanned<String>) -> Result<String, BadInput> {
        let text = name.get_ref();
        if text.chars().all(is_plain) && (1..=100).contains(&text.len()) {
            return Ok(text.clone());
        }
        let what = "name must be letters, digits, -, _ and ., 1 to 100 of them";
        Err(self.toml.error(name.span(), what))
    }

    /// Parses the texts of the list `key`, or `default` without such a list.
    fn each<T>(
        &self,
        key: &str,
        list: Option<Spanned<Vec<Spanned<String>>>>,
        default: &str,
        read: impl Fn(&str) -> Result<T, BadInput>,
    ) -> Result<Vec<T>, BadInput> {
        let Some(list) = list else {
            return Ok(vec![read(default)?]);
        };
        let one = |text: &Spanned<String>| {
            read(text.get_ref()).map_err(|error| self.toml.error(text.span(), error))
        };
        match list.get_ref().as_slice() {
            [] => Err(self.empty(key, list.span())),
            texts => texts.iter().map(one).collect(),
        }
    }

    fn empty(&self, key: &str, at: Range<usize>) -> BadInput {
        let what = format!("{key} must be a list with at least one entry: [ … ]");
        self.toml.error(at, what)
    }

    fn seeds(&self, value: &Spanned<ChoiceValue>) -> Result<Vec<u64>, BadInput> {
        let wrong = || {
            let what =
                "seeds must be a whole number from 0 on, a list of them, or a range: \"1..=10\"";
            self.toml.error(value.span(), what)
        };
        let seed = |text: &str| text.trim().parse::<u64>().map_err(|_| wrong());
        let text = match value.get_ref() {
            ChoiceValue::Scalar(text) => text,
            ChoiceValue::List(seeds) if !seeds.is_empty() => {
                let one = |seed_value: &Spanned<ChoiceValue>| match seed_value.get_ref() {
                    ChoiceValue::Scalar(text) => seed(text),
                    _ => Err(wrong()),
                };
                return seeds.iter().map(one).collect();
            }
            _ => return Err(wrong()),
        };
        let Some((first, last)) = text.split_once("..=") else {
            return Ok(vec![seed(text)?]);
        };
        let (first, last) = (seed(first)?, seed(last)?);
        if first > last || last - first >= MAX_SEEDS {
            let what = format!("seeds must be a range of 1 to {MAX_SEEDS} seeds");
            return Err(self.toml.error(value.span(), what));
        }
        Ok((first..=last).collect())
    }

    fn points(
        &self,
        fixed: &ChoiceTable,
        grid: &ChoiceTable,
        list: &[ChoiceTable],
    ) -> Result<SweepPoints, BadInput> {
        let mut points = SweepPoints::default();
        for (key, at, value) in self.choices(fixed)? {
            let text = self.text(&key, at, value)?;
            points.fixed.push((key, text));
        }
        let mut last = 0..0;
        for (key, at, value) in self.choices(grid)? {
            self.check_varied(&points, &key, &at)?;
            let ChoiceValue::List(values) = value.get_ref() else {
                return Err(self.empty(&key, value.span()));
            };
            let texts = values.iter();
            let texts = texts.map(|value| self.text(&key, at.clone(), value));
            let texts: Vec<_> = texts.collect::<Result<_, _>>()?;
            if texts.is_empty() {
                return Err(self.empty(&key, value.span()));
            }
            points.add_axis(&key, texts);
            last = at;
        }
        for row in list {
            let row = self.row(&points, row)?;
            points.add(row);
        }
        if points.count().is_none_or(|count| count > MAX_POINTS) {
            let what = format!("the sweep has more than {MAX_POINTS} points");
            return Err(self.toml.error(last, what));
        }
        Ok(points)
    }

    /// A point of the list.
    fn row(&self, points: &SweepPoints, table: &ChoiceTable) -> Result<PointOptions, BadInput> {
        let mut row = PointOptions::new();
        for (key, at, value) in self.choices(table)? {
            self.check_varied(points, &key, &at)?;
            let text = self.text(&key, at, value)?;
            row.push((key, text));
        }
        Ok(row)
    }

    /// The options of a table in the order of the file; `a.b = 1` is the key "a.b".
    fn choices<'t>(&self, table: &'t ChoiceTable) -> Result<Vec<Choice<'t>>, BadInput> {
        let mut choices = Vec::new();
        flatten(table, "", &mut choices);
        choices.sort_by_key(|(_, at, _)| at.start);
        for (index, (key, at, _)) in choices.iter().enumerate() {
            self.known(key, at)?;
            if choices.iter().take(index).any(|(other, ..)| other == key) {
                let what = format!("\"{key}\" occurs twice");
                return Err(self.toml.error(at.clone(), what));
            }
        }
        Ok(choices)
    }

    fn known(&self, key: &str, at: &Range<usize>) -> Result<(), BadInput> {
        let flags = self.vocabulary.flags.iter().map(String::as_str);
        let known: Vec<_> = flags
            .chain(SETTINGS.iter().map(|setting| setting.key))
            .collect();
        if known.contains(&key) || is_key(key) {
            return Ok(());
        }
        let elsewhere = match key {
            "world" | "worlds" | "behavior" | "behaviors" | "seed" | "seeds" => {
                ": worlds, behaviors and seeds are lists at the top of the file".to_owned()
            }
            _ => format!(
                "{} (keys: {}, and those of `host-sim settings`)",
                suggestion(key, &known),
                self.vocabulary.flags.join(", ")
            ),
        };
        let what = format!("a point has no key \"{key}\"{elsewhere}");
        Err(self.toml.error(at.clone(), what))
    }

    /// Refuses a key that `[fixed]` already sets for all points.
    fn check_varied(
        &self,
        points: &SweepPoints,
        key: &str,
        at: &Range<usize>,
    ) -> Result<(), BadInput> {
        if points.fixed.iter().any(|(fixed, _)| fixed == key) {
            let what = format!("\"{key}\" is in [fixed] already");
            return Err(self.toml.error(at.clone(), what));
        }
        Ok(())
    }

    /// A value in the form of the command line, after validation.
    fn text(
        &self,
        key: &str,
        at: Range<usize>,
        value: &Spanned<ChoiceValue>,
    ) -> Result<String, BadInput> {
        let ChoiceValue::Scalar(text) = value.get_ref() else {
            let what = format!("a value of {key} must be a number, a text, true or false");
            return Err(self.toml.error(at, what));
        };
        (self.vocabulary.check)(key, text).map_err(|error| self.toml.error(value.span(), error))?;
        Ok(text.clone())
    }
}

fn flatten<'t>(table: &'t ChoiceTable, before: &str, into: &mut Vec<Choice<'t>>) {
    for (key, value) in table {
        let name = format!("{before}{}", key.get_ref());
        match value.get_ref() {
            ChoiceValue::Table(inner) => flatten(inner, &format!("{name}."), into),
            _ => into.push((name, key.span(), value)),
        }
    }
}

#[cfg(test)]
mod tests;
