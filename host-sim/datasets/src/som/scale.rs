//! The straight line between the data's units and the maps' [0, 1].
//!
//! One line serves all columns, so that a Euclidean distance between weights is the distance in the
//! data's units divided by one number, and no column gains or loses importance. (Columns scaled one
//! by one would make distances that mean nothing in the data's units; to get that,
//! standardize the columns first.) Samples and code vectors have steps of 2⁻²⁹ of the whole
//! range.

use files::error::BadInput;
use files::table::Table;
use std::ops::RangeInclusive;
use std::str::FromStr;
use tinysom::fixed::{FINE_ONE_BITS, Weight32};

/// Half a step of a weight.
const HALF_STEP: f64 = 0.5 / FINE_ONE_BITS as f64;
/// Where code vectors may begin: as far below the scale as it is wide, and printed values may be
/// off by their rounding.
const CODE: RangeInclusive<f64> = -1.0 - HALF_STEP..=1.0 + HALF_STEP;

/// Maps a range of the data's values to weights from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    least: f64,
    span: f64,
}

impl Scale {
    /// From the least to the greatest value of a table; a table of one value all over is mapped to
    /// 0.
    ///
    /// # Errors
    /// Values so far apart that their difference is no finite number.
    pub fn of(table: &Table) -> Result<Self, BadInput> {
        let values = || table.rows.iter().flatten().copied();
        let least = values().fold(f64::INFINITY, f64::min);
        let greatest = values().fold(f64::NEG_INFINITY, f64::max);
        if greatest <= least {
            return Ok(Self { least, span: 1.0 });
        }
        Self::between(least, greatest)
            .map_err(|why| BadInput::new(format!("{}: its values: {why}", table.source)))
    }

    /// From one value to another.
    ///
    /// # Errors
    /// Ends in the wrong order, or so near or far that distances are lost.
    pub fn between(least: f64, greatest: f64) -> Result<Self, String> {
        let span = greatest - least;
        if span <= 0.0 {
            return Err(format!("{least} is not below {greatest}"));
        }
        if !(span.is_finite() && (1.0 / span).is_finite()) {
            return Err(format!("{least} to {greatest} is no usable range"));
        }
        Ok(Self { least, span })
    }

    /// The factor from distances between weights (1.0 = one) to distances between data.
    #[must_use]
    pub const fn span(self) -> f64 {
        self.span
    }

    /// The weight nearest to a value, or nothing when the value lies outside this part of the
    /// scale.
    fn weight(self, value: f64, part: &RangeInclusive<f64>) -> Option<Weight32> {
        let share = (value - self.least) / self.span;
        let bits = (share.clamp(-1.0, 1.0) * f64::from(FINE_ONE_BITS)).round();
        part.contains(&share)
            .then(|| Weight32::from_bits(bits as i32))
    }

    /// The value a weight stands for.
    #[must_use]
    pub fn value(self, weight: Weight32) -> f64 {
        self.at(f64::from(weight.to_bits()) / f64::from(FINE_ONE_BITS))
    }

    fn at(self, share: f64) -> f64 {
        self.least + self.span * share
    }

    /// Decimals with which a value tells neighboring weights apart.
    #[must_use]
    pub fn decimals(self) -> usize {
        let step = self.span / f64::from(FINE_ONE_BITS);
        (1.0 - libm::floor(libm::log10(step))).clamp(0.0, 320.0) as usize
    }

    /// All values of a table as weights, row by row.
    ///
    /// # Errors
    /// A sentence naming the line, column and value that lies outside the scale.
    pub fn samples(self, table: &Table) -> Result<Vec<Weight32>, BadInput> {
        self.weights(table, &(0.0..=1.0))
    }

    /// As [`samples`](Self::samples) for code vectors, which may begin outside the data: as far
    /// below the scale as it is wide.
    ///
    /// # Errors
    /// As [`samples`](Self::samples).
    pub fn code(self, table: &Table) -> Result<Vec<Weight32>, BadInput> {
        self.weights(table, &CODE)
    }

    fn weights(self, table: &Table, part: &RangeInclusive<f64>) -> Result<Vec<Weight32>, BadInput> {
        let mut weights = Vec::with_capacity(table.rows.len() * table.columns());
        for (row, &line) in table.rows.iter().zip(&table.lines) {
            for (index, &value) in row.iter().enumerate() {
                weights.push(self.weight(value, part).ok_or_else(|| {
                    let (from, to) = (self.at(*part.start()), self.at(*part.end()));
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

    /// Reads `MIN:MAX`.
    fn from_str(text: &str) -> Result<Self, BadInput> {
        let ends = text.split_once(':').and_then(|(least, greatest)| {
            Some((least.trim().parse().ok()?, greatest.trim().parse().ok()?))
        });
        let (least, greatest) =
            ends.ok_or_else(|| BadInput::new("it must be two numbers, MIN:MAX"))?;
        Self::between(least, greatest).map_err(BadInput::new)
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
    fn the_ends_become_0_and_1() {
        let data = table("10,20\n15,12\n");
        let scale = Scale::of(&data).unwrap();
        let bits: Vec<_> = scale
            .samples(&data)
            .unwrap()
            .iter()
            .map(|w| w.to_bits())
            .collect();
        assert_eq!(bits, [0, 1 << 29, 1 << 28, 107_374_182]);
        assert_eq!(scale.span(), 10.0);
        assert_eq!(
            Scale::of(&table("3,3\n3,3\n"))
                .unwrap()
                .value(Weight32::ZERO),
            3.0
        );
    }

    #[test]
    fn values_outside_are_named() {
        let data = table("x,y\n0,1\n0.5,1.25\n");
        let scale: Scale = "0:1".parse().unwrap();
        assert_eq!(
            scale.samples(&data).unwrap_err().to_string(),
            "t.csv, line 3, column 2: 1.25 lies outside 0 to 1"
        );
        assert!(scale.code(&table("-1,1")).is_ok());
        assert!(scale.code(&table("-1.01,1")).is_err());
    }

    #[test]
    fn bad_scales_say_what_is_wrong() {
        for (text, why) in [
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
            assert!(error.contains(why), "{text}: {error}");
        }
        let far = Scale::of(&table("-1e308,1e308")).unwrap_err().to_string();
        assert!(far.starts_with("t.csv: its values"), "{far}");
    }

    proptest! {
        #[test]
        fn printed_values_read_back_as_the_same_weights(
            least in -1e6_f64..1e6, span in 1e-6_f64..1e6, bits in -FINE_ONE_BITS..=FINE_ONE_BITS,
        ) {
            // Below a relative width of 2⁻²⁰ the value's own 53 bits no longer hold the steps.
            prop_assume!(span / least.abs().max(span) > 1e-6);
            let scale = Scale::between(least, least + span).unwrap();
            let printed = format!("{:.*}", scale.decimals(), scale.value(Weight32::from_bits(bits)));
            let read = scale.weight(printed.parse().unwrap(), &CODE);
            prop_assert_eq!(read, Some(Weight32::from_bits(bits)));
        }
    }
}
