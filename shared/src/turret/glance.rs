//! Looking around: a body turns on the spot until it has seen enough to decide. One that is blind
//! ahead looks to where it is about to go.

use super::{BodySpec, RingController, Robot, VirtualTurret};
use crate::controller::{Motion, Progress};
use crate::fixed::Mask;
use crate::points::sector_at;
use crate::units::{Bearing, Displacement, Millis};

/// Glances before a decision, at most: a whole turn of quarters.
const MAX_GLANCES: u8 = 4;
/// A base turns to where it goes, so a glance is a way to the left, of this length, millimeters.
const GLANCE_MM: i32 = 2;
/// The same for a glance in another direction: whole millimeters tell it to 7°.
const GLANCE_ANYWHERE_MM: i32 = 4;
/// A body goes where these bearings from its front are free: 45° to each side.
const AHEAD: [Bearing; 5] = [
    Bearing::ZERO,
    Bearing::of_place(1, 16),
    Bearing::of_place(15, 16),
    Bearing::of_place(2, 16),
    Bearing::of_place(14, 16),
];
/// A body sees there if a sensor's axis is as near as this: 22.5°.
const SEES_WITHIN: u16 = 65_536_u32.div_ceil(16) as u16;

impl<const SECTORS: usize, const POINTS: usize, const RECORDS: usize>
    VirtualTurret<SECTORS, POINTS, RECORDS>
{
    /// Whether it looks around. A base that takes longer than it may is waited for no more.
    pub(super) fn is_glancing(&self, at: Millis, longest_ms: u16) -> bool {
        let since = self.glance_since;
        since.is_some_and(|since| at.after(since) <= u32::from(longest_ms))
    }
}

impl<C, const SECTORS: usize, const BEAMS: usize, const POINTS: usize, const RECORDS: usize>
    Robot<'_, C, SECTORS, BEAMS, POINTS, RECORDS>
where
    C: RingController<SECTORS>,
{
    /// The motion that looks around, where too little was seen for a decision.
    pub(super) fn glance(&mut self) -> Option<Motion> {
        let limits = &self.body.points;
        let seen = self.turret.memory.seen_from_here::<SECTORS>(limits);
        let unseen = seen.complement().indices(SECTORS).count();
        let is_enough = unseen <= usize::from(self.body.most_unseen);
        if !self.controller.awaits_ring() {
            self.turret.glances = 0;
            return None;
        }
        let has_looked = unseen == 0 || self.turret.first_looks >= self.body.first_looks;
        self.turret.knows_place |= has_looked;
        if !self.turret.knows_place {
            self.turret.first_looks += 1;
            return Some(self.turn_by(Bearing::of_place(1, 12), GLANCE_ANYWHERE_MM));
        }
        if is_enough || self.turret.glances >= MAX_GLANCES {
            return None;
        }
        Some(self.turn_by(Bearing::of_place(1, 4), GLANCE_MM))
    }

    /// The motion that looks along a way instead of going it, where the robot is blind ahead and
    /// has not looked there from here. Who looks around before each decision has.
    pub(super) fn glance_along(&mut self, way: Bearing) -> Option<Motion> {
        let looks_around = usize::from(self.body.most_unseen) < SECTORS;
        if looks_around || self.turret.glances >= MAX_GLANCES || !self.controller.pursues_goal() {
            return None;
        }
        let blind = AHEAD.into_iter().filter(|ahead| !self.body.sees(*ahead));
        let mut blind = blind.map(|ahead| way.plus(ahead)).peekable();
        blind.peek()?;
        let seen = self
            .turret
            .memory
            .seen_from_here::<SECTORS>(&self.body.points);
        let is_seen = |bearing| sector_at::<SECTORS>(bearing).is_some_and(|s| seen.contains(s));
        let bearing = blind.find(|bearing| !is_seen(*bearing))?;
        let turns = self
            .body
            .axes()
            .map(|axis| bearing.minus(self.turret.memory.heading().plus(axis)));
        let turn = turns.min_by_key(|turn| turn.as_signed_turns().unsigned_abs())?;
        self.controller.abandon_motion(self.at);
        self.turret.motion = None;
        Some(self.turn_by(turn, GLANCE_ANYWHERE_MM))
    }

    /// A turn on the spot to look.
    fn turn_by(&mut self, turn: Bearing, length_mm: i32) -> Motion {
        self.turret.glances = self.turret.glances.saturating_add(1);
        self.turret.glance_since = Some(self.at);
        self.turret.fresh = Mask::NONE;
        let displacement = Displacement::along(turn, length_mm);
        Motion {
            id: self.turret.last_motion_id,
            displacement: self.body.actuation.command(displacement),
            speed_mm_s: self.config.robot.speed_mm_s,
        }
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

impl<const BEAMS: usize> BodySpec<BEAMS> {
    /// Where the sensors look that are used, from the body's front.
    fn axes(&self) -> impl Iterator<Item = Bearing> {
        self.known_bearings().bearings.into_iter().flatten()
    }

    /// Whether a sensor looks in this direction from the body's front.
    fn sees(&self, direction: Bearing) -> bool {
        self.axes().any(|axis| {
            let offset = axis.minus(direction).as_signed_turns();
            offset.unsigned_abs() <= SEES_WITHIN
        })
    }
}
