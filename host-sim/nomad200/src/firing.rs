//! The firing schedule of the sonars, as set by `conf_sn`.

use arena::sonar::{FIRING_ORDER, FIRING_SLOT_S, SOUND_M_S};

/// Unit of the rate, ms.
const RATE_MS: u32 = 4;

/// Rate for the value 0, which the library does not define: 40 ms, enough for an echo from 255 in.
const RATE: u8 = (FIRING_SLOT_S * 1e3) as u8 / RATE_MS as u8;

/// Ends a list of fewer than 16 sonars.
const END: u8 = 255;

/// One firing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shot {
    pub(super) sensor: usize,
    /// An echo from farther away would come after the next firing, m.
    pub(super) reach_m: f64,
}

/// Order of the sonars and the next one to fire.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct FiringSchedule {
    slot_ms: u32,
    order: Vec<u8>,
    next: usize,
    due_ms: u32,
}

impl Default for FiringSchedule {
    /// The drivers' order, a ring in 0.64 s; the robot's own default is not known.
    fn default() -> Self {
        Self::new(RATE, FIRING_ORDER.map(|sensor| sensor as u8), 0)
    }
}

impl FiringSchedule {
    /// Starts at `now_ms` with this order; sonars above 15 are ignored, 255 ends the list.
    pub(super) fn new(rate: u8, order: [u8; 16], now_ms: u32) -> Self {
        let rate = if rate == 0 { RATE } else { rate };
        let listed = order.into_iter().take_while(|&sensor| sensor != END);
        Self {
            slot_ms: u32::from(rate) * RATE_MS,
            order: listed.filter(|&sensor| sensor < 16).collect(),
            next: 0,
            due_ms: now_ms,
        }
    }

    /// The sonar that fires in this millisecond, if any.
    pub(super) fn due(&mut self, now_ms: u32) -> Option<Shot> {
        let sensor = *self.order.get(self.next)?;
        if now_ms != self.due_ms {
            return None;
        }
        self.next = (self.next + 1) % self.order.len();
        self.due_ms = now_ms.wrapping_add(self.slot_ms);
        Some(Shot {
            sensor: usize::from(sensor),
            reach_m: f64::from(self.slot_ms) * 1e-3 * SOUND_M_S / 2.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shots(firing: &mut FiringSchedule, from_ms: u32, ms: u32) -> Vec<(u32, usize)> {
        let times = (0..ms).map(|i| from_ms.wrapping_add(i));
        times
            .filter_map(|at| firing.due(at).map(|shot| (at, shot.sensor)))
            .collect()
    }

    #[test]
    fn a_ring_takes_sixteen_slots_in_the_drivers_order() {
        let mut firing = FiringSchedule::default();
        let fired = shots(&mut firing, 0, 641);
        assert_eq!(fired.len(), 17);
        for (slot, (at, sensor)) in fired.into_iter().enumerate() {
            assert_eq!((at, sensor), (40 * slot as u32, FIRING_ORDER[slot % 16]));
        }
    }

    #[test]
    fn a_short_order_ends_at_255_and_an_empty_one_is_silent() {
        let mut order = [255; 16];
        order[..3].copy_from_slice(&[0, 1, 15]);
        let mut firing = FiringSchedule::new(15, order, 100);
        assert_eq!(
            shots(&mut firing, 100, 200),
            [(100, 0), (160, 1), (220, 15), (280, 0)]
        );
        assert_eq!(shots(&mut FiringSchedule::new(0, [255; 16], 0), 0, 500), []);
        // Across the wrap of the clock.
        let mut firing = FiringSchedule::new(10, order, u32::MAX - 9);
        assert_eq!(
            shots(&mut firing, u32::MAX - 9, 60),
            [(u32::MAX - 9, 0), (30, 1)]
        );
    }

    #[test]
    fn what_comes_back_after_the_next_firing_is_out_of_reach() {
        let reach = |rate: u8| {
            FiringSchedule::new(rate, [3; 16], 0)
                .due(0)
                .map(|shot| shot.reach_m)
        };
        assert!(reach(10).is_some_and(|m| m > 255.0 * 0.0254));
        assert!(reach(9).is_some_and(|m| m < 255.0 * 0.0254));
        assert_eq!(reach(0), reach(10));
    }
}
