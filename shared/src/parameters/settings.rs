//! The table of settings: every open choice by key, with its meaning, its values, and where it lies
//! in the configuration.
//!
//! It knows numbers, not text: a host reads and prints them. A program that does not use the table
//! does not contain it.

use super::Parameter;
use crate::config::{Config, Wander};
use crate::som::Schedule;

mod rows;
mod table;

/// Former keys, which are accepted but not listed, and what they are called now.
const FORMER_KEYS: [(&str, &str); 10] = [
    ("mask", "disabled-sensors"),
    ("start", "initialization"),
    ("turned", "augment-rotations"),
    ("taught", "learn-from"),
    ("choose", "planner"),
    ("intermediate", "subgoal"),
    ("from", "change-from"),
    ("wanted", "probe-components"),
    ("answer", "probe-neurons"),
    ("shield.least-range", "shield.min-range"),
];

/// One open choice of the method.
#[derive(Debug)]
pub struct Setting<const SENSORS: usize> {
    /// Its name.
    pub key: &'static str,
    /// What it means and what it takes.
    pub help: &'static str,
    /// What its values are.
    pub kind: SettingKind,
    access: Access<SENSORS>,
}

/// How a setting is read and written.
#[derive(Debug)]
enum Access<const SENSORS: usize> {
    /// As the parameter that a host may also set over the link.
    Parameter(Parameter),
    /// By functions of its own.
    Functions {
        get: fn(&Config<SENSORS>) -> Value,
        put: fn(&mut Config<SENSORS>, Value),
    },
}

/// What the values of a setting are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SettingKind {
    /// A number within a range, both ends included.
    Number {
        /// What 1 stands for.
        format: NumberFormat,
        /// Least value.
        least: i32,
        /// Greatest value.
        greatest: i32,
    },
    /// 0 or 1.
    Switch,
    /// One of these words, by its index.
    Words(&'static [&'static str]),
    /// A bit for each transducer that is enabled.
    Sensors,
    /// A schedule whose values lie between 0 and this, Q16.
    Schedule {
        /// Greatest value, Q16.
        greatest_q16: u32,
    },
    /// What to do when no action leads nearer to a place.
    Wander,
}

/// What 1 stands for in a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NumberFormat {
    /// 1.
    Count,
    /// A millimeter.
    Millimeters,
    /// A millisecond.
    Milliseconds,
    /// 1/256.
    Q8,
    /// 1/65 536.
    Q16,
    /// 1/65 536 of a turn.
    Turns,
    /// A bit of a [`Weight`](crate::fixed::Weight).
    WeightBits,
}

/// The value of a setting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Value {
    /// Of every kind but the following two.
    Number(i32),
    /// Of [`SettingKind::Schedule`].
    Schedule(Schedule),
    /// Of [`SettingKind::Wander`].
    Wander(Option<Wander>),
}

/// The value is not among those that the setting takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotTaken;

impl core::fmt::Display for NotTaken {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("it is not among the values that the setting takes")
    }
}

impl core::error::Error for NotTaken {}

impl SettingKind {
    /// Whether a setting of this kind takes the value.
    #[must_use]
    pub fn takes(self, value: Value) -> bool {
        match (self, value) {
            (
                Self::Number {
                    least, greatest, ..
                },
                Value::Number(number),
            ) => (least..=greatest).contains(&number),
            (Self::Switch, Value::Number(number)) => (0..=1).contains(&number),
            (Self::Words(words), Value::Number(index)) => {
                usize::try_from(index).is_ok_and(|index| index < words.len())
            }
            (Self::Schedule { greatest_q16 }, Value::Schedule(schedule)) => {
                schedule.start_q16().max(schedule.end_q16()) <= greatest_q16
            }
            (Self::Sensors, Value::Number(_)) | (Self::Wander, Value::Wander(_)) => true,
            _ => false,
        }
    }
}

impl<const SENSORS: usize> Setting<SENSORS> {
    /// The setting with this key or former key.
    #[must_use]
    pub fn find(key: &str) -> Option<&'static Self> {
        let former = FORMER_KEYS.iter().find(|(old, _)| *old == key);
        let key = former.map_or(key, |(_, new)| *new);
        Self::ALL.iter().find(|setting| setting.key == key)
    }

    /// Its value.
    #[must_use]
    pub fn get(&self, config: &Config<SENSORS>) -> Value {
        match &self.access {
            Access::Parameter(parameter) => Value::Number(parameter.get(config)),
            Access::Functions { get, .. } => get(config),
        }
    }

    /// Sets it. What belongs to a part that is switched off (shield, online learning) changes
    /// nothing.
    ///
    /// # Errors
    /// [`NotTaken`]; nothing has changed then.
    pub fn set(&self, config: &mut Config<SENSORS>, value: Value) -> Result<(), NotTaken> {
        if !self.kind.takes(value) {
            return Err(NotTaken);
        }
        match &self.access {
            Access::Parameter(parameter) => parameter.put(config, value.number()),
            Access::Functions { put, .. } => put(config, value),
        }
        Ok(())
    }
}

impl Value {
    /// A number that fits 32 bits with its sign.
    fn of(number: impl Into<i64>) -> Self {
        Self::Number(i32::try_from(number.into()).unwrap_or(i32::MAX))
    }

    /// The number; 0 for another kind.
    const fn number(self) -> i32 {
        match self {
            Self::Number(number) => number,
            Self::Schedule(_) | Self::Wander(_) => 0,
        }
    }

    /// The number as one of 32 bits without a sign: the rows' ranges keep it within.
    const fn long(self) -> u32 {
        self.number().cast_unsigned()
    }

    /// The number as one of 16 bits: the rows' ranges keep it within.
    const fn short(self) -> u16 {
        self.number() as u16
    }

    /// The number as one of 8 bits: the rows' ranges keep it within.
    const fn byte(self) -> u8 {
        self.number() as u8
    }

    const fn is_on(self) -> bool {
        self.number() != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::som::Decay;
    use std::collections::BTreeSet;

    type Row = Setting<16>;

    #[test]
    fn keys_and_former_keys_name_one_setting_each() {
        let former = FORMER_KEYS.map(|(old, _)| old);
        let keys = Row::ALL.iter().map(|row| row.key);
        let names: BTreeSet<_> = keys.clone().chain(former).collect();
        assert_eq!(names.len(), Row::ALL.len() + former.len());
        for (name, key) in keys.map(|key| (key, key)).chain(FORMER_KEYS) {
            assert_eq!(Row::find(name).map(|row| row.key), Some(key), "{name}");
        }
        assert!(Row::find("").is_none());
    }

    fn ends(kind: SettingKind) -> [Value; 2] {
        let schedule = |start| Value::Schedule(Schedule::from_q16(start, 0, Decay::Inverse));
        let wander = |count| Wander {
            patience: count,
            moves: count,
        };
        match kind {
            SettingKind::Number {
                least, greatest, ..
            } => [least, greatest].map(Value::Number),
            SettingKind::Switch => [0, 1].map(Value::Number),
            SettingKind::Words(words) => [0, words.len() as i32 - 1].map(Value::Number),
            SettingKind::Sensors => [0, -1].map(Value::Number),
            SettingKind::Schedule { greatest_q16 } => [schedule(0), schedule(greatest_q16)],
            SettingKind::Wander => [Value::Wander(None), Value::Wander(Some(wander(255)))],
        }
    }

    #[test]
    fn every_setting_takes_its_ends_and_changes_nothing_else() {
        for row in Row::ALL {
            for value in ends(row.kind) {
                let mut config = Config::recommended();
                assert_eq!(row.set(&mut config, value), Ok(()), "{}", row.key);
                assert_eq!(row.get(&config), value, "{}", row.key);
                let others = Row::ALL.iter().filter(|other| other.key != row.key);
                for other in others {
                    let unchanged = other.get(&Config::recommended());
                    assert_eq!(other.get(&config), unchanged, "{} {}", row.key, other.key);
                }
            }
        }
    }

    #[test]
    fn a_value_beyond_the_range_or_of_another_kind_is_not_taken() {
        let beyond = |kind: SettingKind| match kind {
            SettingKind::Number { greatest, .. } => Value::Number(greatest.saturating_add(1)),
            SettingKind::Switch => Value::Number(2),
            SettingKind::Words(words) => Value::Number(words.len() as i32),
            SettingKind::Sensors => Value::Wander(None),
            SettingKind::Schedule { greatest_q16 } => {
                Value::Schedule(Schedule::constant(greatest_q16 + 1))
            }
            SettingKind::Wander => Value::Number(0),
        };
        for row in Row::ALL {
            let mut config = Config::recommended();
            let refused = row.set(&mut config, beyond(row.kind));
            assert_eq!(refused, Err(NotTaken), "{}", row.key);
            assert_eq!(config, Config::recommended(), "{}", row.key);
        }
    }

    #[test]
    fn what_belongs_to_a_part_that_is_off_changes_nothing() {
        let mut config = Config::recommended();
        (config.shield, config.online) = (None, None);
        let off = config.clone();
        let parts = ["shield.", "online."];
        for row in
            (Row::ALL.iter()).filter(|row| parts.iter().any(|part| row.key.starts_with(part)))
        {
            let [_, greatest] = ends(row.kind);
            assert_eq!(row.set(&mut config, greatest), Ok(()), "{}", row.key);
            assert_eq!(
                (row.get(&config), &config),
                (Value::Number(0), &off),
                "{}",
                row.key
            );
        }
    }
}
