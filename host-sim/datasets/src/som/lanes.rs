//! The loops of a map by vectors of 128 bits, which every x86-64 and every 64-bit ARM processor has. The results are those of
//! the portable kernels of `amp`, bit for bit.
//!
//! A vector of components in [−1, 1] is held in whole blocks of sixteen lanes; lanes without a component are 0.

use amp::fixed::{FINE_ONE_BITS, Gain, Weight32};
use wide::{i16x8, i32x4, i32x8, u32x4};

/// Components of a block: as many as have products whose sum fits 32 bits, 16 · 2²⁶ = 2³⁰.
const LANES: usize = 16;

/// The upper halves of a block's components.
pub type Upper = [i16x8; 2];

/// Blocks of a vector of `dims` components.
pub const fn blocks(dims: usize) -> usize {
    dims.div_ceil(LANES)
}

/// The upper halves of a vector's components, into its blocks.
#[inline(always)]
pub fn round_down<'a>(vector: &[Weight32], mut upper: impl Iterator<Item = &'a mut Upper>) {
    let (whole, rest) = vector.as_chunks();
    for (block, upper) in whole.iter().zip(&mut upper) {
        *upper = upper_halves(load(block));
    }
    if let Some(upper) = upper.next() {
        *upper = upper_halves(load(&padded(rest)));
    }
}

/// Sum of products of two blocks, in units of 2⁻²⁶.
#[inline(always)]
pub fn dot([a0, a1]: &Upper, [b0, b1]: &Upper) -> i64 {
    i64::from((a0.dot(*b0) + a1.dot(*b1)).reduce_add())
}

/// Moves a code vector towards the probe by `gain` and keeps its upper halves in step; returns its new squared length, in
/// units of 2⁻²⁶.
#[inline(always)]
pub fn pull<'a>(
    row: &mut [Weight32],
    mut upper: impl Iterator<Item = &'a mut Upper>,
    probe: &[Weight32],
    gain: Gain,
) -> i64 {
    let ((whole, rest), (probe, probe_rest)) = (row.as_chunks_mut(), probe.as_chunks());
    let mut norm = 0_i64;
    for ((block, probe), upper) in whole.iter_mut().zip(probe).zip(&mut upper) {
        *upper = pull_block(block, probe, gain);
        norm = norm.wrapping_add(dot(upper, upper));
    }
    if let Some(upper) = upper.next() {
        let mut block = padded(rest);
        *upper = pull_block(&mut block, &padded(probe_rest), gain);
        norm = norm.wrapping_add(dot(upper, upper));
        for (w, moved) in rest.iter_mut().zip(block) {
            *w = moved;
        }
    }
    norm
}

#[inline(always)]
fn pull_block(block: &mut [Weight32; LANES], probe: &[Weight32; LANES], gain: Gain) -> Upper {
    let (from, to) = (load(block), load(probe));
    let moved = match gain {
        Gain::ONE => to,
        _ => std::array::from_fn(|i| approach(from[i], to[i], gain)),
    };
    let bits = moved.map(i32x4::to_array);
    for (w, bits) in block.iter_mut().zip(bits.as_flattened()) {
        *w = Weight32::from_bits(*bits);
    }
    upper_halves(moved)
}

#[cold]
fn padded(components: &[Weight32]) -> [Weight32; LANES] {
    let mut block = [Weight32::ZERO; LANES];
    for (component, given) in block.iter_mut().zip(components) {
        *component = *given;
    }
    block
}

/// The components, four by four.
#[inline(always)]
fn load(block: &[Weight32; LANES]) -> [i32x4; 4] {
    let (fours, _) = block.as_chunks();
    std::array::from_fn(|i| i32x4::new(fours[i].map(Weight32::to_bits)))
}

#[inline(always)]
fn upper_halves(block: [i32x4; 4]) -> Upper {
    let [a, b, c, d] = block.map(|four| (four >> 16_i32).to_array());
    let join = |[a, b, c, d]: [i32; 4], [e, f, g, h]: [i32; 4]| {
        i16x8::from_i32x8_saturate(i32x8::new([a, b, c, d, e, f, g, h]))
    };
    [join(a, b), join(c, d)]
}

/// As `amp::fixed::approach` by a gain below 1. Baseline vector instructions multiply without signs, so 1 is added to the
/// difference, which then lies in [0, 2³¹], and the step it makes too much, the gain itself, is taken off again.
#[inline(always)]
fn approach(from: i32x4, to: i32x4, gain: Gain) -> i32x4 {
    let bits = gain.to_bits();
    let ahead = to - from + i32x4::splat(2 * FINE_ONE_BITS);
    let step = ahead.cast_unsigned().mul_keep_high(u32x4::splat(bits << 2));
    from + (step - u32x4::splat(bits)).cast_signed()
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::fixed::{approach, squared_norm, to_weight16};
    use proptest::prelude::*;

    fn vector(bits: impl Iterator<Item = i32>) -> Vec<Weight32> {
        bits.map(Weight32::from_bits).collect()
    }

    proptest! {
        /// Of any number of components, in a column of blocks beside another vector's.
        #[test]
        fn a_row_moves_as_its_components_do(
            pairs in prop::collection::vec((-FINE_ONE_BITS..=FINE_ONE_BITS, -FINE_ONE_BITS..=FINE_ONE_BITS), 1..70),
            gain in prop_oneof![Just(0_u32), Just(1), Just((1 << 30) - 1), Just(1 << 30), 0_u32..=1 << 30],
        ) {
            let (row, probe) = (vector(pairs.iter().map(|p| p.0)), vector(pairs.iter().map(|p| p.1)));
            let gain = Gain::from_bits(gain);
            let mut moved = row.clone();
            let mut upper = vec![Upper::default(); 2 * blocks(row.len())];
            let norm = pull(&mut moved, upper.iter_mut().skip(1).step_by(2), &probe, gain);
            let expected: Vec<_> = row.iter().zip(&probe).map(|(w, x)| approach(*w, *x, gain)).collect();
            prop_assert_eq!(&moved, &expected);
            prop_assert_eq!(norm, squared_norm(&expected));
            let mut fresh = vec![Upper::default(); blocks(row.len())];
            round_down(&moved, fresh.iter_mut());
            for (block, fresh) in fresh.iter().enumerate() {
                prop_assert_eq!((upper[2 * block], upper[2 * block + 1]), (Upper::default(), *fresh));
            }
        }

        #[test]
        fn blocks_multiply_as_their_components_do(pairs in prop::collection::vec((-FINE_ONE_BITS..=FINE_ONE_BITS, -FINE_ONE_BITS..=FINE_ONE_BITS), 1..70)) {
            let vectors = [vector(pairs.iter().map(|p| p.0)), vector(pairs.iter().map(|p| p.1))];
            let [a, b] = vectors.each_ref().map(|vector| {
                let mut upper = vec![Upper::default(); blocks(vector.len())];
                round_down(vector, upper.iter_mut());
                upper
            });
            let [x, y] = vectors.map(|vector| vector.into_iter().map(to_weight16).collect::<Vec<_>>());
            let product: i64 = a.iter().zip(&b).map(|(a, b)| dot(a, b)).sum();
            prop_assert_eq!(product, amp::fixed::dot(&x, &y));
        }
    }
}
