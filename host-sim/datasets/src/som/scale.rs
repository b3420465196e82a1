//! Linear scaling between the units of the data and the maps' [0, 1].
//!
//! All columns have the same scale. So a Euclidean distance between weights is the distance in the
//! data divided by one factor, and all columns keep their weight. Separate scales would give
//! distances without a unit; to get them, standardize the columns first. The resolution is 2⁻²⁹ of
//! the range.

use files::error::BadInput;
use files::table::Table;
use std::ops::RangeInclusive;
use std::str::FromStr;
use tinysom::fixed::{FINE_ONE_BITS, Weight32};

/// Half a step of a weight.
const HALF_STEP: f64 = 0.5 / FINE_ONE_BITS as f64;
/// Range of the components of code vectors. Half a step beyond the ends allows for the rounding of
/// printed values.
const CODE_RANGE: RangeInclusive<f64> = -1.0 - HALF_STEP..=1.0 + HALF_STEP;

/// Maps a range of the data's values to weights from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    min: f64,
    span: f64,
}

impl Scale {
    /// Scales the smallest value of a table to 0 and the largest to 1. If all values are equal,
    /// they are scaled to 0.
    ///
    /// # Errors
    /// Values whose difference is not finite.
    pub fn from_table(table: &Table) -> Result<Self, BadInput> {
        let values = || table.rows.iter().flatten().copied();
        let min = values().fold(f64::INFINITY, f64::min);
        let max = values().fold(f64::NEG_INFINITY, f64::max);
        if max <= min {
            return Ok(Self { min, span: 1.0 });
        }
        Self::between(min, max)
            .map_err(|why| BadInput::new(format!("{}: its values: {why}", table.source)))
    }

    /// Scales `min` to 0 and `max` to 1.
    ///
    /// # Errors
    /// `min` not below `max`, or a difference that is not finite or whose inverse is not.
    pub fn between(min: f64, max: f64) -> Result<Self, String> {
        let span = max - min;
        if span <= 0.0 {
            return Err(format!("{min} is not below {max}"));
        }
        if !(span.is_finite() && (1.0 / span).is_finite()) {
            return Err(format!("{min} to {max} is no usable range"));
        }
        Ok(Self { min, span })
    }

    /// Factor that converts distances between weights to distances in the units of the data.
    #[must_use]
    pub const fn span(self) -> f64 {
        self.span
    }

    /// The weight nearest to a value; `None` if the scaled value is not in `range`.
    fn weight(self, value: f64, range: &RangeInclusive<f64>) -> Option<Weight32> {
        let scaled = (value - self.min) / self.span;
        let bits = (scaled.clamp(-1.0, 1.0) * f64::from(FINE_ONE_BITS)).round();
        range
            .contains(&scaled)
            .then(|| Weight32::from_bits(bits as i32))
    }

    /// The value of a weight in the units of the data.
    #[must_use]
    pub fn value(self, weight: Weight32) -> f64 {
        self.unscaled(f64::from(weight.to_bits()) / f64::from(FINE_ONE_BITS))
    }

    fn unscaled(self, scaled: f64) -> f64 {
        self.min + self.span * scaled
    }

    /// Number of decimals that distinguishes the values of neighboring weights.
    #[must_use]
    pub fn decimals(self) -> usize {
        let step = self.span / f64::from(FINE_ONE_BITS);
        (1.0 - libm::floor(libm::log10(step))).clamp(0.0, 320.0) as usize
    }

    /// All values of a table as weights, row by row.
    ///
    /// # Errors
    /// A sentence that names line, column and value if a value lies outside the scale.
    pub fn samples(self, table: &Table) -> Result<Vec<Weight32>, BadInput> {
        self.weights(table, &(0.0..=1.0))
    }

    /// As [`samples`](Self::samples), for code vectors: their scaled values may be in [−1, 1].
    ///
    /// # Errors
    /// As [`samples`](Self::samples).
    pub fn code_vectors(self, table: &Table) -> Result<Vec<Weight32>, BadInput> {
        self.weights(table, &CODE_RANGE)
    }

    fn weights(
        self,
        table: &Table,
        range: &RangeInclusive<f64>,
    ) -> Result<Vec<Weight32>, BadInput> {
        let mut weights = Vec::with_capacity(table.rows.len() * table.columns());
        for (row, &line) in table.rows.iter().zip(&table.lines) {
            for (index, &value) in row.iter().enumerate() {
                weights.push(self.weight(value, range).ok_or_else(|| {
                    let (from, to) = (self.unscaled(*range.start()), self.unscaled(*range.end()));
                    let what = format!("{value} lies outside {from} to {to}");
                    Table::cell(&table.source, line, index, what)
                })?);
            }
        }
        Ok(weights)
    }
}

impl FromStr for Scale {
    type Err = BadInput;

    /// Parses `MIN:MAX`.
    fn from_str(text: &str) -> Result<Self, BadInput> {
        let ends = text
            .split_once(':')
            .and_then(|(min, max)| Some((min.trim().parse().ok()?, max.trim().parse().ok()?)));
        let (min, max) = ends.ok_or_else(|| BadInput::new("it must be two numbers, MIN:MAX"))?;
        Self::between(min, max).map_err(BadInput::new)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn table(text: &str) -> Table {
        Table::parse("t.csv", text).unwrap()
    }

    #[test]
    fn smallest_and_largest_value_become_0_and_1() {
        let data = table("10,20\n15,12\n");
        let scale = Scale::from_table(&data).unwrap();
        let bits: Vec<_> = scale
            .samples(&data)
            .unwrap()
            .iter()
            .map(|w| w.to_bits())
            .collect();
        assert_eq!(bits, [0, 1 << 29, 1 << 28, 107_374_182]);
        assert_eq!(scale.span(), 10.0);
        assert_eq!(
            Scale::from_table(&table("3,3\n3,3\n"))
                .unwrap()
                .value(Weight32::ZERO),
            3.0
        );
    }

    #[test]
    fn errors_name_values_outside() {
        let data = table("x,y\n0,1\n0.5,1.25\n");
        let scale: Scale = "0:1".parse().unwrap();
        assert_eq!(
            scale.samples(&data).unwrap_err().to_string(),
            "t.csv, line 3, column 2: 1.25 lies outside 0 to 1"
        );
        assert!(scale.code_vectors(&table("-1,1")).is_ok());
        assert!(scale.code_vectors(&table("-1.01,1")).is_err());
    }

    #[test]
    fn invalid_scales_give_an_error() {
        for (text, expected) in [
            ("1:1", "1 is not below 1"),
            ("5:2", "5 is not below 2"),
            ("a:b", "two numbers"),
            ("7", "two numbers"),
            ("1:2:3", "two numbers"),
            ("0:inf", "no usable range"),
            ("NaN:1", "no usable range"),
            ("-1e308:1e308", "no usable range"),
        ] {
            let error = text.parse::<Scale>().expect_err(text).to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
        let far = Scale::from_table(&table("-1e308,1e308"))
            .unwrap_err()
            .to_string();
        assert!(far.starts_with("t.csv: its values"), "{far}");
    }

    proptest! {
        #[test]
        fn printed_values_parse_to_the_same_weights(
            min in -1e6_f64..1e6, span in 1e-6_f64..1e6, bits in -FINE_ONE_BITS..=FINE_ONE_BITS,
        ) {
            // At a relative width below 2⁻²⁰ the 53 bits of a value are too few for steps of 2⁻²⁹.
            prop_assume!(span / min.abs().max(span) > 1e-6);
            let scale = Scale::between(min, min + span).unwrap();
            let printed = format!("{:.*}", scale.decimals(), scale.value(Weight32::from_bits(bits)));
            let parsed = scale.weight(printed.parse().unwrap(), &CODE_RANGE);
            prop_assert_eq!(parsed, Some(Weight32::from_bits(bits)));
        }
    }
}
