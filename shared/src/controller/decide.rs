//! A ring is complete and the base stands: what now?

use super::search::Search;
use super::tracked::Tracked;
use super::{Decision, Mode, Motion, Outputs, Pending, State, StopReason};
use crate::action_map::Effect;
use crate::config::{Choice, Config, Taught};
use crate::fixed::Mask;
use crate::goal::{Frame, Goal, cost_of};
use crate::memory::{self, Sample};
use crate::planner::{NEXT_COURSE, Plan, Planner, Why};
use crate::scan::{Aligned, Situation, rotated};
use crate::som::Neighborhood;
use crate::som::neighborhood::Update;
use crate::units::{Bearing, Displacement, Millis};

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    State<SENSORS, NEURONS, SAMPLES>
{
    /// A ring is complete and the base stands. Apart from the echoes that bring about nothing.
    #[inline(never)]
    pub(super) fn decide(&mut self, config: &Config<SENSORS>, now: Millis) -> Outputs<SENSORS> {
        if self.hears_nothing() {
            return self.alarm(now, StopReason::NothingHeard);
        }
        let situation = &Aligned(config.encoding.situation(&self.scan));
        match self.mode {
            Mode::Explore { left } => self.explore(config, now, situation, left),
            Mode::Seek { .. } => self.seek(config, now, situation),
            Mode::Idle | Mode::Learn { .. } | Mode::Stopped(_) => {
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
            // The command was refused unless the memory holds all the samples.
            let _ = self.memory.keep(Sample {
                before: memory::to_bytes(&pending.before.0, enabled),
                after: memory::to_bytes(&situation.0, enabled),
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
        self.go(config, now, situation, wanted, None)
    }

    /// A random displacement; drawn anew a few times while the shield would take more than half of it.
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
        // Stays where it is until the next one takes its place: it is much to copy.
        let cut = self.pending.as_ref().is_some_and(Pending::was_cut);
        let current = self.learn_online(config, enabled, &situation.0);
        self.inhibit(config, cut);
        if config.planning.choice != Choice::Recall {
            self.actions.keep_products();
        }
        let mut allowed = Mask::ALL;
        if self.inhibited_mut().next().is_some() {
            let inhibited = self.inhibited.iter().enumerate();
            for (neuron, _) in inhibited.filter(|(_, left)| **left > 0) {
                allowed = allowed.without(neuron);
            }
        }
        // Looked at where it lies: it is much to copy.
        let Mode::Seek { goal } = &self.mode else {
            return Outputs::none();
        };
        let pursued = pursued(
            config,
            enabled,
            &situation.0,
            goal,
            &mut self.search,
            &mut self.course,
        );
        if pursued.is_some() {
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
        let goal = pursued.as_ref().unwrap_or(goal);
        let mut plan = planner.plan_next(&situation.0, goal, &mut self.last_plan);
        let travel = self.last_plan.travel();
        if pursued.is_some() {
            self.last_plan.forget_cost();
            plan.at_goal = false;
            plan.why = Why::Wander;
        }
        // A robot that backs away from what it follows still looks at it.
        let looks = goal.frame == Frame::Travel && goal.going_q16 == 0;
        let outputs = self.go(config, now, situation, plan.action, Some(&plan));
        if let Some(direction) = config.robot.directions.get(travel).filter(|_| looks) {
            let (x, y) = direction.times(i32::from(config.robot.step_mm));
            self.course = Tracked::new(Displacement::saturating(x, y));
        }
        outputs
    }

    /// Those that are inhibited, and a few others: mostly none at all.
    fn inhibited_mut(&mut self) -> impl Iterator<Item = &mut u8> {
        let (fours, rest) = self.inhibited.as_chunks_mut::<4>();
        let fours = fours.iter_mut().filter(|four| **four != [0; 4]);
        fours.flatten().chain(rest)
    }

    /// A move cut below half inhibits the neuron that asked for it.
    fn inhibit(&mut self, config: &Config<SENSORS>, cut: bool) {
        let asked = self.asked_by.filter(|_| cut);
        let neuron = asked.map(usize::from);
        if let Some(left) = neuron.and_then(|neuron| self.inhibited.get_mut(neuron)) {
            *left = config.planning.inhibition;
        }
    }

    /// How often the rates of online learning have been halved: after 2048 lessons, and each time their number has doubled
    /// since. So they fall as 1 / n, by which averages settle (Robbins and Monro, Ann. Math. Stat. 22, 1951): a map that
    /// learns for a day by steps that stay as long wanders off.
    pub(super) fn halvings(&mut self) -> u32 {
        self.lessons = self.lessons.saturating_add(1);
        u16::BITS - (self.lessons >> 11).leading_zeros()
    }

    /// Both maps learn from the last move: the best-matching unit of the situation it led to, if it is known afterwards.
    fn learn_online(
        &mut self,
        config: &Config<SENSORS>,
        enabled: Mask,
        after: &Situation<SENSORS>,
    ) -> Option<usize> {
        let online = config.online?;
        let pending = self.pending.as_ref()?;
        let taught = match config.learning.taught {
            Taught::Commanded => pending.commanded,
            Taught::Executed => pending.executed,
        };
        // Both lie in [0, 1].
        let mut change = *after;
        for (value, before) in change.iter_mut().zip(&pending.before.0) {
            *value = value.wrapping_sub(*before);
        }
        // The moves of a behavior are one-sided; turned by a random number of ring places they teach every
        // direction, as the random moves did.
        let turns = config.learning.turned
            && config.robot.symmetric
            && enabled.covers(SENSORS)
            && config.planning.choice != Choice::Recall;
        let places = if turns { self.below(SENSORS as u32) } else { 0 } as usize;
        let turned = match config.robot.directions.get(places) {
            Some(direction) if places > 0 => taught.rotated(*direction),
            _ => taught,
        };
        if places > 0 {
            change = rotated(&change, places);
        }
        let effect = Effect {
            change,
            action: config.action_code.encode(turned, config.robot.step_mm),
            mask: enabled,
        };
        let halvings = self.halvings();
        let pull =
            |rate: u32| Update::new(Neighborhood::Direct, rate >> halvings, online.share_q16);
        let winner = match self.asked_by {
            Some(neuron) if online.blame_recalled => usize::from(neuron),
            _ => self
                .actions
                .winner(&effect, config.learning.action_weight_q8),
        };
        let action_pull = pull(online.action_rate_q16);
        if config.planning.choice == Choice::Recall {
            self.actions.learn(winner, &effect, &action_pull);
        } else {
            self.actions.learn_on(winner, &effect, &action_pull);
        }
        let situation_pull = pull(online.situation_rate_q16);
        let winner = self.situations.teach(after, enabled, &situation_pull);
        if online.share_q16 != 0 {
            self.last_plan.forget_cost();
        }
        // A winner that came nearer, alone, is still the winner.
        (online.share_q16 == 0).then_some(winner)
    }

    /// Sends the base on its way as far as the shield allows.
    fn go(
        &mut self,
        config: &Config<SENSORS>,
        now: Millis,
        situation: &Aligned<SENSORS>,
        wanted: Displacement,
        plan: Option<&Plan<SENSORS>>,
    ) -> Outputs<SENSORS> {
        let enabled = self.enabled(config);
        let aside = self.shield.step_aside(config, enabled, wanted, now);
        let (wanted, limit) = aside.unwrap_or_else(|| match plan {
            Some(_) => (self.shield).detour(config, enabled, wanted, now, self.closed),
            None => (wanted, self.shield.allow(config, enabled, wanted, now)),
        });
        let allowed = if wanted.is_shorter_than(u32::from(limit.distance_mm).wrapping_add(1)) {
            wanted
        } else {
            wanted.with_length(limit.distance_mm)
        };
        if allowed != Displacement::ZERO {
            self.closed = 0;
        } else if wanted != Displacement::ZERO {
            self.closed = self.closed.wrapping_add(1);
        }
        self.motion_id = self.motion_id.wrapping_add(1);
        if wanted != Displacement::ZERO || config.planning.choice == Choice::Recall {
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
        self.asked_by = plan.and_then(|plan| plan.recalled.then_some(plan.action_neuron));
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

/// What is pursued instead of the goal while the robot wanders: obstacle avoidance on another course.
fn pursued<const SENSORS: usize>(
    config: &Config<SENSORS>,
    enabled: Mask,
    situation: &Situation<SENSORS>,
    goal: &Goal<SENSORS>,
    search: &mut Search,
    course: &mut Tracked,
) -> Option<Goal<SENSORS>> {
    let wander = config.planning.wander?;
    if goal.going_q16 > 0 || goal.frame != Frame::Ring {
        return None;
    }
    let values = situation.iter().map(|value| i32::from(value.to_bits()));
    let asked = || goal.asked(0, enabled);
    let deviation = cost_of(asked(), values, goal.cap_bits(), i64::MAX);
    if goal.is_met_by(deviation, asked()) {
        *search = Search::NEW;
    } else if search.is_stuck(deviation, wander) {
        let onward = course.now().with_length(config.robot.step_mm);
        *course = Tracked::new(onward.rotated(NEXT_COURSE.direction()));
    }
    search.wanders().then(|| Goal::avoiding(config))
}
