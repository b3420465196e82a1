use super::*;
use proptest::prelude::*;
use std::vec::Vec;

#[test]
fn exp_neg_error_bound() {
    let (mut worst, mut sum) = (0.0_f64, 0.0_f64);
    for x in (0..20 << 16).step_by(37) {
        let exact = libm::exp(-f64::from(x) / 65_536.0);
        let error = (f64::from(exp_neg(x)) / 2_147_483_648.0 - exact).abs();
        worst = worst.max(error);
        sum += error;
    }
    assert!(worst <= 3e-5, "worst {worst}");
    assert!(sum / 35_000.0 <= 2e-6, "mean {}", sum / 35_000.0);
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
fn halves_round_away_from_zero() {
    assert_eq!(
        (div_round(5, -2), div_round(-5, -2), div_round(4, 3)),
        (-3, 3, 1)
    );
    assert_eq!(div_round(1, 0), 0);
}

proptest! {
    #[test]
    fn dot_equals_the_wide_sum(pairs in prop::collection::vec((-8192_i16..=8192, -8192_i16..=8192), 0..70)) {
        let a: Vec<_> = pairs.iter().map(|p| Weight::from_bits(p.0)).collect();
        let b: Vec<_> = pairs.iter().map(|p| Weight::from_bits(p.1)).collect();
        let wide: i64 = pairs.iter().map(|p| i64::from(p.0) * i64::from(p.1)).sum();
        prop_assert_eq!(dot(&a, &b), wide);
        let expanded = squared_norm(&a) + squared_norm(&b) - 2 * wide;
        prop_assert_eq!(squared_distance(&a, &b, Mask::ALL), (expanded as u64) << 24);
    }

    #[test]
    fn approach_stays_between(from in -1_i32 << 29..=1 << 29, to in -1_i32 << 29..=1 << 29, gain in 0_u32..=1 << 30) {
        let (a, b) = (Fine::from_bits(from), Fine::from_bits(to));
        let moved = approach(a, b, Gain::from_bits(gain));
        prop_assert!(moved >= a.min(b) && moved <= a.max(b));
        let exact = f64::from(from) + (f64::from(to) - f64::from(from)) * f64::from(gain) / f64::from(1 << 30);
        prop_assert!((f64::from(moved.to_bits()) - exact).abs() < 1.0);
        let plain = i64::from(from) + ((i64::from(to - from) * i64::from(gain)) >> 30);
        prop_assert_eq!(i64::from(moved.to_bits()), plain);
        prop_assert_eq!(approach(a, b, Gain::ZERO), a);
        prop_assert_eq!(approach(a, b, Gain::ONE), b);
        if gain < 1 << 30 {
            prop_assert_eq!(approach_in_lanes(a, b, Gain::from_bits(gain)), moved);
        }
    }

    #[test]
    fn small_roots_are_those_of_core(value in any::<u32>()) {
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
