//! The Nomad 200: its ring and base, and how careful its shield is.

use super::RobotSpec;
use crate::shield::ShieldConfig;
use crate::units::{Bearing, Direction};

/// [`evenly_spaced`](super::evenly_spaced) for 16 transducers, as a constant.
const RING_OF_16: [Direction; 16] = {
    // cos 0°, 22.5°, 45° … by micromath's cosine, 16 384 = 1; the sine lags by a quarter turn.
    const COSINES: [i16; 16] = [
        16_384, 15_144, 11_597, 6_261, 0, -6_261, -11_597, -15_144, -16_384, -15_144, -11_597,
        -6_261, 0, 6_261, 11_597, 15_144,
    ];
    let mut ring = [Direction { x_q14: 0, y_q14: 0 }; 16];
    let mut place = 0;
    while place < 16 {
        ring[place] = Direction {
            x_q14: COSINES[place],
            y_q14: COSINES[(place + 12) % 16],
        };
        place += 1;
    }
    ring
};

impl RobotSpec<16> {
    /// The Nomad 200: 16 sonars at 22.5° steps, faces at 0.2305 m, collision radius 0.269 m, at
    /// most 20 in/s and 30 in/s² (drivers' software limits), steps of 0.25 m.
    #[must_use]
    pub const fn nomad200() -> Self {
        Self {
            directions: RING_OF_16,
            symmetric: true,
            face_radius_mm: 231,
            body_radius_mm: 269,
            step_mm: 250,
            speed_mm_s: 508,
            braking_mm_s2: 762,
            ring_period_ms: 640,
            // Half a turn at 45 °/s and 30 °/s² takes 5.5 s.
            steer_ms: 6_000,
            // Sonars of 25°.
            half_cone: Bearing::from_turns(2_276),
        }
    }
}

impl ShieldConfig {
    /// For the Nomad's ring: lobes of ±15°, at least 6 in, a margin of 90 mm.
    #[must_use]
    pub const fn nomad200() -> Self {
        Self {
            margin_mm: 90,
            half_lobe: Bearing::from_turns(2_731),
            fresh_ms: 2_000,
            forget_ms: 600_000,
            least_mm: 10,
            least_range_mm: 153,
        }
    }
}
