//! The bearings that make readings after turns most similar.

use super::{BINS, Calibration, Slope, place};
use crate::actuation::{Actuation, ONE_Q12};
use crate::fixed::Mask;
use crate::units::Bearing;
use micromath::F32Ext;

/// Sensors that the growth of a solution starts from, at most.
const STARTS: usize = 6;
/// Rounds in which each sensor takes its best bearing, the others as they are.
const SWEEPS: usize = 6;
/// Rounds of reweighted least squares.
const FITS: usize = 10;
/// Weights of a bin and its neighbors, tenths.
const SMOOTH: [u32; 5] = [2, 7, 10, 7, 2];

/// What was learned of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LearnedBody<const BEAMS: usize> {
    /// Bearing of each sensor, from where the body goes ahead; `None` = dead.
    pub bearings: [Option<Bearing>; BEAMS],
    /// What its base makes of its commands. Left and right may be exchanged in the base and so in
    /// all bearings: nothing in a room tells which is which.
    pub actuation: Actuation,
}

impl<const BEAMS: usize> Calibration<BEAMS> {
    /// Bearings of the sensors of a body whose base does what it is told.
    #[must_use]
    pub fn solve(&self) -> [Option<Bearing>; BEAMS] {
        self.with_front(self.best_bearings(ONE_Q12).1).0
    }

    /// Bearings of the sensors, and what the base makes of its commands.
    #[must_use]
    pub fn solve_all(&self) -> LearnedBody<BEAMS> {
        let turn_q12 = self.full_turn.turn_q12();
        let (_, bearings) = self.best_bearings(turn_q12);
        let (bearings, length_q12) = self.with_front(bearings);
        LearnedBody {
            bearings,
            actuation: Actuation {
                front: self.front(),
                length_q12,
                turn_q12,
            },
        }
    }

    /// Bearings up to a common turn, and what they cost, where the base turns so far.
    fn best_bearings(&self, turn_q12: u16) -> (i32, [Option<Bearing>; BEAMS]) {
        let alive = self.alive();
        let costs = Costs::of(self, turn_q12);
        let starts = alive.indices(BEAMS).take(STARTS);
        let found = starts.map(|first| costs.swept(alive, costs.grow(alive, first)));
        let none = (i32::MAX, [None; BEAMS]);
        found.fold(none, |best, one| if one.0 < best.0 { one } else { best })
    }

    /// The bearings from the body's front, and the true length of what the base takes for 4 096.
    fn with_front(&self, bearings: [Option<Bearing>; BEAMS]) -> ([Option<Bearing>; BEAMS], u16) {
        let (x, y) = ahead(&self.slopes, &bearings);
        let turns = F32Ext::atan2(y, x) * (32_768.0 / core::f32::consts::PI);
        let front = Bearing::from_turns(F32Ext::round(turns) as i32 as u16);
        let from_front = bearings.map(|bearing| bearing.map(|bearing| bearing.plus(front)));
        let square = (x * x + y * y).clamp(0.25 * 0.25, 4.0 * 4.0);
        let square_q24 = (square * (1 << 24) as f32) as u32;
        (from_front, crate::fixed::isqrt_u32(square_q24) as u16)
    }
}

/// Dissimilarity of two sensors' readings, less its average over all turns.
struct Costs<'a, const BEAMS: usize> {
    calibration: &'a Calibration<BEAMS>,
    means: [[u16; BEAMS]; BEAMS],
    /// True turn of what the base takes for 4 096.
    turn_q12: u16,
}

impl<'a, const BEAMS: usize> Costs<'a, BEAMS> {
    fn of(calibration: &'a Calibration<BEAMS>, turn_q12: u16) -> Self {
        let mut costs = Self {
            calibration,
            means: [[0; BEAMS]; BEAMS],
            turn_q12,
        };
        for before in 0..BEAMS {
            for after in 0..BEAMS {
                let mean = costs.weighted((before, after), (0..BINS).map(|bin| (bin, 1)), (0, 0));
                if let Some(cell) = costs
                    .means
                    .get_mut(before)
                    .and_then(|row| row.get_mut(after))
                {
                    *cell = mean;
                }
            }
        }
        costs
    }

    /// Mean of the bins that were compared, with weights; `start` is a sum and a weight to begin
    /// with. 16 = 1 of a dissimilarity.
    fn weighted(
        &self,
        pair: (usize, usize),
        bins: impl Iterator<Item = (usize, u32)>,
        start: (u32, u32),
    ) -> u16 {
        let (sum, weight) = bins.fold(start, |(sum, weight), (bin, share)| {
            let (before, after, bin) = place(pair, bin % BINS);
            let row = self.calibration.dissimilarity.get(before);
            let cell = row.and_then(|row| row.get(after)?.get(bin));
            cell.and_then(|cell| cell.mean())
                .map_or((sum, weight), |mean| {
                    let part = u32::from(mean).wrapping_mul(16).wrapping_mul(share);
                    (sum.wrapping_add(part), weight.wrapping_add(share))
                })
        });
        sum.checked_div(weight).unwrap_or(0) as u16
    }

    /// Of a bin, smoothed over its neighbors; a bin without comparisons costs the average.
    fn smoothed(&self, (before, after): (usize, usize), bin: usize) -> i32 {
        let mean = self.means.get(before).and_then(|row| row.get(after));
        let mean = mean.copied().unwrap_or(0);
        let bins = SMOOTH
            .into_iter()
            .enumerate()
            .map(|(offset, share)| ((bin + BINS + offset - 2) % BINS, share));
        let start = (u32::from(mean), 1);
        i32::from(self.weighted((before, after), bins, start)) - i32::from(mean)
    }

    /// Of two sensors whose bearings differ by a turn; `None` for one that the base does not reach
    /// with half a turn of its own.
    fn between(&self, pair: (usize, usize), turn: Bearing) -> Option<i32> {
        let told = i32::from(turn.as_signed_turns()) * i32::from(ONE_Q12)
            / i32::from(self.turn_q12.max(1));
        let told = i16::try_from(told).ok()?;
        // Bins have their values in their middles.
        let position = (told as u16).wrapping_sub(1 << 9);
        let (bin, within) = (usize::from(position >> 10), i32::from(position & 1_023));
        let (low, high) = (self.smoothed(pair, bin), self.smoothed(pair, bin + 1));
        Some(low + (((high - low) * within) >> 10))
    }

    /// Of a sensor with this bearing and all others that have one.
    fn at(&self, bearings: &[Option<Bearing>; BEAMS], sensor: usize, bearing: Bearing) -> i32 {
        let others = bearings.iter().enumerate();
        let others = others.filter(|(other, _)| *other != sensor);
        others.fold(0, |sum, (other, known)| {
            // At a heading h sensor i looks along h + b_i; after a turn φ sensor j looks there if
            // b_i = b_j + φ.
            let cost = known.and_then(|known| self.between((sensor, other), bearing.minus(known)));
            sum.saturating_add(cost.unwrap_or(0))
        })
    }

    /// Best bearing of a sensor among so many, and its cost.
    fn best(
        &self,
        bearings: &[Option<Bearing>; BEAMS],
        sensor: usize,
        count: usize,
    ) -> (i32, Bearing) {
        let candidates = (0..count).map(|index| {
            let bearing = Bearing::of_place(index, count);
            (self.at(bearings, sensor, bearing), bearing)
        });
        let first = (i32::MAX, Bearing::ZERO);
        candidates.fold(first, |best, one| if one.0 < best.0 { one } else { best })
    }

    /// Bearings relative to the first sensor's; the surest sensor is placed next.
    fn grow(&self, alive: Mask, first: usize) -> [Option<Bearing>; BEAMS] {
        let mut bearings = [None; BEAMS];
        if let Some(own) = bearings.get_mut(first) {
            *own = Some(Bearing::ZERO);
        }
        for _ in alive.indices(BEAMS).skip(1) {
            let open = alive.indices(BEAMS).filter(|sensor| {
                let known = bearings.get(*sensor).copied().flatten();
                known.is_none()
            });
            let mut next: Option<(i32, usize, Bearing)> = None;
            for sensor in open {
                let (cost, bearing) = self.best(&bearings, sensor, BINS);
                if next.is_none_or(|(least, ..)| cost < least) {
                    next = Some((cost, sensor, bearing));
                }
            }
            let Some((_, sensor, bearing)) = next else {
                break;
            };
            if let Some(own) = bearings.get_mut(sensor) {
                *own = Some(bearing);
            }
        }
        bearings
    }

    /// Improves the bearings of all sensors; with what they then cost.
    fn swept(
        &self,
        alive: Mask,
        mut bearings: [Option<Bearing>; BEAMS],
    ) -> (i32, [Option<Bearing>; BEAMS]) {
        for _ in 0..SWEEPS {
            for sensor in alive.indices(BEAMS) {
                self.improve(&mut bearings, sensor);
            }
        }
        let total = alive.indices(BEAMS).fold(0_i32, |sum, sensor| {
            let own = bearings.get(sensor).copied().flatten();
            sum.saturating_add(own.map_or(0, |own| self.at(&bearings, sensor, own)))
        });
        (total, bearings)
    }

    /// Gives a sensor its best bearing, the others as they are.
    fn improve(&self, bearings: &mut [Option<Bearing>; BEAMS], sensor: usize) {
        let (_, bearing) = self.best(bearings, sensor, 8 * BINS);
        if let Some(own) = bearings.get_mut(sensor) {
            *own = Some(bearing);
        }
    }
}

/// By how much all bearings are to be turned so that the body's front is at 0, as a vector whose
/// length is the true length of what the base takes for 1. Along a straight move of l a range
/// changes by −l cos b: least squares for the cosine and sine of the turn, where what fits badly
/// counts less from round to round.
fn ahead<const BEAMS: usize>(slopes: &[Slope], bearings: &[Option<Bearing>; BEAMS]) -> (f32, f32) {
    let (mut x, mut y) = (0.0_f32, 0.0_f32);
    for fit in 0..FITS {
        let (mut xx, mut xy, mut yy, mut xr, mut yr) =
            (0.0_f32, 0.0_f32, 0.0_f32, 0.0_f32, 0.0_f32);
        for slope in slopes {
            let Some(bearing) = bearings.get(usize::from(slope.sensor)).copied().flatten() else {
                continue;
            };
            let direction = bearing.direction();
            let ahead = f32::from(slope.ahead_4mm) * 4e-3;
            let unit = ahead / 16_384.0;
            let (u, v) = (
                -unit * f32::from(direction.x_q14),
                unit * f32::from(direction.y_q14),
            );
            let change = f32::from(slope.change_mm) / 1e3;
            let weight = if fit == 0 {
                1.0
            } else {
                let off = (change - (u * x + v * y)) / ahead / 0.1;
                1.0 / (1.0 + off * off)
            };
            xx += weight * u * u;
            xy += weight * u * v;
            yy += weight * v * v;
            xr += weight * u * change;
            yr += weight * v * change;
        }
        let determinant = xx * yy - xy * xy;
        if F32Ext::abs(determinant) < 1e-9 {
            return (1.0, 0.0);
        }
        x = (xr * yy - yr * xy) / determinant;
        y = (yr * xx - xr * xy) / determinant;
    }
    (x, y)
}
