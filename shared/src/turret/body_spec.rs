//! A robot's body: where its sensors stand, how long what they tell counts, and what its base does.

use crate::actuation::Actuation;
use crate::calibration::{KnownBearings, LearnedBody};
#[cfg(feature = "store")]
use crate::config::MAX_CONFIG;
use crate::fixed::Mask;
use crate::points::PointLimits;
use crate::units::{Bearing, Displacement, Range};
use core::num::NonZeroU16;
use serde::{Deserialize, Serialize};

/// Where a sensor stands on the body and looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Mount {
    /// Position: x ahead, y to the left of the body's center.
    pub position: Displacement,
    /// Direction, from the body's front.
    pub axis: Bearing,
}

/// What a guard has to know of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Guard {
    /// Distance that it keeps between the body and what was heard, millimeters.
    pub margin_mm: NonZeroU16,
    /// What is heard at this range or a shorter one may be nearer, millimeters; 0 for a sensor that
    /// tells every range.
    pub least_range_mm: u16,
}

/// A body with `BEAMS` sensors, at most 32.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct BodySpec<const BEAMS: usize> {
    /// Its sensors.
    #[serde(with = "crate::arrays")]
    pub mounts: [Mount; BEAMS],
    /// Sensors that exist and are used.
    pub enabled: Mask,
    /// What the base makes of its commands.
    pub actuation: Actuation,
    /// How long points last.
    pub points: PointLimits,
    /// How far a sensor that hears nothing sees free space, millimeters from its face; `None` = it
    /// tells nothing: the echo of a sonar may have gone astray on a smooth wall.
    pub silence_mm: Option<NonZeroU16>,
    /// Where it knows nothing of its surroundings, it turns by 30° so often before it decides, and
    /// listens.
    pub first_looks: u8,
    /// With more sectors than these unseen from here the robot turns on the spot before it
    /// decides.
    pub most_unseen: u8,
    /// Ends motions short of everything heard; `None` = no guard.
    pub guard: Option<Guard>,
    /// Distance that random moves leave to the nearest thing heard, wherever that is, while the
    /// robot finds where its sensors look, millimeters.
    pub babble_margin_mm: u16,
    /// Its heading does not drift: a compass measures it.
    pub has_compass: bool,
}

impl<const BEAMS: usize> BodySpec<BEAMS> {
    /// No sensors. All zeros.
    pub const NONE: Self = Self {
        mounts: [Mount {
            position: Displacement::ZERO,
            axis: Bearing::ZERO,
        }; BEAMS],
        enabled: Mask::NONE,
        actuation: Actuation {
            front: Bearing::ZERO,
            length_q12: 0,
            turn_q12: 0,
        },
        points: PointLimits {
            face_radius_mm: 0,
            keep_mm: 0,
            half_cone: Bearing::ZERO,
            short_of_echo_mm: 0,
            nearer_mm: 0,
            here_mm: 0,
            near_mm: 0,
            replan_within_mm: 0,
            replan_nearer_mm: 0,
        },
        silence_mm: None,
        first_looks: 0,
        most_unseen: 0,
        guard: None,
        babble_margin_mm: 0,
        has_compass: false,
    };

    /// How far a sensor that hears nothing sees free space; `None` = it tells nothing.
    pub(crate) fn silence(&self) -> Option<Range> {
        self.silence_mm.map(|mm| Range::from_mm(mm.get()))
    }

    /// The same body with its sensors where they were found to look; those that were not are not
    /// used.
    #[must_use]
    pub fn with(&self, found: &LearnedBody<BEAMS>) -> Self {
        let nothing = Self {
            actuation: found.actuation,
            enabled: Mask::NONE,
            ..self.clone()
        };
        nothing.with_more(&found.bearings)
    }

    /// The same body with more sensors, where they were found to look.
    #[must_use]
    pub fn with_more(mut self, bearings: &[Option<Bearing>; BEAMS]) -> Self {
        let face_mm = self.points.face_radius_mm.into();
        let mounts = self.mounts.iter_mut().zip(bearings);
        for (sensor, (mount, bearing)) in mounts.enumerate() {
            if let Some(axis) = *bearing {
                let position = Displacement::along(axis, face_mm);
                *mount = Mount { position, axis };
                self.enabled = self.enabled.with(sensor);
            }
        }
        self
    }

    /// Where the sensors look that are used.
    #[must_use]
    pub fn known_bearings(&self) -> KnownBearings<BEAMS> {
        KnownBearings {
            bearings: core::array::from_fn(|sensor| {
                let mount = self.mounts.get(sensor);
                let used = mount.filter(|_| self.enabled.contains(sensor));
                used.map(|mount| mount.axis)
            }),
            turn_q12: self.actuation.turn_q12,
        }
    }

    /// A sensor's range as one would read it that stands where the ring's ranges begin and looks
    /// the same way. It is at least 0.
    pub(crate) fn as_on_ring(&self, sensor: usize, range: Range) -> Range {
        let Some(Mount { position, axis }) = self.mounts.get(sensor) else {
            return range;
        };
        let (x, y) = (position.dx_mm.into(), position.dy_mm.into());
        let face_mm = axis.direction().along(x, y);
        let mm = i32::from(range.as_mm()) + face_mm - i32::from(self.points.face_radius_mm);
        Range::from_mm(mm.clamp(0, u16::MAX.into()) as u16)
    }

    /// As bytes in postcard's form.
    // One copy of it in a program.
    #[cfg(feature = "store")]
    #[inline(never)]
    #[must_use]
    pub fn to_bytes<'a>(&self, buffer: &'a mut [u8; MAX_CONFIG]) -> &'a [u8] {
        postcard::to_slice(self, buffer).map_or(&[], |bytes| bytes)
    }

    /// Undoes [`to_bytes`](Self::to_bytes); `None` for bytes that are no body, for one without
    /// sensors or with more than `BEAMS`, or for a base that never moves or turns.
    #[cfg(feature = "store")]
    #[inline(never)]
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let body: Self = postcard::from_bytes(bytes).ok()?;
        let surplus = body.enabled.indices(32).any(|sensor| sensor >= BEAMS);
        let has_sensors = body.enabled != Mask::NONE && !surplus;
        let moves = body.actuation.length_q12 > 0 && body.actuation.turn_q12 > 0;
        (has_sensors && moves).then_some(body)
    }
}
