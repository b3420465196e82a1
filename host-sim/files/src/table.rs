//! Reads tables of numbers from text files.
//!
//! One sample per line, separated by semicolons, tabs or commas (the first of these in the first
//! line). Empty lines and lines that begin with `#` are skipped. A first line without numbers is a
//! header; a last column without numbers holds labels and is skipped.

use crate::error::BadInput;
use crate::{MAX_INPUT_BYTES, read_text};
use std::fmt::Display;
use std::path::Path;

/// Largest number of columns.
pub const MAX_COLUMNS: usize = 4096;

/// Finite numbers in rows of equal length; at least one row and one column.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Name of the source in messages.
    pub source: String,
    /// Names of the columns; empty without a header.
    pub names: Vec<String>,
    /// The rows.
    pub rows: Vec<Vec<f64>>,
    /// Line of the file (from 1) of each row.
    pub lines: Vec<usize>,
}

impl Table {
    /// Reads a table from a file.
    ///
    /// # Errors
    /// A sentence that names the file, and line and column where they apply: a file that cannot be
    /// read or is not text, no samples, rows of different lengths, a field that is not a finite
    /// number.
    pub fn load(path: &Path) -> Result<Self, BadInput> {
        let text = read_text(path, MAX_INPUT_BYTES)?;
        Self::parse(&path.display().to_string(), &text)
    }

    /// Reads a table from a text; `source` names it in messages.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn parse(source: &str, text: &str) -> Result<Self, BadInput> {
        let Records { heading, rows } = Records::parse(source, text, None)?;
        let names = heading.into_iter().map(str::to_owned).collect();
        Self::of(source, names, &rows)
    }

    /// An error about one field; `index` is the column, from 0.
    pub fn cell(source: &str, line: usize, index: usize, what: impl Display) -> BadInput {
        let column = index + 1;
        BadInput::new(format!("{source}, line {line}, column {column}: {what}"))
    }

    /// Number of columns.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.rows.first().map_or(0, Vec::len)
    }

    fn of(source: &str, mut names: Vec<String>, records: &[Record]) -> Result<Self, BadInput> {
        let last = |fields: &[&str]| fields.last().and_then(|field| number(field));
        let width = records.first().map_or(0, |(_, fields)| fields.len());
        let labeled = width > 1 && records.iter().all(|(_, fields)| last(fields).is_none());
        let columns = width - usize::from(labeled);
        if columns > MAX_COLUMNS {
            let what = format!("{columns} columns are more than {MAX_COLUMNS}");
            return Err(BadInput::new(format!("{source}: {what}")));
        }
        names.truncate(columns);
        let row = |(line, fields): &Record| {
            let numbered = fields.iter().take(columns).enumerate();
            numbered
                .map(|(index, field)| {
                    finite(field).map_err(|what| Self::cell(source, *line, index, what))
                })
                .collect()
        };
        Ok(Self {
            source: source.to_owned(),
            names,
            rows: records.iter().map(row).collect::<Result<_, _>>()?,
            lines: records.iter().map(|(line, _)| *line).collect(),
        })
    }
}

/// Number of a line, and its fields.
pub type Record<'a> = (usize, Vec<&'a str>);

/// The lines of a table as text: at least one row, all with the same number of fields.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Records<'a> {
    /// The fields of the header; empty without one.
    pub heading: Vec<&'a str>,
    /// The other lines.
    pub rows: Vec<Record<'a>>,
}

impl<'a> Records<'a> {
    /// Splits a text into lines and fields; `source` names it in messages. If `headed` is `None`,
    /// the fields of the first line decide whether it is a header.
    ///
    /// # Errors
    /// No line, only a header, lines of different lengths.
    pub fn parse(source: &str, text: &'a str, headed: Option<bool>) -> Result<Self, BadInput> {
        let about = |what: &str| BadInput::new(format!("{source}: {what}"));
        let mut rows = records(text);
        let Some((_, first)) = rows.first() else {
            return Err(about("the file is empty"));
        };
        let no_number = || first.iter().all(|field| number(field).is_none());
        let heading = if headed.unwrap_or_else(no_number) {
            rows.remove(0).1
        } else {
            Vec::new()
        };
        if rows.is_empty() {
            return Err(about(match headed {
                None => "there is no sample: its only line holds no number at all",
                Some(_) => "there is no sample: its only line is the heading",
            }));
        }
        same_length(source, &heading, &rows)?;
        Ok(Self { heading, rows })
    }
}

fn records(text: &str) -> Vec<Record<'_>> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines = text.lines().map(str::trim).zip(1..);
    let filled: Vec<_> = lines
        .filter(|(line, _)| !line.is_empty() && !line.starts_with('#'))
        .collect();
    let first = filled.first().map_or("", |(line, _)| line);
    let separator = [';', '\t'].into_iter().find(|&mark| first.contains(mark));
    let separator = separator.unwrap_or(',');
    let split = |(line, index)| (index, fields(line, separator));
    filled.into_iter().map(split).collect()
}

/// The fields of a line; separators between double quotes do not count.
fn fields(line: &str, separator: char) -> Vec<&str> {
    let mut quoted = false;
    line.split(|character| {
        quoted ^= character == '"';
        character == separator && !quoted
    })
    .map(|field| field.trim().trim_matches('"'))
    .collect()
}

/// The number in a field; `None` if it is no number.
#[must_use]
pub fn number(field: &str) -> Option<f64> {
    field.parse().ok()
}

fn finite(field: &str) -> Result<f64, String> {
    match number(field) {
        Some(value) if value.is_finite() => Ok(value),
        Some(_) => Err(format!("\"{field}\" is not a finite number")),
        None if field.is_empty() => Err("the field is empty".to_owned()),
        None => Err(format!("\"{field}\" is not a number")),
    }
}

fn same_length(source: &str, names: &[&str], records: &[Record]) -> Result<(), BadInput> {
    let Some((first_line, first)) = records.first() else {
        return Ok(());
    };
    let (expected, of) = if names.is_empty() {
        (first.len(), format!("line {first_line}"))
    } else {
        (names.len(), "the heading".to_owned())
    };
    match records.iter().find(|(_, fields)| fields.len() != expected) {
        Some((line, fields)) => {
            let what = format!("{} fields where {of} has {expected}", fields.len());
            Err(BadInput::line(source, *line, what))
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn say(text: &str) -> String {
        Table::parse("t.csv", text).expect_err(text).to_string()
    }

    #[test]
    fn headings_and_labels_are_recognized() {
        let plain = Table::parse("t.csv", "1,2\n3,-4e-1\n").unwrap();
        assert_eq!(plain.rows, [[1.0, 2.0], [3.0, -0.4]]);
        assert!(plain.names.is_empty());
        let full =
            "\u{feff}# made by hand\r\n\r\n\"a, or b\";c;class\r\n1; 2 ;left\r\n\r\n3;4;\r\n";
        let full = Table::parse("t.csv", full).unwrap();
        assert_eq!(full.names, ["a, or b", "c"]);
        assert_eq!(full.rows, [[1.0, 2.0], [3.0, 4.0]]);
        assert_eq!(full.lines, [4, 6]);
        assert_eq!(Table::parse("t.csv", "7").unwrap().columns(), 1);
        assert_eq!(Table::parse("t.csv", "x\ty\n1\t2").unwrap().columns(), 2);
    }

    #[test]
    fn bad_tables_are_named_with_line_and_column() {
        assert_eq!(say(""), "t.csv: the file is empty");
        assert_eq!(say("\n# nothing\n"), "t.csv: the file is empty");
        assert!(say("a,b\n").starts_with("t.csv: there is no sample"));
        assert_eq!(
            say("1,2\n\n1,2,3\n"),
            "t.csv, line 3: 3 fields where line 1 has 2"
        );
        assert_eq!(
            say("a,b\n1,2\n1\n"),
            "t.csv, line 3: 1 fields where the heading has 2"
        );
        assert_eq!(
            say("1,2\nx,2\n"),
            "t.csv, line 2, column 1: \"x\" is not a number"
        );
        assert!(say("1,2\n1,n/a\n").contains("line 2, column 2: \"n/a\" is not a number"));
        assert!(say("1,NaN\n").contains("line 1, column 2: \"NaN\" is not a finite number"));
        assert!(say("1,2\n-inf,3").contains("line 2, column 1: \"-inf\""));
        assert!(say("1,,2").contains("column 2: the field is empty"));
        assert!(say(&"1,".repeat(5_000)).contains("5000 columns"));
    }

    #[test]
    fn files_that_are_none_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("data.csv");
        let say = || Table::load(&path).unwrap_err().to_string();
        assert!(say().starts_with(&path.display().to_string()));
        std::fs::write(&path, [0x89, 0x50, 0xff, 0x00]).unwrap();
        assert!(say().ends_with("is not a text file"));
        std::fs::write(&path, "1,2\n\0,3\n").unwrap();
        assert!(say().ends_with("is not a text file"));
        std::fs::write(&path, "1,2\n").unwrap();
        assert_eq!(Table::load(&path).unwrap().rows, [[1.0, 2.0]]);
    }
}
