//! Thinking in parts: where the robot is, and which way it goes from there.

use super::ground::Ground;
use super::recall::{Sought, compared};
use super::record::WAYS;
use super::{Aim, CLOSE_MM, Leg, NOWHERE, PlaceLimits, Places, Purpose, ROOMS_MM};
use crate::goal::Goal;
use crate::memory::SituationBytes;
use crate::points::{LATEST, PointMemory, WallDirections};
use crate::scan::Encoding;
use crate::units::Displacement;
use core::mem;
use core::task::Poll;

/// Steps that take a chip less than 168 000 instructions, with 256 places and 256 points: 1 ms of
/// an STM32F405.
pub const SLICE: u16 = 8;

/// Places that are looked at again for open ways in a decision, less one.
const REOPENED: u8 = 3;
/// To compare a point with all others takes about so many steps.
const STEPS_PER_POINT: u16 = 8;

/// What comes next. The first one is all zeros: static memory that begins otherwise takes flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stage {
    /// Nothing.
    Done,
    /// The walls around it, of which the latest points tell, from this one on.
    Walls(u16),
    /// Which way it faces.
    Heading,
    /// Whether it may be elsewhere than it thinks.
    Doubt,
    /// Positions where it may be, from this one on.
    Positions(u16),
    /// Where it may be that was set down elsewhere, of its guesses from this one on.
    Guesses(u16),
    /// Where else it may be, of the places that it knew from this one on.
    Seeds(u16),
    /// The place where the robot is.
    Place,
    /// The free ways around it, from this one on.
    FreeWays(u16),
    /// The ends of those.
    Frontiers,
    /// Short open ways of the next place that it knows, and then of so many more.
    Reopen(u8),
    /// What the robot is to do; a way that it knows needs no wave.
    Purpose,
    /// The places at which the wave begins, from this one on.
    Sources(u16),
    /// The wave from place to place.
    Wave,
    /// The places in sight, from this one on; the best before it.
    Sight(u16, Candidate),
    /// Nothing more, but the decision takes long enough for a part of its own: with a way, or
    /// without.
    Led,
    NotLed,
}

/// Length of the way by a place, and the place: less is better.
pub(super) type Candidate = (u16, u16);
/// None yet.
pub(super) const NO_CANDIDATE: Candidate = (u16::MAX, NOWHERE);

impl<const SECTORS: usize, const RECORDS: usize> Places<SECTORS, RECORDS> {
    /// Begins to think of a robot that stands or is about to decide again, and perceives this in
    /// the frame of the start.
    pub fn begin(&mut self, encoding: Encoding, view: SituationBytes<SECTORS>, purpose: Purpose) {
        (self.encoding, self.view, self.purpose) = (encoding, view, purpose);
        self.stage = if self.has_compass {
            self.whether_lost(Stage::Place)
        } else {
            self.walls = WallDirections::NONE;
            Stage::Walls(0)
        };
    }

    /// Whether it has begun to think and has not come to an end.
    #[must_use]
    pub fn is_thinking(&self) -> bool {
        self.stage != Stage::Done
    }

    /// Thinks no more of what it has begun with.
    pub const fn stop_thinking(&mut self) {
        self.stage = Stage::Done;
    }

    /// Does a part of the thinking: `steps` ways or places of what comes next. The result does not
    /// depend on how many they are. Ready with the way to the next sub-goal; `None` where the robot
    /// is not led or there is none: nothing is known yet, everything has been visited, or the
    /// robot is where the situation may be found. `goal` is the situation that it pursues.
    pub fn think<const POINTS: usize>(
        &mut self,
        limits: &PlaceLimits,
        points: &PointMemory<POINTS>,
        goal: Option<&Goal<SECTORS>>,
        steps: u16,
    ) -> Poll<Option<Leg>> {
        // Where it looks closely narrow ways count, and places stand close.
        let close_mm = if self.is_close() { CLOSE_MM } else { u16::MAX };
        let is_narrow = self.is_close() || self.looks_closely;
        let limits = &PlaceLimits {
            spacing_mm: limits.spacing_mm.min(close_mm),
            ..*limits
        };
        let ground = &Ground {
            points,
            radius_mm: limits.radius_mm,
            is_narrow,
        };
        let compared = goal.map(compared);
        let sought = match (self.purpose, &compared) {
            (Purpose::Lead(Aim::Position(position)), _) => Sought::Position(position),
            (Purpose::Lead(Aim::Situation), Some(goal)) => Sought::Situation(goal),
            _ => Sought::Nothing,
        };
        self.stage = match mem::replace(&mut self.stage, Stage::Done) {
            Stage::Done => return Poll::Ready(None),
            Stage::Walls(first) => self.hear_walls(points, first, steps),
            Stage::Heading => {
                let turn = self.compass.update(self.traveled_mm, &self.walls);
                (self.turn, self.traveled_mm) = (self.turn.plus(turn), 0);
                self.find_heading_anew();
                self.whether_lost(Stage::Doubt)
            }
            Stage::Doubt if self.doubts_position() => Stage::Positions(0),
            Stage::Doubt => Stage::Place,
            Stage::Positions(first) => self.compare_positions(first, steps),
            Stage::Guesses(first) => self.follow_guesses(first, steps),
            Stage::Seeds(first) => self.seed_guesses(first, steps),
            Stage::Place => self.find_place(limits),
            Stage::FreeWays(first) => self.measure_ways(ground, first, ground.steps(steps)),
            Stage::Frontiers => self.find_frontiers(limits),
            Stage::Reopen(left) => self.reopen(limits, left),
            Stage::Purpose => match self.purpose {
                Purpose::Perceive => Stage::NotLed,
                Purpose::Search | Purpose::Stay => self.searched(),
                Purpose::Lead(_) => match self.known_way(limits, ground, sought) {
                    Some(way) => self.led(self.leg_along(ground, way)),
                    None => {
                        self.wavefront.begin();
                        Stage::Sources(0)
                    }
                },
            },
            Stage::Sources(first) => self.begin_wave(limits, sought, first, steps),
            Stage::Wave => self.spread(limits, steps),
            Stage::Sight(first, best) if usize::from(first) < self.graph.records().len() => {
                self.look(limits, ground, (first, best), ground.steps(steps))
            }
            Stage::Sight(_, best) => match self.new_way(limits, ground, sought, best) {
                Some(way) => self.led(self.leg_along(ground, way)),
                None => Stage::NotLed,
            },
            Stage::Led => return Poll::Ready(Some(self.leg)),
            Stage::NotLed => return Poll::Ready(None),
        };
        Poll::Pending
    }

    /// A robot that was set down elsewhere has to find out where; with `otherwise` goes on what any
    /// other one thinks.
    fn whether_lost(&self, otherwise: Stage) -> Stage {
        let is_aligned = self.has_compass || self.compass.is_aligned();
        match self.lost.first_uncertain() {
            Some(_) if is_aligned => Stage::Guesses(0),
            Some(_) => Stage::Place,
            None => otherwise,
        }
    }

    fn hear_walls<const POINTS: usize>(
        &mut self,
        points: &PointMemory<POINTS>,
        first: u16,
        steps: u16,
    ) -> Stage {
        let count = steps.div_ceil(STEPS_PER_POINT);
        let last = first.saturating_add(count).min(LATEST);
        for latest in first..last {
            points.add_walls(latest, self.compass.frame(), &mut self.walls);
        }
        if last < LATEST {
            Stage::Walls(last)
        } else {
            Stage::Heading
        }
    }

    /// It looks for a position, or for something anywhere and nothing else is left.
    fn is_close(&self) -> bool {
        match self.purpose {
            Purpose::Lead(Aim::Everywhere) => self.looks_closely,
            _ => self.looks_for_position(),
        }
    }

    /// It is led to a position, by a way that it has not gone.
    pub(crate) const fn looks_for_position(&self) -> bool {
        matches!(self.purpose, Purpose::Lead(Aim::Position(_))) && self.frontier.is_some()
    }

    fn find_place(&mut self, limits: &PlaceLimits) -> Stage {
        self.graph.pass_decision();
        if self.lost.first_uncertain().is_some() {
            if self.graph.is_full() {
                self.forget_uncertain();
            }
        } else if let Some(merged) = self.graph.thin_out() {
            self.current = self.current.map(|place| merged.renumbered(place));
            // What they were to lead to is looked for anew.
            (self.frontier, self.target) = (None, None);
        }
        let Some(index) = self.graph.place_at(limits, self.here, &self.view) else {
            return self.reopen_some();
        };
        if let Some(before) = self.current.filter(|before| *before != index) {
            self.graph.went(before, index);
        }
        self.current = Some(index);
        if self.graph.complete(index, self.here, &self.view) {
            Stage::FreeWays(0)
        } else {
            self.reopen_some()
        }
    }

    /// If it looks closely some of the places that it knows may have more open ways.
    fn reopen_some(&self) -> Stage {
        if self.looks_closely
            && self.is_close()
            && usize::from(self.reopened) < self.graph.records().len()
        {
            Stage::Reopen(REOPENED)
        } else {
            Stage::Purpose
        }
    }

    fn reopen(&mut self, limits: &PlaceLimits, left: u8) -> Stage {
        self.graph.find_frontiers(limits, self.reopened);
        self.reopened = self.reopened.saturating_add(1);
        match left {
            0 => Stage::Purpose,
            left => Stage::Reopen(left - 1),
        }
    }

    fn measure_ways<const POINTS: usize>(
        &mut self,
        ground: &Ground<'_, POINTS>,
        first: u16,
        steps: u16,
    ) -> Stage {
        let last = first.saturating_add(steps).min(WAYS as u16);
        if let Some(current) = self.current {
            for way in first..last {
                self.graph.measure(ground, current, self.here, way.into());
            }
        }
        if usize::from(last) < WAYS {
            Stage::FreeWays(last)
        } else {
            Stage::Frontiers
        }
    }

    fn find_frontiers(&mut self, limits: &PlaceLimits) -> Stage {
        if let Some(current) = self.current {
            self.graph.find_frontiers(limits, current);
        }
        self.reopen_some()
    }

    /// The situation that it seeks is found here, or sought here in vain.
    fn searched(&mut self) -> Stage {
        let is_found = self.purpose == Purpose::Stay;
        if let Some(current) = self.current {
            self.graph.searched(current, is_found);
        }
        if is_found {
            self.led(Leg::HERE)
        } else {
            Stage::NotLed
        }
    }

    const fn led(&mut self, leg: Leg) -> Stage {
        self.leg = leg;
        Stage::Led
    }

    fn leg_along<const POINTS: usize>(
        &self,
        ground: &Ground<'_, POINTS>,
        way: Displacement,
    ) -> Leg {
        let fits = |room_mm: &u16| ground.fits_with(*room_mm, way);
        let end = Aim::Position(self.here.plus(way));
        Leg {
            way,
            room_mm: ROOMS_MM.into_iter().find(fits).unwrap_or(0),
            is_new: self.looks_for_position(),
            is_straight: self.is_straight && self.target.is_some(),
            is_last: self.purpose == Purpose::Lead(end),
        }
    }
}
