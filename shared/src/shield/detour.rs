//! Detours: other motions when the wanted one is blocked, or has been seen from one place only.

use super::{Allowed, SECOND_VIEW_MM, Shield};
use crate::config::Config;
use crate::fixed::Mask;
use crate::units::{Bearing, Displacement, Millis};

impl<const SENSORS: usize> Shield<SENSORS> {
    /// The first move after the start, or after the robot was carried: a short one across the way,
    /// to look at it from a second place. `None` where that is known already, or where both sides
    /// are closed.
    #[must_use]
    pub fn step_aside(
        &self,
        config: &Config<SENSORS>,
        enabled: Mask,
        wanted: Displacement,
        now: Millis,
    ) -> Option<(Displacement, Allowed)> {
        if config.shield.is_none() || !self.has_one_view() {
            return None;
        }
        let step = wanted.with_length(SECOND_VIEW_MM);
        let aside = [1, 3].map(|quarters| {
            let way = step.rotated(Bearing::of_place(quarters, 4).direction());
            let mut allowed = self.allow(config, enabled, way, now);
            // Not yet seen: slowly.
            allowed.speed_mm_s = allowed.speed_mm_s.min(config.robot.speed_mm_s / 2);
            (way, allowed)
        });
        let freer = aside
            .into_iter()
            .max_by_key(|(_, allowed)| allowed.distance_mm);
        freer.filter(|(_, allowed)| allowed.distance_mm > 0)
    }

    /// A way, and what is allowed of it: `wanted`, or the best of four detours where less than half
    /// of `wanted` is free. A detour also shows what stands in the gap between two lobes: from
    /// beside it, it is in a lobe.
    ///
    /// `closed`: decisions in a row for which all of these were closed. Each time others are tried.
    #[must_use]
    pub fn detour(
        &self,
        config: &Config<SENSORS>,
        enabled: Mask,
        wanted: Displacement,
        now: Millis,
        closed: u8,
    ) -> (Displacement, Allowed) {
        best_detour(wanted, closed, |way| self.allow(config, enabled, way, now))
    }
}

/// The best of a way and four detours by what is allowed of each, as of [`Shield::detour`]. Each
/// time all are closed they are 1/64 of a turn farther: the way out between two things may be
/// narrow, and what closes the others may be a phantom echo, found out from elsewhere only.
pub(crate) fn best_detour(
    wanted: Displacement,
    closed: u8,
    mut allow: impl FnMut(Displacement) -> Allowed,
) -> (Displacement, Allowed) {
    let mut best = (wanted, allow(wanted));
    if 2 * best.1.distance_mm >= wanted.length_mm() {
        return best;
    }
    // Eighths of a turn, and what such a way counts for, sixteenths: at 45° what leads along the
    // one wanted; across it nothing does, but a quarter counts for what it shows.
    let mut farthest = 16 * u32::from(best.1.distance_mm);
    for (eighths, share) in [(1, 11), (7, 11), (2, 4), (6, 4)] {
        let bearing = Bearing::of_place(eighths, 8).plus(Bearing::of_place(closed.into(), 64));
        let way = wanted.rotated(bearing.direction());
        let allowed = allow(way);
        let along = share * u32::from(allowed.distance_mm);
        if along > farthest {
            (best, farthest) = ((way, allowed), along);
        }
    }
    best
}
