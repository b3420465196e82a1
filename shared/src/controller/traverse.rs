//! The graph of traversed situations in the controller: learned from the random moves and from each
//! move towards a goal, and asked for the next aim where one step leads no nearer to a place.

use super::{Mode, State};
use crate::config::{Config, PlannerKind};
use crate::fixed::{Mask, Selection};
use crate::memory;
use crate::planner::{Plan, Planner, Why, difference};
use crate::scan::Situation;
use crate::units::Displacement;

pub(super) use crate::graph::TraversedGraph;

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    State<SENSORS, NEURONS, SAMPLES>
{
    /// Learns the graph anew from the memory, with the maps as they are now.
    pub(super) fn traverse_memory(&mut self, config: &Config<SENSORS>) {
        self.graph = TraversedGraph::new();
        if config.planning.planner != PlannerKind::Traversed {
            return;
        }
        for sample in self.memory.samples() {
            for (bytes, moved) in [
                (&sample.before, Displacement::ZERO),
                (&sample.after, sample.executed),
            ] {
                // Each move begins where the one before ended.
                if moved == Displacement::ZERO && !self.graph.is_interrupted() {
                    continue;
                }
                let (situation, known) = memory::from_bytes(bytes);
                let neuron = self.situations.bmu(&situation, known);
                self.graph.observe(neuron, moved);
            }
        }
        self.graph.interrupt();
    }

    /// The robot may be elsewhere than after its last move.
    pub(super) const fn interrupt_traversal(&mut self) {
        self.graph.interrupt();
    }

    /// Learns from the last move; returns the present neuron where it searched for it.
    pub(super) fn traverse(
        &mut self,
        config: &Config<SENSORS>,
        enabled: Mask,
        situation: &Situation<SENSORS>,
        current: Option<usize>,
    ) -> Option<usize> {
        if config.planning.planner != PlannerKind::Traversed {
            return current;
        }
        let current = current.unwrap_or_else(|| self.situations.bmu(situation, enabled));
        let moved = self.pending.as_ref().map(|pending| pending.executed);
        self.graph
            .observe(current, moved.unwrap_or(Displacement::ZERO));
        Some(current)
    }

    /// Forgets what was traversed: the neurons are others now.
    pub(super) const fn forget_traversals(&mut self) {
        self.graph = TraversedGraph::new();
    }

    /// The plan for a place that a chain of passages leads to, for a robot that would wander
    /// otherwise; `None` where no chain does.
    pub(super) fn plan_traversed<S: Selection>(
        &mut self,
        config: &Config<SENSORS>,
        enabled: Mask,
        allowed: S,
        situation: &Situation<SENSORS>,
        current: Option<usize>,
    ) -> Option<Plan<SENSORS>> {
        let Mode::Seek { goal } = &self.mode else {
            return None;
        };
        if config.planning.planner != PlannerKind::Traversed {
            return None;
        }
        let one_step = Planner {
            config,
            situations: &self.situations,
            actions: &self.actions,
            enabled,
            allowed,
            current,
            course: self.course.now(),
            cut: false,
        }
        .plan(situation, goal);
        let goal_neuron = usize::from(one_step.goal_neuron);
        let aim = self.graph.aim(goal_neuron, config.robot.step_mm)?;
        let code = self.situations.code_vector(usize::from(aim.to));
        Some(Plan {
            subgoal_neuron: aim.to,
            wanted: difference(&code, situation),
            recalled: false,
            action: aim.way,
            why: Why::Neighbor,
            ..one_step
        })
    }
}
