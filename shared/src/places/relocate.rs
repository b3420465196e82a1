//! A robot that is elsewhere than it thinks: what it perceives contradicts the places around it,
//! and fits them around another position.

use super::Places;
use super::locate::nearer_things;
use super::stage::Stage;
use crate::units::{Bearing, Direction, Displacement};

/// Positions that are compared: so many steps to each side of where the robot thinks it is.
const STEPS: i32 = 6;
const STEP_MM: i32 = 100;
const SIDE: u16 = 2 * STEPS as u16 + 1;
const POSITIONS: u16 = SIDE * SIDE;
/// To compare a position takes about so many steps of thinking.
const STEPS_PER_POSITION: u16 = 3;
/// Views of places that are not farther are compared, millimeters.
const AROUND_MM: u16 = 700;
/// There must be enough places near by: the sum of what their distances lack of that, millimeters.
const MIN_NEARNESS_MM: u32 = 1_000;
/// Greatest deviation that counts for one sector, millimeters: beyond that stands something else.
const MAX_DEVIATION_MM: i32 = 400;
/// Sectors that must be known here and there.
const MIN_SECTORS: u32 = 8;
/// The mean square at another position must be less by this, mm²,
const MIN_GAIN_MM2: u32 = 1_000;
/// and by this again for each squared step to it.
const STEP_COST_MM2: u32 = 300;

/// The position that fits best so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct BestPosition {
    deviation_mm2: u32,
    from_here: Displacement,
}

impl BestPosition {
    /// None.
    pub(super) const ZERO: Self = Self {
        deviation_mm2: 0,
        from_here: Displacement::ZERO,
    };
}

impl<const SECTORS: usize, const RECORDS: usize> Places<SECTORS, RECORDS> {
    /// Whether another position may explain more than the one where the robot thinks it is.
    pub(super) fn doubts_position(&mut self) -> bool {
        let here = self.deviation_mm2(&axes(), Displacement::ZERO);
        let doubted = here.and_then(|mm2| mm2.checked_sub(MIN_GAIN_MM2));
        self.best = BestPosition {
            deviation_mm2: doubted.unwrap_or(0),
            ..BestPosition::ZERO
        };
        doubted.is_some()
    }

    /// Compares a few positions; after the last one half of the way to the best is corrected.
    pub(super) fn compare_positions(&mut self, first: u16, steps: u16) -> Stage {
        let count = steps.div_ceil(STEPS_PER_POSITION);
        let last = first.saturating_add(count).min(POSITIONS);
        let axes = axes();
        for index in first..last {
            let steps = |steps: u16| i32::from(steps) - STEPS;
            let (x, y) = (steps(index % SIDE), steps(index / SIDE));
            let from_here = Displacement::saturating(x * STEP_MM, y * STEP_MM);
            let farther = (x * x + y * y).unsigned_abs() * STEP_COST_MM2;
            if farther >= self.best.deviation_mm2 {
                continue;
            }
            let deviation = self
                .deviation_mm2(&axes, from_here)
                .map(|mm2| mm2 + farther);
            if let Some(deviation_mm2) = deviation.filter(|mm2| *mm2 < self.best.deviation_mm2) {
                self.best = BestPosition {
                    deviation_mm2,
                    from_here,
                };
            }
        }
        if last < POSITIONS {
            return Stage::Positions(last);
        }
        let Displacement { dx_mm, dy_mm } = self.best.from_here;
        self.here = self.here.plus(Displacement {
            dx_mm: dx_mm / 2,
            dy_mm: dy_mm / 2,
        });
        Stage::Place
    }

    /// Mean squared deviation of what is perceived from what the places around a position showed;
    /// `None` where there are too few.
    fn deviation_mm2(&self, axes: &[Direction; SECTORS], from_here: Displacement) -> Option<u32> {
        let position = self.here.plus(from_here);
        let (mut sum, mut weights) = (0_u64, 0_u32);
        for place in self.graph.records() {
            let offset = position.minus(place.at);
            if !offset.is_shorter_than(AROUND_MM.into()) {
                continue;
            }
            let (mut squares, mut sectors) = (0_u32, 0_u32);
            let nearer = nearer_things(self.encoding, &place.view, &self.view);
            for (axis, nearer_mm) in nearer.filter_map(|(sector, mm)| Some((axes.get(sector)?, mm)))
            {
                let expected_mm = axis.along(offset.dx_mm.into(), offset.dy_mm.into());
                let deviation_mm = (nearer_mm - expected_mm)
                    .abs()
                    .min(MAX_DEVIATION_MM)
                    .unsigned_abs();
                squares += deviation_mm * deviation_mm;
                sectors += 1;
            }
            if sectors >= MIN_SECTORS {
                let weight = u32::from(AROUND_MM - offset.length_mm());
                sum += u64::from(weight) * u64::from(squares / sectors);
                weights += weight;
            }
        }
        (weights > MIN_NEARNESS_MM).then(|| (sum / u64::from(weights)) as u32)
    }
}

/// Of all sectors.
// One copy saves flash.
#[inline(never)]
pub(super) fn axes<const SECTORS: usize>() -> [Direction; SECTORS] {
    core::array::from_fn(|sector| Bearing::of_place(sector, SECTORS).direction())
}
