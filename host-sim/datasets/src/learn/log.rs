//! Parses logged runs from text files: ranges and the robot's action, row by row.

use files::error::{BadInput, suggestion};
use files::table::{MAX_COLUMNS, Record, Records, Table, number};
use files::{MAX_INPUT_BYTES, read_text};
use std::path::Path;

/// Maximum number of rows.
pub const MAX_ROWS: usize = 65_535;
/// Maximum magnitude of a finite range or velocity, in the log's unit. Larger squared differences
/// would lose digits in an `f64`.
pub const MAX_VALUE: f64 = 1e6;
/// Maximum number of different labels.
pub const MAX_LABELS: usize = 64;

/// The columns of a log: each is given by its name in the header or by its number from 1.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LogColumns {
    /// Ranges: names, numbers and spans of numbers (`1-24`), separated by commas; `None` = all
    /// numeric columns except those of the action.
    pub ranges: Option<String>,
    /// Label of the action; `None` = the last column. Ignored if there are velocities.
    pub label: Option<String>,
    /// Velocities, in the form of `ranges`; `None` = the log has labels.
    pub velocities: Option<String>,
    /// Whether the first line is a header; `None` = it is one if it contains no number.
    pub has_heading: Option<bool>,
}

/// The robot's action in each row.
#[derive(Debug, Clone, PartialEq)]
pub enum Actions {
    /// Named actions.
    Labels {
        /// The names, in alphabetical order.
        names: Vec<String>,
        /// By row: index into `names`.
        by_row: Vec<usize>,
    },
    /// Velocities.
    Velocities {
        /// Names of the columns.
        names: Vec<String>,
        /// By row: one value per column.
        by_row: Vec<Vec<f64>>,
    },
}

/// A logged run.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    /// Name of the source in messages.
    pub source: String,
    /// Names of the range finders: from the header, otherwise the column numbers.
    pub names: Vec<String>,
    /// By row: one range per range finder, in the log's unit, not negative; infinite = no echo.
    pub ranges: Vec<Vec<f64>>,
    /// The robot's actions.
    pub actions: Actions,
}

impl Log {
    /// Reads a log from a file.
    ///
    /// # Errors
    /// A sentence that names the file, and line and column where they apply: a file that cannot be
    /// read or is not text, unknown columns, invalid ranges or velocities, an empty label, too many
    /// rows or labels.
    pub fn load(path: &Path, columns: &LogColumns) -> Result<Self, BadInput> {
        let text = read_text(path, MAX_INPUT_BYTES)?;
        Self::parse(&path.display().to_string(), &text, columns)
    }

    /// Reads a log from a text; `source` names it in messages.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn parse(source: &str, text: &str, columns: &LogColumns) -> Result<Self, BadInput> {
        let records = Records::parse(source, text, columns.has_heading)?;
        let file = LogRecords { source, records };
        if file.records.rows.len() > MAX_ROWS {
            let what = format!("{} rows are more than {MAX_ROWS}", file.records.rows.len());
            return Err(BadInput::new(format!("{source}: {what}")));
        }
        let (actions, action_columns) = file.actions(columns)?;
        let range_columns = match &columns.ranges {
            Some(list) => file.columns("--ranges", list)?,
            None => file.numeric_except(&action_columns),
        };
        if let Some(&shared) = range_columns
            .iter()
            .find(|column| action_columns.contains(column))
        {
            let name = file.name(shared);
            return Err(BadInput::new(format!(
                "--ranges: column {name} of {source} holds the action already"
            )));
        }
        if range_columns.is_empty() || range_columns.len() > MAX_COLUMNS {
            let count = range_columns.len();
            return Err(BadInput::new(format!(
                "{source}: {count} columns of ranges, there must be 1 to {MAX_COLUMNS}"
            )));
        }
        Ok(Self {
            source: source.to_owned(),
            names: range_columns
                .iter()
                .map(|&column| file.name(column))
                .collect(),
            ranges: file.values(&range_columns, parse_range)?,
            actions,
        })
    }
}

fn parse_range(field: &str) -> Result<f64, String> {
    match number(field) {
        // An infinite range means no echo.
        Some(value) if value > MAX_VALUE && value.is_finite() => Err(too_large_message(field)),
        Some(value) if value >= 0.0 => Ok(value),
        Some(_) => Err(format!("\"{field}\" is no range: it must not be negative")),
        None => Err(not_a_number_message(field)),
    }
}

fn parse_velocity(field: &str) -> Result<f64, String> {
    match number(field) {
        Some(value) if value.abs() <= MAX_VALUE => Ok(value),
        Some(value) if value.is_finite() => Err(too_large_message(field)),
        Some(_) => Err(format!("\"{field}\" is not a finite number")),
        None => Err(not_a_number_message(field)),
    }
}

fn too_large_message(field: &str) -> String {
    format!("\"{field}\" lies beyond ±{MAX_VALUE}")
}

fn not_a_number_message(field: &str) -> String {
    if field.is_empty() {
        "the field is empty".to_owned()
    } else {
        format!("\"{field}\" is not a number")
    }
}

/// The fields of a log before they are interpreted.
struct LogRecords<'a> {
    source: &'a str,
    records: Records<'a>,
}

impl LogRecords<'_> {
    fn width(&self) -> usize {
        self.records.rows.first().map_or(0, |(_, row)| row.len())
    }

    fn name(&self, column: usize) -> String {
        let name = self.records.heading.get(column);
        name.map_or_else(|| (column + 1).to_string(), |name| (*name).to_owned())
    }

    /// The robot's actions and their columns.
    fn actions(&self, columns: &LogColumns) -> Result<(Actions, Vec<usize>), BadInput> {
        if let Some(list) = &columns.velocities {
            let columns = self.columns("--velocities", list)?;
            let names = columns.iter().map(|&column| self.name(column)).collect();
            let by_row = self.values(&columns, parse_velocity)?;
            return Ok((Actions::Velocities { names, by_row }, columns));
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
            by_row: fields.iter().map(index).collect(),
            names: names.into_iter().map(str::to_owned).collect(),
        })
    }

    /// The columns whose first field is a number, except some.
    fn numeric_except(&self, excluded: &[usize]) -> Vec<usize> {
        let first = self.records.rows.first();
        let fields = first.map_or(&[][..], |(_, row)| row);
        let numeric = fields.iter().enumerate();
        numeric
            .filter(|(column, field)| number(field).is_some() && !excluded.contains(column))
            .map(|(column, _)| column)
            .collect()
    }

    /// Column indices of a list of names, numbers from 1 and spans of numbers.
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
                Some(_) => return Err(self.unknown_column(flag, word)),
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
        let by_name = self.records.heading.iter().position(|name| *name == word);
        let by_number = || {
            let number: usize = word.parse().ok()?;
            (1..=self.width()).contains(&number).then(|| number - 1)
        };
        by_name
            .or_else(by_number)
            .ok_or_else(|| self.unknown_column(flag, word))
    }

    fn unknown_column(&self, flag: &str, word: &str) -> BadInput {
        let hint = suggestion(word, &self.records.heading);
        BadInput::new(format!(
            "{flag}: {} has no column \"{word}\"{hint} (columns are named by its heading or by number, 1 to {})",
            self.source,
            self.width()
        ))
    }

    /// The parsed values of some columns, row by row.
    fn values(
        &self,
        columns: &[usize],
        parse: fn(&str) -> Result<f64, String>,
    ) -> Result<Vec<Vec<f64>>, BadInput> {
        let row = |(line, fields): &Record<'_>| {
            let value = |&column: &usize| {
                let field = fields.get(column).copied().unwrap_or_default();
                parse(field).map_err(|what| Table::cell(self.source, *line, column, what))
            };
            columns.iter().map(value).collect()
        };
        self.records.rows.iter().map(row).collect()
    }
}
