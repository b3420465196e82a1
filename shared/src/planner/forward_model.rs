//! Predicts the change of situation by an action: a linear least-squares fit to the action map.
//!
//! Never changes the map.

use crate::action_map::{ActionCode, ActionMap};
use crate::fixed::{Weight, to_weight16};
use crate::scan::Situation;
use crate::units::Direction;

/// The linear map from displacements to changes of the current situation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct ForwardModel<const SENSORS: usize> {
    lines: [Line; SENSORS],
}

impl<const SENSORS: usize> ForwardModel<SENSORS> {
    /// A model that predicts no change from this situation.
    pub(super) fn from(situation: &Situation<SENSORS>) -> Self {
        let mut lines = [Line::default(); SENSORS];
        for (line, value) in lines.iter_mut().zip(situation) {
            line.now = i32::from(value.to_bits());
        }
        Self { lines }
    }

    /// Fits the neurons of an action map; predicts no change where their actions do not span the
    /// plane.
    #[inline(never)]
    pub(super) fn fit<const NEURONS: usize>(
        &mut self,
        actions: &ActionMap<NEURONS, SENSORS>,
        code: ActionCode,
        step_mm: u16,
    ) {
        if code == ActionCode::Displacement
            && let Some(products) = actions.products()
        {
            let [xx, xy, yy] = products.plane.map(i64::from);
            let inverse = Inverse::of(xx, xy, yy);
            for (line, sums) in self.lines.iter_mut().zip(&products.changes) {
                (line.along_x, line.along_y) = inverse.slopes(*sums);
            }
            return;
        }
        let mut vectors = [(0, 0); NEURONS];
        let (mut xx, mut xy, mut yy) = (0_i64, 0_i64, 0_i64);
        for (vector, action) in vectors.iter_mut().zip(actions.actions().code()) {
            let (x, y) = in_plane(code, action.map(to_weight16), step_mm);
            (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
            *vector = (x, y);
        }
        // The sums over 31 neurons always fit; those of larger maps are scaled, all alike.
        let scale = NEURONS.max(16).ilog2().saturating_sub(4);
        let inverse = Inverse::of(xx >> scale, xy >> scale, yy >> scale);
        for (sensor, line) in self.lines.iter_mut().enumerate() {
            let (mut along_x, mut along_y) = (0_i64, 0_i64);
            for ((x, y), change) in vectors.iter().zip(actions.changes().code()) {
                let change = change
                    .get(sensor)
                    .copied()
                    .map_or(0, |change| i64::from(to_weight16(change).to_bits()));
                (along_x, along_y) = (along_x + x * change, along_y + y * change);
            }
            let sum =
                |sum: i64| (sum >> scale).clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32;
            (line.along_x, line.along_y) = inverse.slopes([sum(along_x), sum(along_y)]);
        }
    }

    /// The prediction for each transducer.
    pub(super) const fn lines(&self) -> &[Line; SENSORS] {
        &self.lines
    }

    /// The values (2⁻¹³, from 0 on but not limited to 1) after a displacement given as shares of
    /// the longest step, Q14.
    pub(super) fn after(&self, share: Direction) -> impl Iterator<Item = i32> {
        self.lines.iter().map(move |line| line.after(share))
    }
}

/// One transducer's value as a linear function of the displacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Line {
    /// Current value, 2⁻¹³.
    now: i32,
    /// Change per longest step along x, 2⁻¹³.
    along_x: i32,
    /// Change per longest step along y, 2⁻¹³.
    along_y: i32,
}

impl Line {
    /// The value after a displacement given as shares of the longest step.
    pub(super) fn after(&self, share: Direction) -> i32 {
        let change = share.along(self.along_x, self.along_y);
        change.wrapping_add(self.now).max(0)
    }

    /// Bounds of the value (clamped at 0) after any displacement up to the longest step; unit
    /// vectors may be too long by a sixteenth.
    pub(super) fn range(&self) -> (i32, i32) {
        let most = self.along_x.abs().wrapping_add(self.along_y.abs());
        let most = most.wrapping_add(most >> 4).wrapping_add(2);
        (self.now.wrapping_sub(most), self.now.wrapping_add(most))
    }

    /// Current value, changes per longest step along x and along y.
    pub(super) const fn coefficients(&self) -> (i32, i32, i32) {
        (self.now, self.along_x, self.along_y)
    }
}

/// An action as a vector in units of 2⁻¹³ of the longest step.
fn in_plane(code: ActionCode, action: [Weight; 2], step_mm: u16) -> (i64, i64) {
    let [x, y] = match code {
        ActionCode::Displacement => action,
        ActionCode::TurnStep => {
            ActionCode::Displacement.encode(code.decode(action, step_mm), step_mm)
        }
    };
    (x.to_bits().into(), y.to_bits().into())
}

/// The inverse of the symmetric 2 × 2 matrix of the actions' products, in units of 2⁻¹⁹ of its own:
/// sums of products in 2⁻²⁶ times this are slopes in 2⁻⁴⁵, whose upper half is a slope in 2⁻¹³.
struct Inverse {
    xx: i32,
    xy: i32,
    yy: i32,
}

impl Inverse {
    /// Of sums of squares and products in units of 2⁻²⁶; zero where there is none.
    fn of(xx: i64, xy: i64, yy: i64) -> Self {
        // 2⁻¹³ is fine enough, and the products stay below 2⁴⁸.
        let (xx, xy, yy) = (xx >> 13, xy >> 13, yy >> 13);
        let determinant = (xx * yy - xy * xy).max(0);
        // 15 bits of it are left, so that one 32-bit division is enough.
        let shift = (64 - determinant.leading_zeros()).saturating_sub(15);
        let divisor = (determinant >> shift) as u32;
        let part = |numerator: i64| {
            let scaled = (numerator.unsigned_abs() << 13).min(u64::from(u32::MAX)) as u32;
            let ratio = i64::from(scaled.checked_div(divisor).unwrap_or(0)) << 19 >> shift;
            // Actions that hardly span the plane: slopes are limited anyway.
            let ratio = ratio.min(1 << 30) as i32;
            if numerator < 0 { -ratio } else { ratio }
        };
        Self {
            xx: part(yy),
            xy: part(-xy),
            yy: part(xx),
        }
    }

    /// Both slopes (2⁻¹³) from both sums of products (2⁻²⁶), each within ±2 per step.
    fn slopes(&self, sums: [i32; 2]) -> (i32, i32) {
        let [x, y] = sums;
        let product = |a: i32, b: i32| i64::from(a) * i64::from(b);
        let slope = |a: i32, b: i32| {
            let sum = product(a, x).wrapping_add(product(b, y));
            ((sum >> 32) as i32).clamp(-(1 << 14), 1 << 14)
        };
        (slope(self.xx, self.xy), slope(self.xy, self.yy))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::som::Grid;
    use crate::units::{Bearing, Displacement};
    use proptest::prelude::*;
    use std::vec::Vec;

    const NEURONS: usize = 20;

    /// Actions all round, of different lengths, and anything that they changed.
    fn pairs() -> impl Strategy<Value = Vec<(u16, i32, [i16; 5])>> {
        let one = (
            any::<u16>(),
            60_i32..=250,
            prop::array::uniform5(-2_000_i16..=2_000),
        );
        prop::collection::vec(one, NEURONS)
    }

    fn map(pairs: &[(u16, i32, [i16; 5])], code: ActionCode) -> ActionMap<NEURONS, 5> {
        let action = |k: usize| {
            let (turns, mm, _) = pairs[k];
            code.encode(Displacement::along(Bearing::from_turns(turns), mm), 250)
        };
        let change = |k: usize| pairs[k].2.map(Weight::from_bits);
        let grid = Grid::rectangle(5, 4);
        ActionMap::new(
            grid,
            core::array::from_fn(change),
            core::array::from_fn(action),
        )
    }

    /// Least squares in floats: slopes in 2⁻¹³ per longest step, and how well the actions span the
    /// plane.
    fn exact(map: &ActionMap<NEURONS, 5>, sensor: usize) -> ([f64; 2], f64) {
        let (mut plane, mut sums) = ([0.0; 3], [0.0; 2]);
        for (action, change) in map.actions().code().iter().zip(map.changes().code()) {
            let [x, y] = action.map(|part| part.to_num::<f64>());
            let change = change[sensor].to_num::<f64>();
            plane = [plane[0] + x * x, plane[1] + x * y, plane[2] + y * y];
            sums = [sums[0] + x * change, sums[1] + y * change];
        }
        let [xx, xy, yy] = plane;
        let determinant = xx * yy - xy * xy;
        let slope = |a: f64, b: f64| (a * sums[0] + b * sums[1]) / determinant * 8_192.0;
        ([slope(yy, -xy), slope(-xy, xx)], determinant / (xx * yy))
    }

    fn slopes(forward: &ForwardModel<5>) -> Vec<[i32; 2]> {
        let lines = forward.lines().iter();
        lines.map(|line| [line.along_x, line.along_y]).collect()
    }

    proptest! {
        #[test]
        fn it_fits_the_neurons_best(pairs in pairs(), now in prop::array::uniform5(0_i16..=8_192)) {
            let mut map = map(&pairs, ActionCode::Displacement);
            let situation = now.map(Weight::from_bits);
            let mut forward = ForwardModel::from(&situation);
            forward.fit(&map, ActionCode::Displacement, 250);
            for (sensor, found) in slopes(&forward).into_iter().enumerate() {
                let (exact, span) = exact(&map, sensor);
                prop_assume!(span > 0.1);
                for (found, exact) in found.into_iter().zip(exact) {
                    // 15 bits of the determinant are left.
                    prop_assert!((f64::from(found) - exact).abs() < 3.0 + exact.abs() / 1_000.0, "{} {}", found, exact);
                }
            }
            // The incremental sums give identical results.
            map.keep_products();
            let mut kept = ForwardModel::from(&situation);
            kept.fit(&map, ActionCode::Displacement, 250);
            prop_assert_eq!(&kept, &forward);
            // No move, no change; a value is never below 0.
            prop_assert!(forward.after(Direction::default()).eq(now.map(i32::from)));
            let ahead = Direction { x_q14: 1 << 14, y_q14: 0 };
            for (value, line) in forward.after(ahead).zip(forward.lines()) {
                let (now, along_x, along_y) = line.coefficients();
                prop_assert_eq!(value, (now + along_x).max(0));
                let (least, most) = line.range();
                prop_assert!(least <= now - along_x.abs().max(along_y.abs()) && now + along_x.abs().max(along_y.abs()) <= most);
                prop_assert!(most - now <= (along_x.abs() + along_y.abs()) * 17 / 16 + 2 && now - least == most - now);
            }
        }

        /// Turn and step, or a displacement: two ways to write the same actions.
        #[test]
        fn the_code_of_the_actions_hardly_matters(pairs in pairs()) {
            let fitted = |code: ActionCode| {
                let (mut summed, mut kept) = (ForwardModel::from(&[Weight::ZERO; 5]), ForwardModel::from(&[Weight::ZERO; 5]));
                let mut map = map(&pairs, code);
                summed.fit(&map, code, 250);
                // Sums that were kept are of displacements: of no use for turns.
                map.keep_products();
                kept.fit(&map, code, 250);
                assert_eq!(kept, summed);
                slopes(&summed)
            };
            let (_, span) = exact(&map(&pairs, ActionCode::Displacement), 0);
            prop_assume!(span > 0.3);
            let (vectors, turns) = (fitted(ActionCode::Displacement), fitted(ActionCode::TurnStep));
            for (a, b) in vectors.as_flattened().iter().zip(turns.as_flattened()) {
                prop_assert!((a - b).abs() < 60, "{} {}", a, b);
            }
        }
    }

    /// The sums of 64 neurons exceed 32 bits; the slopes stay.
    #[test]
    fn maps_of_64_neurons_are_fitted_as_well() {
        let bits = |x: i16, y: i16| [Weight::from_bits(x), Weight::from_bits(y)];
        let actions =
            core::array::from_fn(|k| bits(8_192, if k % 2 == 0 { 8_192 } else { -8_192 }));
        let changes = actions.map(|[x, y]: [Weight; 2]| [x, y]);
        let map = ActionMap::<64, 2>::new(Grid::rectangle(8, 8), changes, actions);
        let mut forward = ForwardModel::from(&[Weight::ZERO; 2]);
        forward.fit(&map, ActionCode::Displacement, 250);
        let found: Vec<_> = forward
            .lines()
            .iter()
            .flat_map(|l| [l.along_x, l.along_y])
            .collect();
        for (found, exact) in found.into_iter().zip([8_192, 0, 0, 8_192]) {
            assert!((found - exact).abs() <= 2, "{found} {exact}");
        }
    }

    #[test]
    fn actions_that_do_not_span_the_plane_change_nothing_and_slopes_are_limited() {
        let line = |turns: u16, change: i16| {
            let pairs = [(turns, 250, [change; 5]); NEURONS];
            let mut forward = ForwardModel::from(&[Weight::ONE; 5]);
            forward.fit(
                &map(&pairs, ActionCode::Displacement),
                ActionCode::Displacement,
                250,
            );
            forward
        };
        assert_eq!(line(0, 2_000), ForwardModel::from(&[Weight::ONE; 5]));
        // Short moves that changed much: at most twice the whole scale per step.
        let short = |k: usize| {
            (
                (k * 4_096) as u16,
                40,
                [if k % 16 < 8 { 8_000 } else { -8_000 }; 5],
            )
        };
        let pairs: Vec<_> = (0..NEURONS).map(short).collect();
        let mut forward = ForwardModel::from(&[Weight::ZERO; 5]);
        forward.fit(
            &map(&pairs, ActionCode::Displacement),
            ActionCode::Displacement,
            250,
        );
        assert!(
            slopes(&forward).iter().all(|[_, y]| *y == 1 << 14),
            "{forward:?}"
        );
    }
}
