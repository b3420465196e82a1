//! Deviation of the expected situation from a goal over all displacements; never picks one.
//!
//! Expected values are linear in the displacement: most squared deviations add up to one quadratic
//! form. Only transducers whose value may cross a bound within a step are evaluated one by one.

use super::forward_model::{ForwardModel, Line};
use crate::goal::{Over, ValueBounds};
use crate::units::Direction;
use heapless::Vec;

/// A transducer whose value may cross a bound within the step.
#[derive(Debug, Clone, Copy)]
struct BentTerm {
    line: Line,
    bounds: ValueBounds,
}

/// Deviation from a goal as a function of the displacement, in units of 2⁻²⁶ · weight.
pub(super) struct CostSurface<const SENSORS: usize> {
    form: Option<QuadraticForm>,
    bent: Vec<BentTerm, SENSORS>,
    cap: i32,
}

impl<const SENSORS: usize> CostSurface<SENSORS> {
    /// The surface of a goal without bounds; `cap` limits each deviation.
    pub(super) const fn flat(cap: i32) -> Self {
        Self {
            form: None,
            bent: Vec::new(),
            cap,
        }
    }

    /// Adds the bounds of each transducer.
    pub(super) fn shape(
        &mut self,
        forward: &ForwardModel<SENSORS>,
        bounds: &[ValueBounds; SENSORS],
    ) {
        let mut sums = FormSums::default();
        let mut smooth = false;
        for (bounds, line) in bounds.iter().zip(forward.lines()) {
            if bounds.weight() == 0 {
                continue;
            }
            match bounds.over(line.range(), self.cap) {
                Over::Met => {}
                Over::Capped => {
                    smooth = true;
                    sums.level = sums.level.wrapping_add(bounds.most(self.cap));
                }
                Over::Square(target) => {
                    smooth = true;
                    sums.add(line, target, bounds.weight());
                }
                // Never full: one slot per transducer.
                Over::Bent => drop(self.bent.push(BentTerm {
                    line: *line,
                    bounds: *bounds,
                })),
            }
        }
        self.form = smooth.then(|| sums.form());
    }

    /// The deviation after a displacement given as shares of the longest step, Q14; the sum may
    /// stop once it reaches `limit`.
    pub(super) fn at(&self, share: Direction, limit: i64) -> i64 {
        let mut total = self.form.as_ref().map_or(0, |form| form.at(share));
        for term in &self.bent {
            if total >= limit {
                break;
            }
            let value = term.line.after(share);
            // Most values are within their bounds: no product needed.
            if !term.bounds.holds(value) {
                total = total.wrapping_add(term.bounds.deviation(value, self.cap));
            }
        }
        total
    }
}

/// 64-bit sums of the quadratic form.
#[derive(Default)]
struct FormSums {
    /// w e², where w is the weight and e the deviation at the current position.
    level: i64,
    /// w e a, at most 2³⁹; a is the slope along x and y.
    slope: [i64; 2],
    /// w a a, at most 2⁴⁰: xx, xy, yy.
    bend: [i64; 3],
}

impl FormSums {
    fn add(&mut self, line: &Line, target: i32, weight: i32) {
        let (now, x, y) = line.coefficients();
        let product = |a: i32, b: i32| i64::from(a) * i64::from(b);
        let off = now.wrapping_sub(target);
        // With the weight at most 24 bits.
        let (off_w, x_w, y_w) = (
            off.wrapping_mul(weight),
            x.wrapping_mul(weight),
            y.wrapping_mul(weight),
        );
        self.level = self.level.wrapping_add(product(off_w, off));
        let [slope_x, slope_y] = &mut self.slope;
        *slope_x = slope_x.wrapping_add(product(off_w, x));
        *slope_y = slope_y.wrapping_add(product(off_w, y));
        let [xx, xy, yy] = &mut self.bend;
        *xx = xx.wrapping_add(product(x_w, x));
        *xy = xy.wrapping_add(product(x_w, y));
        *yy = yy.wrapping_add(product(y_w, y));
    }

    fn form(&self) -> QuadraticForm {
        QuadraticForm {
            level: self.level,
            slope: self.slope.map(|sum| (sum >> 9) as i32),
            bend: self.bend.map(|sum| (sum >> 10) as i32),
        }
    }
}

/// A quadratic form in 32 bits: one instruction of the chip per product.
struct QuadraticForm {
    level: i64,
    /// In units of 2⁹ of the sums.
    slope: [i32; 2],
    /// In units of 2¹⁰ of the sums.
    bend: [i32; 3],
}

impl QuadraticForm {
    fn at(&self, share: Direction) -> i64 {
        let (x, y) = (i32::from(share.x_q14), i32::from(share.y_q14));
        let product = |a: i32, b: i32| i64::from(a) * i64::from(b);
        let q20 = |a: i32, b: i32| a.wrapping_mul(b) >> 8;
        let [slope_x, slope_y] = self.slope;
        let [xx, xy, yy] = self.bend;
        let tilt = product(slope_x, x).wrapping_add(product(slope_y, y)) >> 4;
        let bow = product(xx, q20(x, x))
            .wrapping_add(product(xy, q20(x, y) << 1))
            .wrapping_add(product(yy, q20(y, y)))
            >> 10;
        self.level.wrapping_add(tilt).wrapping_add(bow)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::action_map::{ActionCode, ActionMap};
    use crate::fixed::{Mask, Weight};
    use crate::goal::{Component, Goal, cost_of};
    use crate::som::Grid;
    use proptest::prelude::*;

    /// Four actions along the axes and what each changes.
    fn forward(situation: [Weight; 4], slopes: [[i16; 4]; 2]) -> ForwardModel<4> {
        let bits = |row: [i16; 4], sign: i16| row.map(|bits| Weight::from_bits(sign * bits));
        let [x, y] = slopes;
        let actions = [[8_192, 0], [-8_192, 0], [0, 8_192], [0, -8_192]];
        let map = ActionMap::<4, 4>::new(
            Grid::rectangle(2, 2),
            [bits(x, 1), bits(x, -1), bits(y, 1), bits(y, -1)],
            actions.map(|action| action.map(Weight::from_bits)),
        );
        let mut forward = ForwardModel::from(&situation);
        forward.fit(&map, ActionCode::Displacement, 250);
        forward
    }

    proptest! {
        #[test]
        fn it_is_the_deviation_of_the_expected_values(
            situation in prop::array::uniform4(0_i16..=8_192),
            components in prop::array::uniform4((0_i16..=8_192, 0_i16..=8_192, 0_u8..20)),
            slopes in prop::array::uniform2(prop::array::uniform4(-1_500_i16..=1_500)),
            cap in 0_i16..=8_192,
            turns in any::<u16>(),
        ) {
            let mut goal = Goal::of(components.map(|(a, b, weight)| Component {
                low: Weight::from_bits(a.min(b)),
                high: Weight::from_bits(a.max(b)),
                weight,
            }));
            goal.cap = Weight::from_bits(cap);
            let mut bounds = goal.asked(0, Mask::ALL);
            let bounds = core::array::from_fn(|_| bounds.next().unwrap());
            let forward = forward(situation.map(Weight::from_bits), slopes);
            let mut cost_surface = CostSurface::flat(goal.cap_bits());
            cost_surface.shape(&forward, &bounds);
            let share = crate::units::Bearing::from_turns(turns).direction();
            let values = forward.after(share);
            let exact = cost_of(bounds.into_iter().zip(values), goal.cap_bits(), i64::MAX);
            let found = cost_surface.at(share, i64::MAX);
            // Each value is rounded down to one unit; the form's coefficients to 2⁹ and 2¹⁰.
            let weights: i64 = components.iter().map(|(_, _, weight)| i64::from(*weight)).sum();
            let bound = weights * (2 * i64::from(cap) + 2) + 5 * 1_024;
            prop_assert!((exact - found).abs() <= bound, "{exact} {found} {bound}");
        }
    }
}
