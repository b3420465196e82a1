//! A value of an option in a sweep's file; unlike other TOML tables, any key may stand there.

use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;
use std::fmt;
use toml::Spanned;

/// Keys and values, with their positions in the text.
pub(super) type ChoiceTable = BTreeMap<Spanned<String>, Spanned<ChoiceValue>>;

/// A value.
pub(super) enum ChoiceValue {
    /// Text, number, true or false, in the form of the command line.
    Scalar(String),
    List(Vec<Spanned<ChoiceValue>>),
    Table(ChoiceTable),
}

impl<'de> Deserialize<'de> for ChoiceValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ChoiceVisitor)
    }
}

struct ChoiceVisitor;

impl<'de> Visitor<'de> for ChoiceVisitor {
    type Value = ChoiceValue;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, a text, true or false")
    }

    fn visit_bool<E: Error>(self, on: bool) -> Result<ChoiceValue, E> {
        Ok(ChoiceValue::Scalar(
            if on { "on" } else { "off" }.to_owned(),
        ))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<ChoiceValue, E> {
        Ok(ChoiceValue::Scalar(number.to_string()))
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<ChoiceValue, E> {
        if number.is_finite() {
            return Ok(ChoiceValue::Scalar(number.to_string()));
        }
        let what = format!("expected a finite number, found {number}");
        Err(E::custom(what))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<ChoiceValue, E> {
        match text {
            "" => Err(E::custom("expected a non-empty text")),
            text => Ok(ChoiceValue::Scalar(text.to_owned())),
        }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<ChoiceValue, A::Error> {
        let mut values = Vec::new();
        while let Some(value) = list.next_element()? {
            values.push(value);
        }
        Ok(ChoiceValue::List(values))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> Result<ChoiceValue, A::Error> {
        let mut choices = ChoiceTable::new();
        while let Some((key, value)) = table.next_entry()? {
            choices.insert(key, value);
        }
        Ok(ChoiceValue::Table(choices))
    }
}
