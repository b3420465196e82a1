//! The TOML robot file: one table of numbers, then `[[sensor]]` for each sensor.
//!
//! An unknown key is an error, with its line. Examples stand in `host-sim/robots`.

use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use super::{MAX_SENSORS, RobotModel, SensorKind, SensorMount};
use crate::world::Point;
use files::error::BadInput;
use files::toml_reader::{Finite, Keyed, TomlText, TwoNumbers};
use files::{MAX_INPUT_BYTES, read_text};

/// Longest range that a file may state, m.
const MAX_RANGE_M: f64 = 1000.0;

/// Farthest position of a sensor from the center, in radii of the body.
const MAX_RADII: f64 = 2.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RobotFile {
    name: Spanned<String>,
    drive: Spanned<String>,
    radius_m: Spanned<Finite>,
    max_speed_m_s: Spanned<Finite>,
    max_turn_deg_s: Spanned<Finite>,
    range_m: Spanned<TwoNumbers>,
    cone_deg: Spanned<Finite>,
    period_ms: Spanned<Finite>,
    wheel_slip: Option<Spanned<Finite>>,
    heading_drift_deg_m: Option<Spanned<Finite>>,
    firing_order: Option<Spanned<Vec<Spanned<u8>>>>,
    sensor: Spanned<Vec<Keyed<SensorTable>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SensorTable {
    bearing_deg: Spanned<Finite>,
    position_m: Spanned<TwoNumbers>,
    kind: Option<Spanned<String>>,
}

/// Loads the robot file at `path`.
pub(super) fn load(path: &Path) -> Result<RobotModel, BadInput> {
    let text = read_text(path, MAX_INPUT_BYTES)?;
    parse(&text, &path.display().to_string())
}

/// Reads a robot from `text`; `source` names it in errors.
pub(super) fn parse(text: &str, source: &str) -> Result<RobotModel, BadInput> {
    let text = TomlText { text, source };
    let file: RobotFile = text.read()?;
    let name = file.name.get_ref();
    if name.trim().is_empty() {
        return Err(text.error(file.name.span(), "name: expected a text that is not empty"));
    }
    let radius_m = above_zero(&text, "radius_m", &file.radius_m, 10.0)?;
    let sensors = sensors(&text, &file.sensor, radius_m)?;
    Ok(RobotModel {
        name: name.clone(),
        drive: word(&text, "drive", &file.drive)?,
        radius_m,
        max_speed_m_s: above_zero(&text, "max_speed_m_s", &file.max_speed_m_s, 20.0)?,
        max_turn_rad_s: above_zero(&text, "max_turn_deg_s", &file.max_turn_deg_s, 3600.0)?
            .to_radians(),
        range_m: range(&text, &file.range_m)?,
        half_cone_rad: 0.5 * above_zero(&text, "cone_deg", &file.cone_deg, 180.0)?.to_radians(),
        period_s: above_zero(&text, "period_ms", &file.period_ms, 10_000.0)? / 1000.0,
        wheel_slip: optional(&text, "wheel_slip", file.wheel_slip.as_ref(), 1.0)?,
        heading_drift: {
            let drift = file.heading_drift_deg_m.as_ref();
            optional(&text, "heading_drift_deg_m", drift, 90.0)?.to_radians()
        },
        firing_order: match &file.firing_order {
            Some(order) => Some(firing_order(&text, order, sensors.len())?),
            None => None,
        },
        sensors,
    })
}

/// A number above 0, at most `max`.
fn above_zero(
    text: &TomlText<'_>,
    key: &str,
    value: &Spanned<Finite>,
    max: f64,
) -> Result<f64, BadInput> {
    let Finite(number) = *value.get_ref();
    if number > 0.0 && number <= max {
        return Ok(number);
    }
    let what = format!("{key}: must be above 0 and at most {max}, not {number}");
    Err(text.error(value.span(), what))
}

/// A number from 0 to `max`, or 0 if the key is absent.
fn optional(
    text: &TomlText<'_>,
    key: &str,
    value: Option<&Spanned<Finite>>,
    max: f64,
) -> Result<f64, BadInput> {
    let Some(value) = value else {
        return Ok(0.0);
    };
    let Finite(number) = *value.get_ref();
    if (0.0..=max).contains(&number) {
        return Ok(number);
    }
    let what = format!("{key}: must be from 0 to {max}, not {number}");
    Err(text.error(value.span(), what))
}

/// A word of a fixed list.
fn word<T: core::str::FromStr<Err = BadInput>>(
    text: &TomlText<'_>,
    key: &str,
    value: &Spanned<String>,
) -> Result<T, BadInput> {
    let known = value.get_ref().parse();
    known.map_err(|error| text.error(value.span(), format!("{key}: {error}")))
}

/// The shortest and the longest range.
fn range(text: &TomlText<'_>, value: &Spanned<TwoNumbers>) -> Result<[f64; 2], BadInput> {
    let TwoNumbers([shortest, longest]) = *value.get_ref();
    if 0.0 <= shortest && shortest < longest && longest <= MAX_RANGE_M {
        return Ok([shortest, longest]);
    }
    let what = format!(
        "range_m: must be [shortest, longest] with 0 <= shortest < longest <= {MAX_RANGE_M}, \
         not [{shortest}, {longest}]"
    );
    Err(text.error(value.span(), what))
}

/// All sensors, in the order of the file.
fn sensors(
    text: &TomlText<'_>,
    tables: &Spanned<Vec<Keyed<SensorTable>>>,
    radius_m: f64,
) -> Result<Vec<SensorMount>, BadInput> {
    let list = tables.get_ref();
    if list.is_empty() {
        return Err(text.error(tables.span(), "sensor: a robot needs at least one sensor"));
    }
    if let Some(Keyed(extra)) = list.get(MAX_SENSORS) {
        let what = format!(
            "sensor: a robot has at most {MAX_SENSORS} sensors, not {}",
            list.len()
        );
        return Err(text.error(extra.bearing_deg.span(), what));
    }
    let numbered = list.iter().enumerate();
    numbered
        .map(|(number, Keyed(table))| table.mount(text, number, radius_m))
        .collect()
}

impl SensorTable {
    fn mount(
        &self,
        text: &TomlText<'_>,
        number: usize,
        radius_m: f64,
    ) -> Result<SensorMount, BadInput> {
        let Finite(bearing) = *self.bearing_deg.get_ref();
        if bearing.abs() > 360.0 {
            let what = format!("sensor.bearing_deg: must be from -360 to 360, not {bearing}");
            return Err(text.error(self.bearing_deg.span(), what));
        }
        let TwoNumbers([x, y]) = *self.position_m.get_ref();
        let position = Point::new(x, y);
        if position.length() > MAX_RADII * radius_m {
            let what = format!(
                "sensor.position_m: sensor {number} is {:.3} m from the center, \
                 more than {MAX_RADII} times radius_m = {radius_m}",
                position.length()
            );
            return Err(text.error(self.position_m.span(), what));
        }
        let kind = match &self.kind {
            Some(kind) => word(text, "sensor.kind", kind)?,
            None => SensorKind::default(),
        };
        Ok(SensorMount {
            bearing_rad: bearing.to_radians(),
            position,
            kind,
        })
    }
}

/// The firing order: each of `count` sensors once.
fn firing_order(
    text: &TomlText<'_>,
    order: &Spanned<Vec<Spanned<u8>>>,
    count: usize,
) -> Result<Vec<usize>, BadInput> {
    let mut fired = vec![false; count];
    let mut numbers = Vec::with_capacity(count);
    for entry in order.get_ref() {
        let number = usize::from(*entry.get_ref());
        let defect = match fired.get_mut(number) {
            None => {
                let last = count.saturating_sub(1);
                format!("there is no sensor {number}, the last one is {last}")
            }
            Some(true) => format!("sensor {number} appears twice"),
            Some(seen) => {
                *seen = true;
                numbers.push(number);
                continue;
            }
        };
        return Err(text.error(entry.span(), format!("firing_order: {defect}")));
    }
    match fired.iter().position(|&seen| !seen) {
        None => Ok(numbers),
        Some(number) => {
            let what = format!("firing_order: sensor {number} is missing");
            Err(text.error(order.span(), what))
        }
    }
}
