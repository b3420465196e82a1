//! What may be wrong with a single transducer.
//!
//! A fault changes what the ring reports of one transducer, after its model; exchanged cables
//! change which transducer fires. A fault that remembers something keeps it in its own entry of
//! [`ActiveFaults`]. Without a fault nothing is drawn from the noise.

use core::fmt;
use core::str::FromStr;
use std::collections::VecDeque;

use super::inches::{M_PER_INCH, MAX_READING_IN};
use crate::noise::Noise;
use files::error::BadInput;

/// What is wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FaultKind {
    /// It is off: it never hears anything.
    Dead,
    /// It always reports this range, m.
    Stuck(f64),
    /// It reports this share of the range: below 1 it reads short.
    Scaled(f64),
    /// It reports so much more, m: below 0 it reads short.
    Offset(f64),
    /// With this probability it reports anything from 6 to 255 in.
    Jumping(f64),
    /// Its ranges scatter by this standard deviation, m.
    Noisy(f64),
    /// It reports what it heard so many firings ago, and nothing before.
    Delayed(usize),
    /// With this probability it hears nothing.
    Intermittent(f64),
    /// With this probability it takes the echo of the transducer that fired before it for its own,
    /// where that one came sooner.
    Crosstalk(f64),
    /// Its cable and that of this transducer are exchanged.
    Swapped(usize),
}

/// Most firings by which a reading is late.
const MAX_DELAY: usize = 1_000;

impl FaultKind {
    /// The names, in the order of the variants.
    pub const NAMES: [&'static str; 10] = [
        "dead",
        "stuck",
        "scaled",
        "offset",
        "jumping",
        "noisy",
        "delayed",
        "intermittent",
        "crosstalk",
        "swapped",
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Dead => "dead",
            Self::Stuck(_) => "stuck",
            Self::Scaled(_) => "scaled",
            Self::Offset(_) => "offset",
            Self::Jumping(_) => "jumping",
            Self::Noisy(_) => "noisy",
            Self::Delayed(_) => "delayed",
            Self::Intermittent(_) => "intermittent",
            Self::Crosstalk(_) => "crosstalk",
            Self::Swapped(_) => "swapped",
        }
    }

    /// The same kind for a ring turned by so many places: exchanged cables stay as far apart.
    #[must_use]
    pub const fn turned(self, places: usize) -> Self {
        match self {
            Self::Swapped(other) => Self::Swapped((other + places) % 16),
            kind => kind,
        }
    }

    /// What a transducer reports that in good order would have reported `range`, when the one
    /// before it heard `earlier`. `memory` is its own, the newest last.
    fn reported(
        self,
        range: Option<f64>,
        earlier: Option<f64>,
        memory: &mut VecDeque<Option<f64>>,
        noise: &mut Noise,
    ) -> Option<f64> {
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
            Self::Noisy(sigma_m) => {
                // One draw per firing, heard or not.
                let error_m = noise.normal() * sigma_m;
                within(range? + error_m)
            }
            Self::Delayed(firings) => {
                memory.push_back(range);
                (memory.len() > firings).then(|| memory.pop_front())??
            }
            Self::Intermittent(probability) if noise.chance(probability) => None,
            Self::Crosstalk(probability) if noise.chance(probability) => match (range, earlier) {
                (Some(own), Some(earlier)) => Some(own.min(earlier)),
                (own, earlier) => own.or(earlier),
            },
            Self::Jumping(_) | Self::Intermittent(_) | Self::Crosstalk(_) | Self::Swapped(_) => {
                range
            }
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
        match self.kind {
            FaultKind::Dead => Ok(()),
            FaultKind::Delayed(value) | FaultKind::Swapped(value) => write!(f, ":{value}"),
            FaultKind::Stuck(value)
            | FaultKind::Scaled(value)
            | FaultKind::Offset(value)
            | FaultKind::Jumping(value)
            | FaultKind::Noisy(value)
            | FaultKind::Intermittent(value)
            | FaultKind::Crosstalk(value) => write!(f, ":{value}"),
        }
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
        let ends_with =
            |what: &str| refuse(&format!("it ends with {what}, as in {name}:{sensor}:VALUE"));
        let number = |what: &str, least: f64, most: f64| {
            let number = value.and_then(|value| value.parse().ok());
            let fits = number.filter(|number| (least..=most).contains(number));
            fits.ok_or_else(|| ends_with(&format!("{what} from {least} to {most}")))
        };
        let count = |what: &str, least: usize, most: usize| {
            let count = value.and_then(|value| value.parse().ok());
            let fits = count.filter(|count| (least..=most).contains(count));
            fits.ok_or_else(|| ends_with(&format!("{what} from {least} to {most}")))
        };
        let probability = || number("a probability", 0.0, 1.0);
        let kind = match name {
            "stuck" => FaultKind::Stuck(number("a range in meters", 0.0, 6.4)?),
            "scaled" => FaultKind::Scaled(number("a share", 0.01, 10.0)?),
            "offset" => FaultKind::Offset(number("a length in meters", -6.5, 6.5)?),
            "jumping" => FaultKind::Jumping(probability()?),
            "noisy" => FaultKind::Noisy(number("a standard deviation in meters", 0.0, 6.5)?),
            "delayed" => FaultKind::Delayed(count("a number of firings", 1, MAX_DELAY)?),
            "intermittent" => FaultKind::Intermittent(probability()?),
            "crosstalk" => FaultKind::Crosstalk(probability()?),
            "swapped" => match count("another transducer", 0, 15)? {
                other if other == sensor => return Err(ends_with("another transducer")),
                other => FaultKind::Swapped(other),
            },
            _ => FaultKind::Dead,
        };
        Ok(Self { sensor, kind })
    }
}

/// All that is wrong with a ring.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct ActiveFaults {
    faults: Vec<(TransducerFault, VecDeque<Option<f64>>)>,
    /// What the transducer that fired last has heard.
    earlier: Option<f64>,
}

impl ActiveFaults {
    pub(super) fn new(faults: &[TransducerFault]) -> Self {
        Self {
            faults: faults
                .iter()
                .map(|fault| (*fault, VecDeque::new()))
                .collect(),
            earlier: None,
        }
    }

    /// Which transducer fires and listens when this one is asked.
    #[inline]
    pub(super) fn asked(&self, sensor: usize) -> usize {
        self.faults
            .iter()
            .fold(sensor, |asked, (fault, _)| match fault.kind {
                FaultKind::Swapped(other) if asked == fault.sensor => other,
                FaultKind::Swapped(other) if asked == other => fault.sensor,
                _ => asked,
            })
    }

    /// What the ring reports of a transducer that in good order would have reported `range`.
    #[inline]
    pub(super) fn reported(
        &mut self,
        sensor: usize,
        range: Option<f64>,
        noise: &mut Noise,
    ) -> Option<f64> {
        let earlier = std::mem::replace(&mut self.earlier, range);
        let mine = self
            .faults
            .iter_mut()
            .filter(|(fault, _)| fault.sensor == sensor);
        mine.fold(range, |range, (fault, memory)| {
            fault.kind.reported(range, earlier, memory, noise)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(text: &str) -> TransducerFault {
        text.parse().expect(text)
    }

    const ONE_OF_EACH: [&str; 10] = [
        "dead:3",
        "stuck:0:0.5",
        "scaled:15:0.5",
        "offset:7:-0.4",
        "jumping:2:1",
        "noisy:4:0.2",
        "delayed:5:3",
        "intermittent:6:0.5",
        "crosstalk:8:0.25",
        "swapped:9:1",
    ];

    #[test]
    fn a_fault_is_read_as_it_is_written() {
        for (text, name) in ONE_OF_EACH.into_iter().zip(FaultKind::NAMES) {
            assert_eq!(fault(text).to_string(), text);
            assert_eq!(fault(text).kind.name(), name);
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
        assert!(say("stuck:3").contains("range in meters"));
        assert!(say("stuck:3:-1").contains("0 to 6.4"));
        assert!(say("scaled:3:NaN").contains("share"));
        for kind in ["jumping", "intermittent", "crosstalk"] {
            assert!(say(&format!("{kind}:3:2")).contains("probability from 0 to 1"));
        }
        assert!(say("noisy:3:-0.1").contains("standard deviation"));
        assert!(
            say("delayed:3:0").contains("from 1 to 1000") && say("delayed:3:0.5").contains("1")
        );
        assert!(say("swapped:3:3").contains("another") && say("swapped:3:16").contains("0 to 15"));
    }

    /// A ring of two readings after another: those of transducer 2, then those of transducer 3.
    fn said(text: &str, heard: &[Option<f64>]) -> Vec<Option<f64>> {
        let (mut noise, mut faults) = (Noise::new(1), ActiveFaults::new(&[fault(text)]));
        let each = heard.iter().map(|range| {
            let earlier = faults.reported(2, Some(1.0), &mut noise);
            assert_eq!(earlier, Some(1.0), "{text}: another one is in good order");
            faults.reported(3, *range, &mut noise)
        });
        each.collect()
    }

    #[test]
    fn each_kind_changes_its_own_transducer_and_no_other() {
        let one = |text, range| said(text, &[range])[0];
        assert_eq!(one("dead:3", Some(2.0)), None);
        assert_eq!(one("stuck:3:0.5", None), Some(0.5));
        assert_eq!(one("scaled:3:0.5", Some(2.0)), Some(1.0));
        assert_eq!(one("scaled:3:0.5", None), None);
        assert_eq!(one("scaled:3:10", Some(2.0)), None);
        assert_eq!(one("offset:3:-5", Some(2.0)), Some(6.0 * M_PER_INCH));
        assert_eq!(one("noisy:3:0", Some(2.0)), Some(2.0));
        assert_eq!(one("intermittent:3:1", Some(2.0)), None);
        assert_eq!(one("intermittent:3:0", Some(2.0)), Some(2.0));
        assert_eq!(one("crosstalk:3:1", Some(2.0)), Some(1.0));
        assert_eq!(one("crosstalk:3:1", Some(0.5)), Some(0.5));
        assert_eq!(one("crosstalk:3:1", None), Some(1.0));
        assert_eq!(one("crosstalk:3:0", None), None);
        let jumps = said("jumping:3:1", &[None, None]);
        assert!(jumps[0] != jumps[1] && jumps.iter().all(|range| range.is_some_and(|r| r < 6.48)));
    }

    #[test]
    fn a_late_transducer_reports_what_it_heard_then() {
        let heard = [Some(1.0), None, Some(3.0), Some(4.0)];
        let late = said("delayed:3:2", &heard);
        assert_eq!(late, [None, None, Some(1.0), None]);
    }

    /// Mean and scatter of 10 000 readings, and a share of silences, within five standard errors.
    #[test]
    fn noise_has_its_deviation_and_silence_its_share() {
        let heard = [Some(3.0); 10_000];
        let readings = said("noisy:3:0.2", &heard);
        let errors: Vec<_> = readings.iter().flatten().map(|r| r - 3.0).collect();
        let count = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / count;
        let variance = errors.iter().map(|e| e * e).sum::<f64>() / count;
        assert!(mean.abs() < 0.01 && (variance.sqrt() - 0.2).abs() < 0.007);
        let readings = said("intermittent:3:0.25", &heard);
        let silent = readings.iter().filter(|range| range.is_none()).count();
        assert!((2_284..2_717).contains(&silent), "{silent}");
    }

    #[test]
    fn exchanged_cables_exchange_both() {
        let faults = ActiveFaults::new(&[fault("swapped:3:7")]);
        let asked = [2, 3, 4, 7].map(|sensor| faults.asked(sensor));
        assert_eq!(asked, [2, 7, 4, 3]);
        assert_eq!(FaultKind::Swapped(8).turned(10), FaultKind::Swapped(2));
        assert_eq!(FaultKind::Dead.turned(10), FaultKind::Dead);
    }
}
