//! The columns of a sweep's results that pictures need.

use super::CHOICE_PREFIX;
use super::results::{ResultsHeader, read_row};
use files::error::BadInput;
use files::{open_regular, unreadable};
use std::collections::HashMap;
use std::io::BufReader;
use std::path::Path;

/// Numeric columns that are read.
const NUMBERS: [&str; 3] = ["contacts", "distance_m", "success"];
/// Text columns that are read, in addition to the points' options.
const TEXTS: [&str; 3] = ["world", "behavior", "success_unit"];

/// Rows of results, by column.
#[derive(Debug, Clone, PartialEq)]
pub struct ResultsTable {
    header: ResultsHeader,
    columns: Vec<(String, Column)>,
    rows: usize,
}

#[derive(Debug, Clone, PartialEq)]
enum Column {
    Numbers(Vec<f64>),
    Texts(Texts),
    Skipped,
}

/// A text column: each distinct text once, and an index per row.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Texts {
    /// The texts, in order of appearance.
    pub distinct: Vec<String>,
    /// By row: index into `distinct`.
    pub of_row: Vec<usize>,
    known: HashMap<String, usize>,
}

impl ResultsTable {
    /// Reads a results file. Skips a torn last row.
    ///
    /// # Errors
    /// When it cannot be read or is no results file.
    pub fn load(path: &Path) -> Result<Self, BadInput> {
        let mut input = BufReader::new(open_regular(path)?);
        let mut table = Self::new(ResultsHeader::read(path, &mut input)?);
        if let Some(missing) = table.missing() {
            return Err(BadInput::file(path, format!("has no column \"{missing}\"")));
        }
        let mut row = Vec::new();
        while read_row(&mut input, &mut row).map_err(|error| unreadable(path, &error))? {
            let fields = fields(&row).unwrap_or_default();
            let added = table.add(&fields.iter().collect::<Vec<_>>());
            added
                .map_err(|what| BadInput::file(path, format!("row {}: {what}", table.rows + 1)))?;
        }
        Ok(table)
    }

    /// A table without rows.
    pub(super) fn new(header: ResultsHeader) -> Self {
        let column = |name: &str| {
            let column = if NUMBERS.contains(&name) {
                Column::Numbers(Vec::new())
            } else if TEXTS.contains(&name) || name.starts_with(CHOICE_PREFIX) {
                Column::Texts(Texts::default())
            } else {
                Column::Skipped
            };
            (name.to_owned(), column)
        };
        Self {
            columns: header.columns().map(column).collect(),
            rows: 0,
            header,
        }
    }

    /// A column that results have and these lack.
    fn missing(&self) -> Option<&'static str> {
        let is_there = |name: &str| self.columns.iter().any(|(known, _)| known == name);
        NUMBERS
            .into_iter()
            .chain(TEXTS)
            .find(|name| !is_there(name))
    }

    /// Adds a row.
    pub(super) fn add(&mut self, fields: &[&str]) -> Result<(), String> {
        if fields.len() != self.columns.len() {
            let (found, wanted) = (fields.len(), self.columns.len());
            return Err(format!("it has {found} fields, the header has {wanted}"));
        }
        for (field, (name, column)) in fields.iter().zip(&mut self.columns) {
            match column {
                Column::Numbers(numbers) => {
                    let number = field.parse().ok().filter(|number: &f64| number.is_finite());
                    let wrong = || format!("{name} is \"{field}\", not a number");
                    numbers.push(number.ok_or_else(wrong)?);
                }
                Column::Texts(texts) => texts.push(field),
                Column::Skipped => {}
            }
        }
        self.rows += 1;
        Ok(())
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The header of the file.
    #[must_use]
    pub fn header(&self) -> &ResultsHeader {
        &self.header
    }

    /// Keys and values of the points' options; a value is empty where a point does not set the
    /// option.
    pub fn choices(&self) -> impl Iterator<Item = (&str, &Texts)> {
        self.columns.iter().filter_map(|(name, column)| {
            let key = name.strip_prefix(CHOICE_PREFIX)?;
            match column {
                Column::Texts(texts) => Some((key, texts)),
                _ => None,
            }
        })
    }

    /// The values of a numeric column, by row.
    #[must_use]
    pub fn numbers(&self, name: &str) -> &[f64] {
        match self.column(name) {
            Some(Column::Numbers(numbers)) => numbers,
            _ => &[],
        }
    }

    /// A text column.
    #[must_use]
    pub fn texts(&self, name: &str) -> Option<&Texts> {
        match self.column(name) {
            Some(Column::Texts(texts)) => Some(texts),
            _ => None,
        }
    }

    fn column(&self, name: &str) -> Option<&Column> {
        let mut columns = self.columns.iter();
        columns
            .find(|(known, _)| known == name)
            .map(|(_, column)| column)
    }
}

impl Texts {
    fn push(&mut self, text: &str) {
        let index = self.known.get(text).copied().unwrap_or_else(|| {
            self.distinct.push(text.to_owned());
            let index = self.distinct.len() - 1;
            self.known.insert(text.to_owned(), index);
            index
        });
        self.of_row.push(index);
    }
}

/// The fields of a row; `None` if it is no CSV.
pub(super) fn fields(row: &[u8]) -> Option<csv::StringRecord> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .from_reader(row);
    let mut record = csv::StringRecord::new();
    reader.read_record(&mut record).ok().filter(|read| *read)?;
    Some(record)
}
