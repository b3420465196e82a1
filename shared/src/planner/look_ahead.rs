//! Selects the action whose expected situation is nearest to the goal; never looks beyond one step.
//!
//! Expected situation = current situation + change of the action ([`ForwardModel`] or one neuron).
//! A goal in the frame of travel first selects its *travel sensor*: the direction in which the
//! goal fits the current situation best, with a preference for the course.

use super::cost_surface::CostSurface;
use super::forward_model::ForwardModel;
use super::{MAX_COST, Plan, Planner, Why, argmin};
use crate::config::PlannerKind;
use crate::fixed::{ONE_BITS, Selection, Weight, Weight32, to_weight16};
use crate::goal::{Goal, GoalFrame, ValueBounds, cost_of};
use crate::scan::Situation;
use crate::units::{Direction, Displacement};

/// Shares of a step to try along the best direction after the whole step, in 1/4.
const SHORTER_Q2: [i32; 4] = [3, 2, 1, 0];

/// An action and its score.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    /// Unit vector, in the ring's frame.
    direction: Direction,
    /// Share of the longest step, in 1/4.
    share_q2: i32,
    /// Deviation from the goal minus the preference for progress: smaller is better.
    score: i64,
    /// The neuron that gives the expected change; `None` = the forward model.
    neuron: Option<usize>,
}

/// A goal with its bounds and directions resolved for one decision.
pub(super) struct GoalView<'a, const SENSORS: usize> {
    goal: &'a Goal<SENSORS>,
    /// Bounds of each transducer in the ring's frame.
    bounds: &'a [ValueBounds; SENSORS],
    /// Index of the travel sensor; the search over headings starts there.
    place: usize,
    /// Preferred direction of progress; zero = none.
    preferred: Direction,
}

impl<'a, const SENSORS: usize> GoalView<'a, SENSORS> {
    pub(super) fn new<const NEURONS: usize, S>(
        planner: &Planner<'_, SENSORS, NEURONS, S>,
        goal: &'a Goal<SENSORS>,
        bounds: &'a [ValueBounds; SENSORS],
        travel: usize,
    ) -> Self {
        let robot = &planner.config.robot;
        let travels = goal.frame == GoalFrame::Travel && robot.symmetric;
        let ahead = robot.directions.get(travel).copied().filter(|_| travels);
        Self {
            goal,
            bounds,
            place: travel.min(SENSORS),
            preferred: ahead.unwrap_or_else(|| unit(planner.course)),
        }
    }

    fn deviation(&self, values: impl Iterator<Item = i32>) -> i64 {
        let bounds = self.bounds.iter().copied();
        cost_of(bounds.zip(values), self.goal.cap_bits(), i64::MAX)
    }

    /// As [`Goal::holds`].
    fn holds(&self, situation: &Situation<SENSORS>, tolerance: Weight) -> bool {
        let tolerance = i32::from(tolerance.to_bits());
        let mut values = self.bounds.iter().zip(situation);
        values.all(|(bounds, value)| bounds.holds_within(i32::from(value.to_bits()), tolerance))
    }

    /// Bonus for a whole step in this direction.
    fn progress(&self, direction: Direction) -> i64 {
        weighted(
            self.goal.progress_q16,
            cosine_q14(direction, self.preferred),
        )
    }
}

/// A weight in Q16 times a cosine in Q14, in units of 2⁻²⁶.
fn weighted(weight_q16: u16, cosine_q14: i32) -> i64 {
    i64::from(weight_q16).wrapping_mul(i64::from(cosine_q14)) >> 4
}

fn cosine_q14(a: Direction, b: Direction) -> i32 {
    a.along(i32::from(b.x_q14), i32::from(b.y_q14))
}

/// The values of a situation in units of 2⁻¹³.
fn bits(values: &[Weight]) -> impl Iterator<Item = i32> {
    values.iter().map(|value| i32::from(value.to_bits()))
}

/// The situation with these values in units of 2⁻¹³, none of them below 0.
fn situation_of<const SENSORS: usize>(values: impl Iterator<Item = i32>) -> Situation<SENSORS> {
    let mut situation = [Weight::ZERO; SENSORS];
    for (slot, value) in situation.iter_mut().zip(values) {
        *slot = Weight::from_bits(value.min(i32::from(ONE_BITS)) as i16);
    }
    situation
}

/// The unit vector along a displacement; zero for none.
fn unit(displacement: Displacement) -> Direction {
    let length = i32::from(displacement.length_mm());
    let part = |mm: i16| (i32::from(mm) << 14).checked_div(length).unwrap_or(0);
    Direction {
        x_q14: part(displacement.dx_mm).clamp(-(1 << 14), 1 << 14) as i16,
        y_q14: part(displacement.dy_mm).clamp(-(1 << 14), 1 << 14) as i16,
    }
}

/// A part of a unit vector, in 1/4.
fn part(direction: Direction, share_q2: i32) -> Direction {
    let scaled = |q14: i16| (i32::from(q14).wrapping_mul(share_q2) >> 2) as i16;
    Direction {
        x_q14: scaled(direction.x_q14),
        y_q14: scaled(direction.y_q14),
    }
}

impl<const SENSORS: usize, const NEURONS: usize, S: Selection> Planner<'_, SENSORS, NEURONS, S> {
    /// The transducer along which a goal in the frame of travel fits the situation best, with a
    /// preference for the course; 0 for other goals.
    #[must_use]
    pub fn travel_sensor(&self, situation: &Situation<SENSORS>, goal: &Goal<SENSORS>) -> usize {
        self.travel_sensor_from(0, situation, goal)
    }

    /// As [`travel_sensor`](Self::travel_sensor), with a first guess.
    #[inline(never)]
    pub(super) fn travel_sensor_from(
        &self,
        first: usize,
        situation: &Situation<SENSORS>,
        goal: &Goal<SENSORS>,
    ) -> usize {
        if goal.frame == GoalFrame::Ring || !self.config.robot.symmetric {
            return 0;
        }
        let course = unit(self.course);
        let score = |place: usize, limit: i64| {
            let direction = self.config.robot.directions.get(place).copied();
            let along = cosine_q14(direction.unwrap_or_default(), course);
            let steady = weighted(goal.heading_hold_q16, along);
            let limit = limit.wrapping_add(steady);
            // No deviation is below 0: most sensors are skipped.
            if limit <= 0 {
                return i64::MAX;
            }
            let deviation = goal.cost(place, self.enabled, situation, limit);
            deviation.wrapping_sub(steady)
        };
        argmin(SENSORS, first, score).0
    }

    /// The action that leads nearest to the goal.
    #[inline(never)]
    pub(super) fn plan_by_look_ahead(
        &self,
        situation: &Situation<SENSORS>,
        view: &GoalView<'_, SENSORS>,
        [goal_neuron, current]: [usize; 2],
    ) -> Plan<SENSORS> {
        let config = self.config;
        let mask = self.enabled;
        let mut forward = ForwardModel::from(situation);
        forward.fit(self.actions, config.action_code, config.robot.step_mm);
        let best = self.best(situation, view, &forward);
        let to_come = match best.neuron {
            Some(neuron) => situation_of(self.own_values(situation, neuron).into_iter()),
            None => situation_of(forward.after(part(best.direction, best.share_q2))),
        };
        // As `difference`, without its clamp: saves 80 instructions of a decision.
        let mut wanted = to_come;
        for (wanted, now) in wanted.iter_mut().zip(situation) {
            *wanted = wanted.wrapping_sub(*now);
        }
        let now = view.deviation(bits(situation));
        let mut plan = Plan {
            goal_neuron: goal_neuron as u8,
            current_neuron: current as u8,
            subgoal_neuron: self.situations.bmu(&to_come, mask) as u8,
            wanted,
            action_neuron: self.neuron_of(best.direction) as u8,
            at_goal: view.goal.is_met_by(now, view.bounds.iter().copied())
                || view.holds(situation, config.planning.tolerance),
            recalled: true,
            action: Displacement::ZERO,
            why: Why::Stay,
        };
        if best.share_q2 > 0 {
            let step = i32::from(config.robot.step_mm);
            let (x, y) = part(best.direction, best.share_q2).times(step);
            plan.action = Displacement::saturating(x, y);
            plan.why = Why::LookAhead;
        }
        plan
    }

    /// The best candidate that is not inhibited. Goals without progress also try shorter steps.
    #[inline(never)]
    fn best(
        &self,
        situation: &Situation<SENSORS>,
        view: &GoalView<'_, SENSORS>,
        forward: &ForwardModel<SENSORS>,
    ) -> Candidate {
        let mut cost_surface = CostSurface::flat(view.goal.cap_bits());
        cost_surface.shape(forward, view.bounds);
        // Where every action is inhibited, the robot stays.
        let mut best = Candidate {
            direction: Direction::default(),
            share_q2: 0,
            score: MAX_COST,
            neuron: None,
        };
        if self.config.planning.planner == PlannerKind::BestNeuron {
            let allowed = (0..NEURONS).filter(|neuron| self.allowed.contains(*neuron));
            for own in allowed.filter_map(|neuron| self.own_candidate(situation, view, neuron)) {
                if own.score < best.score {
                    best = own;
                }
            }
        } else {
            let directions = &self.config.robot.directions;
            let score = |heading: usize, limit: i64| {
                let direction = directions.get(heading).copied().unwrap_or_default();
                let progress = view.progress(direction);
                let deviation = cost_surface.at(direction, limit.wrapping_add(progress));
                let score = deviation.wrapping_sub(progress);
                match score < limit && self.is_allowed(direction) {
                    true => score,
                    false => i64::MAX,
                }
            };
            let (heading, score) = argmin(SENSORS, view.place, score);
            if let Some(direction) = directions.get(heading) {
                best = Candidate {
                    direction: *direction,
                    share_q2: 4,
                    score,
                    neuron: None,
                };
            }
        }
        if view.goal.progress_q16 == 0 {
            for share_q2 in SHORTER_Q2 {
                let limit = best.score.wrapping_add(1);
                let score = cost_surface.at(part(best.direction, share_q2), limit);
                if score <= best.score {
                    (best.share_q2, best.score, best.neuron) = (share_q2, score, None);
                }
            }
        }
        best
    }

    /// The candidate of a neuron's own action, scaled to a whole step; `None` below a quarter of a
    /// step, where the direction is mostly noise.
    #[inline(never)]
    fn own_candidate(
        &self,
        situation: &Situation<SENSORS>,
        view: &GoalView<'_, SENSORS>,
        neuron: usize,
    ) -> Option<Candidate> {
        let action = self.own_action(neuron);
        if action.length_mm() < self.config.robot.step_mm / 4 {
            return None;
        }
        let direction = unit(action);
        let values = self.own_values(situation, neuron);
        let deviation = view.deviation(values.into_iter());
        Some(Candidate {
            direction,
            share_q2: 4,
            score: deviation.wrapping_sub(view.progress(direction)),
            neuron: Some(neuron),
        })
    }

    fn own_action(&self, neuron: usize) -> Displacement {
        let code = self.actions.actions().code_vector(neuron);
        self.config
            .action_code
            .decode(code, self.config.robot.step_mm)
    }

    /// The situation after a neuron's own change, scaled to a whole step.
    #[inline(never)]
    fn own_values(&self, situation: &Situation<SENSORS>, neuron: usize) -> [i32; SENSORS] {
        let step = i32::from(self.config.robot.step_mm);
        let length = i32::from(self.own_action(neuron).length_mm()).max(1);
        let mut values = [0; SENSORS];
        let change = self.actions.changes().code_vector(neuron);
        for ((value, now), change) in values.iter_mut().zip(situation).zip(&change) {
            let stretched = i32::from(change.to_bits()).wrapping_mul(step) / length;
            *value = stretched.wrapping_add(i32::from(now.to_bits())).max(0);
        }
        values
    }

    /// The neuron whose action goes farthest in a direction; its inhibition applies to it.
    #[inline(never)]
    fn neuron_of(&self, direction: Direction) -> usize {
        let (mut farthest, mut most) = (0, i32::MIN);
        for (neuron, action) in self.actions.actions().code().iter().enumerate() {
            let [x, y] = action;
            let product = |part: &Weight32, q14: i16| {
                i32::from(to_weight16(*part).to_bits()).wrapping_mul(i32::from(q14 >> 1))
            };
            let along = product(x, direction.x_q14).wrapping_add(product(y, direction.y_q14));
            if along > most {
                (farthest, most) = (neuron, along);
            }
        }
        farthest
    }

    fn is_allowed(&self, direction: Direction) -> bool {
        self.allowed == S::ALL || self.allowed.contains(self.neuron_of(direction))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::action_map::ActionMap;
    use crate::config::Config;
    use crate::fixed::Mask;
    use crate::goal::Component;
    use crate::som::{Grid, Som};
    use crate::units::Bearing;
    use proptest::prelude::*;

    type RawBounds = [(i16, i16, u8); 16];

    fn goal(
        bounds: RawBounds,
        frame: GoalFrame,
        progress_q16: u16,
        heading_hold_q16: u16,
    ) -> Goal<16> {
        Goal {
            frame,
            progress_q16,
            heading_hold_q16,
            ..Goal::of(bounds.map(|(a, b, weight)| Component {
                low: Weight::from_bits(a.min(b)),
                high: Weight::from_bits(a.max(b)),
                weight,
            }))
        }
    }

    fn all_asked(goal: &Goal<16>) -> [ValueBounds; 16] {
        let mut bounds = goal.asked(0, Mask::ALL);
        core::array::from_fn(|_| bounds.next().unwrap())
    }

    /// Uses few different values, so that ties are frequent.
    fn bounds() -> impl Strategy<Value = RawBounds> {
        let value = || prop_oneof![Just(0_i16), Just(4_096), Just(8_192), 0_i16..=8_192];
        prop::array::uniform16((value(), value(), 0_u8..3))
    }

    fn course() -> impl Strategy<Value = Displacement> {
        let component = || prop_oneof![Just(0_i16), -250_i16..=250];
        (component(), component()).prop_map(|(dx_mm, dy_mm)| Displacement { dx_mm, dy_mm })
    }

    /// Actions in 16 directions; the changes rotate with the direction.
    fn actions(changes: [i16; 16]) -> ActionMap<16, 16> {
        let action = |k: usize| {
            let (x, y) = Bearing::of_place(k, 16).direction().times(7_000);
            [x, y].map(|bits| Weight::from_bits(bits as i16))
        };
        let change =
            |k: usize| core::array::from_fn(|i| Weight::from_bits(changes[(16 + i - k) % 16]));
        ActionMap::new(
            Grid::rectangle(4, 4),
            core::array::from_fn(change),
            core::array::from_fn(action),
        )
    }

    struct LookAheadFixture {
        config: Config<16>,
        situations: Som<16, 16>,
        actions: ActionMap<16, 16>,
    }

    impl LookAheadFixture {
        fn new(changes: [i16; 16]) -> Self {
            Self {
                config: Config::recommended(),
                situations: Som::zeroed(Grid::rectangle(4, 4)),
                actions: actions(changes),
            }
        }

        fn planner(&self, course: Displacement, allowed: Mask) -> Planner<'_, 16, 16> {
            Planner {
                config: &self.config,
                situations: &self.situations,
                actions: &self.actions,
                enabled: self.config.enabled,
                allowed,
                current: None,
                course,
                cut: false,
            }
        }
    }

    proptest! {
        /// The travel sensor equals an exhaustive search, for any first guess.
        #[test]
        fn the_travel_sensor_fits_best_and_is_the_lowest_on_ties(
            bounds in bounds(), values in prop::array::uniform16(prop_oneof![Just(0_i16), Just(4_096), 0_i16..=8_192]),
            heading_hold in prop_oneof![Just(0_u16), 0_u16..9_000], course in course(), begin in 0_usize..20,
            mask in prop_oneof![Just(Mask::ALL), any::<u32>().prop_map(Mask::from_bits)],
        ) {
            let goal = goal(bounds, GoalFrame::Travel, 0, heading_hold);
            let mut fixture = LookAheadFixture::new([0; 16]);
            fixture.config.enabled = mask;
            let score = |place: usize| {
                let along = cosine_q14(fixture.config.robot.directions[place], unit(course));
                let asked = goal.asked(place, mask).zip(values.into_iter().map(i32::from));
                cost_of(asked, goal.cap_bits(), i64::MAX) - weighted(heading_hold, along)
            };
            let best = (0..16).min_by_key(|&place| (score(place), place));
            let planner = fixture.planner(course, Mask::ALL);
            let situation = values.map(Weight::from_bits);
            prop_assert_eq!(Some(planner.travel_sensor_from(begin, &situation, &goal)), best);
        }

        /// The best heading by every heading's score, and by every share of a step where the robot
        /// may stay.
        #[test]
        fn the_best_heading_is_the_lowest_on_ties(
            bounds in bounds(), values in prop::array::uniform16(0_i16..=8_192), changes in prop::array::uniform16(-900_i16..=900),
            progress in prop_oneof![Just(0_u16), 0_u16..9_000], course in course(), place in 0_usize..16,
            allowed in prop_oneof![Just(Mask::ALL), any::<u32>().prop_map(Mask::from_bits)],
        ) {
            let goal = goal(bounds, GoalFrame::Ring, progress, 0);
            let fixture = LookAheadFixture::new(changes);
            let planner = fixture.planner(course, allowed);
            let situation = values.map(Weight::from_bits);
            let bounds = all_asked(&goal);
            let view = GoalView { goal: &goal, bounds: &bounds, place, preferred: unit(course) };
            let mut forward = ForwardModel::from(&situation);
            forward.fit(&fixture.actions, fixture.config.action_code, 250);
            let mut cost_surface = CostSurface::flat(goal.cap_bits());
            cost_surface.shape(&forward, &bounds);
            let directions = fixture.config.robot.directions;
            let score = |heading: usize, share_q2: i32| {
                let share = part(directions[heading], share_q2);
                let whole = i64::from(progress) * i64::from(cosine_q14(directions[heading], view.preferred));
                let preferred = ((whole >> 4) * i64::from(share_q2)) >> 2;
                cost_surface.at(share, i64::MAX) - preferred
            };
            let open = (0..16).filter(|&k| allowed.contains(planner.neuron_of(directions[k])));
            let best = planner.best(&situation, &view, &forward);
            let Some(heading) = open.min_by_key(|&k| (score(k, 4), k)) else {
                prop_assert_eq!(best.share_q2, 0);
                return Ok(());
            };
            let shares = if progress == 0 { 0..5 } else { 4..5 };
            let share = shares.min_by_key(|&share| (score(heading, share), share)).unwrap();
            prop_assert_eq!((best.direction, best.share_q2), (directions[heading], share));
            prop_assert_eq!((best.score, best.neuron), (score(heading, share), None));
        }
    }

    #[test]
    fn the_neuron_of_a_direction_moves_farthest_along_it() {
        let fixture = LookAheadFixture::new([0; 16]);
        let planner = fixture.planner(Displacement::ZERO, Mask::ALL);
        for (k, direction) in fixture.config.robot.directions.into_iter().enumerate() {
            assert_eq!(planner.neuron_of(direction), k);
            assert!(planner.is_allowed(direction));
            let without = fixture.planner(Displacement::ZERO, Mask::ALL.without(k));
            assert!(!without.is_allowed(direction));
        }
        assert_eq!(
            planner.neuron_of(Direction::default()),
            0,
            "the first on ties"
        );
        assert_eq!(unit(Displacement::ZERO), Direction::default());
        let (x, y) = (3_000, -4_000);
        let found = unit(Displacement { dx_mm: x, dy_mm: y });
        assert_eq!((found.x_q14, found.y_q14), (9_830, -13_107));
        assert_eq!(
            unit(Displacement { dx_mm: 1, dy_mm: 1 }),
            Direction {
                x_q14: 1 << 14,
                y_q14: 1 << 14
            }
        );
    }

    #[test]
    fn an_action_from_a_quarter_of_a_step_on_has_a_direction() {
        let mut fixture = LookAheadFixture::new([0; 16]);
        for (k, mm) in [(0, 62), (1, 61)] {
            let along = Displacement {
                dx_mm: 0,
                dy_mm: mm,
            };
            let code = fixture.config.action_code.encode(along, 250);
            fixture.actions.actions_mut().set_code_vector(k, &code);
        }
        let goal = goal([(0, 0, 1); 16], GoalFrame::Ring, 0, 0);
        let bounds = all_asked(&goal);
        let (goal, bounds, preferred) = (&goal, &bounds, Direction::default());
        let view = GoalView {
            goal,
            bounds,
            place: 0,
            preferred,
        };
        let planner = fixture.planner(Displacement::ZERO, Mask::ALL);
        let own = |k| planner.own_candidate(&[Weight::ZERO; 16], &view, k);
        let left = Direction {
            x_q14: 0,
            y_q14: 1 << 14,
        };
        assert_eq!(own(0).map(|own| own.direction), Some(left));
        assert!(own(1).is_none());
    }
}
