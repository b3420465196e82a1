//! A decision: a complete ring and a standing base become a random move or a step towards the goal.

use super::motion::Pending;
use super::search::wandering_goal;
use super::tracked::Tracked;
use super::{Decision, Mode, Motion, Outputs, State, StopReason};
use crate::action_map::Effect;
use crate::config::{Config, LearnFrom, PlannerKind};
use crate::fixed::{Mask, Selection, WideMask};
use crate::goal::{Goal, GoalFrame};
use crate::memory::{self, Sample};
use crate::planner::{Plan, Planner, Why};
use crate::scan::{Aligned, Situation};
use crate::som::Neighborhood;
use crate::som::Update;
use crate::units::{Bearing, Direction, Displacement, Millis};

/// The end of a way is reached within this, millimeters.
const ARRIVED_MM: u32 = 100;

/// Neurons that a [`Mask`] can leave out; larger maps need a [`WideMask`].
const MASKED_NEURONS: usize = 32;

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    State<SENSORS, NEURONS, SAMPLES>
{
    /// Takes a decision by the mode.
    // Apart, so that it adds nothing to the stack of other echoes.
    #[inline(never)]
    pub(super) fn decide(&mut self, config: &Config<SENSORS>, now: Millis) -> Outputs<SENSORS> {
        if self.hears_nothing() {
            return self.alarm(now, StopReason::NoEchoes);
        }
        let situation = &Aligned(config.encoding.situation(&self.scan));
        match self.mode {
            Mode::Explore { left } => self.explore(config, now, situation, left),
            Mode::Seek { .. } => self.seek(config, now, situation),
            _ => {
                self.pending = None;
                Outputs::none()
            }
        }
    }

    fn explore(
        &mut self,
        config: &Config<SENSORS>,
        now: Millis,
        situation: &Aligned<SENSORS>,
        left: u16,
    ) -> Outputs<SENSORS> {
        let mut left = left;
        let enabled = self.enabled(config);
        if let Some(pending) = self.pending.take() {
            let seen = enabled.and(same_surfaces(config, &pending.before.0, &situation.0));
            // The command was refused unless the memory holds all the samples.
            let _ = self.memory.keep(Sample {
                before: memory::to_bytes(&pending.before.0, seen),
                after: memory::to_bytes(&situation.0, seen),
                commanded: pending.commanded,
                executed: pending.executed,
            });
            left = left.saturating_sub(1);
        }
        if left == 0 {
            return self.enter(now, Mode::Idle);
        }
        self.mode = Mode::Explore { left };
        let wanted = self.random_move(config, now);
        self.start_motion(config, now, situation, wanted, None)
    }

    /// A random displacement; drawn anew a few times while the shield would take more than half of
    /// it.
    fn random_move(&mut self, config: &Config<SENSORS>, now: Millis) -> Displacement {
        let (shortest, longest) = (config.exploration.shortest_mm, config.robot.step_mm);
        let span = u32::from(longest.saturating_sub(shortest));
        let mut wanted = Displacement::ZERO;
        for _ in 0..config.exploration.draws.max(1) {
            let bearing = Bearing::from_turns((self.random() >> 16) as u16);
            let length = u32::from(shortest).saturating_add(self.below(span.saturating_add(1)));
            wanted = Displacement::along(bearing, length as i32);
            let allowed = self.shield.allow(config, self.enabled(config), wanted, now);
            if allowed.distance_mm >= wanted.length_mm() / 2 {
                break;
            }
        }
        wanted
    }

    fn seek(
        &mut self,
        config: &Config<SENSORS>,
        now: Millis,
        situation: &Aligned<SENSORS>,
    ) -> Outputs<SENSORS> {
        for left in self.inhibited_mut() {
            *left = left.saturating_sub(1);
        }
        let enabled = self.enabled(config);
        // Borrowed: a copy would be expensive.
        let cut = self.pending.as_ref().is_some_and(Pending::was_cut);
        let current = self.learn_online(config, enabled, &situation.0);
        let current = self.traverse(config, enabled, &situation.0, current);
        self.inhibit(config, cut);
        if config.planning.planner != PlannerKind::Recall {
            self.actions.keep_products();
        }
        let situation_now = &situation.0;
        let planned = if NEURONS > MASKED_NEURONS {
            self.plan_step::<WideMask>(config, enabled, situation_now, current, cut)
        } else {
            self.plan_step::<Mask>(config, enabled, situation_now, current, cut)
        };
        let Some((plan, facing)) = planned else {
            return Outputs::none();
        };
        let outputs = self.start_motion(config, now, situation, plan.action, Some(&plan));
        if let Some(direction) = facing {
            let (x, y) = direction.times(i32::from(config.robot.step_mm));
            self.course = Tracked::new(Displacement::saturating(x, y));
        }
        outputs
    }

    /// Plans one step towards the goal, or away from it while the robot wanders; with the direction
    /// that the robot keeps facing while it follows something.
    fn plan_step<S: Selection>(
        &mut self,
        config: &Config<SENSORS>,
        enabled: Mask,
        situation: &Situation<SENSORS>,
        current: Option<usize>,
        cut: bool,
    ) -> Option<(Plan<SENSORS>, Option<Direction>)> {
        let allowed = self.allowed_neurons::<S>();
        // Borrowed: a copy would be expensive.
        let Mode::Seek { goal } = &self.mode else {
            return None;
        };
        let (search, course) = (&mut self.search, &mut self.course);
        let leg = self.is_led.then_some(self.leg);
        let leading = leg.map(|leg| {
            *course = Tracked::new(leg.way.with_length(config.robot.step_mm));
            Goal::leading(config, leg.room_mm)
        });
        let wandering = match &leading {
            Some(_) => None,
            None => wandering_goal(config, enabled, situation, goal, search, course),
        };
        if wandering.is_some()
            && let Some(plan) = self.plan_traversed(config, enabled, S::ALL, situation, current)
        {
            return Some((plan, None));
        }
        let Mode::Seek { goal } = &self.mode else {
            return None;
        };
        if wandering.is_some() || leading.is_some() {
            self.last_plan.forget_cost();
        }
        let planner = Planner {
            config,
            situations: &self.situations,
            actions: &self.actions,
            enabled,
            allowed,
            current,
            course: self.course.now(),
            cut,
        };
        let goal = leading.as_ref().or(wandering.as_ref()).unwrap_or(goal);
        let mut plan = planner.plan_next(situation, goal, &mut self.last_plan);
        let travel = self.last_plan.travel();
        if wandering.is_some() {
            self.last_plan.forget_cost();
            plan.at_goal = false;
            plan.why = Why::Wander;
        }
        if let Some(leg) = leg {
            self.last_plan.forget_cost();
            plan.at_goal = leg.is_last && leg.way.is_shorter_than(ARRIVED_MM);
            plan.action = if plan.at_goal {
                Displacement::ZERO
            } else {
                leg.stride(plan.action, config.robot.step_mm)
            };
        }
        // A robot that backs away from what it follows keeps facing it.
        let keeps_facing = goal.frame == GoalFrame::Travel && goal.progress_q16 == 0;
        let facing = config.robot.directions.get(travel).copied();
        Some((plan, facing.filter(|_| keeps_facing)))
    }

    /// The inhibited neurons and up to three others beside each; mostly none.
    fn inhibited_mut(&mut self) -> impl Iterator<Item = &mut u8> {
        let (fours, rest) = self.inhibited.as_chunks_mut::<4>();
        let fours = fours.iter_mut().filter(|four| **four != [0; 4]);
        fours.flatten().chain(rest)
    }

    /// The action neurons that are not inhibited.
    pub(super) fn allowed_neurons<S: Selection>(&mut self) -> S {
        let mut allowed = S::ALL;
        if self.inhibited_mut().next().is_some() {
            let inhibited = self.inhibited.iter().enumerate();
            for (neuron, _) in inhibited.filter(|(_, left)| **left > 0) {
                allowed = allowed.without(neuron);
            }
        }
        allowed
    }

    /// A move cut below half inhibits the neuron that asked for it.
    fn inhibit(&mut self, config: &Config<SENSORS>, cut: bool) {
        let neuron = self.acting_neuron.filter(|_| cut).map(usize::from);
        if let Some(left) = neuron.and_then(|neuron| self.inhibited.get_mut(neuron)) {
            *left = config.planning.inhibition;
        }
    }

    /// How often the rates of online learning have been halved: after 2048 updates, and each time
    /// their number has doubled since. The rates fall as 1 / n, so that averages converge (Robbins
    /// and Monro, Ann. Math. Stat. 22, 1951): at a constant rate a map drifts within a day.
    pub(super) fn halvings(&mut self) -> u32 {
        self.updates = self.updates.saturating_add(1);
        u16::BITS - (self.updates >> 11).leading_zeros()
    }

    /// Updates both maps by the last move. Returns the best-matching unit of the situation it led
    /// to, if that is known afterwards.
    fn learn_online(
        &mut self,
        config: &Config<SENSORS>,
        enabled: Mask,
        after: &Situation<SENSORS>,
    ) -> Option<usize> {
        let online = config.online?;
        let learns_action = self.learns_action(config, enabled, after)?;
        let halvings = self.halvings();
        let update =
            |rate: u32| Update::from_q16(Neighborhood::Direct, rate >> halvings, online.share_q16);
        if learns_action && let Some(effect) = self.last_effect(config, enabled, after) {
            let winner = match self.acting_neuron {
                Some(neuron) if online.blame_recalled => usize::from(neuron),
                _ => self.actions.bmu(&effect, config.learning.action_weight_q8),
            };
            let action_update = update(online.action_rate_q16);
            self.actions.update(winner, &effect, &action_update);
        }
        let situation_update = update(online.situation_rate_q16);
        let winner = self
            .situations
            .train_step(after, enabled, &situation_update);
        if online.share_q16 != 0 {
            self.last_plan.forget_cost();
        }
        // If the winner alone was updated, it is still the winner.
        (online.share_q16 == 0).then_some(winner)
    }

    /// Whether the action map learns from the last move: few enough transducers met another
    /// surface. `None` without a move.
    fn learns_action(
        &self,
        config: &Config<SENSORS>,
        enabled: Mask,
        after: &Situation<SENSORS>,
    ) -> Option<bool> {
        let before = &self.pending.as_ref()?.before.0;
        let most = usize::from(config.learning.most_changed);
        let others = || enabled.and(same_surfaces(config, before, after).complement());
        // Saves 200 instructions of a decision where all of them may.
        Some(most >= SENSORS || others().indices(SENSORS).count() <= most)
    }

    /// The last move and the change it brought, rotated by random ring steps if so configured.
    fn last_effect(
        &mut self,
        config: &Config<SENSORS>,
        enabled: Mask,
        after: &Situation<SENSORS>,
    ) -> Option<Effect<SENSORS>> {
        let pending = self.pending.as_ref()?;
        let action = match config.learning.learn_from {
            LearnFrom::Commanded => pending.commanded,
            LearnFrom::Executed => pending.executed,
        };
        // The moves of a behavior are one-sided. Rotated by random ring steps they update every
        // direction, as the random moves did.
        let augments = config.learning.augment_rotations
            && config.robot.symmetric
            && enabled.covers(SENSORS)
            && config.planning.planner != PlannerKind::Recall;
        let steps = if augments {
            self.below(SENSORS as u32)
        } else {
            0
        } as usize;
        let action = match config.robot.directions.get(steps) {
            Some(direction) if steps > 0 => action.rotated(*direction),
            _ => action,
        };
        let before = &self.pending.as_ref()?.before.0;
        let largest = config
            .encoding
            .change_bits(config.learning.largest_change_mm);
        // As `same_surfaces`, in the same loop.
        let (mut change, mut mask) = (*after, enabled);
        for (place, slot) in change.iter_mut().enumerate() {
            let from = place.wrapping_add(SENSORS.wrapping_sub(steps));
            let from = from.checked_rem(SENSORS).unwrap_or(0);
            if let (Some(is), Some(was)) = (after.get(from), before.get(from)) {
                *slot = is.wrapping_sub(*was);
            }
            if slot.to_bits().unsigned_abs() > largest {
                mask = mask.without(place);
            }
        }
        Some(Effect {
            change,
            action: config.action_code.encode(action, config.robot.step_mm),
            mask,
        })
    }

    /// Starts a motion, as far as the shield allows.
    fn start_motion(
        &mut self,
        config: &Config<SENSORS>,
        now: Millis,
        situation: &Aligned<SENSORS>,
        wanted: Displacement,
        plan: Option<&Plan<SENSORS>>,
    ) -> Outputs<SENSORS> {
        let (wanted, limit) = self.limit_motion(config, now, wanted, plan.is_some());
        let allowed = wanted.shortened(limit.distance_mm);
        if allowed != Displacement::ZERO {
            self.blocked = 0;
        } else if wanted != Displacement::ZERO {
            self.blocked = self.blocked.wrapping_add(1);
        }
        self.motion_id = self.motion_id.wrapping_add(1);
        if wanted != Displacement::ZERO || config.planning.planner == PlannerKind::Recall {
            self.course = Tracked::new(wanted);
        }
        self.await_ring(now);
        self.pending = Some(Pending {
            before: *situation,
            commanded: wanted,
            executed: Displacement::ZERO,
            remaining: Tracked::new(allowed),
            turned: Bearing::ZERO,
            speed_mm_s: limit.speed_mm_s,
        });
        self.moving = true;
        self.acting_neuron = plan.and_then(|plan| plan.recalled.then_some(plan.action_neuron));
        let motion = Motion {
            id: self.motion_id,
            displacement: allowed,
            speed_mm_s: limit.speed_mm_s,
        };
        self.deadline = self.now.plus_ms(motion.longest_ms());
        Outputs {
            motion: Some(motion),
            decision: Some(Decision {
                situation: situation.0,
                plan: plan.copied(),
                wanted,
                allowed,
                at_goal: plan.is_some_and(|plan| plan.at_goal),
            }),
            ..Outputs::none()
        }
    }
}

/// The transducers that met the same surface before and after a move.
fn same_surfaces<const SENSORS: usize>(
    config: &Config<SENSORS>,
    before: &Situation<SENSORS>,
    after: &Situation<SENSORS>,
) -> Mask {
    let largest_mm = config.learning.largest_change_mm;
    config.encoding.changed_within(before, after, largest_mm)
}
