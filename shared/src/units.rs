//! Physical quantities: millimeters, milliseconds, binary turns.
//!
//! Each is a newtype with a private field, so that a range cannot be taken for a time; raw integers
//! appear only on the wire and in drivers, always with a unit suffix.
//!
//! The few floats are micromath's, called by path: with the standard library linked (as in tests) a
//! method call would silently become the C library's, and the chip and the host would differ.

use core::cmp::Ordering;
use core::num::NonZeroU16;
use micromath::F32Ext;
use serde::{Deserialize, Serialize};

/// Distance from a transducer's face to what it hears, 0 … 65.534 m in millimeters.
///
/// Kept as what it lacks of 65.535 m, so that an `Option` of it takes two bytes as well.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Range(NonZeroU16);

impl Range {
    /// A range of `mm` millimeters, at most 65 534.
    #[must_use]
    pub const fn from_mm(mm: u16) -> Self {
        match NonZeroU16::new(!mm) {
            Some(nearness) => Self(nearness),
            None => Self(NonZeroU16::MIN),
        }
    }

    /// Millimeters.
    #[must_use]
    pub const fn as_mm(self) -> u16 {
        !self.0.get()
    }
}

impl Ord for Range {
    fn cmp(&self, other: &Self) -> Ordering {
        other.0.cmp(&self.0)
    }
}

impl PartialOrd for Range {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// A moment in milliseconds since the robot's start; wraps after 49.7 days.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Millis(u32);

impl Millis {
    /// The moment `ms` milliseconds after the start.
    #[must_use]
    pub const fn from_ms(ms: u32) -> Self {
        Self(ms)
    }

    /// Milliseconds since the start.
    #[must_use]
    pub const fn as_ms(self) -> u32 {
        self.0
    }

    /// Milliseconds from `earlier` to here; right across the wrap while the two are less than 49.7
    /// days apart.
    #[must_use]
    pub const fn since(self, earlier: Self) -> u32 {
        self.0.wrapping_sub(earlier.0)
    }

    /// Milliseconds since `earlier`; 0 if that is the later of the two.
    #[must_use]
    pub const fn after(self, earlier: Self) -> u32 {
        if self.is_before(earlier) {
            0
        } else {
            self.since(earlier)
        }
    }

    /// Whether this moment comes before `other`; right across the wrap while the two are less than
    /// 24.8 days apart.
    #[must_use]
    pub const fn is_before(self, other: Self) -> bool {
        (self.0.wrapping_sub(other.0) as i32) < 0
    }

    /// The moment `ms` milliseconds before this one.
    #[must_use]
    pub const fn minus_ms(self, ms: u32) -> Self {
        Self(self.0.wrapping_sub(ms))
    }

    /// The moment `ms` milliseconds after this one.
    #[must_use]
    pub(crate) const fn plus_ms(self, ms: u32) -> Self {
        Self(self.0.wrapping_add(ms))
    }
}

/// A direction as a binary turn: 65 536 units are one full turn, counter-clockwise from the frame's
/// x axis; wraps for free.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Bearing(u16);

impl Bearing {
    /// Straight along the x axis.
    pub const ZERO: Self = Self(0);

    /// The bearing of `turns`/65 536 of a full turn.
    #[must_use]
    pub const fn from_turns(turns: u16) -> Self {
        Self(turns)
    }

    /// The bearing of place `index` of `count` evenly spaced ones, rounded down.
    #[must_use]
    pub const fn of_place(index: usize, count: usize) -> Self {
        match ((index as u64) << 16).checked_div(count as u64) {
            Some(turns) => Self(turns as u16),
            None => Self::ZERO,
        }
    }

    /// Units of 1/65 536 turn.
    #[must_use]
    pub const fn as_turns(self) -> u16 {
        self.0
    }

    /// Units of 1/65 536 turn, −32 768 … 32 767.
    #[must_use]
    pub const fn as_signed_turns(self) -> i16 {
        self.0 as i16
    }

    /// Sum of two bearings.
    #[must_use]
    pub const fn plus(self, other: Self) -> Self {
        Self(self.0.wrapping_add(other.0))
    }

    /// Difference of two bearings.
    #[must_use]
    pub const fn minus(self, other: Self) -> Self {
        Self(self.0.wrapping_sub(other.0))
    }

    /// The unit vector in this direction; error of each component at most 0.0012 (micromath's
    /// sine).
    #[must_use]
    #[inline(never)]
    pub fn direction(self) -> Direction {
        let angle = f32::from(self.as_signed_turns()) * (core::f32::consts::PI / 32_768.0);
        Direction {
            x_q14: to_q14(F32Ext::cos(angle)),
            y_q14: to_q14(F32Ext::sin(angle)),
        }
    }
}

fn to_q14(value: f32) -> i16 {
    // Float to integer casts saturate: the sine's small overshoot beyond 1 cannot wrap.
    F32Ext::round(value * 16_384.0) as i16
}

/// A unit vector with 14 bits behind the point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Direction {
    /// Component along x, 16 384 = 1.
    pub x_q14: i16,
    /// Component along y, 16 384 = 1.
    pub y_q14: i16,
}

impl Direction {
    /// Component of a vector along this direction, in the vector's unit.
    #[must_use]
    pub fn along(self, x: i32, y: i32) -> i32 {
        (x.wrapping_mul(i32::from(self.x_q14))
            .wrapping_add(y.wrapping_mul(i32::from(self.y_q14))))
            >> 14
    }

    /// Components of a vector along this direction and to the left of it, in the vector's unit.
    #[must_use]
    pub(crate) fn components(self, x: i32, y: i32) -> (i32, i32) {
        (self.along(x, y), self.along(y, x.wrapping_neg()))
    }

    /// The same angle to the other side.
    #[must_use]
    pub const fn mirrored(self) -> Self {
        Self {
            x_q14: self.x_q14,
            y_q14: self.y_q14.saturating_neg(),
        }
    }

    /// The vector of this length in this direction.
    #[must_use]
    pub fn times(self, length: i32) -> (i32, i32) {
        let scale = |q14: i16| (length.wrapping_mul(i32::from(q14)).wrapping_add(1 << 13)) >> 14;
        (scale(self.x_q14), scale(self.y_q14))
    }

    /// A vector turned by this direction's angle.
    #[must_use]
    pub fn rotate(self, x: i32, y: i32) -> (i32, i32) {
        let (c, s) = (i32::from(self.x_q14), i32::from(self.y_q14));
        let round = |v: i32| v.wrapping_add(1 << 13) >> 14;
        (
            round(x.wrapping_mul(c).wrapping_sub(y.wrapping_mul(s))),
            round(x.wrapping_mul(s).wrapping_add(y.wrapping_mul(c))),
        )
    }
}

/// A straight move in the ring's frame: x along transducer 0, y along the one a quarter turn to its
/// left; ±32.767 m.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Displacement {
    /// Millimeters along x.
    pub dx_mm: i16,
    /// Millimeters along y.
    pub dy_mm: i16,
}

impl Displacement {
    /// No move.
    pub const ZERO: Self = Self { dx_mm: 0, dy_mm: 0 };

    /// The move by (x, y) millimeters, each saturated to 16 bits.
    #[must_use]
    #[inline]
    pub fn saturating(x_mm: i32, y_mm: i32) -> Self {
        let clamp = |v: i32| v.clamp(i32::from(i16::MIN), i32::from(i16::MAX)) as i16;
        Self {
            dx_mm: clamp(x_mm),
            dy_mm: clamp(y_mm),
        }
    }

    /// The move of `length_mm` along `bearing`.
    #[must_use]
    pub fn along(bearing: Bearing, length_mm: i32) -> Self {
        let (x, y) = bearing.direction().times(length_mm);
        Self::saturating(x, y)
    }

    /// Length in millimeters, rounded down.
    #[must_use]
    pub fn length_mm(self) -> u16 {
        crate::fixed::isqrt_u32(self.squared_mm2()) as u16
    }

    /// Whether [`length_mm`](Self::length_mm) is below this; without its root.
    pub(crate) const fn is_shorter_than(self, mm: u32) -> bool {
        self.squared_mm2() < mm.saturating_mul(mm)
    }

    /// Squared length; at most 2³¹.
    pub(crate) const fn squared_mm2(self) -> u32 {
        let (x, y) = (self.dx_mm as i32, self.dy_mm as i32);
        (x.wrapping_mul(x) as u32).wrapping_add(y.wrapping_mul(y) as u32)
    }

    /// Bearing of the move; zero for no move. Error at most 0.003 rad (micromath's arc tangent).
    #[must_use]
    #[inline(never)]
    pub fn bearing(self) -> Bearing {
        let angle = F32Ext::atan2(f32::from(self.dy_mm), f32::from(self.dx_mm));
        Bearing(F32Ext::round(angle * (32_768.0 / core::f32::consts::PI)) as i32 as u16)
    }

    /// The same direction with another length; no move stays no move.
    #[must_use]
    #[inline(never)]
    pub fn with_length(self, length_mm: u16) -> Self {
        let own = i32::from(self.length_mm());
        if own == 0 {
            return Self::ZERO;
        }
        let scale = |v: i16| div_round(i32::from(v).wrapping_mul(i32::from(length_mm)), own);
        Self::saturating(scale(self.dx_mm), scale(self.dy_mm))
    }

    /// The same direction, at most so long.
    #[must_use]
    pub fn shortened(self, most_mm: u16) -> Self {
        // Without a root where nothing is taken away.
        if self.is_shorter_than(u32::from(most_mm).wrapping_add(1)) {
            self
        } else {
            self.with_length(most_mm)
        }
    }

    /// Sum of two moves, saturated.
    #[must_use]
    pub const fn plus(self, other: Self) -> Self {
        Self {
            dx_mm: self.dx_mm.saturating_add(other.dx_mm),
            dy_mm: self.dy_mm.saturating_add(other.dy_mm),
        }
    }

    /// Difference of two moves, saturated.
    #[must_use]
    pub const fn minus(self, other: Self) -> Self {
        Self {
            dx_mm: self.dx_mm.saturating_sub(other.dx_mm),
            dy_mm: self.dy_mm.saturating_sub(other.dy_mm),
        }
    }

    /// Whether it leads more than a right angle away from where `other` leads.
    #[must_use]
    pub const fn opposes(self, other: Self) -> bool {
        // Each product has 31 bits, their sum might need 33.
        let along_x = self.dx_mm as i32 * other.dx_mm as i32;
        let along_y = self.dy_mm as i32 * other.dy_mm as i32;
        along_x < -along_y
    }

    /// The move as seen after its frame has been turned by `direction`'s angle.
    #[must_use]
    pub fn rotated(self, direction: Direction) -> Self {
        let (x, y) = direction.rotate(i32::from(self.dx_mm), i32::from(self.dy_mm));
        Self::saturating(x, y)
    }

    /// The same move turned to the left by so many right angles.
    pub(crate) const fn turned_left(self, quarters: u8) -> Self {
        let Self { dx_mm, dy_mm } = self;
        let [back_mm, right_mm] = [dx_mm.saturating_neg(), dy_mm.saturating_neg()];
        let [dx_mm, dy_mm] = match quarters % 4 {
            0 => [dx_mm, dy_mm],
            1 => [right_mm, dx_mm],
            2 => [back_mm, right_mm],
            _ => [dy_mm, back_mm],
        };
        Self { dx_mm, dy_mm }
    }
}

/// `numerator / denominator` rounded to nearest, halves away from zero; 0 for a denominator of 0.
#[must_use]
pub(crate) const fn div_round(numerator: i32, denominator: i32) -> i32 {
    if denominator == 0 {
        return 0;
    }
    let half = (denominator / 2).saturating_abs();
    let biased = if numerator < 0 {
        numerator.saturating_sub(half)
    } else {
        numerator.saturating_add(half)
    };
    biased.wrapping_div(denominator)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_leads_back_opposes() {
        let way = |dx_mm, dy_mm| Displacement { dx_mm, dy_mm };
        for (one, other, expected) in [
            (way(10, 0), way(-1, 100), true),
            (way(10, 0), way(0, 100), false),
            (way(10, 10), way(20, -19), false),
            (way(10, 10), way(19, -20), true),
            (way(i16::MIN, i16::MIN), way(i16::MIN, i16::MIN), false),
            (way(i16::MIN, i16::MIN), way(i16::MAX, i16::MAX), true),
            (Displacement::ZERO, way(1, 1), false),
        ] {
            assert_eq!(one.opposes(other), expected, "{one:?} {other:?}");
        }
    }

    #[test]
    fn what_is_nearer_is_less() {
        for mm in [0, 1, 300, 65_533] {
            let (range, next) = (Range::from_mm(mm), Range::from_mm(mm + 1));
            assert_eq!((range.as_mm(), next.as_mm()), (mm, mm + 1));
            assert!(range < next && range.min(next) == range);
        }
        assert_eq!(Range::from_mm(u16::MAX), Range::from_mm(65_534));
        assert_eq!(size_of::<Option<Range>>(), 2);
    }

    #[test]
    fn directions_match_the_exact_ones() {
        for turns in (0..=u16::MAX).step_by(97) {
            let angle = f64::from(turns) * core::f64::consts::TAU / 65_536.0;
            let direction = Bearing::from_turns(turns).direction();
            assert!((f64::from(direction.x_q14) / 16_384.0 - libm::cos(angle)).abs() < 0.0012);
            assert!((f64::from(direction.y_q14) / 16_384.0 - libm::sin(angle)).abs() < 0.0012);
        }
    }

    #[test]
    fn bearing_of_a_move_comes_back() {
        for turns in (0..=u16::MAX).step_by(1021) {
            let back = Displacement::along(Bearing::from_turns(turns), 10_000).bearing();
            let error = back.as_turns().wrapping_sub(turns) as i16;
            // 0.003 rad of the arc tangent and 0.0012 of the sine are 44 units.
            assert!(error.abs() <= 48, "{turns}: {error}");
        }
    }

    #[test]
    fn time_runs_across_the_wrap() {
        assert_eq!(Millis::from_ms(5).since(Millis::from_ms(u32::MAX - 4)), 10);
    }

    #[test]
    fn a_new_length_keeps_the_direction() {
        let moved = Displacement {
            dx_mm: 30,
            dy_mm: -40,
        }
        .with_length(250);
        assert_eq!(
            moved,
            Displacement {
                dx_mm: 150,
                dy_mm: -200
            }
        );
        assert_eq!(Displacement::ZERO.with_length(250), Displacement::ZERO);
        assert_eq!(moved.length_mm(), 250);
    }

    #[test]
    fn shorter_is_what_is_shorter_rounded_down() {
        for (dx_mm, dy_mm) in [(0, 0), (3, 4), (3, 5), (-250, 1), (i16::MIN, i16::MIN)] {
            let moved = Displacement { dx_mm, dy_mm };
            let length = u32::from(moved.length_mm());
            for limit in [0, 1, length.saturating_sub(1), length, length + 1, 65_536] {
                assert_eq!(
                    moved.is_shorter_than(limit),
                    length < limit,
                    "{moved:?} {limit}"
                );
            }
        }
    }

    #[test]
    fn halves_round_away_from_zero_and_nothing_overflows() {
        assert_eq!((div_round(7, 2), div_round(-7, 2)), (4, -4));
        assert_eq!(
            (div_round(5, -2), div_round(-5, -2), div_round(4, 3)),
            (-3, 3, 1)
        );
        assert_eq!(div_round(1, 0), 0);
        assert_eq!(
            (div_round(i32::MAX, 2), div_round(i32::MIN, 2)),
            ((1 << 30) - 1, -(1 << 30))
        );
        assert_eq!(
            (div_round(i32::MIN, -1), div_round(7, i32::MIN)),
            (i32::MIN, 0)
        );
    }
}
