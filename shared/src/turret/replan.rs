//! A body that turns before it goes listens on the way, and decides again if something is nearer
//! than it was thought to be.

use super::{RingController, Robot, VirtualTurret};
use crate::controller::{Event, Motion, Outputs};
use crate::fixed::Mask;
use crate::points::PointLimits;
use crate::units::{Bearing, Range};

/// New decisions in a row before one is carried out whatever shows up.
const MAX_LOOKS: u8 = 3;
/// The body counts as turned towards its way within this angle: 7.5°.
const TURNED: u16 = 65_536_u32.div_ceil(48) as u16;

impl<const SECTORS: usize, const POINTS: usize, const RECORDS: usize>
    VirtualTurret<SECTORS, POINTS, RECORDS>
{
    /// Whether the body faces its way and has not begun to roll.
    fn faces_way(&self, motion: &Motion) -> bool {
        let offset = motion.displacement.bearing().minus(self.memory.heading());
        !self.is_rolling && offset.as_signed_turns().unsigned_abs() <= TURNED
    }

    /// Sensors that need not be heard again before the next decision. Where the robot looks for a
    /// position, those count that it heard on its way: otherwise it stands for half of the time.
    /// After a command or an alarm none count.
    pub(super) fn heard_on_way(&self, outputs: &Outputs<SECTORS>) -> Mask {
        if outputs.mode_changed || !self.places.looks_for_position() {
            Mask::NONE
        } else if self.heard_all {
            Mask::ALL
        } else {
            self.fresh
        }
    }

    /// Whether a sector within 75° of the way is near, and clearly nearer than at the last
    /// decision.
    fn is_blocked(
        &self,
        limits: &PointLimits,
        way: Bearing,
        ring: &[Option<Range>; SECTORS],
    ) -> bool {
        const DEGREES_75: u16 = (65_536 * 75 / 360) as u16;
        let mm = |range: Option<Range>| range.map_or(u16::MAX, Range::as_mm);
        let mut sectors = ring.iter().zip(&self.last_ring).enumerate();
        sectors.any(|(sector, (now, before))| {
            let offset = Bearing::of_place(sector, SECTORS).minus(way);
            let (now, before) = (mm(*now), mm(*before));
            offset.as_signed_turns().unsigned_abs() < DEGREES_75
                && now < limits.replan_within_mm
                && now < before.saturating_sub(limits.replan_nearer_mm)
        })
    }
}

impl<C, const SECTORS: usize, const BEAMS: usize, const POINTS: usize, const RECORDS: usize>
    Robot<'_, C, SECTORS, BEAMS, POINTS, RECORDS>
where
    C: RingController<SECTORS>,
{
    /// All sensors were heard during a motion.
    pub(super) fn ring_under_way(&mut self) -> Outputs<SECTORS> {
        self.turret.fresh = Mask::NONE;
        self.turret.heard_all |= self.turret.is_rolling;
        let (ring, _) = self.turret.memory.ring(&self.body.points);
        if self.must_decide_again(&ring) {
            self.turret.replans = self.turret.replans.saturating_add(1);
            return self.decide();
        }
        // The controller stops a robot whose ring falls silent during a motion.
        for sector in self.controller.enabled(self.config).indices(SECTORS) {
            let range = ring.get(sector).copied().flatten();
            let sensor = sector as u8;
            let _ = self.control(Event::Echo { sensor, range });
        }
        self.shorten()
    }

    /// Whether a robot that has just turned towards its way sees something that it did not know.
    /// Random moves are not reconsidered.
    fn must_decide_again(&self, ring: &[Option<Range>; SECTORS]) -> bool {
        let turret = &self.turret;
        let seeks = self.controller.pursues_goal();
        let motion = turret.motion.filter(|motion| turret.faces_way(motion));
        motion.is_some_and(|motion| {
            let way = motion.displacement.bearing();
            seeks
                && !turret.is_thinking()
                && turret.replans < MAX_LOOKS
                && turret.is_blocked(&self.body.points, way, ring)
        })
    }
}
