//! The results of a sweep, or of a part of it, as columns.

use super::CHOICE_PREFIX;
use super::results::{Header, read_row};
use files::error::BadInput;
use files::{open_regular, unreadable};
use std::collections::HashMap;
use std::io::BufReader;
use std::path::Path;

/// What a column of results holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Whole numbers from 0 on.
    Whole,
    /// Numbers.
    Real,
    /// Texts.
    Text,
    /// What a point chooses; empty where it leaves it to the preset.
    Choice,
}

impl Kind {
    /// That of the column `name`.
    #[must_use]
    pub fn of(name: &str) -> Self {
        match name {
            "episode" | "seed" | "explore_moves" | "explore_contacts" | "steps" | "contacts"
            | "touched_by" | "goal_steps" | "shield_stops" => Self::Whole,
            "distance_m" | "min_clearance_m" | "coverage_m2" | "time_s" | "success" => Self::Real,
            _ if name.starts_with(CHOICE_PREFIX) => Self::Choice,
            _ => Self::Text,
        }
    }
}

/// One column.
#[derive(Debug, Clone, PartialEq)]
pub enum Column {
    /// Numbers.
    Numbers(Vec<f64>),
    /// Texts: each once, and which of them each row has.
    Texts {
        /// The texts, as they come first.
        names: Vec<String>,
        /// By row.
        of_row: Vec<u32>,
    },
}

/// Rows of results.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    names: Vec<String>,
    columns: Vec<Column>,
    known: Vec<HashMap<String, u32>>,
    rows: usize,
    header: Header,
}

impl Table {
    /// Reads a results file: CSV, or Parquet if it is called so and the program can. A torn last row is left out.
    ///
    /// # Errors
    /// When it cannot be read or is no results file.
    pub fn load(path: &Path) -> Result<Self, BadInput> {
        let is_parquet = path
            .extension()
            .is_some_and(|end| end.eq_ignore_ascii_case("parquet"));
        if is_parquet {
            return load_parquet(path);
        }
        let file = open_regular(path)?;
        let mut input = BufReader::new(file);
        let mut table = Self::new(Header::read(path, &mut input)?);
        let mut row = Vec::new();
        while read_row(&mut input, &mut row).map_err(|error| unreadable(path, &error))? {
            let fields = fields(&row).unwrap_or_default();
            table.add(path, fields.iter())?;
        }
        Ok(table)
    }

    /// No rows yet.
    pub(super) fn new(header: Header) -> Self {
        let names: Vec<_> = header.columns().map(str::to_owned).collect();
        let column = |name: &String| match Kind::of(name) {
            Kind::Whole | Kind::Real => Column::Numbers(Vec::new()),
            Kind::Text | Kind::Choice => Column::Texts {
                names: Vec::new(),
                of_row: Vec::new(),
            },
        };
        Self {
            columns: names.iter().map(column).collect(),
            known: vec![HashMap::new(); names.len()],
            names,
            rows: 0,
            header,
        }
    }

    /// One more row; `path` is where it stands.
    pub(super) fn add<'r>(
        &mut self,
        path: &Path,
        fields: impl Iterator<Item = &'r str>,
    ) -> Result<(), BadInput> {
        let row = self.rows + 1;
        let wrong = |what: String| BadInput::file(path, format!("row {row}: {what}"));
        let mut count = 0;
        let columns = self
            .names
            .iter()
            .zip(&mut self.columns)
            .zip(&mut self.known);
        for (field, ((name, column), known)) in fields.zip(columns) {
            count += 1;
            match column {
                Column::Numbers(numbers) => {
                    let number = field.parse().ok().filter(|number: &f64| number.is_finite());
                    numbers
                        .push(number.ok_or_else(|| {
                            wrong(format!("{name} is \"{field}\", not a number"))
                        })?);
                }
                Column::Texts { names, of_row } => {
                    let index = known.get(field).copied().unwrap_or_else(|| {
                        let index = names.len() as u32;
                        names.push(field.to_owned());
                        known.insert(field.to_owned(), index);
                        index
                    });
                    of_row.push(index);
                }
            }
        }
        if count != self.names.len() {
            return Err(wrong(format!(
                "it has {count} fields, the head has {}",
                self.names.len()
            )));
        }
        self.rows = row;
        Ok(())
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The head of the file.
    #[must_use]
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The names of the columns.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The numbers of a column; none if there is no such column of numbers.
    #[must_use]
    pub fn numbers(&self, name: &str) -> &[f64] {
        match self.column(name) {
            Some(Column::Numbers(numbers)) => numbers,
            _ => &[],
        }
    }

    /// The texts of a column, and which of them each row has; none if there is no such column of texts.
    #[must_use]
    pub fn texts(&self, name: &str) -> (&[String], &[u32]) {
        match self.column(name) {
            Some(Column::Texts { names, of_row }) => (names, of_row),
            _ => (&[], &[]),
        }
    }

    fn column(&self, name: &str) -> Option<&Column> {
        let place = self.names.iter().position(|known| known == name)?;
        self.columns.get(place)
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

#[cfg(feature = "parquet")]
use super::parquet_file::load_parquet;

#[cfg(not(feature = "parquet"))]
fn load_parquet(path: &Path) -> Result<Table, BadInput> {
    Err(BadInput::file(path, super::NO_PARQUET))
}
