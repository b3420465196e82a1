//! Reads TOML files with serde; an error is one sentence that names file, line and key.

use crate::error::{BadInput, suggestion};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;
use std::marker::PhantomData;
use std::ops::Range;

/// The text of a file, and its name in errors.
#[derive(Debug, Clone, Copy)]
pub struct TomlText<'a> {
    /// The text.
    pub text: &'a str,
    /// Name of the file in errors.
    pub source: &'a str,
}

impl<'a> TomlText<'a> {
    /// Parses the whole file as a `T`, which refuses unknown keys by `deny_unknown_fields`.
    ///
    /// # Errors
    /// When it is empty, no TOML, or no `T`.
    pub fn read<T: Deserialize<'a>>(&self) -> Result<T, BadInput> {
        if self.text.trim().is_empty() {
            return Err(BadInput::new(format!("{}: the file is empty", self.source)));
        }
        toml::from_str(self.text).map_err(|error| self.sentence(error))
    }

    /// An error about a position in the file.
    pub fn error(&self, span: Range<usize>, what: impl fmt::Display) -> BadInput {
        let before = self.text.as_bytes().get(..span.start).unwrap_or_default();
        let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
        BadInput::line(self.source, line, what)
    }

    fn sentence(&self, mut error: toml::de::Error) -> BadInput {
        let span = error.span().unwrap_or_default();
        let message = error.message().replace('\n', " ");
        // Without the text it displays as its message, then "in `KEY`" on a separate line.
        error.set_input(None);
        let text = error.to_string();
        let key = text.trim_end().rsplit_once("\nin `").map(|(_, key)| key);
        self.error(
            span,
            reworded(&message, key.and_then(|key| key.strip_suffix('`'))),
        )
    }
}

/// Serde's message about the value of `key`, or about the whole file, in plain words.
fn reworded(message: &str, key: Option<&str>) -> String {
    let place = key.unwrap_or("the file");
    if let Some((word, known)) = unknown_field(message) {
        let hint = suggestion(word, &known);
        let known = known.join(", ");
        return format!("{place} has no key \"{word}\"{hint} (keys: {known})");
    }
    if let Some(word) = quoted(message, "missing field `") {
        return format!("{place} needs the key \"{word}\"");
    }
    let what = ["invalid type: ", "invalid value: ", "invalid length "];
    let found = what.iter().find_map(|what| message.strip_prefix(what));
    let what = match found.and_then(|rest| rest.split_once(", expected ")) {
        Some(("map", "a sequence")) => format!("expected a list of tables: [[{place}]]"),
        Some((found, expected)) => format!("expected {}, found {}", plain(expected), plain(found)),
        None => message.to_owned(),
    };
    key.map_or(what.clone(), |key| format!("{key}: {what}"))
}

/// The unknown key, and the known ones.
fn unknown_field(message: &str) -> Option<(&str, Vec<&str>)> {
    let (word, known) = message
        .strip_prefix("unknown field `")?
        .split_once("`, expected ")?;
    Some((word, known.split('`').skip(1).step_by(2).collect()))
}

fn quoted<'m>(message: &'m str, before: &str) -> Option<&'m str> {
    message.strip_prefix(before)?.strip_suffix('`')
}

/// Serde's word for a type or a value in terms of TOML.
fn plain(word: &str) -> &str {
    match word {
        "a sequence" | "sequence" => "a list",
        "a string" => "a text",
        "f64" => "a number",
        "u8" => "a whole number from 0 to 255",
        "a map" | "map" => "a table",
        _ => {
            // `string "…"`, or as in "integer `7`".
            let value = word.strip_prefix("string ");
            let kinds = ["integer `", "floating point `", "boolean `"];
            let number = kinds.iter().find_map(|kind| word.strip_prefix(kind));
            let number = number.and_then(|value| value.split('`').next());
            value.or(number).unwrap_or(word)
        }
    }
}

/// A table. Serde alone would also accept a list of the values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Keyed<T>(pub T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Keyed<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct TableVisitor<T>(PhantomData<T>);

        impl<'de, T: Deserialize<'de>> Visitor<'de> for TableVisitor<T> {
            type Value = Keyed<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table")
            }

            fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<Keyed<T>, A::Error> {
                T::deserialize(MapAccessDeserializer::new(table)).map(Keyed)
            }
        }

        deserializer.deserialize_map(TableVisitor(PhantomData))
    }
}

/// A finite number.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(try_from = "f64")]
pub struct Finite(pub f64);

impl TryFrom<f64> for Finite {
    type Error = String;

    fn try_from(number: f64) -> Result<Self, String> {
        let finite = Some(number).filter(|number| number.is_finite());
        let wrong = || format!("expected a finite number, found {number}");
        finite.map(Self).ok_or_else(wrong)
    }
}

/// Two finite numbers: [x, y].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoNumbers(pub [f64; 2]);

impl<'de> Deserialize<'de> for TwoNumbers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct TwoNumbersVisitor;

        impl<'de> Visitor<'de> for TwoNumbersVisitor {
            type Value = TwoNumbers;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("two numbers: [x, y]")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<TwoNumbers, A::Error> {
                let mut numbers = Vec::new();
                while let Some(Finite(number)) = list.next_element()? {
                    numbers.push(number);
                }
                let pair = <[f64; 2]>::try_from(numbers);
                pair.map(TwoNumbers)
                    .map_err(|numbers| A::Error::invalid_length(numbers.len(), &self))
            }
        }

        deserializer.deserialize_seq(TwoNumbersVisitor)
    }
}
