//! Number formats of the maps, and the arithmetic on them.
//!
//! Nothing here panics. The documentation of each operation that may overflow defines the result.

mod functions;
mod mask;
mod vectors;

pub use functions::{exp_neg, exp2_neg, isqrt, isqrt_u32, log2_ratio, quotient};
pub use mask::{Mask, Selection, WideMask};
pub use vectors::{Scalar, approach, dot, squared_distance, squared_norm};

pub(crate) use vectors::high_product;

/// A component of a sample: I3F13, 1.0 = 8192, resolution 2⁻¹³ = 0.000122.
pub type Weight = ::fixed::types::I3F13;

/// A component of a code vector: I3F29, 1.0 = 2²⁹. Its upper 16 bits are the value rounded down to
/// a [`Weight`].
///
/// Training needs the lower 16 bits: with 16 bits, every change below 2⁻¹⁴ is lost. At a learning
/// rate of 1 % a component would stop 50 units of 2⁻¹³ before its samples.
pub type Weight32 = ::fixed::types::I3F29;

/// 1.0 as raw bits of a [`Weight`].
pub const ONE_BITS: i16 = 1 << 13;

/// 1.0 as raw bits of a [`Weight32`].
pub const FINE_ONE_BITS: i32 = 1 << 29;

/// A component rounded down to a [`Weight`]: its upper 16 bits.
#[inline]
#[must_use]
pub const fn to_weight16(component: Weight32) -> Weight {
    Weight::from_bits((component.to_bits() >> 16) as i16)
}

/// The weight of `bits`/8192, clamped to [−1, 1].
#[must_use]
pub const fn unit_weight(bits: i32) -> Weight {
    let one = ONE_BITS as i32;
    let clamped = if bits > one {
        one
    } else if bits < -one {
        -one
    } else {
        bits
    };
    Weight::from_bits(clamped as i16)
}

/// A component clamped to [−1, 1].
#[must_use]
pub(crate) fn unit_weight32(component: Weight32) -> Weight32 {
    Weight32::from_bits(component.to_bits().clamp(-FINE_ONE_BITS, FINE_ONE_BITS))
}

/// `value` in Q16 (65 536 = 1.0), rounded to nearest; 0 for a negative value, saturated above.
#[must_use]
pub const fn q16(value: f32) -> u32 {
    (value * 65_536.0 + 0.5) as u32
}

/// A fraction in [0, 1] with 30 fractional bits: learning rates and neighborhood values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Gain(i32);

impl Gain {
    /// 0: no change.
    pub const ZERO: Self = Self(0);
    /// 1: the code vector becomes the sample.
    pub const ONE: Self = Self(1 << 30);

    /// The gain of `bits`/2³⁰, clamped to 1.
    #[must_use]
    pub const fn from_bits(bits: u32) -> Self {
        if bits > 1 << 30 {
            Self::ONE
        } else {
            Self(bits as i32)
        }
    }

    /// The gain of a Q16 value (65 536 = 1.0), clamped to 1.
    #[must_use]
    pub const fn from_q16(value: u32) -> Self {
        Self::from_bits(value.saturating_mul(1 << 14))
    }

    /// Raw bits, 2³⁰ = 1.0.
    #[must_use]
    pub const fn to_bits(self) -> u32 {
        self.0 as u32
    }

    /// Product of two gains, rounded to nearest.
    #[must_use]
    pub const fn times(self, other: Self) -> Self {
        Self(((self.0 as i64 * other.0 as i64 + (1 << 29)) >> 30) as i32)
    }

    /// Whether it is below 1/2, so that it fits [`to_q32`](Self::to_q32).
    #[must_use]
    pub(crate) const fn is_below_half(self) -> bool {
        self.0 < 1 << 29
    }

    /// A gain below 1/2 in units of 2⁻³².
    #[must_use]
    pub(crate) const fn to_q32(self) -> i32 {
        self.0 << 2
    }
}

#[cfg(test)]
mod tests;
