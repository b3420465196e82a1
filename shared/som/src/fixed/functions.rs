//! Square roots, quotients, exponentials and logarithms in integer arithmetic.

/// Integer square root, rounded down.
///
/// ```
/// # use tinysom::fixed::isqrt;
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

/// Integer square root by Heron's method, from above. On a chip with a division instruction it is
/// three times as fast as the digit-by-digit root of `core`.
#[inline(never)]
pub const fn isqrt_u32(value: u32) -> u32 {
    if value < 2 {
        return value;
    }
    // The first estimate is a power of two at or above the root.
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

/// `numerator / denominator` rounded towards 0; 0 for a denominator of 0. Divides in 32 bits where
/// both fit: that is one instruction on the chip; 64 bits take about 50.
#[must_use]
pub fn quotient(numerator: i64, denominator: i64) -> i64 {
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

/// 2^(−x) for x in Q16, as Q31 (2³¹ = 1.0). Interpolates linearly in a table of 64 intervals:
/// relative error at most 2·10⁻⁵, plus the rounding to 2⁻³¹.
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

/// log₂(`numerator`/`denominator`) in Q16, rounded down to 2⁻¹⁶; 0 if the ratio is below 1 or
/// `denominator` is 0.
#[must_use]
pub const fn log2_ratio(numerator: u32, denominator: u32) -> u32 {
    if denominator == 0 || numerator <= denominator {
        return 0;
    }
    // Normalizes the ratio to [1, 2) in Q31; each squaring then gives one bit of the logarithm.
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
