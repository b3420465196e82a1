//! Geometry of a ring of evenly spaced transducers.

use core::f64::consts::TAU;

use super::{FACE_RADIUS_M, FIRING_ORDER};

/// Transducers on a circle, evenly spaced. Number 0 points ahead; numbers increase to the left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingGeometry {
    /// Number of transducers, at least 1.
    pub count: usize,
    /// Distance from the turret's axis to each transducer's face, m.
    pub face_radius_m: f64,
}

impl Default for RingGeometry {
    /// The Nomad 200: 16 transducers at 0.2305 m.
    fn default() -> Self {
        Self {
            count: 16,
            face_radius_m: FACE_RADIUS_M,
        }
    }
}

impl RingGeometry {
    /// Bearing of a transducer relative to the turret's heading, rad, positive to the left.
    #[must_use]
    pub fn bearing(&self, sensor: usize) -> f64 {
        TAU * sensor as f64 / self.count.max(1) as f64
    }

    /// Firing order: the Nomad's for 16 transducers, otherwise front first, then alternating sides.
    #[must_use]
    pub fn firing_order(&self) -> Vec<usize> {
        if self.count == FIRING_ORDER.len() {
            return FIRING_ORDER.to_vec();
        }
        let sides = |i: usize| {
            if i % 2 == 1 {
                i.div_ceil(2)
            } else {
                self.count - i / 2
            }
        };
        (0..self.count)
            .map(|i| if i == 0 { 0 } else { sides(i) })
            .collect()
    }
}
