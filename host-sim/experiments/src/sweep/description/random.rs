//! The table `[random]` of a sweep's description.

use super::super::draws::{Drawn, Draws};
use super::{File, MAX_POINTS};
use crate::sweep::Points;
use files::error::BadInput;
use files::toml_reader::Value;
use std::ops::Range;
use toml::de::DeValue;

impl File<'_> {
    /// Draws the points it asks for.
    pub(super) fn random(&self, value: &Value<'_>, points: &mut Points) -> Result<(), BadInput> {
        let DeValue::Table(table) = value.get_ref() else {
            return Err(self
                .reader
                .error(value.span(), "random must be a table: [random]"));
        };
        let count = self
            .reader
            .required(table, "points", "[random]", &value.span())?;
        let at = count.span();
        let count = self.whole(count, "points")?;
        if !(1..=MAX_POINTS).contains(&count) {
            let what = format!("points must lie between 1 and {MAX_POINTS}");
            return Err(self.reader.error(at, what));
        }
        let seed = table
            .get("seed")
            .map_or(Ok(1), |seed| self.whole(seed, "seed"))?;
        let mut draws = Draws::new(seed);
        for (key, at, value) in self.choices(value, "[random]")? {
            let drawn = self.drawn(&key, &at, value)?;
            draws.add(self.varied(points, &key, &at)?, drawn);
        }
        for _ in 0..count {
            points.add(draws.draw());
        }
        Ok(())
    }

    /// What a value of [random] is drawn from.
    fn drawn(&self, key: &str, at: &Range<usize>, value: &Value<'_>) -> Result<Drawn, BadInput> {
        let wrong = |what: &str| self.reader.error(value.span(), format!("{key} {what}"));
        let DeValue::Table(range) = value.get_ref() else {
            let values = self.array(value, key)?.iter();
            let texts = values.map(|value| self.text(key, at.clone(), value));
            return Ok(Drawn::OneOf(texts.collect::<Result<_, _>>()?));
        };
        self.reader.only_keys(key, range, &["min", "max", "log"])?;
        let end = |name: &str| {
            let end = self.reader.required(range, name, key, &value.span())?;
            self.text(key, at.clone(), end)?;
            let whole = matches!(end.get_ref(), DeValue::Integer(_));
            Ok::<_, BadInput>((self.reader.number(end, name)?, whole))
        };
        let ((min, min_whole), (max, max_whole)) = (end("min")?, end("max")?);
        let log = match range.get("log").map(|log| log.get_ref()) {
            None => false,
            Some(DeValue::Boolean(log)) => *log,
            Some(_) => return Err(wrong("takes log = true or false")),
        };
        if max <= min {
            return Err(wrong("must have a max above its min"));
        }
        if log && min <= 0.0 {
            return Err(wrong("must have a min above 0 for log = true"));
        }
        let whole = min_whole && max_whole;
        Ok(Drawn::Between {
            min,
            max,
            log,
            whole,
        })
    }
}
