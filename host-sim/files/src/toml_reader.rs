//! Reads our TOML files: values become ours, and what does not fit an error that names file, line and key.

use crate::error::{BadInput, suggestion};
use std::fmt;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A table of a file.
pub type Table<'a> = DeTable<'a>;
/// A value of a file and where it stands.
pub type Value<'a> = Spanned<DeValue<'a>>;

/// The text of a file, and what the file is called in errors.
#[derive(Debug, Clone, Copy)]
pub struct Reader<'a> {
    /// The text.
    pub text: &'a str,
    /// What the file is called in errors.
    pub source: &'a str,
}

impl<'a> Reader<'a> {
    /// The whole file.
    ///
    /// # Errors
    /// When it is empty or no TOML.
    pub fn document(&self) -> Result<Spanned<Table<'a>>, BadInput> {
        if self.text.trim().is_empty() {
            return Err(BadInput::new(format!("{}: the file is empty", self.source)));
        }
        DeTable::parse(self.text).map_err(|error| {
            let first_line = error.message().lines().next().unwrap_or("is not TOML");
            self.error(error.span().unwrap_or_default(), first_line)
        })
    }

    /// An error about what stands at a place of the file.
    pub fn error(&self, span: Range<usize>, what: impl fmt::Display) -> BadInput {
        let before = self.text.as_bytes().get(..span.start).unwrap_or_default();
        let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
        BadInput::line(self.source, line, what)
    }

    /// Refuses keys that are not `known`; `what` has these.
    pub fn only_keys(&self, what: &str, table: &Table<'_>, known: &[&str]) -> Result<(), BadInput> {
        let mut keys = table.iter().map(|(key, _)| key);
        let Some(key) = keys.find(|key| !known.contains(&key.get_ref().as_ref())) else {
            return Ok(());
        };
        let hint = suggestion(key.get_ref(), known);
        let known = known.join(", ");
        let what = format!(
            "{what} has no key \"{}\"{hint} (keys: {known})",
            key.get_ref()
        );
        Err(self.error(key.span(), what))
    }

    /// The value of a key that `what`, which stands at `span`, must have.
    pub fn required<'t, 'i>(
        &self,
        table: &'t Table<'i>,
        key: &str,
        what: &str,
        span: &Range<usize>,
    ) -> Result<&'t Value<'i>, BadInput> {
        let missing = || self.error(span.clone(), format!("{what} needs the key \"{key}\""));
        table.get(key).ok_or_else(missing)
    }

    /// A text that is not empty.
    pub fn text<'t>(&self, value: &'t Value<'_>, key: &str) -> Result<&'t str, BadInput> {
        match value.get_ref() {
            DeValue::String(text) if !text.is_empty() => Ok(text),
            _ => Err(self.error(
                value.span(),
                format!("{key} must be a text that is not empty"),
            )),
        }
    }

    /// A finite number.
    pub fn number(&self, value: &Value<'_>, key: &str) -> Result<f64, BadInput> {
        let number = match value.get_ref() {
            DeValue::Float(float) => float.as_str().parse().ok(),
            DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix())
                .ok()
                .map(|integer| integer as f64),
            _ => None,
        };
        match number {
            Some(number) if f64::is_finite(number) => Ok(number),
            Some(_) => Err(self.error(value.span(), format!("{key} must be a finite number"))),
            None => Err(self.error(value.span(), format!("{key} must be a number"))),
        }
    }
}
