//! What may be wrong with a single transducer.
//!
//! A fault changes what the ring reports of one transducer, after everything its model does to the reading. A fault that
//! remembers something keeps it in its own entry of [`Faults`]; one that concerns which transducer is asked, and not what
//! is said, would be asked before the ping.

use core::fmt;
use core::str::FromStr;

use super::{M_PER_INCH, MAX_READING_IN};
use crate::error::BadInput;
use crate::noise::Noise;

/// What is wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FaultKind {
    /// It never hears anything.
    Dead,
    /// It always reports this range, m.
    Stuck(f64),
    /// It reports this share of the range: below 1 it reads short.
    Scaled(f64),
    /// It reports so much more, m: below 0 it reads short. Never less than 6 in.
    Offset(f64),
    /// With this probability it reports anything from 6 to 255 in.
    Jumping(f64),
}

impl FaultKind {
    /// The names, in the order of the variants.
    pub const NAMES: [&'static str; 5] = ["dead", "stuck", "scaled", "offset", "jumping"];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Dead => "dead",
            Self::Stuck(_) => "stuck",
            Self::Scaled(_) => "scaled",
            Self::Offset(_) => "offset",
            Self::Jumping(_) => "jumping",
        }
    }

    /// The number that goes with it.
    const fn value(self) -> Option<f64> {
        match self {
            Self::Dead => None,
            Self::Stuck(value)
            | Self::Scaled(value)
            | Self::Offset(value)
            | Self::Jumping(value) => Some(value),
        }
    }
}

/// A transducer and what is wrong with it. As text `KIND:SENSOR` or `KIND:SENSOR:VALUE`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransducerFault {
    /// The transducer.
    pub sensor: usize,
    /// What is wrong with it.
    pub kind: FaultKind,
}

impl fmt::Display for TransducerFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.kind.name(), self.sensor)?;
        self.kind
            .value()
            .map_or(Ok(()), |value| write!(f, ":{value}"))
    }
}

impl FromStr for TransducerFault {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        let mut parts = text.split(':');
        let name = parts.next().unwrap_or_default();
        if !FaultKind::NAMES.contains(&name) {
            return Err(BadInput::unknown("fault", name, &FaultKind::NAMES));
        }
        let refuse = |why: &str| BadInput::new(format!("fault \"{text}\": {why}"));
        let sensor = parts.next().and_then(|sensor| sensor.parse().ok());
        let sensor = sensor.filter(|sensor| *sensor < 16).ok_or_else(|| {
            refuse("after the kind comes a transducer from 0 to 15, as in dead:3")
        })?;
        let value = parts.next();
        if parts.next().is_some() || (name == "dead" && value.is_some()) {
            return Err(refuse("there is something left over at its end"));
        }
        let number = |what: &str, least: f64, most: f64| {
            let number = value.and_then(|value| value.parse().ok());
            let fits = number.filter(|number| (least..=most).contains(number));
            fits.ok_or_else(|| {
                refuse(&format!(
                    "it ends with {what} from {least} to {most}, as in {name}:{sensor}:VALUE"
                ))
            })
        };
        let kind = match name {
            "stuck" => FaultKind::Stuck(number("a range in metres", 0.0, 6.4)?),
            "scaled" => FaultKind::Scaled(number("a share", 0.01, 10.0)?),
            "offset" => FaultKind::Offset(number("a length in metres", -6.5, 6.5)?),
            "jumping" => FaultKind::Jumping(number("a probability", 0.0, 1.0)?),
            _ => FaultKind::Dead,
        };
        Ok(Self { sensor, kind })
    }
}

/// All that is wrong with a ring.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Faults(Vec<TransducerFault>);

impl Faults {
    pub(super) fn new(faults: &[TransducerFault]) -> Self {
        Self(faults.to_vec())
    }

    /// What the ring reports of a transducer that in good order would have reported `range`.
    pub(super) fn reported(
        &self,
        sensor: usize,
        range: Option<f64>,
        noise: &mut Noise,
    ) -> Option<f64> {
        let mine = self.0.iter().filter(|fault| fault.sensor == sensor);
        mine.fold(range, |range, fault| fault.kind.reported(range, noise))
    }
}

impl FaultKind {
    fn reported(self, range: Option<f64>, noise: &mut Noise) -> Option<f64> {
        let (least, most) = (6.0 * M_PER_INCH, f64::from(MAX_READING_IN) * M_PER_INCH);
        let within = |range: f64| (range < most).then_some(range.max(least));
        match self {
            Self::Dead => None,
            Self::Stuck(range) => Some(range),
            Self::Scaled(share) => within(range? * share),
            Self::Offset(length) => within(range? + length),
            Self::Jumping(probability) if noise.chance(probability) => {
                Some(noise.uniform_in(least, most))
            }
            Self::Jumping(_) => range,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(text: &str) -> TransducerFault {
        text.parse().expect(text)
    }

    #[test]
    fn a_fault_is_read_as_it_is_written() {
        for text in [
            "dead:3",
            "stuck:0:0.5",
            "scaled:15:0.5",
            "offset:7:-0.4",
            "jumping:2:1",
        ] {
            assert_eq!(fault(text).to_string(), text);
        }
    }

    #[test]
    fn what_is_no_fault_is_refused_by_what_is_wrong_with_it() {
        let say = |text: &str| {
            let refused = text.parse::<TransducerFault>();
            refused.expect_err(text).to_string()
        };
        assert!(say("daed:3").contains("did you mean \"dead\""));
        assert!(say("dead").contains("0 to 15") && say("dead:16").contains("0 to 15"));
        assert!(say("dead:3:1").contains("left over") && say("stuck:3:1:1").contains("left over"));
        assert!(
            say("stuck:3").contains("range in metres") && say("stuck:3:-1").contains("0 to 6.4")
        );
        assert!(
            say("scaled:3:NaN").contains("share") && say("jumping:3:2").contains("probability")
        );
    }

    #[test]
    fn each_kind_changes_its_own_transducer_and_no_other() {
        let mut noise = Noise::new(1);
        let mut said = |text: &str, sensor, range| {
            Faults::new(&[fault(text)]).reported(sensor, range, &mut noise)
        };
        for text in [
            "dead:3",
            "stuck:3:0.5",
            "scaled:3:0.5",
            "offset:3:-0.4",
            "jumping:3:1",
        ] {
            assert_eq!(said(text, 4, Some(2.0)), Some(2.0), "{text}");
        }
        assert_eq!(said("dead:3", 3, Some(2.0)), None);
        assert_eq!(said("stuck:3:0.5", 3, None), Some(0.5));
        assert_eq!(said("scaled:3:0.5", 3, Some(2.0)), Some(1.0));
        assert_eq!(said("scaled:3:0.5", 3, None), None);
        assert_eq!(said("scaled:3:10", 3, Some(2.0)), None);
        assert_eq!(said("offset:3:-5", 3, Some(2.0)), Some(6.0 * M_PER_INCH));
        let jumps = [said("jumping:3:1", 3, None), said("jumping:3:1", 3, None)];
        assert!(jumps[0] != jumps[1] && jumps.iter().all(|range| range.is_some_and(|r| r < 6.48)));
    }
}
