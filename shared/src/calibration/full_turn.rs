//! How far a base turns when it takes itself to have turned once around: then all sensors read what
//! they read at first.

use crate::actuation::ONE_Q12;

/// Turns from here on are compared, 1/1 024 turn: 240°.
const LEAST: i16 = 683;
/// Turns that are told apart, 1/1 024 turn: 5.6°.
const STEP: i16 = 16;
/// From 240° to 527°.
const BINS: usize = 51;

/// How much readings of the same sensor differ after about a full turn of what the base takes for
/// one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct FullTurn {
    sums: [u32; BINS],
    counts: [u16; BINS],
}

impl FullTurn {
    pub(super) const NEW: Self = Self {
        sums: [0; BINS],
        counts: [0; BINS],
    };

    /// Two readings of one sensor differ by this after a turn, 1/1 024 turn.
    pub(super) fn compare(&mut self, turned: i16, difference: u16) {
        let bin = turned.unsigned_abs().checked_sub(LEAST.unsigned_abs());
        let Some(bin) = bin.map(|from| usize::from(from / STEP.unsigned_abs())) else {
            return;
        };
        if let (Some(sum), Some(count)) = (self.sums.get_mut(bin), self.counts.get_mut(bin)) {
            *sum = sum.saturating_add(difference.min(512).into());
            *count = count.saturating_add(1);
        }
    }

    /// True turn of what the base takes for one of 4 096: the one by which it takes itself to have
    /// turned when all is as before. 4 096 if it has not turned so far.
    pub(super) fn turn_q12(&self) -> u16 {
        let mean = |bin: usize| {
            let (sum, count) = (*self.sums.get(bin)?, *self.counts.get(bin)?);
            (count > 0).then(|| sum as f32 / f32::from(count))
        };
        // The least of parabolas over seven bins each.
        let mut best: Option<(f32, f32)> = None;
        for middle in 3..BINS.saturating_sub(3) {
            let near = (0..7).filter_map(|i| Some((i as f32 - 3.0, mean(middle + i - 3)?)));
            if let Some((at, least)) = parabola(near)
                && best.is_none_or(|(_, before)| least < before)
            {
                best = Some((middle as f32 + at, least));
            }
        }
        best.map_or(ONE_Q12, |(bin, _)| {
            let told = f32::from(LEAST) + f32::from(STEP) * (bin + 0.5);
            (1_024.0 / told * f32::from(ONE_Q12)) as u16
        })
    }
}

/// Where a parabola through points around 0 has its least value, and that; `None` if it has none
/// within 1 of the middle or there are fewer than three points.
fn parabola(points: impl Iterator<Item = (f32, f32)>) -> Option<(f32, f32)> {
    let mut s = [0.0_f32; 5];
    let mut r = [0.0_f32; 3];
    for (x, y) in points {
        let mut power = 1.0;
        for (i, sum) in s.iter_mut().enumerate() {
            *sum += power;
            if let Some(moment) = r.get_mut(i) {
                *moment += power * y;
            }
            power *= x;
        }
    }
    let [s0, s1, s2, s3, s4] = s;
    let [r0, r1, r2] = r;
    // Cramer's rule for c + b x + a x².
    let det = |m: [[f32; 3]; 3]| {
        let [[a, b, c], [d, e, f], [g, h, i]] = m;
        a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    };
    let whole = det([[s0, s1, s2], [s1, s2, s3], [s2, s3, s4]]);
    if s0 < 3.0 || whole <= 0.0 {
        return None;
    }
    let c = det([[r0, s1, s2], [r1, s2, s3], [r2, s3, s4]]) / whole;
    let b = det([[s0, r0, s2], [s1, r1, s3], [s2, r2, s4]]) / whole;
    let a = det([[s0, s1, r0], [s1, s2, r1], [s2, s3, r2]]) / whole;
    let at = -b / (2.0 * a);
    (a > 0.0 && (-1.0..=1.0).contains(&at)).then_some((at, c + b * at / 2.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings differ by the distance to a turn, up to a bound.
    fn found(around: i16) -> u16 {
        let mut full = FullTurn::NEW;
        for turned in (600..1_500).step_by(7) {
            let off = (turned - around).unsigned_abs() * 5;
            full.compare(turned, off.min(400));
        }
        full.turn_q12()
    }

    #[test]
    fn a_base_that_turns_too_far_takes_less_for_a_full_turn() {
        for around in [800, 950, 1_024, 1_200, 1_350] {
            let wanted = 1_024.0 / f64::from(around) * 4_096.0;
            let off = f64::from(found(around)) / wanted - 1.0;
            assert!(off.abs() < 0.006, "{around}: {off}");
        }
    }

    #[test]
    fn without_a_full_turn_nothing_is_known() {
        let mut full = FullTurn::NEW;
        full.compare(100, 3);
        full.compare(i16::MIN, 3);
        assert_eq!(full.turn_q12(), 4_096);
    }
}
