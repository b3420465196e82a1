//! Faults of single transducers.
//!
//! A fault changes the reading of one transducer, after the sonar model, from some time on. Swapped
//! cables change which transducer fires, a turned one looks elsewhere. The state of a fault is in
//! its entry of [`ActiveFaults`]. Without faults no random number is drawn.

use core::fmt;
use core::str::FromStr;
use std::collections::VecDeque;

use super::inches::{M_PER_INCH, MAX_READING_IN};
use crate::noise::Noise;
use files::error::BadInput;

/// Kind of fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FaultKind {
    /// Never reports an echo.
    Dead,
    /// Always reports this range, m.
    Stuck(f64),
    /// Multiplies the range by this factor.
    Scaled(f64),
    /// Adds this offset to the range, m.
    Offset(f64),
    /// With this probability, reports a random range from 6 to 255 in.
    Jumping(f64),
    /// Adds normal noise with this standard deviation to the range, m.
    Noisy(f64),
    /// Reports the reading of this number of firings ago; before that, no echo.
    Delayed(usize),
    /// With this probability, reports no echo.
    Intermittent(f64),
    /// With this probability, reports the range of the transducer that fired before it, if that is
    /// shorter.
    Crosstalk(f64),
    /// Its cable and that of this transducer are swapped.
    Swapped(usize),
    /// It sits so many degrees farther to the left on the body.
    Turned(f64),
}

/// Maximum number of firings by which a reading is delayed.
const MAX_DELAY: usize = 1_000;
/// Latest begin of a fault, s.
const MAX_SINCE_S: f64 = 1e6;

impl FaultKind {
    /// The names, in the order of the variants.
    pub const NAMES: [&'static str; 11] = [
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
        "turned",
    ];

    /// Name of the kind.
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
            Self::Turned(_) => "turned",
        }
    }

    /// The same kind for a ring rotated by this number of transducers.
    #[must_use]
    pub const fn turned(self, places: usize) -> Self {
        match self {
            Self::Swapped(other) => Self::Swapped((other + places) % 16),
            kind => kind,
        }
    }

    /// The reading of a faulty transducer. Without the fault it would be `range`; `previous` is the
    /// range of the transducer that fired before. `history` holds delayed readings, oldest first.
    fn reported(
        self,
        range: Option<f64>,
        previous: Option<f64>,
        history: &mut VecDeque<Option<f64>>,
        noise: &mut Noise,
    ) -> Option<f64> {
        let (min, max) = (6.0 * M_PER_INCH, f64::from(MAX_READING_IN) * M_PER_INCH);
        let limited = |range: f64| (range < max).then_some(range.max(min));
        match self {
            Self::Dead => None,
            Self::Stuck(range) => Some(range),
            Self::Scaled(factor) => limited(range? * factor),
            Self::Offset(offset_m) => limited(range? + offset_m),
            Self::Jumping(probability) if noise.chance(probability) => {
                Some(noise.uniform_in(min, max))
            }
            Self::Noisy(sigma_m) => {
                // Draws once per firing, with or without an echo.
                let error_m = noise.normal() * sigma_m;
                limited(range? + error_m)
            }
            Self::Delayed(firings) => {
                history.push_back(range);
                (history.len() > firings).then(|| history.pop_front())??
            }
            Self::Intermittent(probability) if noise.chance(probability) => None,
            Self::Crosstalk(probability) if noise.chance(probability) => match (range, previous) {
                (Some(own), Some(previous)) => Some(own.min(previous)),
                (own, previous) => own.or(previous),
            },
            Self::Jumping(_)
            | Self::Intermittent(_)
            | Self::Crosstalk(_)
            | Self::Swapped(_)
            | Self::Turned(_) => range,
        }
    }
}

/// A fault of one transducer. Text form: `KIND:SENSOR` or `KIND:SENSOR:VALUE`, with `@SECONDS` at
/// the end if it begins later.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransducerFault {
    /// The transducer.
    pub sensor: usize,
    /// Kind of fault.
    pub kind: FaultKind,
    /// When it begins, simulated seconds from the start.
    pub since_s: f64,
}

impl fmt::Display for TransducerFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.kind.name(), self.sensor)?;
        match self.kind {
            FaultKind::Dead => {}
            FaultKind::Delayed(value) | FaultKind::Swapped(value) => write!(f, ":{value}")?,
            FaultKind::Stuck(value)
            | FaultKind::Scaled(value)
            | FaultKind::Offset(value)
            | FaultKind::Jumping(value)
            | FaultKind::Noisy(value)
            | FaultKind::Intermittent(value)
            | FaultKind::Crosstalk(value)
            | FaultKind::Turned(value) => write!(f, ":{value}")?,
        }
        match self.since_s {
            0.0 => Ok(()),
            since_s => write!(f, "@{since_s}"),
        }
    }
}

impl FromStr for TransducerFault {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        let (fault, since) = text
            .split_once('@')
            .map_or((text, None), |(fault, since)| (fault, Some(since)));
        let mut parts = fault.split(':');
        let name = parts.next().unwrap_or_default();
        if !FaultKind::NAMES.contains(&name) {
            return Err(BadInput::unknown("fault", name, &FaultKind::NAMES));
        }
        let error = |why: &str| BadInput::new(format!("fault \"{text}\": {why}"));
        let since_s = since.map_or(Some(0.0), |since| since.parse().ok());
        let since_s = since_s
            .filter(|since_s| (0.0..=MAX_SINCE_S).contains(since_s))
            .ok_or_else(|| error("after @ come the seconds until it begins, as in dead:3@600"))?;
        let sensor = parts.next().and_then(|sensor| sensor.parse().ok());
        let sensor = sensor
            .filter(|sensor| *sensor < 16)
            .ok_or_else(|| error("after the kind comes a transducer from 0 to 15, as in dead:3"))?;
        let value = parts.next();
        if parts.next().is_some() || (name == "dead" && value.is_some()) {
            return Err(error("there is something left over at its end"));
        }
        let ends_with =
            |what: &str| error(&format!("it ends with {what}, as in {name}:{sensor}:VALUE"));
        let number = |what: &str, min: f64, max: f64| {
            let number = value.and_then(|value| value.parse().ok());
            let number = number.filter(|number| (min..=max).contains(number));
            number.ok_or_else(|| ends_with(&format!("{what} from {min} to {max}")))
        };
        let count = |what: &str, min: usize, max: usize| {
            let count = value.and_then(|value| value.parse().ok());
            let count = count.filter(|count| (min..=max).contains(count));
            count.ok_or_else(|| ends_with(&format!("{what} from {min} to {max}")))
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
            "turned" => FaultKind::Turned(number("an angle in degrees", -180.0, 180.0)?),
            _ => FaultKind::Dead,
        };
        Ok(Self {
            sensor,
            kind,
            since_s,
        })
    }
}

/// Faults of a ring, with their states.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct ActiveFaults {
    faults: Vec<(TransducerFault, VecDeque<Option<f64>>)>,
    /// Range of the transducer that fired last.
    previous: Option<f64>,
    /// Simulated time, s.
    now_s: f64,
}

impl ActiveFaults {
    pub(super) fn new(faults: &[TransducerFault]) -> Self {
        let faults = faults.iter().map(|fault| (*fault, VecDeque::new()));
        Self {
            faults: faults.collect(),
            ..Self::default()
        }
    }

    /// From now on it is this time, s.
    pub(super) fn set_time(&mut self, now_s: f64) {
        self.now_s = now_s;
    }

    /// The faults that have begun.
    fn begun(&self) -> impl Iterator<Item = &TransducerFault> {
        let faults = self.faults.iter().map(|(fault, _)| fault);
        faults.filter(|fault| self.now_s >= fault.since_s)
    }

    /// The transducer that fires and listens when the ring fires `sensor`: swapped cables.
    #[inline]
    pub(super) fn wired_to(&self, sensor: usize) -> usize {
        self.begun().fold(sensor, |wired, fault| match fault.kind {
            FaultKind::Swapped(other) if wired == fault.sensor => other,
            FaultKind::Swapped(other) if wired == other => fault.sensor,
            _ => wired,
        })
    }

    /// How far a transducer sits to the left of where it should, rad; `None` = it does not.
    #[inline]
    pub(super) fn turn_of(&self, sensor: usize) -> Option<f64> {
        let turns = self.begun().filter_map(|fault| match fault.kind {
            FaultKind::Turned(degrees) if fault.sensor == sensor => Some(degrees.to_radians()),
            _ => None,
        });
        turns.reduce(|sum, turn| sum + turn)
    }

    /// The reading of a transducer that without faults would be `range`.
    #[inline]
    pub(super) fn reported(
        &mut self,
        sensor: usize,
        range: Option<f64>,
        noise: &mut Noise,
    ) -> Option<f64> {
        let previous = std::mem::replace(&mut self.previous, range);
        let now_s = self.now_s;
        let own_faults = self
            .faults
            .iter_mut()
            .filter(|(fault, _)| fault.sensor == sensor && now_s >= fault.since_s);
        own_faults.fold(range, |range, (fault, history)| {
            fault.kind.reported(range, previous, history, noise)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(text: &str) -> TransducerFault {
        text.parse().expect(text)
    }

    const ONE_OF_EACH: [&str; 11] = [
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
        "turned:10:-30",
    ];

    #[test]
    fn faults_round_trip_through_their_text() {
        for (text, name) in ONE_OF_EACH.into_iter().zip(FaultKind::NAMES) {
            assert_eq!(fault(text).to_string(), text);
            assert_eq!(fault(text).kind.name(), name);
            let later = format!("{text}@12.5");
            assert_eq!(fault(&later).to_string(), later);
        }
    }

    #[test]
    fn a_fault_begins_at_its_time() {
        let faults = ["dead:3@10", "swapped:4:5@20", "turned:6:90@30"];
        let mut faults = ActiveFaults::new(&faults.map(fault));
        let mut noise = Noise::new(1);
        let mut at = |now_s| {
            faults.set_time(now_s);
            let heard = faults.reported(3, Some(1.0), &mut noise);
            (heard, faults.wired_to(4), faults.turn_of(6).is_some())
        };
        assert_eq!(at(9.9), (Some(1.0), 4, false));
        assert_eq!(at(10.0), (None, 4, false));
        assert_eq!(at(20.0), (None, 5, false));
        assert_eq!(at(30.0), (None, 5, true));
    }

    #[test]
    fn invalid_faults_give_a_specific_error() {
        let error = |text: &str| {
            let parsed = text.parse::<TransducerFault>();
            parsed.expect_err(text).to_string()
        };
        assert!(error("daed:3").contains("did you mean \"dead\""));
        assert!(error("dead").contains("0 to 15") && error("dead:16").contains("0 to 15"));
        assert!(
            error("dead:3:1").contains("left over") && error("stuck:3:1:1").contains("left over")
        );
        assert!(error("stuck:3").contains("range in meters"));
        assert!(error("stuck:3:-1").contains("0 to 6.4"));
        assert!(error("scaled:3:NaN").contains("share"));
        for kind in ["jumping", "intermittent", "crosstalk"] {
            assert!(error(&format!("{kind}:3:2")).contains("probability from 0 to 1"));
        }
        assert!(error("turned:3").contains("degrees") && error("turned:3:181").contains("180"));
        for since in ["", "-1", "NaN", "later", "2e6"] {
            assert!(error(&format!("dead:3@{since}")).contains("dead:3@600"));
        }
        assert!(error("noisy:3:-0.1").contains("standard deviation"));
        assert!(
            error("delayed:3:0").contains("from 1 to 1000") && error("delayed:3:0.5").contains("1")
        );
        assert!(
            error("swapped:3:3").contains("another") && error("swapped:3:16").contains("0 to 15")
        );
    }

    /// The readings of transducer 3 with a fault, for these ranges. Transducer 2 fires before it.
    fn readings(text: &str, ranges: &[Option<f64>]) -> Vec<Option<f64>> {
        let (mut noise, mut faults) = (Noise::new(1), ActiveFaults::new(&[fault(text)]));
        let readings = ranges.iter().map(|range| {
            let other = faults.reported(2, Some(1.0), &mut noise);
            assert_eq!(other, Some(1.0), "{text}: transducer 2 has no fault");
            faults.reported(3, *range, &mut noise)
        });
        readings.collect()
    }

    #[test]
    fn each_kind_changes_only_its_own_transducer() {
        let one = |text, range| readings(text, &[range])[0];
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
        let jumps = readings("jumping:3:1", &[None, None]);
        assert!(jumps[0] != jumps[1] && jumps.iter().all(|range| range.is_some_and(|r| r < 6.48)));
    }

    #[test]
    fn a_delayed_transducer_reports_earlier_readings() {
        let ranges = [Some(1.0), None, Some(3.0), Some(4.0)];
        let delayed = readings("delayed:3:2", &ranges);
        assert_eq!(delayed, [None, None, Some(1.0), None]);
    }

    /// Tests mean and standard deviation of 10 000 readings, and the share without an echo, within
    /// five standard errors.
    #[test]
    fn noise_and_missing_echoes_have_their_rates() {
        let ranges = [Some(3.0); 10_000];
        let noisy = readings("noisy:3:0.2", &ranges);
        let errors: Vec<_> = noisy.iter().flatten().map(|r| r - 3.0).collect();
        let count = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / count;
        let variance = errors.iter().map(|e| e * e).sum::<f64>() / count;
        assert!(mean.abs() < 0.01 && (variance.sqrt() - 0.2).abs() < 0.007);
        let intermittent = readings("intermittent:3:0.25", &ranges);
        let missing = intermittent.iter().filter(|range| range.is_none()).count();
        assert!((2_284..2_717).contains(&missing), "{missing}");
    }

    #[test]
    fn swapped_cables_swap_both_transducers() {
        let faults = ActiveFaults::new(&[fault("swapped:3:7")]);
        let wired = [2, 3, 4, 7].map(|sensor| faults.wired_to(sensor));
        assert_eq!(wired, [2, 7, 4, 3]);
        assert_eq!(FaultKind::Swapped(8).turned(10), FaultKind::Swapped(2));
        assert_eq!(FaultKind::Dead.turned(10), FaultKind::Dead);
    }
}
