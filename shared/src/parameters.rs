//! Configuration values by name, each with unit and range: those that a host sets over the link,
//! and the table of all.

mod settings;

pub use settings::{NotTaken, NumberFormat, Setting, SettingKind, Value};

use crate::config::Config;
use crate::fixed::Mask;
use crate::shield::ShieldConfig;
use serde::{Deserialize, Serialize};

/// A value that may be changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Parameter {
    /// At this range and nearer a situation's value is 1.
    Near,
    /// From this range on a situation's value is 0.
    Far,
    /// What "free of obstacles" means.
    Clearance,
    /// Longest single displacement.
    Step,
    /// Highest speed.
    Speed,
    /// Whether echoes limit motion: 0 or 1.
    Shield,
    /// Distance to keep from anything heard (with the shield on).
    Margin,
    /// Whether the maps go on learning: 0 or 1. Switched on, the rates are those of the default
    /// preset.
    Online,
    /// Presentations of the whole memory.
    Epochs,
    /// Bit mask of the enabled transducers.
    Enabled,
    /// Time the ring takes.
    RingPeriod,
    /// Whether transducers that misbehave are disabled: 0 or 1.
    FaultDetection,
}

/// Unit of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Unit {
    /// A number.
    Count,
    /// Millimeters.
    Millimeters,
    /// Millimeters per second.
    MillimetersPerSecond,
    /// Milliseconds.
    Milliseconds,
    /// 0 or 1.
    Switch,
    /// A bit for each transducer.
    Bits,
}

impl core::fmt::Display for Unit {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Count => "",
            Self::Millimeters => "mm",
            Self::MillimetersPerSecond => "mm/s",
            Self::Milliseconds => "ms",
            Self::Switch => "0 or 1",
            Self::Bits => "bits",
        })
    }
}

/// What a parameter may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ParameterSpec {
    /// Its unit.
    pub unit: Unit,
    /// Smallest value.
    pub min: i32,
    /// Largest value.
    pub max: i32,
}

/// Why a parameter was not set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ParameterError {
    /// The value lies outside this range.
    OutOfRange(ParameterSpec),
    /// The near limit would not lie below the far limit.
    Crossed,
    /// There is no shield to set a margin of.
    NoShield,
}

impl core::fmt::Display for ParameterError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::OutOfRange(ParameterSpec {
                unit: Unit::Switch, ..
            }) => f.write_str("it must be 0 or 1"),
            Self::OutOfRange(ParameterSpec {
                unit: Unit::Count,
                min,
                max,
            }) => write!(f, "it must lie between {min} and {max}"),
            Self::OutOfRange(ParameterSpec { unit, min, max }) => {
                write!(f, "it must lie between {min} and {max} {unit}")
            }
            Self::Crossed => f.write_str("near must lie below far"),
            Self::NoShield => f.write_str("the shield is off"),
        }
    }
}

impl core::error::Error for ParameterError {}

impl Parameter {
    /// All of them, in the order of their numbers on the wire.
    pub const ALL: [Self; 12] = [
        Self::Near,
        Self::Far,
        Self::Clearance,
        Self::Step,
        Self::Speed,
        Self::Shield,
        Self::Margin,
        Self::Online,
        Self::Epochs,
        Self::Enabled,
        Self::RingPeriod,
        Self::FaultDetection,
    ];

    /// Its name in lower case.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Near => "near",
            Self::Far => "far",
            Self::Clearance => "clearance",
            Self::Step => "step",
            Self::Speed => "speed",
            Self::Shield => "shield",
            Self::Margin => "margin",
            Self::Online => "online",
            Self::Epochs => "epochs",
            Self::Enabled => "enabled",
            Self::RingPeriod => "ring-period",
            Self::FaultDetection => "fault-detection",
        }
    }

    /// What it may be.
    #[must_use]
    pub const fn spec(self) -> ParameterSpec {
        let (unit, min, max) = match self {
            Self::Near => (Unit::Millimeters, 0, 6_500),
            Self::Far | Self::Clearance => (Unit::Millimeters, 1, 6_500),
            Self::Step => (Unit::Millimeters, 10, 1_000),
            Self::Speed => (Unit::MillimetersPerSecond, 10, 508),
            Self::Margin => (Unit::Millimeters, 0, 1_000),
            Self::Shield | Self::Online | Self::FaultDetection => (Unit::Switch, 0, 1),
            Self::Epochs => (Unit::Count, 1, 1_000),
            Self::Enabled => (Unit::Bits, i32::MIN, i32::MAX),
            Self::RingPeriod => (Unit::Milliseconds, 1, 10_000),
        };
        ParameterSpec { unit, min, max }
    }

    /// Its value.
    #[must_use]
    pub fn get<const SENSORS: usize>(self, config: &Config<SENSORS>) -> i32 {
        match self {
            Self::Near => i32::from(config.encoding.near_mm),
            Self::Far => i32::from(config.encoding.far_mm),
            Self::Clearance => i32::from(config.clearance_mm),
            Self::Step => i32::from(config.robot.step_mm),
            Self::Speed => i32::from(config.robot.speed_mm_s),
            Self::Shield => i32::from(config.shield.is_some()),
            Self::Margin => config
                .shield
                .map_or(0, |shield| i32::from(shield.margin_mm)),
            Self::Online => i32::from(config.online.is_some()),
            Self::Epochs => i32::from(config.learning.epochs),
            Self::Enabled => config.enabled.to_bits() as i32,
            Self::RingPeriod => i32::from(config.robot.ring_period_ms),
            Self::FaultDetection => i32::from(config.fault_detection),
        }
    }

    /// Sets it.
    ///
    /// # Errors
    /// [`ParameterError`]; nothing has changed then.
    pub fn set<const SENSORS: usize>(
        self,
        config: &mut Config<SENSORS>,
        value: i32,
    ) -> Result<(), ParameterError> {
        let spec = self.spec();
        if value < spec.min || value > spec.max {
            return Err(ParameterError::OutOfRange(spec));
        }
        match self {
            Self::Near if value >= i32::from(config.encoding.far_mm) => {
                return Err(ParameterError::Crossed);
            }
            Self::Far if value <= i32::from(config.encoding.near_mm) => {
                return Err(ParameterError::Crossed);
            }
            Self::Margin if config.shield.is_none() => return Err(ParameterError::NoShield),
            _ => self.put(config, value),
        }
        Ok(())
    }

    /// Sets it to a value within its range, whatever the others are. A margin without a shield
    /// changes nothing.
    fn put<const SENSORS: usize>(self, config: &mut Config<SENSORS>, value: i32) {
        // All ranges but that of the mask fit 16 bits.
        let small = value as u16;
        match self {
            Self::Near => config.encoding.near_mm = small,
            Self::Far => config.encoding.far_mm = small,
            Self::Clearance => config.clearance_mm = small,
            Self::Step => config.robot.step_mm = small,
            Self::Speed => config.robot.speed_mm_s = small,
            Self::Shield => {
                let on = config.shield.unwrap_or_else(ShieldConfig::nomad200);
                config.shield = (value == 1).then_some(on);
            }
            Self::Margin => {
                if let Some(shield) = &mut config.shield {
                    shield.margin_mm = small;
                }
            }
            Self::Online => {
                let on = config.online.or(Config::recommended().online);
                config.online = if value == 1 { on } else { None };
            }
            Self::Epochs => config.learning.epochs = small,
            Self::Enabled => config.enabled = Mask::from_bits(value as u32),
            Self::RingPeriod => config.robot.ring_period_ms = small,
            Self::FaultDetection => config.fault_detection = value == 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::format;
    use std::string::ToString as _;

    #[test]
    fn every_parameter_takes_its_ends_and_nothing_beyond() {
        for parameter in Parameter::ALL {
            let spec = parameter.spec();
            for value in [spec.min, spec.max] {
                let mut config = Config::recommended();
                config.encoding.near_mm = 0;
                config.encoding.far_mm = 6_501;
                assert_eq!(parameter.set(&mut config, value), Ok(()), "{parameter:?}");
                assert_eq!(parameter.get(&config), value, "{parameter:?}");
            }
            let mut config = Config::recommended();
            let beyond = [spec.min.checked_sub(1), spec.max.checked_add(1)];
            for value in beyond.into_iter().flatten() {
                let refused = Err(ParameterError::OutOfRange(spec));
                assert_eq!(parameter.set(&mut config, value), refused, "{parameter:?}");
            }
            assert_eq!(config, Config::recommended(), "{parameter:?}");
        }
    }

    #[test]
    fn near_stays_below_far_and_a_margin_needs_a_shield() {
        let mut config = Config::recommended();
        let far = i32::from(config.encoding.far_mm);
        assert_eq!(
            Parameter::Near.set(&mut config, far),
            Err(ParameterError::Crossed)
        );
        assert_eq!(Parameter::Shield.set(&mut config, 0), Ok(()));
        assert_eq!(
            Parameter::Margin.set(&mut config, 50),
            Err(ParameterError::NoShield)
        );
    }

    #[test]
    fn refusals_name_the_bounds_with_their_unit() {
        let said = |parameter: Parameter, value| {
            let refused = parameter.set(&mut Config::recommended(), value);
            refused.map_err(|error| error.to_string())
        };
        let between = |text: &str| Err(format!("it must lie between {text}"));
        assert_eq!(said(Parameter::Step, 9), between("10 and 1000 mm"));
        assert_eq!(said(Parameter::Speed, 509), between("10 and 508 mm/s"));
        assert_eq!(said(Parameter::Online, 2), Err("it must be 0 or 1".into()));
        assert_eq!(said(Parameter::Epochs, 0), between("1 and 1000"));
        assert_eq!(said(Parameter::RingPeriod, 0), between("1 and 10000 ms"));
        assert_eq!(Unit::Bits.to_string(), "bits");
        assert_eq!(
            ParameterError::Crossed.to_string(),
            "near must lie below far"
        );
        assert_eq!(ParameterError::NoShield.to_string(), "the shield is off");
    }

    #[test]
    fn every_parameter_has_a_name_of_its_own() {
        let names: BTreeSet<_> = Parameter::ALL.map(Parameter::name).into();
        assert_eq!(names.len(), Parameter::ALL.len());
        assert!(names.contains("ring-period"));
    }

    #[test]
    fn a_limit_may_come_as_near_as_a_millimeter() {
        let mut config = Config::recommended();
        (config.encoding.near_mm, config.encoding.far_mm) = (100, 200);
        let mut set = |parameter: Parameter, value| parameter.set(&mut config, value);
        assert_eq!(
            (set(Parameter::Near, 200), set(Parameter::Near, 199)),
            (Err(ParameterError::Crossed), Ok(()))
        );
        assert_eq!(
            (set(Parameter::Far, 199), set(Parameter::Far, 200)),
            (Err(ParameterError::Crossed), Ok(()))
        );
        assert_eq!(
            (config.encoding.near_mm, config.encoding.far_mm),
            (199, 200)
        );
    }

    #[test]
    fn what_is_switched_on_again_is_as_it_was_or_as_by_default() {
        let mut config = Config::touzet();
        let (shield, online) = (config.shield, config.online);
        assert_ne!(online, Config::recommended().online);
        for switch in [Parameter::Shield, Parameter::Online] {
            assert_eq!(switch.set(&mut config, 1), Ok(()));
        }
        assert_eq!(
            (config.shield, config.online),
            (shield, online),
            "they were on"
        );
        for switch in [Parameter::Shield, Parameter::Online] {
            assert_eq!(switch.set(&mut config, 0), Ok(()));
            assert_eq!(
                (switch.get(&config), switch.set(&mut config, 1)),
                (0, Ok(()))
            );
        }
        assert_eq!(
            (config.shield, config.online),
            (Some(ShieldConfig::nomad200()), Config::recommended().online)
        );
        assert_eq!(Parameter::Margin.set(&mut config, 55), Ok(()));
        assert_eq!(Parameter::Margin.get(&config), 55);
        config.shield = None;
        assert_eq!(Parameter::Margin.get(&config), 0);
    }
}
