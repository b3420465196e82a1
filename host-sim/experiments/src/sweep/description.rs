//! A sweep's description:
//!
//! ```toml
//! name = "range-and-shield"            # [default: the file's]
//! worlds = ["random:1..=20", "paper"]  # as for `run --world` [default: paper]
//! behaviors = ["avoid", "nest"]        # as for `run --behavior` [default: avoid]
//! seeds = "1..=10"                     # or a number, or a list of numbers [default: 1]
//!
//! [fixed]                              # for every episode
//! steps = 500
//! shield = false                       # true and false are on and off
//!
//! [grid]                               # points: every combination, the last key fastest
//! far = [1.5, 3.0, 4.5]
//! explore = [50, 100]
//!
//! [[list]]                             # one more point
//! preset = "probe"
//! far = 2.0
//!
//! [random]                             # so many more, drawn with this seed
//! points = 20
//! seed = 1
//! far = { min = 1.0, max = 6.0 }       # evenly; whole numbers where both ends are
//! tolerance = { min = 0.01, max = 0.3, log = true }
//! recall = ["direction", "projection"] # one of them
//! ```
//!
//! Keys are the flags of `run` that say what an episode is made of, and the keys of `--set`. Points are numbered as they stand above: grid,
//! list, random; without any there is one. A key that is not known is an error, with its line.

mod random;

use super::plan::Vocabulary;
use super::points::Points;
use arena::world::{WorldSource, parse_worlds};
use files::error::{BadInput, suggestion};
use files::read_text;
use files::toml_reader::{Reader, Table, Value};
use sim::scenes::Behavior;
use sim::settings::SETTINGS;
use std::ops::Range;
use std::path::Path;
use toml::de::DeValue;

/// Larger files are refused, bytes.
const MAX_FILE_BYTES: u64 = 16 << 20;
/// Most seeds of a sweep.
const MAX_SEEDS: u64 = 1_000_000;
/// Most points: each of them is looked at before anything is run.
const MAX_POINTS: u64 = 100_000;

/// What a sweep's file says.
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
    /// Its sets of choices.
    pub points: Points,
}

impl Description {
    /// Reads the file of a sweep whose keys are those of `vocabulary`.
    ///
    /// # Errors
    /// A sentence that names the file, the line and what is wrong there.
    pub fn load(path: &Path, vocabulary: &Vocabulary) -> Result<Self, BadInput> {
        let text = read_text(path, MAX_FILE_BYTES)?;
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        Self::read(&text, &path.display().to_string(), &tame(&stem), vocabulary)
    }

    /// Reads the text of a sweep's file; `source` names it in errors, and the sweep is called `default_name` if it has no name.
    ///
    /// # Errors
    /// As [`Description::load`].
    pub fn read(
        text: &str,
        source: &str,
        default_name: &str,
        vocabulary: &Vocabulary,
    ) -> Result<Self, BadInput> {
        let reader = Reader { text, source };
        let document = reader.document()?;
        let top = document.get_ref();
        let known = [
            "name",
            "worlds",
            "behaviors",
            "seeds",
            "fixed",
            "grid",
            "list",
            "random",
        ];
        reader.only_keys("a sweep", top, &known)?;
        let file = File { reader, vocabulary };
        let name = match top.get("name") {
            Some(value) => file.name(value)?,
            None => default_name.to_owned(),
        };
        Ok(Self {
            name,
            worlds: file.each(top, "worlds", "paper", parse_worlds)?.concat(),
            behaviors: file.each(top, "behaviors", "avoid", str::parse)?,
            seeds: file.seeds(top.get("seeds"))?,
            points: file.points(top)?,
        })
    }
}

/// A file's name as a sweep's.
fn tame(name: &str) -> String {
    let tame = |c: char| if is_plain(c) { c } else { '-' };
    name.chars().map(tame).collect()
}

fn is_plain(c: char) -> bool {
    c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.')
}

/// A choice that the file makes: its key, where that stands, and its value.
type Choice<'t, 'a> = (String, Range<usize>, &'t Value<'a>);

struct File<'a> {
    reader: Reader<'a>,
    vocabulary: &'a Vocabulary,
}

impl<'a> File<'a> {
    fn name(&self, value: &Value<'_>) -> Result<String, BadInput> {
        let name = self.reader.text(value, "name")?;
        if name.chars().all(is_plain) && name.len() <= 100 {
            return Ok(name.to_owned());
        }
        let what = "name must be letters, digits, -, _ and ., at most 100 of them";
        Err(self.reader.error(value.span(), what))
    }

    /// What the texts of the list `key` mean; of `default` if there is none.
    fn each<T>(
        &self,
        top: &Table<'_>,
        key: &str,
        default: &str,
        read: impl Fn(&str) -> Result<T, BadInput>,
    ) -> Result<Vec<T>, BadInput> {
        let Some(value) = top.get(key) else {
            return Ok(vec![read(default)?]);
        };
        let one = |entry: &Value<'_>| {
            let text = self.reader.text(entry, &format!("each of {key}"))?;
            read(text).map_err(|error| self.reader.error(entry.span(), error))
        };
        self.array(value, key)?.iter().map(one).collect()
    }

    /// The entries of an array that is not empty.
    fn array<'t, 'i>(&self, value: &'t Value<'i>, key: &str) -> Result<&'t [Value<'i>], BadInput> {
        match value.get_ref() {
            DeValue::Array(entries) if !entries.is_empty() => Ok(entries),
            _ => {
                let what = format!("{key} must be a list with something in it: [ … ]");
                Err(self.reader.error(value.span(), what))
            }
        }
    }

    fn seeds(&self, value: Option<&Value<'_>>) -> Result<Vec<u64>, BadInput> {
        let Some(value) = value else {
            return Ok(vec![1]);
        };
        let wrong = || {
            let what = "seeds must be a number, a list of numbers, or a range: \"1..=10\"";
            self.reader.error(value.span(), what)
        };
        let (first, last) = match value.get_ref() {
            DeValue::Array(_) => {
                let seeds = self.array(value, "seeds")?.iter();
                return seeds
                    .map(|seed| self.whole(seed, "each of seeds"))
                    .collect();
            }
            DeValue::Integer(_) => return Ok(vec![self.whole(value, "seeds")?]),
            DeValue::String(text) => text.split_once("..=").ok_or_else(wrong)?,
            _ => return Err(wrong()),
        };
        let seed = |text: &str| text.trim().parse::<u64>().map_err(|_| wrong());
        let (first, last) = (seed(first)?, seed(last)?);
        if first > last || last - first >= MAX_SEEDS {
            let what = format!("seeds must be a range of 1 to {MAX_SEEDS} seeds");
            return Err(self.reader.error(value.span(), what));
        }
        Ok((first..=last).collect())
    }

    /// A whole number from 0 on.
    fn whole(&self, value: &Value<'_>, key: &str) -> Result<u64, BadInput> {
        let number = match value.get_ref() {
            DeValue::Integer(number) => u64::from_str_radix(number.as_str(), number.radix()).ok(),
            _ => None,
        };
        number.ok_or_else(|| {
            let what = format!("{key} must be a whole number from 0 on");
            self.reader.error(value.span(), what)
        })
    }

    fn points(&self, top: &Table<'_>) -> Result<Points, BadInput> {
        let mut points = Points::default();
        if let Some(value) = top.get("fixed") {
            for (key, at, value) in self.choices(value, "[fixed]")? {
                points
                    .fixed
                    .push((key.clone(), self.text(&key, at, value)?));
            }
        }
        if let Some(value) = top.get("grid") {
            for (key, at, value) in self.choices(value, "[grid]")? {
                let values = self.array(value, &key)?.iter();
                let texts = values.map(|value| self.text(&key, at.clone(), value));
                let texts = texts.collect::<Result<_, _>>()?;
                points.add_axis(self.varied(&points, &key, &at)?, texts);
            }
        }
        if let Some(value) = top.get("list") {
            for entry in self.array(value, "list")? {
                let mut row = Vec::new();
                for (key, at, value) in self.choices(entry, "[[list]]")? {
                    let text = self.text(&key, at.clone(), value)?;
                    row.push((self.varied(&points, &key, &at)?.to_owned(), text));
                }
                points.add(row);
            }
        }
        if let Some(value) = top.get("random") {
            self.random(value, &mut points)?;
        }
        if points.count().is_none_or(|count| count > MAX_POINTS) {
            let what = format!("the grid has more than {MAX_POINTS} points");
            let span = top.get("grid").map(Value::span).unwrap_or_default();
            return Err(self.reader.error(span, what));
        }
        Ok(points)
    }

    /// The choices of a table in the file's order; `a.b = 1` is the key "a.b".
    fn choices<'t, 'i>(
        &self,
        value: &'t Value<'i>,
        what: &str,
    ) -> Result<Vec<Choice<'t, 'i>>, BadInput> {
        let DeValue::Table(table) = value.get_ref() else {
            return Err(self
                .reader
                .error(value.span(), format!("{what} must be a table")));
        };
        let mut choices = Vec::new();
        flatten(table, "", &mut choices);
        if what == "[random]" {
            choices.retain(|(key, ..)| key != "points" && key != "seed");
        }
        choices.sort_by_key(|(_, at, _)| at.start);
        for (index, (key, at, _)) in choices.iter().enumerate() {
            self.known(key, at)?;
            if choices.iter().take(index).any(|(other, ..)| other == key) {
                let what = format!("\"{key}\" is there twice");
                return Err(self.reader.error(at.clone(), what));
            }
        }
        Ok(choices)
    }

    fn known(&self, key: &str, at: &Range<usize>) -> Result<(), BadInput> {
        let flags = self.vocabulary.flags.iter().map(String::as_str);
        let known: Vec<_> = flags
            .chain(SETTINGS.iter().map(|setting| setting.key))
            .collect();
        if known.contains(&key) {
            return Ok(());
        }
        let elsewhere = match key {
            "world" | "worlds" | "behavior" | "behaviors" | "seed" | "seeds" => {
                ": worlds, behaviors and seeds are lists of their own at the top of the file"
                    .to_owned()
            }
            _ => format!(
                "{} (keys: {}, and those of `host-sim settings`)",
                suggestion(key, &known),
                self.vocabulary.flags.join(", ")
            ),
        };
        let what = format!("a point has no key \"{key}\"{elsewhere}");
        Err(self.reader.error(at.clone(), what))
    }

    /// A key that is not the same for all points.
    fn varied<'k>(
        &self,
        points: &Points,
        key: &'k str,
        at: &Range<usize>,
    ) -> Result<&'k str, BadInput> {
        if points.fixed.iter().any(|(fixed, _)| fixed == key) {
            let what = format!("\"{key}\" is in [fixed] already");
            return Err(self.reader.error(at.clone(), what));
        }
        Ok(key)
    }

    /// A value as the command line takes it, once it is known to be good.
    fn text(&self, key: &str, at: Range<usize>, value: &Value<'_>) -> Result<String, BadInput> {
        let text = match value.get_ref() {
            DeValue::String(text) if !text.is_empty() => text.to_string(),
            DeValue::Boolean(true) => "on".to_owned(),
            DeValue::Boolean(false) => "off".to_owned(),
            DeValue::Integer(_) | DeValue::Float(_) => self.reader.number(value, key)?.to_string(),
            _ => {
                let what = format!("a value of {key} must be a number, a text, true or false");
                return Err(self.reader.error(at, what));
            }
        };
        (self.vocabulary.check)(key, &text)
            .map_err(|error| self.reader.error(value.span(), error))?;
        Ok(text)
    }
}

/// A table with an end of a range is no table of further keys.
fn flatten<'t, 'i>(table: &'t Table<'i>, before: &str, into: &mut Vec<Choice<'t, 'i>>) {
    for (key, value) in table {
        let name = format!("{before}{}", key.get_ref());
        match value.get_ref() {
            DeValue::Table(inner) if !inner.contains_key("min") && !inner.contains_key("max") => {
                flatten(inner, &format!("{name}."), into);
            }
            _ => into.push((name, key.span(), value)),
        }
    }
}

#[cfg(test)]
mod tests;
