//! Fixed-point arithmetic: the number format of the maps and the few functions it needs.
//!
//! | type | bits | range | resolution | used for |
//! |---|---|---|---|---|
//! | [`Weight`] | I3F13 | −4 … 4 | 2⁻¹³ = 0.000122 | situations, changes of situation, probes |
//! | [`Weight32`] | I3F29 | −4 … 4 | 2⁻²⁹ = 1.9·10⁻⁹ | code vectors |
//! | [`Gain`] | Q30 | 0 … 1 | 2⁻³⁰ | learning rates, neighborhood values |
//! | Q16 `u32` | 16.16 | 0 … 65 536 | 2⁻¹⁶ | schedule values, exponents |
//!
//! A code vector's components are 16-bit weights with 16 more bits below: searches read the upper half, learning moves the
//! whole. Without the lower half, learning would lose every change below half a unit (with a rate of 1 % a component stops
//! 50 units short of what it is taught), and a map would part from the same map in floats.
//!
//! Values in the maps stay within [−1, 1]; then a product of two weights is at most 2²⁶ and the sum of 31 of them fits an
//! `i32`: [`dot`] adds blocks of 16 products in 32 bits, which compilers turn into paired multiply–adds, and only the
//! block sums in 64 bits. This is the only module with bit tricks; nothing here can panic, and every operation that could
//! overflow says what it does instead.

use serde::{Deserialize, Serialize};

/// A component of a situation or a change of situation: I3F13, 1.0 = 8192.
pub type Weight = ::fixed::types::I3F13;

/// A component of a code vector: I3F29, 1.0 = 2²⁹. Its upper half is the [`Weight`] below it.
pub type Weight32 = ::fixed::types::I3F29;

/// 1.0 as raw bits of a [`Weight32`].
pub const FINE_ONE_BITS: i32 = 1 << 29;

/// The weight at or next below a component: its upper 16 bits.
#[inline]
#[must_use]
pub const fn to_weight16(component: Weight32) -> Weight {
    Weight::from_bits((component.to_bits() >> 16) as i16)
}

/// 1.0 as raw bits of a [`Weight`].
pub const ONE_BITS: i16 = 1 << 13;

/// The weight made of `bits`/8192, clamped to [−1, 1].
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

/// A fraction in [0, 1] with 30 bits behind the point: learning rates and neighborhood values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Gain(i32);

impl Gain {
    /// 0: nothing moves.
    pub const ZERO: Self = Self(0);
    /// 1: the code vector becomes the probe.
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

    /// The gain of a Q16 value (65536 = 1.0), clamped to 1.
    #[must_use]
    pub const fn from_q16(value: u32) -> Self {
        Self::from_bits(value.saturating_mul(1 << 14))
    }

    /// Raw bits, 2³⁰ = 1.0.
    #[must_use]
    pub const fn to_bits(self) -> u32 {
        self.0 as u32
    }

    /// A gain below 1/2 in units of 2⁻³².
    #[must_use]
    pub(crate) const fn to_q32(self) -> i32 {
        self.0 << 2
    }

    /// The gain of [`to_q32`](Self::to_q32).
    #[must_use]
    pub(crate) const fn from_q32(bits: i32) -> Self {
        Self(bits >> 2)
    }

    /// Whether it is below 1/2.
    #[must_use]
    pub(crate) const fn is_below_half(self) -> bool {
        self.0 < 1 << 29
    }

    /// Product of two gains, rounded to nearest.
    #[must_use]
    pub const fn times(self, other: Self) -> Self {
        Self(((self.0 as i64 * other.0 as i64 + (1 << 29)) >> 30) as i32)
    }
}

/// `from` moved towards `to` by the fraction `gain`, rounded down to 2⁻²⁹. Stays between the two while both lie in [−1, 1];
/// gain 0 and 1 are exact.
#[inline]
#[must_use]
pub const fn approach(from: Weight32, to: Weight32, gain: Gain) -> Weight32 {
    // Values of the maps (|w| <= 1) differ by at most 2³⁰.
    let difference = to.to_bits().wrapping_sub(from.to_bits());
    // The step is the upper half of difference · 4 gain, one instruction on the chip. From 1/2 on, 4 gain leaves 31 bits
    // and wraps to 4 gain − 2³², which lacks just one difference: the way begins at its other end instead.
    let step = (difference as i64 * (gain.0 << 2) as i64) >> 32;
    let begin = if gain.0 < 1 << 29 { from } else { to };
    Weight32::from_bits(begin.to_bits().wrapping_add(step as i32))
}

/// [`approach`] by a gain below 1/2.
#[inline]
#[must_use]
pub(crate) const fn approach_slowly(from: Weight32, to: Weight32, gain: Gain) -> Weight32 {
    let difference = to.to_bits().wrapping_sub(from.to_bits());
    let step = (difference as i64 * (gain.0 << 2) as i64) >> 32;
    Weight32::from_bits(from.to_bits().wrapping_add(step as i32))
}

/// The upper half of a product of 64 bits, rounded down: one instruction on the chip, addition included.
#[inline]
pub(crate) const fn high_product(a: i32, b: i32) -> i32 {
    ((a as i64 * b as i64) >> 32) as i32
}

/// Products summed in 32 bits before they are widened: 16 · 2²⁶ = 2³⁰.
const BLOCK: usize = 16;

/// A component of a vector, in either precision.
pub trait Scalar: Copy {
    /// The 16-bit value at or next below it.
    fn to_weight16(self) -> Weight;
    /// Its value in full precision.
    fn to_weight32(self) -> Weight32;
}

impl Scalar for Weight {
    #[inline]
    fn to_weight16(self) -> Weight {
        self
    }

    #[inline]
    fn to_weight32(self) -> Weight32 {
        Weight32::from_bits(i32::from(self.to_bits()) << 16)
    }
}

impl Scalar for Weight32 {
    #[inline]
    fn to_weight16(self) -> Weight {
        to_weight16(self)
    }

    #[inline]
    fn to_weight32(self) -> Weight32 {
        self
    }
}

/// Sum of products of the 16-bit values of two vectors in units of 2⁻²⁶; exact while components lie in [−1, 1]. The
/// shorter one decides.
#[inline]
#[must_use]
pub fn dot<A: Scalar, B: Scalar>(a: &[A], b: &[B]) -> i64 {
    let shorter = a.len().min(b.len());
    let (a, b) = (a.get(..shorter).unwrap_or(a), b.get(..shorter).unwrap_or(b));
    let (blocks_a, rest_a) = a.as_chunks::<BLOCK>();
    let (blocks_b, rest_b) = b.as_chunks::<BLOCK>();
    let mut total = i64::from(block_dot(rest_a, rest_b));
    for (block_a, block_b) in blocks_a.iter().zip(blocks_b) {
        total = total.wrapping_add(i64::from(block_dot(block_a, block_b)));
    }
    total
}

/// The same of at most 31 components.
#[inline]
pub(crate) fn block_dot<A: Scalar, B: Scalar>(a: &[A], b: &[B]) -> i32 {
    let mut sum = 0_i32;
    for (x, y) in a.iter().zip(b) {
        let (x, y) = (x.to_weight16().to_bits(), y.to_weight16().to_bits());
        sum = sum.wrapping_add(i32::from(x).wrapping_mul(i32::from(y)));
    }
    sum
}

/// Squared Euclidean length in units of 2⁻²⁶; exact while components lie in [−1, 1].
#[inline]
#[must_use]
pub fn squared_norm<A: Scalar>(a: &[A]) -> i64 {
    dot(a, a)
}

/// Squared Euclidean distance over the components that `mask` believes, in units of 2⁻⁵⁰. Differences are rounded down
/// to 2⁻²⁵; up to 4096 components in [−1, 1] cannot overflow.
#[inline]
#[must_use]
pub fn squared_distance<A: Scalar, B: Scalar>(a: &[A], b: &[B], mask: Mask) -> u64 {
    let squared = |x: A, y: B| {
        let difference = i64::from(
            x.to_weight32()
                .to_bits()
                .wrapping_sub(y.to_weight32().to_bits())
                >> 4,
        );
        difference * difference
    };
    let pairs = a.iter().zip(b).map(|(x, y)| squared(*x, *y));
    let total = if mask.covers(a.len()) {
        pairs.fold(0, i64::wrapping_add)
    } else {
        let believed = pairs.enumerate().filter(|(index, _)| mask.contains(*index));
        believed
            .map(|(_, square)| square)
            .fold(0, i64::wrapping_add)
    };
    total.unsigned_abs()
}

/// Which components count: bit `i` for component `i`; components from 32 on always count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mask(u32);

impl Mask {
    /// Every component counts.
    pub const ALL: Self = Self(u32::MAX);

    /// None of the first 32 components counts.
    pub const NONE: Self = Self(0);

    /// The mask with these raw bits.
    #[must_use]
    pub const fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// Raw bits.
    #[must_use]
    pub const fn to_bits(self) -> u32 {
        self.0
    }

    /// Whether component `index` counts.
    #[must_use]
    pub const fn contains(self, index: usize) -> bool {
        index >= 32 || self.0 & (1 << index) != 0
    }

    /// Whether each of the first `dims` components counts.
    #[must_use]
    pub const fn covers(self, dims: usize) -> bool {
        let low = if dims >= 32 {
            u32::MAX
        } else {
            (1 << dims) - 1
        };
        self.0 & low == low
    }

    /// The first `count` components, at most 32, that count, in order.
    pub(crate) fn indices(self, count: usize) -> impl Iterator<Item = usize> {
        let low = if count >= 32 {
            u32::MAX
        } else {
            (1 << count) - 1
        };
        let mut left = self.0 & low;
        core::iter::from_fn(move || {
            let first = left.trailing_zeros();
            (left != 0).then(|| {
                left &= left.wrapping_sub(1);
                first as usize
            })
        })
    }

    /// This mask without component `index`.
    #[must_use]
    pub const fn without(self, index: usize) -> Self {
        if index < 32 {
            Self(self.0 & !(1 << index))
        } else {
            self
        }
    }

    /// This mask with component `index`.
    #[must_use]
    pub const fn with(self, index: usize) -> Self {
        if index < 32 {
            Self(self.0 | (1 << index))
        } else {
            self
        }
    }

    /// The components that count in both.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

/// Integer square root, rounded down.
///
/// ```
/// # use amp::fixed::isqrt;
/// assert_eq!(isqrt(99), 9);
/// assert_eq!(isqrt(100), 10);
/// assert_eq!(isqrt(u64::MAX), u32::MAX);
/// ```
#[must_use]
pub const fn isqrt(value: u64) -> u32 {
    if value <= u32::MAX as u64 {
        isqrt_u32(value as u32)
    } else {
        value.isqrt() as u32
    }
}

/// Heron's iteration from above: with a division in one instruction three times as fast on the chip as the digit by digit
/// root of `core`.
#[inline(never)]
pub(crate) const fn isqrt_u32(value: u32) -> u32 {
    if value < 2 {
        return value;
    }
    // A power of two not below the root.
    let mut root = 1 << (32 - value.leading_zeros()).div_ceil(2);
    while let Some(quotient) = value.checked_div(root) {
        let next = root.wrapping_add(quotient) >> 1;
        if next >= root {
            break;
        }
        root = next;
    }
    root
}

/// `numerator / denominator` rounded to nearest, halves away from zero; 0 for a denominator of 0.
///
/// ```
/// # use amp::fixed::div_round;
/// assert_eq!(div_round(7, 2), 4);
/// assert_eq!(div_round(-7, 2), -4);
/// ```
#[must_use]
pub const fn div_round(numerator: i32, denominator: i32) -> i32 {
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

/// `numerator / denominator` rounded towards 0; 0 for a denominator of 0. What fits is divided in 32 bits, which is one
/// instruction on the chip and 64 bits are some 50.
#[must_use]
pub(crate) fn quotient(numerator: i64, denominator: i64) -> i64 {
    let small = (i32::try_from(numerator), i32::try_from(denominator));
    if let (Ok(numerator), Ok(denominator)) = small
        && let Some(quotient) = numerator.checked_div(denominator)
    {
        return i64::from(quotient);
    }
    numerator.checked_div(denominator).unwrap_or(0)
}

/// 2^(−i/64) in Q31 for i = 0 … 64.
const EXP2_TABLE: [u32; 65] = {
    let mut table = [0_u32; 65];
    let mut value = 2_147_483_648.0_f64;
    let mut i = 0;
    while i < 65 {
        table[i] = (value + 0.5) as u32;
        // 2^(−1/64)
        value *= 0.989_228_013_193_975_5;
        i += 1;
    }
    table
};

/// 2^(−x) for x in Q16, as Q31 (2³¹ = 1.0); relative error at most 2·10⁻⁵ (table of 64, linear in
/// between) beside the rounding to 2⁻³¹.
#[must_use]
pub const fn exp2_neg(x_q16: u32) -> u32 {
    let octaves = x_q16 >> 16;
    if octaves > 31 {
        return 0;
    }
    let fraction = x_q16 & 0xffff;
    let index = (fraction >> 10) as usize;
    let rest = (fraction & 0x3ff) as u64;
    let (high, low) = (EXP2_TABLE[index], EXP2_TABLE[index + 1]);
    (high - (((high - low) as u64 * rest) >> 10) as u32) >> octaves
}

/// log₂ e in Q16.
const LOG2_E_Q16: u64 = 94_548;

/// e^(−x) for x in Q16, as Q31 (2³¹ = 1.0); absolute error at most 3·10⁻⁵.
#[must_use]
pub const fn exp_neg(x_q16: u32) -> u32 {
    let x = (x_q16 as u64 * LOG2_E_Q16) >> 16;
    exp2_neg(if x > u32::MAX as u64 {
        u32::MAX
    } else {
        x as u32
    })
}

/// log₂(`numerator`/`denominator`) in Q16, rounded down to 2⁻¹⁶; 0 where the ratio is below 1 or not a number.
#[must_use]
pub const fn log2_ratio(numerator: u32, denominator: u32) -> u32 {
    if denominator == 0 || numerator <= denominator {
        return 0;
    }
    // The ratio in Q31 between 1 and 2, then one bit of the logarithm per squaring.
    let ratio = ((numerator as u64) << 31) / denominator as u64;
    let octaves = 63 - ratio.leading_zeros() - 31;
    let mut mantissa = ratio >> octaves;
    let mut log = octaves;
    let mut bit = 0;
    while bit < 16 {
        mantissa = (mantissa * mantissa) >> 31;
        log <<= 1;
        if mantissa >= 1 << 32 {
            mantissa >>= 1;
            log |= 1;
        }
        bit += 1;
    }
    log
}

#[cfg(test)]
mod tests;
