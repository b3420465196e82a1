//! What the rows of the table of settings are made of.

use super::{Access, NumberFormat, Setting, SettingKind, Value};
use crate::config::{Config, Online};
use crate::parameters::{Parameter, Unit};
use crate::shield::ShieldConfig;

/// A number from `least` to `greatest`.
pub(super) const fn number(format: NumberFormat, least: i32, greatest: i32) -> SettingKind {
    SettingKind::Number {
        format,
        least,
        greatest,
    }
}

/// Any number of 8 bits above zero.
pub(super) const BYTE: SettingKind = number(NumberFormat::Count, 1, 255);
/// A factor in 1/256, up to 255.
pub(super) const FACTOR: SettingKind = number(NumberFormat::Q8, 0, 255 << 8);
/// A share of 1.
pub(super) const SHARE: SettingKind = number(NumberFormat::Q16, 0, 1 << 16);
/// A length up to 2 m.
pub(super) const LENGTH: SettingKind = number(NumberFormat::Millimeters, 0, 2_000);
/// A time from 0.1 s to a day.
pub(super) const TIME: SettingKind = number(NumberFormat::Milliseconds, 100, 86_400_000);
/// A learning rate.
pub(super) const RATE: SettingKind = SettingKind::Schedule {
    greatest_q16: 1 << 16,
};
/// A radius of a neighborhood.
pub(super) const RADIUS: SettingKind = SettingKind::Schedule {
    greatest_q16: 64 << 16,
};

/// A setting that takes words, each with the value that it stands for.
macro_rules! words {
    ($key:literal, $help:literal, $($field:ident).+, [$(($word:literal, $value:expr)),+]) => {
        Setting::new(
            $key,
            $help,
            SettingKind::Words(&[$($word),+]),
            |config| index_of(&[$($value),+], &config.$($field).+),
            |config, word| {
                if let Some(value) = [$($value),+].get(usize::from(word.byte())) {
                    config.$($field).+ = *value;
                }
            },
        )
    };
}

/// A setting that takes a schedule.
macro_rules! schedule {
    ($key:literal, $help:literal, $kind:expr, $($field:ident).+) => {
        Setting::new(
            $key,
            $help,
            $kind,
            |config| Value::Schedule(config.$($field).+),
            |config, value| {
                if let Value::Schedule(schedule) = value {
                    config.$($field).+ = schedule;
                }
            },
        )
    };
}

pub(super) use {schedule, words};

/// The index of the word that stands for a value.
pub(super) fn index_of<T: PartialEq>(values: &[T], value: &T) -> Value {
    let index = values.iter().position(|other| other == value).unwrap_or(0);
    Value::of(index as u32)
}

/// A value of online learning; 0 if it is off.
pub(super) fn of_online<const SENSORS: usize>(
    config: &Config<SENSORS>,
    get: fn(&Online) -> u32,
) -> Value {
    Value::of(config.online.as_ref().map_or(0, get))
}

/// A value of the shield; 0 if it is off.
pub(super) fn of_shield<const SENSORS: usize>(
    config: &Config<SENSORS>,
    get: fn(&ShieldConfig) -> u32,
) -> Value {
    Value::of(config.shield.as_ref().map_or(0, get))
}

/// Changes online learning, if it is on.
pub(super) fn put_online<const SENSORS: usize>(
    config: &mut Config<SENSORS>,
    put: impl FnOnce(&mut Online),
) {
    if let Some(online) = &mut config.online {
        put(online);
    }
}

/// Changes the shield, if it is on.
pub(super) fn put_shield<const SENSORS: usize>(
    config: &mut Config<SENSORS>,
    put: impl FnOnce(&mut ShieldConfig),
) {
    if let Some(shield) = &mut config.shield {
        put(shield);
    }
}

impl<const SENSORS: usize> Setting<SENSORS> {
    /// A row of the table.
    pub(super) const fn new(
        key: &'static str,
        help: &'static str,
        kind: SettingKind,
        get: fn(&Config<SENSORS>) -> Value,
        put: fn(&mut Config<SENSORS>, Value),
    ) -> Self {
        Self {
            key,
            help,
            kind,
            access: Access::Functions { get, put },
        }
    }

    /// A row that a host may also set over the link, with the parameter's unit and range.
    pub(super) const fn of(parameter: Parameter, key: &'static str, help: &'static str) -> Self {
        let spec = parameter.spec();
        let format = match spec.unit {
            Unit::Millimeters => NumberFormat::Millimeters,
            Unit::Milliseconds => NumberFormat::Milliseconds,
            _ => NumberFormat::Count,
        };
        let kind = match spec.unit {
            Unit::Switch => SettingKind::Switch,
            Unit::Bits => SettingKind::Sensors,
            _ => SettingKind::Number {
                format,
                least: spec.min,
                greatest: spec.max,
            },
        };
        Self {
            key,
            help,
            kind,
            access: Access::Parameter(parameter),
        }
    }

    /// The same row with another range: a simulated robot may leave that of the link.
    pub(super) const fn between(self, least: i32, greatest: i32) -> Self {
        let kind = match self.kind {
            SettingKind::Number { format, .. } => SettingKind::Number {
                format,
                least,
                greatest,
            },
            other => other,
        };
        Self { kind, ..self }
    }
}
