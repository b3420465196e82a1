//! Results as an Apache Parquet file: the same columns and rows as in CSV, with types.
//!
//! Counts and seeds are 64-bit integers, measures doubles, names texts. What points choose is a double where all values of the column are
//! numbers, else a text; null where a point leaves it to the preset. The head of the CSV file is kept under the key `host-sim.head`.

use super::merge::Merged;
use super::results::Header;
use super::table::{Kind, Table, fields};
use files::error::BadInput;
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::record::Field;
use parquet::schema::types::{Type, TypePtr};
use std::fs::{self, File};
use std::path::Path;
use std::sync::Arc;

/// Rows of a row group: bounds memory.
const GROUP: usize = 1 << 14;
/// The key of the head.
const HEAD: &str = "host-sim.head";

/// Writes a whole sweep's results; the file is there completely or not at all.
///
/// # Errors
/// When it cannot be written, or a file of results cannot be read any more.
pub fn write_parquet(merged: &mut Merged, path: &Path) -> Result<(), BadInput> {
    let refused =
        |error: &dyn std::fmt::Display| BadInput::file(path, format!("cannot be written: {error}"));
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(|error| refused(&error))?;
    }
    files::write_with(
        path,
        |error| refused(&error),
        |file| fill(merged, file, &refused),
    )
}

fn fill(
    merged: &mut Merged,
    file: &File,
    refused: &dyn Fn(&dyn std::fmt::Display) -> BadInput,
) -> Result<(), BadInput> {
    let header = merged.header().clone();
    let mut columns: Vec<_> = header.columns().map(Values::of).collect();
    merged.rows(&mut |row| {
        let fields = fields(row).unwrap_or_default();
        columns
            .iter_mut()
            .zip(&fields)
            .for_each(|(column, field)| column.look(field));
        Ok::<_, BadInput>(())
    })?;
    let schema = schema(&header, &columns).map_err(|error| refused(&error))?;
    let head = KeyValue::new(HEAD.to_owned(), header.text().to_owned());
    let properties = WriterProperties::builder()
        .set_key_value_metadata(Some(vec![head]))
        .build();
    let writer = SerializedFileWriter::new(file, schema, Arc::new(properties));
    let mut writer = writer.map_err(|error| refused(&error))?;
    let mut held = 0;
    merged.rows(&mut |row| {
        let fields = fields(row).unwrap_or_default();
        for (column, field) in columns.iter_mut().zip(&fields) {
            column
                .push(field)
                .ok_or_else(|| refused(&format!("\"{field}\" is not a number")))?;
        }
        held += 1;
        if held < GROUP {
            return Ok(());
        }
        held = 0;
        flush(&mut writer, &mut columns).map_err(|error| refused(&error))
    })?;
    if held > 0 {
        flush(&mut writer, &mut columns).map_err(|error| refused(&error))?;
    }
    writer.close().map_err(|error| refused(&error))?;
    Ok(())
}

/// The values of one column that are not yet written.
enum Values {
    Whole(Vec<i64>),
    Real(Vec<f64>),
    Text(Vec<ByteArray>),
    /// Of a choice: 1 for each row that has a value; the values, as numbers as long as all are.
    Choice {
        there: Vec<i16>,
        numbers: Option<Vec<f64>>,
        texts: Vec<ByteArray>,
    },
}

impl Values {
    fn of(name: &str) -> Self {
        match Kind::of(name) {
            Kind::Whole => Self::Whole(Vec::new()),
            Kind::Real => Self::Real(Vec::new()),
            Kind::Text => Self::Text(Vec::new()),
            Kind::Choice => Self::Choice {
                there: Vec::new(),
                numbers: Some(Vec::new()),
                texts: Vec::new(),
            },
        }
    }

    /// Learns what a choice's column must hold.
    fn look(&mut self, field: &str) {
        if let Self::Choice { numbers, .. } = self
            && !field.is_empty()
            && !is_number(field)
        {
            *numbers = None;
        }
    }

    fn push(&mut self, field: &str) -> Option<()> {
        match self {
            // The bits of a u64, as the format has it.
            Self::Whole(values) => values.push(field.parse::<u64>().ok()? as i64),
            Self::Real(values) => values.push(field.parse().ok()?),
            Self::Text(values) => values.push(field.into()),
            Self::Choice { there, .. } if field.is_empty() => there.push(0),
            Self::Choice {
                there,
                numbers,
                texts,
            } => {
                there.push(1);
                match numbers {
                    Some(numbers) => numbers.push(field.parse().ok()?),
                    None => texts.push(field.into()),
                }
            }
        }
        Some(())
    }

    fn write(&mut self, column: &mut SerializedColumnWriter<'_>) -> Result<(), ParquetError> {
        match self {
            Self::Whole(values) => {
                column
                    .typed::<Int64Type>()
                    .write_batch(values, None, None)?;
                values.clear();
            }
            Self::Real(values) => {
                column
                    .typed::<DoubleType>()
                    .write_batch(values, None, None)?;
                values.clear();
            }
            Self::Text(values) => {
                column
                    .typed::<ByteArrayType>()
                    .write_batch(values, None, None)?;
                values.clear();
            }
            Self::Choice {
                there,
                numbers: Some(numbers),
                ..
            } => {
                column
                    .typed::<DoubleType>()
                    .write_batch(numbers, Some(there), None)?;
                numbers.clear();
                there.clear();
            }
            Self::Choice {
                there,
                numbers: None,
                texts,
            } => {
                column
                    .typed::<ByteArrayType>()
                    .write_batch(texts, Some(there), None)?;
                texts.clear();
                there.clear();
            }
        }
        Ok(())
    }

    fn field(&self, name: &str) -> Result<TypePtr, ParquetError> {
        let text = || Some(LogicalType::String);
        let whole = LogicalType::integer(64, false);
        let (required, optional) = (Repetition::REQUIRED, Repetition::OPTIONAL);
        let (physical, logical, repetition) = match self {
            Self::Whole(_) => (Physical::INT64, Some(whole), required),
            Self::Real(_) => (Physical::DOUBLE, None, required),
            Self::Text(_) => (Physical::BYTE_ARRAY, text(), required),
            Self::Choice {
                numbers: Some(_), ..
            } => (Physical::DOUBLE, None, optional),
            Self::Choice { numbers: None, .. } => (Physical::BYTE_ARRAY, text(), optional),
        };
        let field = Type::primitive_type_builder(name, physical).with_logical_type(logical);
        Ok(Arc::new(field.with_repetition(repetition).build()?))
    }
}

/// Whether it comes back from a double as it was.
fn is_number(text: &str) -> bool {
    text.parse::<f64>()
        .is_ok_and(|number| number.is_finite() && number.to_string() == text)
}

fn schema(header: &Header, columns: &[Values]) -> Result<TypePtr, ParquetError> {
    let fields = header
        .columns()
        .zip(columns)
        .map(|(name, column)| column.field(name));
    let fields = fields.collect::<Result<_, _>>()?;
    Ok(Arc::new(
        Type::group_type_builder("sweep")
            .with_fields(fields)
            .build()?,
    ))
}

fn flush(
    writer: &mut SerializedFileWriter<&File>,
    columns: &mut [Values],
) -> Result<(), ParquetError> {
    let mut group = writer.next_row_group()?;
    for values in columns {
        if let Some(mut column) = group.next_column()? {
            values.write(&mut column)?;
            column.close()?;
        }
    }
    group.close()?;
    Ok(())
}

/// Reads the results of a sweep from Parquet.
///
/// # Errors
/// When the file cannot be read or does not come from [`write_parquet`].
pub(super) fn load_parquet(path: &Path) -> Result<Table, BadInput> {
    let unreadable = |error: ParquetError| BadInput::file(path, format!("cannot be read: {error}"));
    let file = files::open_regular(path)?;
    let reader = SerializedFileReader::new(file).map_err(unreadable)?;
    let kept = reader.metadata().file_metadata().key_value_metadata();
    let head = kept.and_then(|pairs| pairs.iter().find(|pair| pair.key == HEAD)?.value.as_deref());
    let header = Header::read(path, &mut head.unwrap_or_default().as_bytes())?;
    let mut table = Table::new(header);
    for row in reader.get_row_iter(None).map_err(unreadable)? {
        let row = row.map_err(unreadable)?;
        let texts: Vec<_> = row
            .get_column_iter()
            .map(|(_, field)| text(field))
            .collect();
        table.add(path, texts.iter().map(String::as_str))?;
    }
    Ok(table)
}

/// A value as it stands in the CSV file.
fn text(field: &Field) -> String {
    match field {
        Field::Null => String::new(),
        Field::Str(text) => text.clone(),
        Field::Double(number) => number.to_string(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_that_come_back() {
        for text in ["1", "1.5", "-0.25", "100"] {
            assert!(is_number(text), "{text}");
        }
        for text in ["1.50", "on", "inf", "NaN", "0x1", "0.3:0.1"] {
            assert!(!is_number(text), "{text}");
        }
    }
}
