//! Looking around: a body with few sensors turns on the spot until it has seen enough to decide.

use super::{RingController, Robot, VirtualTurret};
use crate::controller::{Motion, Progress};
use crate::fixed::Mask;
use crate::units::{Bearing, Displacement, Millis};

/// Glances before a decision, at most: a whole turn of quarters.
const MAX_GLANCES: u8 = 4;
/// A base turns to where it goes, so a glance is a way to the left, of this length, millimeters.
const GLANCE_MM: i32 = 2;

impl<const SECTORS: usize, const POINTS: usize> VirtualTurret<SECTORS, POINTS> {
    /// Whether it looks around. A base that takes longer than it may is waited for no more.
    pub(super) fn is_glancing(&self, at: Millis, longest_ms: u16) -> bool {
        let since = self.glance_since;
        since.is_some_and(|since| at.after(since) <= u32::from(longest_ms))
    }
}

impl<C, const SECTORS: usize, const BEAMS: usize, const POINTS: usize>
    Robot<'_, C, SECTORS, BEAMS, POINTS>
where
    C: RingController<SECTORS>,
{
    /// The motion that looks around, where too little was seen for a decision.
    pub(super) fn glance(&mut self) -> Option<Motion> {
        let limits = &self.body.points;
        let seen = self.turret.memory.seen_from_here::<SECTORS>(limits);
        let unseen = seen.complement().indices(SECTORS).count();
        let is_enough = unseen <= usize::from(self.body.most_unseen);
        if is_enough || self.turret.glances >= MAX_GLANCES || !self.controller.awaits_ring() {
            self.turret.glances = 0;
            return None;
        }
        self.turret.glances += 1;
        self.turret.glance_since = Some(self.at);
        self.turret.fresh = Mask::NONE;
        let to_the_left = Displacement::along(Bearing::of_place(1, 4), GLANCE_MM);
        Some(Motion {
            id: self.turret.last_motion_id,
            displacement: self.body.actuation.command(to_the_left),
            speed_mm_s: self.config.robot.speed_mm_s,
        })
    }

    /// A report of the base during a glance: the controller's ring comes later.
    pub(super) fn glanced(&mut self, progress: Progress) {
        if !self.turret.is_glancing(self.at, self.config.robot.steer_ms) {
            return;
        }
        self.controller.await_ring(self.at);
        if matches!(progress, Progress::Ended | Progress::Touched) {
            self.turret.glance_since = None;
            self.turret.fresh = Mask::NONE;
        }
    }
}
