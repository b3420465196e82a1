//! Configuration of the shield: margins, lobes and times.

use super::{Allowed, braking_distance, stopping_speed};
use crate::config::Config;
use crate::points::Lobe;
use crate::units::{Bearing, Displacement};
use serde::{Deserialize, Serialize};

/// A reading as short as the shortest range may be anything nearer. It counts as halfway, or as the
/// margin where that is less: so nothing fits between the face and the margin around it.
pub(crate) fn shortest_possible_mm(range_mm: u16, least_range_mm: u16, margin_mm: u16) -> u16 {
    if range_mm > least_range_mm {
        range_mm
    } else {
        (least_range_mm / 2).min(margin_mm)
    }
}

/// Margins, lobes and times of the shield.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShieldConfig {
    /// Distance to keep between body and anything heard, millimeters.
    pub margin_mm: u16,
    /// Half the opening of a transducer's lobe.
    pub half_lobe: Bearing,
    /// A direction is open only while the transducers that look there have been heard within this
    /// time, milliseconds.
    pub fresh_ms: u32,
    /// When a transducer is heard that was silent for longer than this, the robot may have been
    /// carried elsewhere, and all else that was heard is forgotten, milliseconds. Nothing else
    /// expires.
    pub forget_ms: u32,
    /// Displacements that would be shortened to less than this are not begun, millimeters.
    pub least_mm: u16,
    /// The shortest range the ring can report, millimeters: a reading this short may be anything
    /// nearer, so the place before it is closed as well.
    pub least_range_mm: u16,
}

impl ShieldConfig {
    /// Five places of a lobe are kept. An echo frees a place if its cone contains what lies between
    /// it and its neighbors as well.
    pub(super) fn lobe<const SENSORS: usize>(&self, config: &Config<SENSORS>) -> Lobe {
        let robot = &config.robot;
        // A quarter turn at most: sines grow up to there.
        let half = self.half_lobe.as_turns().min(1 << 14);
        let half_free = robot.half_cone.as_turns().saturating_sub(half / 4);
        // What the body may meet on the next two steps.
        let steps_mm = 2 * i32::from(robot.step_mm) + braking_distance(config);
        let body_mm = i32::from(robot.body_radius_mm) + i32::from(self.margin_mm);
        Lobe {
            half: Bearing::from_turns(half),
            half_free: Bearing::from_turns(half_free),
            reach_mm: (steps_mm + body_mm).unsigned_abs(),
            similar_mm: 60,
            // Four deviations of a near range, and its rounding to inches.
            short_of_echo_mm: 60,
            short_of_echo_part: 32,
            doubts_free: true,
        }
    }

    /// What is allowed of a displacement of which `free_mm` and what it takes to brake are free.
    pub(super) fn allowed<const SENSORS: usize>(
        &self,
        config: &Config<SENSORS>,
        wanted: Displacement,
        free_mm: i32,
    ) -> Allowed {
        let length = i32::from(wanted.length_mm());
        let distance = free_mm.min(length);
        let begun = distance >= i32::from(self.least_mm).min(length);
        Allowed {
            distance_mm: if begun { distance as u16 } else { 0 },
            speed_mm_s: stopping_speed(config, free_mm),
        }
    }
}
