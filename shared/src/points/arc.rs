//! Carving by cones: an echo tells how far something is, not where in the beam's cone. Later beams
//! show parts of that arc free, until nothing is left.

use crate::disc::until_contact;
use crate::units::{Direction, Displacement};

/// Steps of an arc are kept in units of so many millimeters: 256 points have to fit.
const UNIT_MM: i32 = 4;
/// The places of an arc in steps from the beam's axis.
const PLACES: [i8; 5] = [-2, -1, 0, 1, 2];
/// The place on the axis.
const ON_AXIS: u8 = 1 << (PLACES.len() / 2);
/// All places are free.
const ALL_FREE: u8 = (1 << PLACES.len()) - 1;
/// Nothing returned an echo there.
const NO_ECHO: u8 = 1 << 7;
/// A first beam has shown a part of it free, and may have been wrong.
const CONTRADICTED: u8 = 1 << 6;

/// Five places across a beam's cone, along a line at right angles to its axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Arc {
    /// From one place to the next on its left, in units.
    step: (i8, i8),
    /// Places that beams have shown free, a bit for each, and [`CONTRADICTED`] and [`NO_ECHO`].
    marks: u8,
}

impl Arc {
    /// Nothing returned an echo: a sensor saw free space as far as the axis.
    pub(super) const NOTHING: Self = Self {
        step: (0, 0),
        marks: NO_ECHO,
    };

    /// Places `step_mm` apart across `axis`.
    pub(super) fn new(axis: Direction, step_mm: i32) -> Self {
        let (x, y) = axis.times(step_mm);
        let units = |mm: i32| {
            let units = crate::units::div_round(mm, UNIT_MM);
            units.clamp(-i32::from(i8::MAX), i8::MAX.into()) as i8
        };
        Self {
            step: (units(-y), units(x)),
            marks: 0,
        }
    }

    /// Whether something returned an echo.
    pub(super) const fn is_echo(&self) -> bool {
        self.marks & NO_ECHO == 0
    }

    /// Whether its places stand about its axis as those of another arc do, to within 64 mm.
    pub(super) fn is_similar(&self, other: &Self) -> bool {
        let apart = |a: i8, b: i8| (i32::from(a) - i32::from(b)).abs();
        apart(self.step.0, other.step.0) + apart(self.step.1, other.step.1) <= 8
    }

    /// Something has returned an echo again: it may be at any place.
    pub(super) const fn confirm(&mut self) {
        self.marks = 0;
    }

    /// The place nearest to the axis that no beam has shown free, from the axis.
    pub(super) fn place_left(&self) -> Displacement {
        let left = PLACES.into_iter().enumerate();
        let left = left.filter(|(bit, _)| self.marks & (1 << bit) == 0);
        let places = left.map(|(_, place)| place);
        let place = places.min_by_key(|place| place.abs()).unwrap_or(0);
        // At most 2 times 127 units.
        let mm = |units: i8| (i32::from(place) * i32::from(units) * UNIT_MM) as i16;
        Displacement {
            dx_mm: mm(self.step.0),
            dy_mm: mm(self.step.1),
        }
    }

    /// Takes the places away that a beam has shown free; `axis` is where the arc's axis is, from
    /// the robot. `tells`: whether the beam tells of this arc. Returns whether any place is left.
    // Inlined, and the rare part not: a body's echo is over its budget of instructions otherwise.
    #[inline]
    pub(super) fn carve(
        &mut self,
        axis: Displacement,
        beam: &FreeBeam,
        tells: impl FnOnce() -> bool,
    ) -> bool {
        let offset = axis.minus(beam.face);
        let from_face = beam
            .axis
            .components(offset.dx_mm.into(), offset.dy_mm.into());
        !self.is_reached(from_face, beam) || !tells() || self.carve_places(from_face, beam)
    }

    /// Distance until a disc that goes along `way` touches a place that no beam has shown free, at
    /// most `limit`; `axis` is where the arc's axis is, from the disc's center. `until` tells the
    /// distance for one place, as [`until_contact`](crate::disc::until_contact) does.
    pub(super) fn until_contact(
        &self,
        axis: Displacement,
        way: Direction,
        radius_mm: i32,
        limit: i32,
        until: impl Fn((i32, i32), i32, i32) -> i32,
    ) -> i32 {
        let (along, aside) = way.components(axis.dx_mm.into(), axis.dy_mm.into());
        if !self.is_in_way((along, aside), radius_mm, limit) {
            return limit;
        }
        let (x, y) = (i32::from(self.step.0), i32::from(self.step.1));
        let (step_along, step_aside) = way.components(x * UNIT_MM, y * UNIT_MM);
        let left = PLACES.into_iter().enumerate();
        let left = left.filter(|(bit, _)| self.marks & (1 << bit) == 0);
        left.fold(limit, |limit, (_, place)| {
            let place = i32::from(place);
            let at = (along + place * step_along, aside + place * step_aside);
            until(at, radius_mm, limit)
        })
    }

    /// As [`until_contact`](Self::until_contact), with the place that is likely alone.
    pub(super) fn until_likely_contact(
        &self,
        axis: Displacement,
        way: Direction,
        radius_mm: i32,
        limit: i32,
    ) -> i32 {
        let (along, aside) = way.components(axis.dx_mm.into(), axis.dy_mm.into());
        if !self.is_in_way((along, aside), radius_mm, limit) {
            return limit;
        }
        // No beam saw past most of them.
        if self.marks & ON_AXIS == 0 {
            return until_contact((along, aside), radius_mm, limit);
        }
        let Displacement { dx_mm, dy_mm } = self.place_left();
        let (more_along, more_aside) = way.components(dx_mm.into(), dy_mm.into());
        until_contact((along + more_along, aside + more_aside), radius_mm, limit)
    }

    /// Whether a disc may touch any place, by where the arc's axis is along the way and aside of
    /// it. A quick test, or decisions are over their budget: most arcs are behind, beside the way
    /// or beyond.
    fn is_in_way(&self, (along, aside): (i32, i32), radius_mm: i32, limit: i32) -> bool {
        let reach = self.reach_mm();
        along + reach > 0 && aside.abs() - reach < radius_mm && along - reach - limit < radius_mm
    }

    /// No place is farther from the arc's axis than this, along any direction.
    fn reach_mm(&self) -> i32 {
        2 * UNIT_MM * (i32::from(self.step.0).abs() + i32::from(self.step.1).abs())
    }

    /// Whether a beam may show any place free, by where the arc's axis is along the beam and aside
    /// of it. Most arcs are behind the sensor, beyond the echo or beside the cone.
    fn is_reached(&self, (along, aside): (i32, i32), beam: &FreeBeam) -> bool {
        let reach = self.reach_mm();
        let nearest = (along + reach, aside.abs() - reach);
        along - reach < beam.length_mm && beam.is_in_cone(nearest)
    }

    /// Takes the places away one by one.
    #[inline(never)]
    pub(super) fn carve_places(&mut self, (along, aside): (i32, i32), beam: &FreeBeam) -> bool {
        let (x, y) = (i32::from(self.step.0), i32::from(self.step.1));
        let (step_along, step_aside) = beam.axis.components(x * UNIT_MM, y * UNIT_MM);
        let before = self.marks;
        for (bit, place) in PLACES.into_iter().enumerate() {
            let place = i32::from(place);
            let along = along + place * step_along;
            let aside = (aside + place * step_aside).abs();
            if along < beam.length_mm && beam.is_in_cone((along, aside)) {
                self.marks |= 1 << bit;
            }
        }
        if beam.may_be_stray && self.marks != before && before & CONTRADICTED == 0 {
            self.marks = before | CONTRADICTED;
        }
        self.marks & ALL_FREE != ALL_FREE
    }
}

/// A beam, from the robot's center in the frame of the start.
#[derive(Clone, Copy)]
pub(crate) struct Ray {
    pub(super) face: Displacement,
    pub(super) axis: Direction,
    pub(super) range_mm: i32,
}

impl Ray {
    /// The same with another range, millimeters.
    pub(crate) fn with_range(self, range_mm: u16) -> Self {
        Self {
            range_mm: range_mm.into(),
            ..self
        }
    }

    /// Where its axis is so far from the face.
    pub(super) fn at(&self, distance_mm: i32) -> Displacement {
        let (x_mm, y_mm) = self.axis.times(distance_mm);
        self.face.plus(Displacement::saturating(x_mm, y_mm))
    }

    /// The part of its cone that it shows free.
    pub(super) const fn free(&self, half_cone: Direction, length_mm: i32) -> FreeBeam {
        FreeBeam {
            face: self.face,
            axis: self.axis,
            half_cone,
            length_mm,
            may_be_stray: false,
            is_silent: false,
        }
    }
}

/// The part of a beam's cone that is known to be free.
pub(super) struct FreeBeam {
    /// Where the sensor stands, from the robot's center.
    pub(super) face: Displacement,
    pub(super) axis: Direction,
    /// Half the opening of the cone.
    pub(super) half_cone: Direction,
    pub(super) length_mm: i32,
    /// Its echo may be a stray one: of each arc the first such beam frees nothing.
    pub(super) may_be_stray: bool,
    /// Nothing was heard: see [`hear_nothing`](super::PointMemory::hear_nothing).
    pub(super) is_silent: bool,
}

impl FreeBeam {
    /// Whether a place is within the cone's opening, by its distances along the axis and aside of
    /// it.
    fn is_in_cone(&self, (along, aside): (i32, i32)) -> bool {
        self.half_cone.components(along, aside).1 < 0
    }
}
