use super::*;
use proptest::prelude::*;
use std::vec::Vec;

#[test]
fn exp_neg_error_bound() {
    let (mut max, mut sum) = (0.0_f64, 0.0_f64);
    let stride = if cfg!(miri) { 3_701 } else { 37 };
    for x in (0..20 << 16).step_by(stride) {
        let exact = libm::exp(-f64::from(x) / 65_536.0);
        let error = (f64::from(exp_neg(x)) / 2_147_483_648.0 - exact).abs();
        max = max.max(error);
        sum += error;
    }
    assert!(max <= 3e-5, "max {max}");
    let mean = sum * stride as f64 / f64::from(20 << 16);
    assert!(mean <= 2e-6, "mean {mean}");
}

#[test]
fn log2_ratio_error_bound() {
    for (a, b) in [
        (1, 1),
        (2, 1),
        (3, 1),
        (65_536, 3),
        (32_768, 655),
        (u32::MAX, 1),
        (7, 5),
    ] {
        let exact = libm::log2(f64::from(a) / f64::from(b));
        let error = exact - f64::from(log2_ratio(a, b)) / 65_536.0;
        assert!((-1e-6..3.2e-5).contains(&error), "{a}/{b}: {error}");
    }
}

#[test]
fn a_mask_selects_its_bits_and_all_components_from_32() {
    for index in [0, 5, 31] {
        let (one, others) = (Mask::NONE.with(index), Mask::ALL.without(index));
        assert_eq!(
            (one.to_bits(), others.to_bits()),
            (1 << index, !(1 << index))
        );
        assert!(one.contains(index) && !one.contains(index ^ 1));
        assert!(others.contains(index ^ 1) && !others.contains(index));
        assert_eq!((one.with(index), others.without(index)), (one, others));
        assert_eq!(
            (one.without(index), others.with(index)),
            (Mask::NONE, Mask::ALL)
        );
    }
    for index in [32, 33, 1_000] {
        assert!(Mask::NONE.contains(index));
        assert_eq!(Mask::NONE.with(index), Mask::NONE);
        assert_eq!(Mask::ALL.without(index), Mask::ALL);
    }
    let (low, even) = (Mask::from_bits(0b111), Mask::from_bits(0b1_0101));
    assert_eq!(low.and(even), Mask::from_bits(0b101));
    assert!(low.covers(3) && !low.covers(4) && Mask::NONE.covers(0));
    let lower_31 = Mask::ALL.without(31);
    assert!(
        lower_31.covers(31) && !lower_31.covers(32) && Mask::ALL.covers(32) && Mask::ALL.covers(33)
    );
}

#[test]
fn a_wide_mask_leaves_out_any_of_64() {
    for index in [0, 31, 32, 40, 63] {
        let others = WideMask::ALL.without(index);
        assert!(!others.contains(index), "{index}");
        let left_out = (0..70).filter(|k| !others.contains(*k)).count();
        assert_eq!(left_out, 1, "{index}");
    }
    assert_eq!(WideMask::ALL.without(64), WideMask::ALL);
}

#[test]
fn the_indices_of_a_mask_come_in_order() {
    let indices = |mask: Mask, count| mask.indices(count).collect::<Vec<_>>();
    assert_eq!(indices(Mask::from_bits(0b1_0110), 4), [1, 2]);
    assert_eq!(indices(Mask::from_bits(0b1_0110), 5), [1, 2, 4]);
    assert_eq!(indices(Mask::ALL, 31), (0..31).collect::<Vec<_>>());
    assert_eq!(indices(Mask::ALL, 40), (0..32).collect::<Vec<_>>());
    assert!(indices(Mask::ALL, 0).is_empty());
}

#[test]
fn weights_and_gains_are_clamped_to_one() {
    let one = i32::from(ONE_BITS);
    for (bits, clamped) in [
        (one + 1, one),
        (one, one),
        (3, 3),
        (-3, -3),
        (-one - 1, -one),
    ] {
        assert_eq!(i32::from(unit_weight(bits).to_bits()), clamped);
    }
    assert_eq!(Gain::from_bits(u32::MAX), Gain::ONE);
    assert_eq!(Gain::from_bits((1 << 30) - 1).to_bits(), (1 << 30) - 1);
    assert_eq!(Gain::from_q16(32_768).to_bits(), 1 << 29);
    assert_eq!(Gain::from_q16(u32::MAX), Gain::ONE);
}

#[test]
fn gains_multiply_to_the_nearest_and_compare_with_half() {
    let gain = Gain::from_bits;
    assert_eq!(gain(1 << 29).times(gain(1 << 29)), gain(1 << 28));
    assert_eq!(gain(3).times(gain(1 << 29)), gain(2), "1.5 is rounded up");
    assert_eq!(
        gain(5).times(gain(1 << 28)),
        gain(1),
        "1.25 is rounded down"
    );
    assert_eq!(Gain::ONE.times(gain(77)), gain(77));
    assert!(gain((1 << 29) - 1).is_below_half() && !gain(1 << 29).is_below_half());
    let below = gain((1 << 29) - 1);
    assert_eq!(below.to_q32(), i32::MAX - 3);
}

#[test]
fn upper_halves_are_rounded_down() {
    assert_eq!(
        to_weight16(Weight32::from_bits((5 << 16) + 65_535)).to_bits(),
        5
    );
    assert_eq!(to_weight16(Weight32::from_bits(-1)).to_bits(), -1);
    assert_eq!(Weight::from_bits(-7).to_weight32().to_bits(), -7 << 16);
    assert_eq!(
        Weight::from_bits(-7).to_weight32().to_weight16(),
        Weight::from_bits(-7).to_weight16()
    );
    assert_eq!(Weight32::from_bits(9).to_weight32(), Weight32::from_bits(9));
    assert_eq!(
        (high_product(1 << 20, 1 << 20), high_product(-1, 1)),
        (1 << 8, -1)
    );
}

#[test]
fn powers_of_two_reach_the_last_bit_and_then_zero() {
    assert_eq!(
        (exp2_neg(0), exp2_neg(1 << 16), exp2_neg(31 << 16)),
        (1 << 31, 1 << 30, 1)
    );
    assert_eq!(
        (exp2_neg(32 << 16), exp2_neg(u32::MAX), exp_neg(u32::MAX)),
        (0, 0, 0)
    );
    // The logarithm is 0 for ratios up to 1 and for zeros.
    for (a, b) in [(0, 0), (5, 0), (0, 5), (3, 5), (5, 5)] {
        assert_eq!(log2_ratio(a, b), 0, "{a}/{b}");
    }
    assert_eq!((log2_ratio(8, 1), log2_ratio(4, 2)), (3 << 16, 1 << 16));
}

#[test]
fn quotients_at_the_ends_do_not_overflow() {
    assert_eq!(
        (
            quotient(i64::MIN, -1),
            quotient(9, 0),
            quotient(i64::MAX, 0)
        ),
        (0, 0, 0)
    );
}

proptest! {
    #[test]
    fn a_quotient_is_the_same_in_32_and_64_bits(a in any::<i64>(), b in any::<i64>(), shifts in (0_u32..63, 0_u32..63)) {
        let (a, b) = (a >> shifts.0, b >> shifts.1);
        prop_assert_eq!(quotient(a, b), a.checked_div(b).unwrap_or(0));
    }

    #[test]
    fn dot_equals_the_64_bit_sum(pairs in prop::collection::vec((-8192_i16..=8192, -8192_i16..=8192), 0..70)) {
        let a: Vec<_> = pairs.iter().map(|p| Weight::from_bits(p.0)).collect();
        let b: Vec<_> = pairs.iter().map(|p| Weight::from_bits(p.1)).collect();
        let sum: i64 = pairs.iter().map(|p| i64::from(p.0) * i64::from(p.1)).sum();
        prop_assert_eq!(dot(&a, &b), sum);
        let expanded = squared_norm(&a) + squared_norm(&b) - 2 * sum;
        prop_assert_eq!(squared_distance(&a, &b, Mask::ALL), (expanded as u64) << 24);
    }

    #[test]
    fn approach_stays_between_its_arguments(from in -1_i32 << 29..=1 << 29, to in -1_i32 << 29..=1 << 29, gain in 0_u32..=1 << 30) {
        let (a, b) = (Weight32::from_bits(from), Weight32::from_bits(to));
        let moved = approach(a, b, Gain::from_bits(gain));
        prop_assert!(moved >= a.min(b) && moved <= a.max(b));
        let exact = f64::from(from) + (f64::from(to) - f64::from(from)) * f64::from(gain) / f64::from(1 << 30);
        prop_assert!((f64::from(moved.to_bits()) - exact).abs() < 1.0);
        let expected = i64::from(from) + ((i64::from(to - from) * i64::from(gain)) >> 30);
        prop_assert_eq!(i64::from(moved.to_bits()), expected);
        prop_assert_eq!(approach(a, b, Gain::ZERO), a);
        prop_assert_eq!(approach(a, b, Gain::ONE), b);
    }

    #[test]
    fn isqrt_u32_equals_core(value in any::<u32>()) {
        for value in [value, value >> 16, value >> 28] {
            prop_assert_eq!(isqrt_u32(value), value.isqrt());
        }
    }

    #[test]
    fn isqrt_is_the_floor(value in any::<u64>()) {
        let root = u128::from(isqrt(value));
        prop_assert!(root * root <= u128::from(value) && (root + 1) * (root + 1) > u128::from(value));
    }
}

#[test]
fn floats_become_q16() {
    assert_eq!((q16(0.5), q16(1.0), q16(0.0)), (32_768, 65_536, 0));
    assert_eq!((q16(-3.0), q16(f32::NAN), q16(1e9)), (0, 0, u32::MAX));
    assert_eq!(q16(0.01), 655, "655.36 is rounded");
}
