//! Points where something returned an echo: a short memory of the surroundings, for robots whose
//! sensors do not look everywhere at once.
//!
//! Each echo leaves a point on its beam's axis, in the odometry's frame. A ring of sectors, evenly
//! spaced and with the bearings it had at the start, is read off the points however few sensors
//! there are and wherever they look. What returned an echo may stand anywhere in its beam's cone:
//! seen from elsewhere a point stands where newer echoes have left it, and it goes when they came
//! from beyond all of its cone, or when it was heard too long ago, by distance traveled.
//!
//! A [shield](crate::shield) that has to end motions in time, wherever in a cone their obstacle
//! stands, keeps the near ones alone.
//!
//! Nothing here depends on the maps, the planner or the time.

use crate::fixed::Mask;
use crate::units::{Bearing, Displacement, Range};
use heapless::{Vec, VecView};
use serde::{Deserialize, Serialize};

mod arc;
mod free;
mod near;
mod sectors;
mod walls;

pub(crate) use arc::Ray;
use arc::{Arc, FreeBeam};
pub(crate) use near::Lobe;
pub(crate) use sectors::sector_at;
use sectors::{keep_least, sectors_at, with_views};
pub(crate) use walls::{LATEST, PART, PARTS, WallDirections, shares};

/// How long points last and what they tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct PointLimits {
    /// Distance from the robot's center that a sector's range is counted from, millimeters.
    pub face_radius_mm: u16,
    /// Points seen longer ago than this travel are dropped, millimeters, to within 64; 16 320 or
    /// more: points last until there is no room.
    pub keep_mm: u16,
    /// Half the opening of a sensor's cone.
    pub half_cone: Bearing,
    /// A beam shows its cone free as far as its echo less this, millimeters.
    pub short_of_echo_mm: u16,
    /// A point beside a beam that looks along a sector's axis tells that sector's range only where
    /// it is nearer by more than this, millimeters.
    pub nearer_mm: u16,
    /// A point counts as seen from here if it was seen within this distance, millimeters.
    pub here_mm: u16,
    /// A point nearer to the body than this tells its sector's range wherever it was seen from,
    /// millimeters.
    pub near_mm: u16,
    /// A robot about to roll decides again only if a sector's range is below this, millimeters.
    pub replan_within_mm: u16,
    /// It also has to be this much shorter than at the last decision, millimeters.
    pub replan_nearer_mm: u16,
}

impl PointLimits {
    /// For a body of the Nomad's size, in rooms.
    pub const NOMAD: Self = Self {
        face_radius_mm: 231,
        keep_mm: 6_000,
        half_cone: Bearing::from_turns((65_536 * 25 / 720) as u16),
        short_of_echo_mm: 30,
        nearer_mm: 300,
        here_mm: 300,
        near_mm: 1_000,
        replan_within_mm: 1_200,
        replan_nearer_mm: 100,
    };
}

/// A reading of one sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Beam {
    /// Position of the sensor on the body: x ahead, y to the left.
    pub mount: Displacement,
    /// Where the sensor looks, relative to the body's front.
    pub axis: Bearing,
    /// Range of its echo, or how far it sees free space.
    pub range: Range,
    /// Something returned an echo at that range.
    pub is_echo: bool,
}

/// A place where something returned an echo. All vectors begin at the robot's center and have the
/// frame of the start. Three words: 256 points are searched and moved up at each echo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(align(4))]
struct Point {
    at: Displacement,
    /// Where the robot stood when it heard the echo.
    seen_from: Displacement,
    /// Travel at the echo.
    traveled: Travel,
    /// Where in the beam's cone it may be.
    arc: Arc,
}

/// A distance traveled, in units of 64 mm; wraps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Travel(u8);

impl Travel {
    /// As far as this, from a travel in millimeters that wraps.
    const fn to(traveled_mm: u16) -> Self {
        Self((traveled_mm / 64) as u8)
    }

    /// Whether no more than `keep_mm` lie between this and now.
    fn is_within(self, keep_mm: u16, now: Self) -> bool {
        u16::from(now.0.wrapping_sub(self.0)) <= keep_mm / 64
    }
}

/// The latest points, at most `POINTS`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PointMemory<const POINTS: usize> {
    points: Vec<Point, POINTS>,
    /// Bearing of the body's front in the frame of the start.
    heading: Bearing,
    /// Travel since the start, millimeters; wraps.
    traveled_mm: u16,
}

impl<const POINTS: usize> Default for PointMemory<POINTS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const POINTS: usize> PointMemory<POINTS> {
    /// No points yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            points: Vec::new(),
            heading: Bearing::ZERO,
            traveled_mm: 0,
        }
    }

    /// Forgets all points: the robot may have been carried elsewhere.
    pub fn forget(&mut self) {
        self.points.clear();
    }

    /// Forgets all, and starts anew from here.
    pub fn restart(&mut self) {
        self.points.clear();
        (self.heading, self.traveled_mm) = (Bearing::ZERO, 0);
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there are no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Bearing of the body's front in the frame of the start.
    #[must_use]
    pub const fn heading(&self) -> Bearing {
        self.heading
    }

    /// The robot has moved, in the body's frame, and then turned: points keep their place in the
    /// world. Those seen long ago, by travel, are dropped.
    pub fn moved(&mut self, limits: &PointLimits, moved: Displacement, turned: Bearing) {
        self.carry(moved, turned);
        if moved != Displacement::ZERO {
            let now = Travel::to(self.traveled_mm);
            self.points
                .retain(|point| point.traveled.is_within(limits.keep_mm, now));
        }
    }

    /// The robot faces farther to the left than was thought. Points stay where they are thought to
    /// be.
    pub(crate) fn correct_heading(&mut self, turn: Bearing) {
        self.heading = self.heading.plus(turn);
    }

    /// The robot faces this much farther to the left than it thought, and always did: all that it
    /// heard stands there as well.
    pub(crate) fn turn_frame(&mut self, turn: Bearing) {
        let direction = turn.direction();
        for point in &mut self.points {
            point.at = point.at.rotated(direction);
            point.seen_from = point.seen_from.rotated(direction);
        }
        self.correct_heading(turn);
    }

    /// As [`moved`](Self::moved); all points are kept.
    pub(crate) fn carry(&mut self, moved: Displacement, turned: Bearing) {
        if moved != Displacement::ZERO {
            let moved = moved.rotated(self.heading.direction());
            self.traveled_mm = self.traveled_mm.wrapping_add(moved.length_mm());
            for point in &mut self.points {
                point.at = point.at.minus(moved);
                point.seen_from = point.seen_from.minus(moved);
            }
        }
        self.heading = self.heading.plus(turned);
    }

    /// Takes a reading: its beam shows free what lies before its echo, which is a new point.
    pub fn hear(&mut self, limits: &PointLimits, beam: &Beam) {
        self.hear_along(limits, &self.ray(beam), beam.is_echo);
    }

    /// As [`hear`](Self::hear), in the frame of the start.
    pub(crate) fn hear_along(&mut self, limits: &PointLimits, ray: &Ray, is_echo: bool) {
        let half_cone = limits.half_cone.direction();
        let echo_mm = if is_echo {
            limits.short_of_echo_mm.into()
        } else {
            0
        };
        let free = ray.free(half_cone, ray.range_mm - echo_mm);
        self.carve(&free);
        // Points stand in the order heard.
        if self.points.is_full() {
            self.points.remove(0);
        }
        let arc = if is_echo {
            // Four fifths of the cone.
            let edge_mm = half_cone.times(ray.range_mm).1;
            Arc::new(ray.axis, edge_mm * 2 / 5)
        } else {
            Arc::NOTHING
        };
        let at = ray.at(ray.range_mm);
        let _ = self.points.push(Point::new(at, self.traveled_mm, arc));
    }

    /// A sonar heard nothing as far as the ray's range. On a smooth wall an echo may go astray, but
    /// what returned one in almost the same direction would have returned this one too. Of the
    /// rest silence tells nothing. `half_cone`: of what it shows free; `may_be_stray`: once alone
    /// it shows nothing.
    pub(crate) fn hear_nothing(&mut self, half_cone: Bearing, ray: &Ray, may_be_stray: bool) {
        self.carve(&FreeBeam {
            may_be_stray,
            is_silent: true,
            ..ray.free(half_cone.direction(), ray.range_mm)
        });
    }

    /// A beam in the frame of the start.
    pub(crate) fn ray(&self, beam: &Beam) -> Ray {
        Ray {
            face: beam.mount.rotated(self.heading.direction()),
            axis: self.heading.plus(beam.axis).direction(),
            range_mm: beam.range.as_mm().into(),
        }
    }

    /// A beam has shown a part of its cone free.
    fn carve(&mut self, free: &FreeBeam) {
        carve(self.points.as_mut_view(), free);
    }

    /// Ranges of a ring of evenly spaced sectors, with the bearings of the frame of the start, and
    /// the sectors that are known. The range of an unknown sector is `None`, and so is that of a
    /// sector in which a sensor has seen from here that nothing is within its reach.
    ///
    /// A sector's range is that of its nearest point, within 12.5° of its axis in a ring of 16.
    /// Far points seen from elsewhere count only in sectors without others. But what returned an
    /// echo may lie anywhere in the beam's cone. So if a beam looks along the axis from here, the
    /// others only count where they are nearer by more than [`nearer_mm`](PointLimits::nearer_mm).
    #[must_use]
    pub fn ring<const SECTORS: usize>(
        &self,
        limits: &PointLimits,
    ) -> ([Option<Range>; SECTORS], Mask) {
        let mut nearest = [None; SECTORS];
        let mut older = [None; SECTORS];
        let mut along_axis = [None; SECTORS];
        let mut known = Mask::NONE;
        for point in &self.points {
            let at = point.place(limits);
            let [own, other] = sectors_at::<SECTORS>(at.bearing());
            if !point.is_echo() {
                if point.is_from_here(limits) {
                    known = with_views(known, [own, other]);
                }
                continue;
            }
            let square = at.squared_mm2();
            let squares = if point.tells(limits, at) {
                &mut nearest
            } else {
                &mut older
            };
            keep_least(squares, own.sector, square);
            keep_least(squares, other.sector, square);
            if own.is_central && point.seen_from.is_shorter_than(AT_THIS_PLACE_MM) {
                keep_least(&mut along_axis, own.sector, square);
            }
        }
        let mut ring = [None; SECTORS];
        let sectors = ring.iter_mut().zip(nearest).zip(older).zip(along_axis);
        for (sector, (((range, nearest), older), along_axis)) in sectors.enumerate() {
            let from_face = |square| {
                let mm = crate::fixed::isqrt_u32(square) as u16;
                mm.saturating_sub(limits.face_radius_mm)
            };
            let Some(nearest) = nearest.or(older).map(from_face) else {
                continue;
            };
            let along_axis = along_axis.map(from_face);
            let fitting = along_axis.filter(|mm| mm.saturating_sub(nearest) <= limits.nearer_mm);
            *range = Some(Range::from_mm(fitting.unwrap_or(nearest)));
            known = known.with(sector);
        }
        (ring, known)
    }

    /// The sectors of such a ring that were looked at from here, within
    /// [`here_mm`](PointLimits::here_mm).
    #[must_use]
    pub fn seen_from_here<const SECTORS: usize>(&self, limits: &PointLimits) -> Mask {
        let here = self
            .points
            .iter()
            .filter(|point| point.is_from_here(limits));
        let views = here.map(|point| sectors_at::<SECTORS>(point.at.bearing()));
        views.fold(Mask::NONE, with_views)
    }
}

/// Whether what is at a place was heard in the direction in which it is now, to within 30°.
fn is_heard_alike(seen_from: Displacement, at: Displacement) -> bool {
    seen_from.squared_mm2() <= at.squared_mm2() / 4
}

/// As [`PointMemory::carve`].
// One copy in the program, for memories of any size.
#[inline(never)]
fn carve(points: &mut VecView<Point>, free: &FreeBeam) {
    points.retain_mut(|point| {
        let Point { at, seen_from, .. } = *point;
        let tells = || !free.is_silent || is_heard_alike(seen_from, at);
        point.arc.carve(at, free, tells)
    });
}

impl Point {
    /// Heard from here.
    const fn new(at: Displacement, traveled_mm: u16, arc: Arc) -> Self {
        Self {
            at,
            seen_from: Displacement::ZERO,
            traveled: Travel::to(traveled_mm),
            arc,
        }
    }

    /// Something is there; otherwise this is how far a sensor saw free space.
    fn is_echo(&self) -> bool {
        self.arc.is_echo()
    }

    /// Where its echo came from, as far as beams have told since. A point heard from here stays on
    /// its beam's axis: so it tells what a ring would hear here.
    fn place(&self, limits: &PointLimits) -> Displacement {
        if self.is_from_here(limits) {
            self.at
        } else {
            self.at.plus(self.arc.place_left())
        }
    }

    fn is_from_here(&self, limits: &PointLimits) -> bool {
        let here_mm = u32::from(limits.here_mm) + 1;
        self.seen_from.is_shorter_than(here_mm)
    }

    /// Whether an echo that came from `at` tells its sector's range: it was seen from here, or is
    /// near and was.
    fn tells(&self, limits: &PointLimits, at: Displacement) -> bool {
        let near_mm = u32::from(limits.near_mm.saturating_add(limits.face_radius_mm));
        self.is_from_here(limits)
            || (at.is_shorter_than(near_mm) && at.minus(self.seen_from).is_shorter_than(near_mm))
    }
}

/// A point this near to where its echo was heard was heard at this place, millimeters.
const AT_THIS_PLACE_MM: u32 = 20;

#[cfg(test)]
mod tests;
