//! Logged runs from text files: ranges and what the robot did, row by row.

use files::error::{BadInput, suggestion};
use files::table::{MAX_COLUMNS, Record, Records, Table, number};
use files::{MAX_INPUT_BYTES, read_text};
use std::path::Path;

/// Rows a log may have.
pub const MAX_ROWS: usize = 65_535;
/// Largest size of a finite range or velocity, in the log's unit: beyond it, squared differences
/// lose their last digits.
pub const MAX_VALUE: f64 = 1e6;
/// Different labels a log may have.
pub const MAX_LABELS: usize = 64;

/// Which columns hold what; columns are named as in the heading, or by number from 1.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Columns {
    /// Ranges: names, numbers and spans of numbers (`1-24`), separated by commas; `None` = all
    /// columns of numbers that hold nothing else.
    pub ranges: Option<String>,
    /// The label; `None` = the last column, unless there are velocities.
    pub label: Option<String>,
    /// Velocities, as `ranges`; `None` = there are labels.
    pub velocities: Option<String>,
    /// The first line is a heading; `None` = if it holds no number.
    pub headed: Option<bool>,
}

/// What the robot did at each row.
#[derive(Debug, Clone, PartialEq)]
pub enum Actions {
    /// One of some named actions.
    Labels {
        /// The names, in alphabetical order.
        names: Vec<String>,
        /// By row, an index of `names`.
        of: Vec<usize>,
    },
    /// Velocities.
    Velocities {
        /// What the columns are called.
        names: Vec<String>,
        /// By row, one value per column.
        of: Vec<Vec<f64>>,
    },
}

/// A logged run.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    /// Where it came from, for messages.
    pub source: String,
    /// What the range finders are called: as in the heading, else by number of the column.
    pub names: Vec<String>,
    /// By row, one range per range finder, in the log's unit, not negative; infinite = nothing was
    /// heard.
    pub ranges: Vec<Vec<f64>>,
    /// What the robot did.
    pub actions: Actions,
}

impl Log {
    /// Reads the log in a file.
    ///
    /// # Errors
    /// A sentence naming the file, and line and column where it is about them: a file that cannot
    /// be read or is not text, unknown columns, fields that are no ranges or velocities, no label,
    /// too many rows or labels.
    pub fn load(path: &Path, columns: &Columns) -> Result<Self, BadInput> {
        let text = read_text(path, MAX_INPUT_BYTES)?;
        Self::parse(&path.display().to_string(), &text, columns)
    }

    /// Reads the log in a text; `source` names it in messages.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn parse(source: &str, text: &str, columns: &Columns) -> Result<Self, BadInput> {
        let records = Records::parse(source, text, columns.headed)?;
        let file = File { source, records };
        if file.records.rows.len() > MAX_ROWS {
            let what = format!("{} rows are more than {MAX_ROWS}", file.records.rows.len());
            return Err(BadInput::new(format!("{source}: {what}")));
        }
        let (actions, taken) = file.actions(columns)?;
        let chosen = match &columns.ranges {
            Some(list) => file.columns("--ranges", list)?,
            None => file.numeric_but(&taken),
        };
        if let Some(&both) = chosen.iter().find(|column| taken.contains(column)) {
            let name = file.name(both);
            return Err(BadInput::new(format!(
                "--ranges: column {name} of {source} holds the action already"
            )));
        }
        if chosen.is_empty() || chosen.len() > MAX_COLUMNS {
            let count = chosen.len();
            return Err(BadInput::new(format!(
                "{source}: {count} columns of ranges, there must be 1 to {MAX_COLUMNS}"
            )));
        }
        Ok(Self {
            source: source.to_owned(),
            names: chosen.iter().map(|&column| file.name(column)).collect(),
            ranges: file.values(&chosen, range)?,
            actions,
        })
    }
}

fn range(field: &str) -> Result<f64, String> {
    match number(field) {
        // An infinite range: nothing was heard.
        Some(value) if value > MAX_VALUE && value.is_finite() => Err(too_large(field)),
        Some(value) if value >= 0.0 => Ok(value),
        Some(_) => Err(format!("\"{field}\" is no range: it must not be negative")),
        None => Err(no_number(field)),
    }
}

fn velocity(field: &str) -> Result<f64, String> {
    match number(field) {
        Some(value) if value.abs() <= MAX_VALUE => Ok(value),
        Some(value) if value.is_finite() => Err(too_large(field)),
        Some(_) => Err(format!("\"{field}\" is not a finite number")),
        None => Err(no_number(field)),
    }
}

fn too_large(field: &str) -> String {
    format!("\"{field}\" lies beyond ±{MAX_VALUE}")
}

fn no_number(field: &str) -> String {
    if field.is_empty() {
        "the field is empty".to_owned()
    } else {
        format!("\"{field}\" is not a number")
    }
}

struct File<'a> {
    source: &'a str,
    records: Records<'a>,
}

impl File<'_> {
    fn width(&self) -> usize {
        self.records.rows.first().map_or(0, |(_, row)| row.len())
    }

    fn name(&self, column: usize) -> String {
        let named = self.records.heading.get(column);
        named.map_or_else(|| (column + 1).to_string(), |name| (*name).to_owned())
    }

    /// What the robot did, and the columns that say it.
    fn actions(&self, columns: &Columns) -> Result<(Actions, Vec<usize>), BadInput> {
        if let Some(list) = &columns.velocities {
            let taken = self.columns("--velocities", list)?;
            let names = taken.iter().map(|&column| self.name(column)).collect();
            let of = self.values(&taken, velocity)?;
            return Ok((Actions::Velocities { names, of }, taken));
        }
        let column = match &columns.label {
            Some(name) => self.column("--label", name)?,
            None => self.width().saturating_sub(1),
        };
        Ok((self.labels(column)?, vec![column]))
    }

    fn labels(&self, column: usize) -> Result<Actions, BadInput> {
        let mut fields = Vec::new();
        for (line, row) in &self.records.rows {
            let label = row.get(column).copied().unwrap_or_default();
            if label.is_empty() {
                return Err(Table::cell(
                    self.source,
                    *line,
                    column,
                    "the label is empty",
                ));
            }
            fields.push(label);
        }
        let mut names = fields.clone();
        names.sort_unstable();
        names.dedup();
        if names.len() > MAX_LABELS {
            return Err(BadInput::new(format!(
                "{}: column {} holds {} different labels, more than {MAX_LABELS} (velocities are named by --velocities)",
                self.source,
                self.name(column),
                names.len()
            )));
        }
        let index = |label| names.binary_search(label).unwrap_or(0);
        Ok(Actions::Labels {
            of: fields.iter().map(index).collect(),
            names: names.into_iter().map(str::to_owned).collect(),
        })
    }

    /// The columns whose first field is a number, without those taken.
    fn numeric_but(&self, taken: &[usize]) -> Vec<usize> {
        let first = self.records.rows.first();
        let fields = first.map_or(&[][..], |(_, row)| row);
        let numeric = fields.iter().enumerate();
        numeric
            .filter(|(column, field)| number(field).is_some() && !taken.contains(column))
            .map(|(column, _)| column)
            .collect()
    }

    /// The columns of a list: names, numbers from 1, spans of numbers.
    fn columns(&self, flag: &str, list: &str) -> Result<Vec<usize>, BadInput> {
        let mut columns = Vec::new();
        for word in list.split(',').map(str::trim) {
            let span = word.split_once('-').and_then(|(first, last)| {
                let ends = (first.parse::<usize>().ok()?, last.parse::<usize>().ok()?);
                (!self.records.heading.contains(&word)).then_some(ends)
            });
            match span {
                Some((first, last)) if 1 <= first && first <= last && last <= self.width() => {
                    columns.extend(first - 1..last);
                }
                Some(_) => return Err(self.no_column(flag, word)),
                None => columns.push(self.column(flag, word)?),
            }
        }
        for (place, &column) in columns.iter().enumerate() {
            if columns.iter().take(place).any(|&other| other == column) {
                let name = self.name(column);
                return Err(BadInput::new(format!(
                    "{flag}: column {name} is named twice"
                )));
            }
        }
        Ok(columns)
    }

    fn column(&self, flag: &str, word: &str) -> Result<usize, BadInput> {
        let named = self.records.heading.iter().position(|name| *name == word);
        let counted = || {
            let number: usize = word.parse().ok()?;
            (1..=self.width()).contains(&number).then(|| number - 1)
        };
        named
            .or_else(counted)
            .ok_or_else(|| self.no_column(flag, word))
    }

    fn no_column(&self, flag: &str, word: &str) -> BadInput {
        let hint = suggestion(word, &self.records.heading);
        BadInput::new(format!(
            "{flag}: {} has no column \"{word}\"{hint} (columns are named by its heading or by number, 1 to {})",
            self.source,
            self.width()
        ))
    }

    fn values(
        &self,
        columns: &[usize],
        read: fn(&str) -> Result<f64, String>,
    ) -> Result<Vec<Vec<f64>>, BadInput> {
        let row = |(line, fields): &Record<'_>| {
            let value = |&column: &usize| {
                let field = fields.get(column).copied().unwrap_or_default();
                read(field).map_err(|what| Table::cell(self.source, *line, column, what))
            };
            columns.iter().map(value).collect()
        };
        self.records.rows.iter().map(row).collect()
    }
}
