//! Vectors of weights: products, distances, and a step from one towards another.
//!
//! Components lie in [−1, 1]. So a product is at most 2²⁶ in units of 2⁻²⁶, and a sum of 31
//! products fits an `i32`.

use super::{Gain, Mask, Weight, Weight32, to_weight16};

/// A component of a vector, in 16 or 32 bits.
pub trait Scalar: Copy {
    /// Its value rounded down to 16 bits.
    fn to_weight16(self) -> Weight;
    /// Its value in 32 bits.
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

/// `from` moved towards `to` by the fraction `gain`, rounded down to 2⁻²⁹.
///
/// The result lies between the two if both lie in [−1, 1]; gains 0 and 1 are exact.
#[inline]
#[must_use]
pub const fn approach(from: Weight32, to: Weight32, gain: Gain) -> Weight32 {
    // Values in [−1, 1] differ by at most 2³⁰.
    let difference = to.to_bits().wrapping_sub(from.to_bits());
    // The step is the upper half of difference · 4 gain. For gains of 1/2 or more, 4 gain wraps to
    // 4 gain − 2³², so the step is too small by one difference. Starting at `to` adds it.
    let step = high_product(difference, gain.to_q32());
    let start = if gain.is_below_half() { from } else { to };
    Weight32::from_bits(start.to_bits().wrapping_add(step))
}

/// Upper 32 bits of the 64-bit product, rounded down.
#[inline]
pub(crate) const fn high_product(a: i32, b: i32) -> i32 {
    ((a as i64 * b as i64) >> 32) as i32
}

/// Number of products summed in 32 bits before widening; their sum is at most 16 · 2²⁶ = 2³⁰. The
/// compiler turns such a block into paired multiply–adds.
const BLOCK: usize = 16;

/// Dot product of the 16-bit values of two vectors, in units of 2⁻²⁶. Components beyond the shorter
/// vector are ignored.
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

#[inline]
fn block_dot<A: Scalar, B: Scalar>(a: &[A], b: &[B]) -> i32 {
    let mut sum = 0_i32;
    for (x, y) in a.iter().zip(b) {
        let (x, y) = (x.to_weight16().to_bits(), y.to_weight16().to_bits());
        sum = sum.wrapping_add(i32::from(x).wrapping_mul(i32::from(y)));
    }
    sum
}

/// Squared Euclidean length of the 16-bit values, in units of 2⁻²⁶.
#[inline]
#[must_use]
pub fn squared_norm<A: Scalar>(a: &[A]) -> i64 {
    dot(a, a)
}

/// Squared Euclidean distance over the components in `mask`, in units of 2⁻⁵⁰.
///
/// Differences are rounded down to 2⁻²⁵; up to 4095 components in [−1, 1] cannot overflow.
#[inline]
#[must_use]
pub fn squared_distance<A: Scalar, B: Scalar>(a: &[A], b: &[B], mask: Mask) -> u64 {
    let squares = a.iter().zip(b).map(|(x, y)| squared_difference(*x, *y));
    if mask.covers(a.len()) {
        return squares.fold(0, u64::wrapping_add);
    }
    let selected = squares
        .enumerate()
        .filter(|(index, _)| mask.contains(*index));
    selected
        .map(|(_, square)| square)
        .fold(0, u64::wrapping_add)
}

#[inline]
fn squared_difference<A: Scalar, B: Scalar>(x: A, y: B) -> u64 {
    let (x, y) = (x.to_weight32().to_bits(), y.to_weight32().to_bits());
    let difference = i64::from(x.wrapping_sub(y) >> 4);
    difference.wrapping_mul(difference) as u64
}
