//! The table of settings as text: reads and prints every open choice, for `--set KEY=VALUE`.
//!
//! [`amp::parameters`] holds the table: keys, meanings, ranges. This module adds units, words and
//! error messages.

use amp::config::{Config, Wander};
use amp::fixed::{Mask, Weight};
use amp::parameters::{NumberFormat, Setting, SettingKind, Value};
use amp::som::{Decay, Schedule};
use files::error::BadInput;

/// Every open choice, in the order of the data's way through the controller.
pub static SETTINGS: &[Setting<16>] = Setting::ALL;

/// Shapes of a schedule by name.
pub const DECAYS: &[(&str, Decay)] = &[
    ("linear", Decay::Linear),
    ("exponential", Decay::Exponential),
    ("inverse", Decay::Inverse),
];

/// The words of a switch, the index being that of [`SettingKind::Words`].
const SWITCH: &[&str] = &["on", "off"];

/// Applies several `KEY=VALUE`, in order.
///
/// # Errors
/// A sentence that names the key or the value when a text is not `KEY=VALUE`, a key is unknown
/// (with the nearest known one), a value is not among those it takes, or the values do not go
/// together.
pub fn apply<T: AsRef<str>>(config: &mut Config<16>, assignments: &[T]) -> Result<(), BadInput> {
    for assignment in assignments {
        apply_one(config, assignment.as_ref())?;
    }
    let (near, far) = (config.encoding.near_mm, config.encoding.far_mm);
    if far <= near {
        let (near, far) = (f64::from(near) / 1_000.0, f64::from(far) / 1_000.0);
        return Err(BadInput::new(format!(
            "setting far ({far} m) must lie above setting near ({near} m)"
        )));
    }
    Ok(())
}

fn apply_one(config: &mut Config<16>, assignment: &str) -> Result<(), BadInput> {
    let Some((key, value)) = assignment.split_once('=') else {
        return Err(BadInput::new(format!(
            "--set takes KEY=VALUE, got \"{assignment}\""
        )));
    };
    set(config, key, value)
}

/// Sets one choice. [`apply`] also checks that it goes with the others.
///
/// # Errors
/// A sentence that names the key, if it is unknown, or the value, if it is not among those the key
/// takes.
pub fn set(config: &mut Config<16>, key: &str, text: &str) -> Result<(), BadInput> {
    let Some(setting) = Setting::find(key) else {
        let keys: Vec<_> = SETTINGS.iter().map(|setting| setting.key).collect();
        return Err(BadInput::unknown("setting", key, &keys));
    };
    let set = |value| (setting.set(config, value)).map_err(|error| error.to_string());
    parse(setting.kind, text)
        .and_then(set)
        .map_err(|why| BadInput::new(format!("setting {key} cannot be \"{text}\": {why}")))
}

/// Whether a choice has this name or had it formerly.
#[must_use]
pub fn is_key(key: &str) -> bool {
    Setting::<16>::find(key).is_some()
}

/// The value of a setting as text that [`apply`] takes.
#[must_use]
pub fn text(setting: &Setting<16>, config: &Config<16>) -> String {
    match (setting.kind, setting.get(config)) {
        (SettingKind::Number { format, .. }, Value::Number(number)) => number_text(format, number),
        (SettingKind::Switch, Value::Number(on)) => word(SWITCH, 1 - on),
        (SettingKind::Words(words), Value::Number(index)) => word(words, index),
        (_, Value::Number(bits)) => disabled_text(Mask::from_bits(bits.cast_unsigned())),
        (_, Value::Schedule(schedule)) => schedule_text(schedule),
        (_, Value::Wander(wander)) => wander_text(wander),
    }
}

fn parse(kind: SettingKind, text: &str) -> Result<Value, String> {
    match kind {
        SettingKind::Number {
            format,
            least,
            greatest,
        } => number(format, least, greatest, text).map(Value::Number),
        SettingKind::Switch => index(SWITCH, text).map(|index| Value::Number(1 - index)),
        SettingKind::Words(words) => index(words, text).map(Value::Number),
        SettingKind::Sensors => {
            enabled(text).map(|mask| Value::Number(mask.to_bits().cast_signed()))
        }
        SettingKind::Schedule { greatest_q16 } => {
            schedule(text, f64::from(greatest_q16) / 65_536.0).map(Value::Schedule)
        }
        SettingKind::Wander => wander(text).map(Value::Wander),
    }
}

/// How many of the table's numbers make one of what a person types: meters, seconds, degrees,
/// shares.
const fn per_unit(format: NumberFormat) -> f64 {
    match format {
        NumberFormat::Count => 1.0,
        NumberFormat::Millimeters | NumberFormat::Milliseconds => 1_000.0,
        NumberFormat::Q8 => 256.0,
        NumberFormat::Q16 => 65_536.0,
        NumberFormat::Turns => 65_536.0 / 360.0,
        NumberFormat::WeightBits => 8_192.0,
    }
}

fn number(format: NumberFormat, least: i32, greatest: i32, text: &str) -> Result<i32, String> {
    let typed = |number: i32| f64::from(number) / per_unit(format);
    let value = float(text, typed(least), typed(greatest))?;
    Ok(match format {
        NumberFormat::Millimeters | NumberFormat::Milliseconds => {
            (value * per_unit(format) + 0.5) as i32
        }
        NumberFormat::WeightBits => Weight::from_num(value).to_bits().into(),
        NumberFormat::Turns => (value * 65_536.0 / 360.0) as i32,
        NumberFormat::Count | NumberFormat::Q8 | NumberFormat::Q16 => {
            (value * per_unit(format)) as i32
        }
    })
}

fn number_text(format: NumberFormat, number: i32) -> String {
    match format {
        // The shortest decimals that read back as the same bits.
        NumberFormat::WeightBits => Weight::from_bits(number as i16).to_string(),
        NumberFormat::Turns => (f64::from(number) * 360.0 / 65_536.0).to_string(),
        _ => (f64::from(number) / per_unit(format)).to_string(),
    }
}

fn float(text: &str, least: f64, most: f64) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if (least..=most).contains(&value) => Ok(value),
        Ok(_) => Err(format!("it must lie between {least} and {most}")),
        Err(_) => Err("it is not a number".to_owned()),
    }
}

fn index(words: &[&str], text: &str) -> Result<i32, String> {
    let found = words.iter().position(|word| *word == text);
    found
        .map(|index| index as i32)
        .ok_or_else(|| format!("it must be one of {}", words.join(", ")))
}

fn word(words: &[&str], index: i32) -> String {
    let word = usize::try_from(index).ok().and_then(|at| words.get(at));
    word.map_or_else(String::new, |word| (*word).to_owned())
}

fn wander(text: &str) -> Result<Option<Wander>, String> {
    let count = |text: &str| float(text, 1.0, 255.0).map(|value| value as u8);
    match text.split_once(':') {
        None if text == "off" => Ok(None),
        None => Err("it must be PATIENCE:MOVES or off".to_owned()),
        Some((patience, moves)) => Ok(Some(Wander {
            patience: count(patience)?,
            moves: count(moves)?,
        })),
    }
}

fn wander_text(wander: Option<Wander>) -> String {
    wander.map_or_else(
        || "off".to_owned(),
        |wander| format!("{}:{}", wander.patience, wander.moves),
    )
}

/// A schedule from `START:END:SHAPE`, or a constant from one number; values in 0 … `most`.
///
/// # Errors
/// A sentence that says what is wrong with the text.
pub fn schedule(text: &str, most: f64) -> Result<Schedule, String> {
    let q16 = |text: &str| float(text, 0.0, most).map(|value| (value * 65_536.0 + 0.5) as u32);
    let parts: Vec<_> = text.split(':').collect();
    let falling = |start: &str, end: &str, decay| {
        let (start, end) = (q16(start)?, q16(end)?);
        if end > start {
            return Err("its end must not lie above its start".to_owned());
        }
        Ok(Schedule::from_q16(start, end, decay))
    };
    match parts[..] {
        [value] => Ok(Schedule::constant(q16(value)?)),
        [start, end] => falling(start, end, Decay::Linear),
        [start, end, shape] => falling(start, end, decay(shape)?),
        _ => Err("it must be START:END:SHAPE".to_owned()),
    }
}

fn decay(text: &str) -> Result<Decay, String> {
    let found = DECAYS.iter().find(|(name, _)| *name == text);
    found.map(|(_, decay)| *decay).ok_or_else(|| {
        let names: Vec<_> = DECAYS.iter().map(|(name, _)| *name).collect();
        format!("it must be one of {}", names.join(", "))
    })
}

fn schedule_text(schedule: Schedule) -> String {
    let shape = DECAYS
        .iter()
        .find(|(_, decay)| *decay == schedule.decay())
        .map_or("", |(name, _)| *name);
    let share = |q16: u32| f64::from(q16) / 65_536.0;
    format!(
        "{}:{}:{shape}",
        share(schedule.start_q16()),
        share(schedule.end_q16())
    )
}

/// The enabled transducers from the disabled ones: `none`, or numbers joined by `+`.
fn enabled(text: &str) -> Result<Mask, String> {
    if text == "none" {
        return Ok(Mask::ALL);
    }
    let mut mask = Mask::ALL;
    for part in text.split('+') {
        let sensor = float(part, 0.0, 15.0)?;
        mask = mask.without(sensor as usize);
    }
    Ok(mask)
}

fn disabled_text(mask: Mask) -> String {
    let disabled = (0..16).filter(|&sensor| !mask.contains(sensor));
    let disabled: Vec<_> = disabled.map(|sensor| sensor.to_string()).collect();
    if disabled.is_empty() {
        "none".to_owned()
    } else {
        disabled.join("+")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::action_map::Recall;
    use amp::config::MapTraining;
    use amp::som::Neighborhood;

    #[test]
    fn every_setting_takes_back_what_it_prints() {
        for preset in [Config::touzet(), Config::recommended()] {
            for setting in SETTINGS {
                let value = text(setting, &preset);
                let mut copy = preset.clone();
                apply(&mut copy, &[format!("{}={value}", setting.key)]).expect(setting.key);
                assert_eq!(text(setting, &copy), value, "{}", setting.key);
            }
        }
    }

    #[test]
    fn settings_change_what_they_name() {
        let mut config = Config::recommended();
        let sets = [
            "near=5",
            "far=5.5",
            "recall=projection",
            "disabled-sensors=3+7",
            "action.rate=0.3:0.1:inverse",
        ];
        apply(&mut config, &sets).expect("good settings");
        assert_eq!(
            (config.encoding.near_mm, config.encoding.far_mm),
            (5_000, 5_500)
        );
        assert_eq!(config.planning.recall, Recall::Projection);
        assert!(!config.enabled.contains(3) && !config.enabled.contains(7));
        assert_eq!(config.learning.actions.rate.decay(), Decay::Inverse);
    }

    #[test]
    fn bad_assignments_name_the_trouble() {
        let say = |assignment: &str| {
            let refused = apply(&mut Config::recommended(), &[assignment]);
            refused.expect_err(assignment).to_string()
        };
        assert!(say("far").contains("KEY=VALUE"));
        assert!(say("fra=1").contains("did you mean \"far\""));
        assert!(say("far=NaN").contains("between"));
        assert!(say("recall=telepathy").contains("distance, direction, projection"));
        assert!(say("near=6").contains("setting far (4.5 m)"));
        assert!(say("disabled-sensors=16").contains("between 0 and 15"));
        assert!(say("action.rate=0.1:0.3").contains("above its start"));
    }

    #[test]
    fn former_keys_are_still_accepted() {
        let (mut former, mut now) = (Config::recommended(), Config::recommended());
        apply(&mut former, &["choose=recall", "turned=off", "mask=3"]).expect("former keys");
        let renamed = [
            "planner=recall",
            "augment-rotations=off",
            "disabled-sensors=3",
        ];
        apply(&mut now, &renamed).expect("good settings");
        assert_eq!(former, now);
        assert!(is_key("taught") && !is_key("teach"));
    }

    /// The two presets must not share a struct by accident: the literal one trains directly.
    #[test]
    fn the_presets_differ() {
        let training: MapTraining = Config::touzet().learning.situations;
        assert_eq!(training.neighborhood, Neighborhood::Direct);
        assert_ne!(Config::touzet(), Config::recommended());
    }
}
