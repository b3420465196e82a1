//! Records the steps of an episode for pictures.

use super::body::{Body, Moved, StepResult};
use super::metrics::StepFlags;
use super::setup::Setup;
use crate::behavior::Behavior;
use crate::pilot::SimState;
use crate::recording::{MapRecord, PlanTrace, Recording, Step};
use amp::config::Config;
use amp::controller::Decision;
use amp::fixed::{Scalar, Weight, to_weight16};
use amp::memory::from_bytes;
use amp::planner::{Plan, difference};
use arena::world::{Point, Pose, World};
use std::f64::consts::TAU;

/// Steps of the current phase and of the one before.
#[derive(Debug, Default)]
pub(super) struct StepRecorder {
    earlier: Vec<Step>,
    steps: Vec<Step>,
    open: Option<Step>,
}

impl StepRecorder {
    pub(super) fn open(
        &mut self,
        decision: &Decision<16>,
        result: &StepResult,
        body: &Body<'_>,
        part: usize,
    ) {
        self.open = Some(Step {
            pose: result.pose,
            time_s: result.time_s,
            ranges_m: body.ranges_m().to_vec(),
            situation: values(&decision.situation),
            plan: decision.plan.as_ref().map(plan_record),
            commanded_m: meters(decision.wanted),
            executed_m: [0.0, 0.0],
            touched: false,
            shielded: false,
            leader: body.leader(),
            part,
        });
    }

    pub(super) fn moved(&mut self, moved: &Moved) {
        if let Some(step) = &mut self.open {
            let [x, y] = in_frame(step.pose, moved);
            step.executed_m = [step.executed_m[0] + x, step.executed_m[1] + y];
        }
    }

    pub(super) fn close(&mut self, flags: StepFlags) {
        if let Some(step) = self.open.take() {
            self.steps.push(Step {
                touched: flags.touched,
                shielded: flags.shielded,
                ..step
            });
        }
    }

    pub(super) fn next_phase(&mut self) {
        self.earlier = std::mem::take(&mut self.steps);
    }

    pub(super) fn finish(
        self,
        world: &World,
        setup: &Setup,
        robot_radius_m: f64,
        goal_place: Option<Point>,
        state: &SimState,
    ) -> Recording {
        let encoding = &setup.config.encoding;
        let situations = self.situations();
        Recording {
            world: world.clone(),
            behavior: setup.task(),
            parts: setup.behavior.parts().iter().map(Behavior::name).collect(),
            preset: setup.preset.clone(),
            seed: setup.seed,
            bearings_rad: (0..16).map(|i| f64::from(i) * TAU / 16.0).collect(),
            near_m: f64::from(encoding.near_mm) / 1e3,
            far_m: f64::from(encoding.far_mm) / 1e3,
            goal_place,
            robot_radius_m,
            exploration: self.earlier,
            has_toured: setup.behavior.tour().is_some_and(|tour| tour.steps > 0),
            seeking: self.steps,
            situation_map: MapRecord::new(state.situations(), &situations),
            change_map: MapRecord::new(state.actions().changes(), &sampled_changes(state)),
            actions_m: learned_actions(&setup.config, state),
        }
    }

    /// The situations of all steps.
    fn situations(&self) -> Vec<[Weight; 16]> {
        let situation = |step: &Step| std::array::from_fn(|i| Weight::from_num(step.situation[i]));
        self.earlier
            .iter()
            .chain(&self.steps)
            .map(situation)
            .collect()
    }
}

/// Change of situation of each sample in the memory.
fn sampled_changes(state: &SimState) -> Vec<[Weight; 16]> {
    state
        .memory()
        .samples()
        .iter()
        .map(|sample| difference(&from_bytes(&sample.after).0, &from_bytes(&sample.before).0))
        .collect()
}

/// Displacement of each neuron of the action map, m.
fn learned_actions(config: &Config<16>, state: &SimState) -> Vec<[f64; 2]> {
    let displacement = |code: &[_; 2]| {
        let code = code.map(to_weight16);
        meters(config.action_code.decode(code, config.robot.step_mm))
    };
    let actions = state.actions().actions().code();
    actions.iter().map(displacement).collect()
}

fn in_frame(pose: Pose, moved: &Moved) -> [f64; 2] {
    let way = moved.to - moved.from;
    let (sin, cos) = libm::sincos(pose.heading);
    [way.x * cos + way.y * sin, way.y * cos - way.x * sin]
}

fn meters(displacement: amp::units::Displacement) -> [f64; 2] {
    [
        f64::from(displacement.dx_mm) / 1e3,
        f64::from(displacement.dy_mm) / 1e3,
    ]
}

fn values<T: Scalar>(weights: &[T]) -> Vec<f64> {
    weights
        .iter()
        .map(|weight| weight.to_weight32().to_num())
        .collect()
}

fn plan_record(plan: &Plan<16>) -> PlanTrace {
    PlanTrace {
        goal_neuron: usize::from(plan.goal_neuron),
        current_neuron: usize::from(plan.current_neuron),
        subgoal_neuron: usize::from(plan.subgoal_neuron),
        wanted_change: values(&plan.wanted),
        action_neuron: usize::from(plan.action_neuron),
        reason: plan.why.to_string(),
        at_goal: plan.at_goal,
    }
}
