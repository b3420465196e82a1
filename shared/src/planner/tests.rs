//! The four steps, worked by hand.

use super::*;
use crate::action_map::Recall;
use crate::config::Planning;
use crate::goal::{Component, GoalFrame};
use crate::robot::RobotSpec;
use crate::som::Grid;
use std::string::ToString as _;

/// A robot with four transducers (ahead, left, behind, right) whose values are easily worked out by
/// hand.
fn four() -> Config<4> {
    let robot = RobotSpec {
        directions: core::array::from_fn(|place| Bearing::of_place(place, 4).direction()),
        symmetric: true,
        face_radius_mm: 231,
        body_radius_mm: 269,
        step_mm: 250,
        speed_mm_s: 508,
        braking_mm_s2: 762,
        ring_period_ms: 640,
        steer_ms: 0,
    };
    let mut config = Config::recommended().for_robot(robot);
    config.planning = Planning {
        planner: PlannerKind::Recall,
        subgoal: Subgoal::FewestHops,
        recall: Recall::Direction,
        together: false,
        unmet_only: false,
        full_steps: false,
        inhibition: 0,
        wander: None,
        ..Config::touzet().planning
    };
    config
}

fn weights<const COUNT: usize>(values: [f64; COUNT]) -> [Weight; COUNT] {
    values.map(Weight::from_num)
}

/// Something ahead; less of it; something on the right; nothing: on a square of 2 × 2, where the
/// first and the last are no neighbors.
const SITUATIONS: [[f64; 4]; 4] = [
    [1.0, 0.0, 0.0, 0.0],
    [0.5, 0.0, 0.0, 0.0],
    [0.0, 0.0, 0.0, 1.0],
    [0.0; 4],
];
/// Less ahead by going back, more by going on; less on the right by going left, more by going
/// right.
const CHANGES: [[f64; 4]; 4] = [
    [-0.5, 0.0, 0.25, 0.0],
    [0.5, 0.0, -0.25, 0.0],
    [0.0, 0.25, 0.0, -0.5],
    [0.0, -0.25, 0.0, 0.5],
];
const ACTIONS: [[f64; 2]; 4] = [[-0.8, 0.0], [0.8, 0.0], [0.0, 0.8], [0.0, -0.8]];

struct Bench {
    config: Config<4>,
    situations: Som<4, 4>,
    actions: ActionMap<4, 4>,
    course: Displacement,
    cut: bool,
    allowed: Mask,
}

impl Bench {
    fn new() -> Self {
        let square = Grid::rectangle(2, 2);
        Self {
            config: four(),
            situations: Som::new(square, SITUATIONS.map(weights)),
            actions: ActionMap::new(square, CHANGES.map(weights), ACTIONS.map(weights)),
            course: Displacement::ZERO,
            cut: false,
            allowed: Mask::ALL,
        }
    }

    fn plan(&self, situation: [f64; 4], goal: &Goal<4>) -> Plan<4> {
        let planner = Planner {
            config: &self.config,
            situations: &self.situations,
            actions: &self.actions,
            enabled: self.config.enabled,
            allowed: self.allowed,
            current: None,
            course: self.course,
            cut: self.cut,
        };
        planner.plan(&weights(situation), goal)
    }

    fn free(&self, situation: [f64; 4]) -> Plan<4> {
        self.plan(situation, &Goal::free_of_obstacles())
    }
}

fn mm(dx_mm: i16, dy_mm: i16) -> Displacement {
    Displacement { dx_mm, dy_mm }
}

fn near(found: Displacement, dx_mm: i16, dy_mm: i16) -> bool {
    found.minus(mm(dx_mm, dy_mm)).length_mm() <= 3
}

/// The paper's four steps: goal neuron, present neuron, the neighbor nearer to the goal, recall by
/// the difference.
#[test]
fn the_neighbor_nearer_to_the_goal_is_aimed_at() {
    let mut bench = Bench::new();
    for intermediate in [Subgoal::FewestHops, Subgoal::NearestCode] {
        bench.config.planning.subgoal = intermediate;
        let plan = bench.free([0.9, 0.0, 0.0, 0.0]);
        assert_eq!((plan.goal_neuron, plan.current_neuron), (3, 0));
        // Both neighbors are one step from the goal's neuron; less ahead is nearer to nothing than
        // something on the right.
        assert_eq!((plan.subgoal_neuron, plan.why), (1, Why::Neighbor));
        // From what was measured to the neighbor's code vector.
        assert_eq!(
            plan.wanted,
            difference(&weights(SITUATIONS[1]), &weights([0.9, 0.0, 0.0, 0.0]))
        );
        assert!(!plan.at_goal && plan.recalled && plan.action_neuron == 0);
        assert!(near(plan.action, -200, 0), "{:?}", plan.action);
    }
    bench.config.planning.from_measured = false;
    let plan = bench.free([0.9, 0.0, 0.0, 0.0]);
    assert_eq!(plan.wanted, weights([-0.5, 0.0, 0.0, 0.0]));
}

#[test]
fn without_a_nearer_neighbor_the_goal_itself_is_aimed_at() {
    let mut bench = Bench::new();
    bench.config.planning.subgoal = Subgoal::NearestCode;
    // Both neighbors of the first are farther from nothing than it is.
    bench
        .situations
        .set_code_vector(1, &weights([1.0, 1.0, 0.0, 0.0]));
    bench
        .situations
        .set_code_vector(2, &weights([1.0, 0.0, 1.0, 0.0]));
    let plan = bench.free([0.9, 0.0, 0.0, 0.0]);
    assert_eq!((plan.subgoal_neuron, plan.why), (3, Why::NoNearerNeighbor));
    assert_eq!(
        plan.wanted,
        difference(&[Weight::ZERO; 4], &weights([0.9, 0.0, 0.0, 0.0]))
    );
    // By grid steps it has one all the same.
    bench.config.planning.subgoal = Subgoal::FewestHops;
    assert_eq!(bench.free([0.9, 0.0, 0.0, 0.0]).why, Why::Neighbor);
    // A goal the present neuron meets exactly leaves nothing nearer.
    bench.config.planning.subgoal = Subgoal::NearestCode;
    bench.situations.set_code_vector(0, &weights([0.0; 4]));
    bench
        .situations
        .set_code_vector(3, &weights([0.0, 0.0, 0.0, 0.0]));
    let plan = bench.free([0.0, 0.0, 0.0, 0.1]);
    assert_eq!(
        (plan.goal_neuron, plan.current_neuron, plan.why),
        (0, 0, Why::GoalNeuron)
    );
}

#[test]
fn the_goal_can_be_aimed_at_without_a_neighbor() {
    let mut bench = Bench::new();
    bench.config.planning.subgoal = Subgoal::Goal;
    let plan = bench.free([0.0, 0.0, 0.0, 0.75]);
    assert_eq!((plan.subgoal_neuron, plan.why), (3, Why::GoalDirectly));
    assert_eq!(plan.wanted, weights([0.0, 0.0, 0.0, -0.75]));
    assert!(near(plan.action, 0, 200), "{:?}", plan.action);
    // Whole steps only, and a share of the course on top of it.
    bench.config.planning.full_steps = true;
    assert!(near(bench.free([0.0, 0.0, 0.0, 0.75]).action, 0, 250));
    bench.config.planning.full_steps = false;
    bench.config.planning.inertia_q8 = 256;
    bench.course = mm(100, 0);
    let turned = bench.free([0.0, 0.0, 0.0, 0.75]).action;
    assert!(near(turned, 177, 177), "{turned:?}");
}

#[test]
fn what_is_met_already_is_not_wanted_if_so_configured() {
    let mut bench = Bench::new();
    bench.config.planning.subgoal = Subgoal::FewestHops;
    let goal = Goal::of([
        Component::equal(Weight::ZERO),
        Component::at_least(Weight::from_num(0.25)),
        Component::ANY,
        Component::equal(Weight::ZERO),
    ]);
    let situation = [1.0, 0.5, 0.0, 0.0];
    let plain = bench.plan(situation, &goal);
    assert_eq!(plain.wanted, weights([-0.5, -0.5, 0.0, 0.0]));
    bench.config.planning.unmet_only = true;
    let unmet = bench.plan(situation, &goal);
    assert_eq!(unmet.wanted, weights([-0.5, 0.0, 0.0, 0.0]));
}

#[test]
fn at_the_goal_the_course_is_kept_turned_or_straight_ahead() {
    let mut bench = Bench::new();
    bench.course = mm(0, -100);
    let ahead = bench.free([0.0; 4]);
    assert!(ahead.at_goal && !ahead.recalled && ahead.why == Why::StraightAhead);
    assert_eq!(ahead.action, mm(250, 0));
    bench.config.planning.at_goal = AtGoal::KeepCourse;
    let kept = bench.free([0.0; 4]);
    assert!(near(kept.action, 0, -250) && kept.why == Why::KeepCourse);
    // A course that was cut short turns by 112.5° to the left.
    bench.cut = true;
    let turned = bench.free([0.0; 4]);
    assert_eq!(turned.why, Why::TurnCourse);
    assert!(near(turned.action, 231, 96), "{:?}", turned.action);
    // No course to keep.
    bench.course = Displacement::ZERO;
    assert_eq!(bench.free([0.0; 4]).why, Why::StraightAhead);
    // Within the tolerance, and beyond it.
    bench.config.planning.tolerance = Weight::from_num(0.125);
    assert!(bench.free([0.0, 0.1, 0.0, 0.0]).at_goal);
    assert!(!bench.free([0.0, 0.2, 0.0, 0.0]).at_goal);
}

#[test]
fn together_neurons_that_point_the_wanted_way_share_the_action() {
    let mut bench = Bench::new();
    bench.config.planning.subgoal = Subgoal::Goal;
    bench.config.planning.together = true;
    // Ahead and on the right as much: half back, half left.
    let plan = bench.free([0.5, 0.0, 0.0, 0.5]);
    assert!(near(plan.action, -100, 100), "{:?}", plan.action);
    // After a move that was cut the best one alone.
    bench.cut = true;
    let alone = bench.free([0.5, 0.0, 0.0, 0.5]);
    assert!(near(alone.action, -200, 0), "{:?}", alone.action);
}

/// Two bring the same change by opposite actions; their mean of 12 mm is no direction.
#[test]
fn of_answers_that_cancel_out_the_best_one_counts() {
    let mut bench = Bench::new();
    bench.config.planning.subgoal = Subgoal::Goal;
    bench.config.planning.together = true;
    let situation = [0.5, 0.0, 0.0, 0.0];
    let action = |bench: &mut Bench, second: f64| {
        bench.actions = ActionMap::new(
            Grid::rectangle(2, 2),
            [CHANGES[0], CHANGES[0], CHANGES[2], CHANGES[3]].map(weights),
            [[-0.8, 0.0], [second, 0.0], ACTIONS[2], ACTIONS[3]].map(weights),
        );
        bench.free(situation).action
    };
    let alone = action(&mut bench, 0.7);
    assert!(near(alone, -200, 0), "{alone:?}");
    // 31 mm, an eighth of a step, are one.
    let together = action(&mut bench, 0.54);
    assert!(near(together, -32, 0), "{together:?}");
}

#[test]
fn one_step_ahead_the_neuron_whose_own_change_leads_nearest_is_taken() {
    let mut bench = Bench::new();
    bench.config.planning.planner = PlannerKind::BestNeuron;
    let free_at = |place: usize| {
        let mut components = [Component::ANY; 4];
        components[place] = Component::at_most(Weight::ZERO);
        Goal::of(components)
    };
    let plan = bench.plan([0.6, 0.0, 0.0, 0.0], &free_at(0));
    assert_eq!((plan.why, plan.action_neuron), (Why::LookAhead, 0));
    // Its change of -0.5 in 200 mm is -0.625 in a whole step; 0.6 less that is nothing.
    assert!(near(plan.action, -250, 0), "{:?}", plan.action);
    assert_eq!(plan.wanted[0], Weight::from_num(-0.6));
    let right = bench.plan([0.0, 0.0, 0.0, 0.6], &free_at(3));
    assert!(near(right.action, 0, 250), "{:?}", right.action);
    // Inhibited neurons do not answer, and those whose action is too short have no direction.
    bench.allowed = Mask::NONE.with(0).with(1).with(3);
    bench.actions = ActionMap::new(
        Grid::rectangle(2, 2),
        CHANGES.map(weights),
        [[-0.1, 0.0], ACTIONS[1], ACTIONS[2], ACTIONS[3]].map(weights),
    );
    let other = bench.free([0.6, 0.0, 0.0, 0.6]);
    assert!(
        !near(other.action, 0, 250) && !near(other.action, -250, 0),
        "{:?}",
        other.action
    );
}

/// A wall wanted on the right of where the robot goes: the way is the place of the ring from which
/// it is there.
#[test]
fn the_way_of_a_goal_in_the_frame_of_travel_fits_the_situation() {
    let mut bench = Bench::new();
    bench.config.planning.planner = PlannerKind::BestHeading;
    let wanted = Weight::from_num(0.75);
    let goal = Goal {
        frame: GoalFrame::Travel,
        heading_hold_q16: 0,
        ..Goal::of([
            Component::at_most(Weight::from_num(0.1)),
            Component::ANY,
            Component::ANY,
            Component::equal(wanted),
        ])
    };
    let way = |bench: &Bench, situation: [f64; 4], goal: &Goal<4>| {
        let planner = Planner {
            config: &bench.config,
            situations: &bench.situations,
            actions: &bench.actions,
            enabled: bench.config.enabled,
            allowed: Mask::ALL,
            current: None,
            course: bench.course,
            cut: false,
        };
        planner.travel_sensor(&weights(situation), goal)
    };
    // The wall at place p is on the right of whoever goes towards place p + 1.
    for wall in 0..4 {
        let mut situation = [0.0; 4];
        situation[wall] = 0.75;
        assert_eq!(way(&bench, situation, &goal), (wall + 1) % 4);
        // The same if a transducer is not believed that hears nothing anyway.
        bench.config.enabled = Mask::ALL.without((wall + 3) % 4);
        assert_eq!(way(&bench, situation, &goal), (wall + 1) % 4);
        bench.config.enabled = Mask::ALL;
    }
    // Two walls: the one the course goes along.
    let steady = Goal {
        heading_hold_q16: 6_000,
        ..goal
    };
    bench.course = mm(0, 100);
    assert_eq!(way(&bench, [0.75, 0.0, 0.75, 0.0], &steady), 1);
    bench.course = mm(0, -100);
    assert_eq!(way(&bench, [0.75, 0.0, 0.75, 0.0], &steady), 3);
    // A goal in the ring's frame has no way, nor has a ring that is not symmetric.
    assert_eq!(
        way(
            &bench,
            [0.75, 0.0, 0.0, 0.0],
            &Goal {
                frame: GoalFrame::Ring,
                ..goal
            }
        ),
        0
    );
    bench.config.robot.symmetric = false;
    assert_eq!(way(&bench, [0.75, 0.0, 0.0, 0.0], &goal), 0);
}

#[test]
fn a_goal_in_the_frame_of_travel_is_recalled_along_its_way() {
    let bench = Bench::new();
    let goal = Goal {
        frame: GoalFrame::Travel,
        ..Goal::of([
            Component::at_most(Weight::ZERO),
            Component::ANY,
            Component::ANY,
            Component::equal(Weight::from_num(0.5)),
        ])
    };
    let planner = Planner {
        config: &bench.config,
        situations: &bench.situations,
        actions: &bench.actions,
        enabled: Mask::ALL,
        allowed: Mask::ALL,
        current: None,
        course: Displacement::ZERO,
        cut: false,
    };
    // Towards the left, what is ahead is on the right.
    let situation = weights([1.0, 0.0, 0.0, 0.0]);
    assert_eq!(planner.travel_sensor(&situation, &goal), 1);
    let plan = planner.plan(&situation, &goal);
    assert_eq!(plan.goal_neuron, 1);
    assert_eq!(plan.wanted[0], Weight::from_num(-0.5));
    // Without a neuron in between: half of it on the right, and nothing ahead.
    let mut config = bench.config.clone();
    config.planning.subgoal = Subgoal::Goal;
    let planner = Planner {
        config: &config,
        ..planner
    };
    let plan = planner.plan(&weights([0.75, 0.125, 0.0, 0.0]), &goal);
    assert_eq!(plan.wanted, weights([-0.25, -0.125, 0.0, 0.0]));
}

#[test]
fn each_why_has_words_of_its_own() {
    let whys = [
        Why::Neighbor,
        Why::GoalNeuron,
        Why::NoNearerNeighbor,
        Why::GoalDirectly,
        Why::KeepCourse,
        Why::TurnCourse,
        Why::StraightAhead,
        Why::LookAhead,
        Why::Stay,
        Why::Wander,
    ];
    let words: std::collections::BTreeSet<_> = whys.iter().map(Why::to_string).collect();
    assert_eq!(words.len(), whys.len());
    assert_eq!(Why::LookAhead.to_string(), "look-ahead");
}

/// One step ahead by the plane fitted to all four actions: 0.625 less ahead per step back.
#[test]
fn one_step_ahead_the_heading_that_leads_nearest_is_taken_as_far_as_it_helps() {
    let mut bench = Bench::new();
    bench.config.planning.planner = PlannerKind::BestHeading;
    let mut components = [Component::ANY; 4];
    components[0] = Component::at_most(Weight::ZERO);
    let goal = Goal::of(components);
    let plan = bench.plan([0.9, 0.0, 0.0, 0.0], &goal);
    assert_eq!(
        (plan.why, plan.action_neuron, plan.action),
        (Why::LookAhead, 0, mm(-250, 0))
    );
    assert!(plan.recalled && !plan.at_goal);
    let left = plan.wanted[0].to_num::<f64>();
    assert!((left + 0.625).abs() < 0.001, "{left}");
    // Half of a step is enough.
    let half = bench.plan([0.3, 0.0, 0.0, 0.0], &goal);
    assert_eq!((half.why, half.action), (Why::LookAhead, mm(-125, 0)));
    // At a place the robot stays.
    let there = bench.plan([0.0; 4], &goal);
    assert_eq!((there.why, there.action), (Why::Stay, Displacement::ZERO));
    assert!(there.at_goal);
    // The situation to come is that of the neuron nearest to it: nothing.
    assert_eq!((plan.current_neuron, half.subgoal_neuron), (0, 3));
}

/// A look-ahead holds its goal by the mean of all deviations or by each of them.
#[test]
fn a_place_is_reached_on_average_or_at_every_sensor() {
    let mut bench = Bench::new();
    bench.config.planning.planner = PlannerKind::BestHeading;
    let at_goal = |bench: &Bench, tolerance: f64, first: f64| {
        let goal = Goal {
            tolerance: Weight::from_num(tolerance),
            ..Goal::of([Component::equal(Weight::ZERO); 4])
        };
        bench.plan([first, 0.0, 0.0, 0.0], &goal).at_goal
    };
    bench.config.planning.tolerance = Weight::from_num(0.125);
    assert!(at_goal(&bench, 0.0, 0.125) && !at_goal(&bench, 0.0, 0.25));
    bench.config.planning.tolerance = Weight::ZERO;
    assert!(at_goal(&bench, 0.125, 0.25) && !at_goal(&bench, 0.125, 0.375));
}

#[test]
fn who_goes_keeps_to_the_course_where_the_goal_does_not_care() {
    let mut bench = Bench::new();
    bench.config.planning.planner = PlannerKind::BestHeading;
    let anything = Goal {
        progress_q16: 100,
        ..Goal::of([Component::ANY; 4])
    };
    for (course, neuron) in [(mm(0, -100), 3), (mm(0, 70), 2), (mm(-9, 0), 0)] {
        bench.course = course;
        let plan = bench.plan([0.2; 4], &anything);
        assert_eq!(
            (plan.action, plan.action_neuron),
            (course.with_length(250), neuron)
        );
    }
    // The neuron that answers for this heading is inhibited: of both others as good the first.
    bench.course = mm(0, -100);
    bench.allowed = Mask::ALL.without(3);
    assert_eq!(bench.plan([0.2; 4], &anything).action, mm(250, 0));
    bench.allowed = Mask::NONE;
    let none = bench.plan([0.2; 4], &anything);
    assert_eq!((none.why, none.action), (Why::Stay, Displacement::ZERO));
    // In the frame of travel going on is going the chosen way, not the course.
    bench.allowed = Mask::ALL;
    let travel = Goal {
        frame: GoalFrame::Travel,
        progress_q16: 100,
        ..Goal::of([
            Component::ANY,
            Component::ANY,
            Component::ANY,
            Component::at_least(Weight::from_num(0.5)),
        ])
    };
    // Something at place 1 is on the right of whoever goes towards place 2.
    assert_eq!(
        bench.plan([0.0, 1.0, 0.0, 0.0], &travel).action,
        mm(-250, 0)
    );
}

#[test]
fn the_strength_of_going_is_weighed_against_the_deviation() {
    let mut bench = Bench::new();
    bench.config.planning.planner = PlannerKind::BestHeading;
    // Ahead 0.2 is asked and heard, and every step ahead makes it 0.825: a deviation of 0.39.
    let goal = |progress_q16| Goal {
        progress_q16,
        ..Goal::of([
            Component::at_most(Weight::from_num(0.2)),
            Component::ANY,
            Component::ANY,
            Component::ANY,
        ])
    };
    bench.course = mm(100, 0);
    // Ahead less aside: going · 1 against 0.39 · 65 536 = 25 600.
    assert_eq!(
        bench.plan([0.2, 0.0, 0.0, 0.0], &goal(26_000)).action,
        mm(250, 0)
    );
    assert_eq!(
        bench.plan([0.2, 0.0, 0.0, 0.0], &goal(25_200)).action,
        mm(0, 250)
    );
}

#[test]
fn a_neuron_that_keeps_the_course_is_preferred_where_so_configured() {
    let mut bench = Bench::new();
    bench.config.planning.subgoal = Subgoal::Goal;
    let situation = [0.5, 0.0, 0.0, 0.5];
    assert!(near(bench.free(situation).action, -200, 0));
    bench.course = mm(0, 100);
    bench.config.planning.straight_q8 = 64;
    assert!(near(bench.free(situation).action, 0, 200));
}

#[test]
fn a_share_of_the_course_is_added_and_the_sum_is_at_most_a_step() {
    let mut bench = Bench::new();
    bench.config.planning.subgoal = Subgoal::Goal;
    bench.config.planning.inertia_q8 = 64;
    bench.course = mm(100, 0);
    // A step to the left and a quarter of one ahead, brought back to a step.
    let action = bench.free([0.0, 0.0, 0.0, 0.75]).action;
    assert!(near(action, 60, 242), "{action:?}");
}

#[test]
fn changes_are_differences_within_one() {
    let (a, b) = (weights([1.0, -1.0, 0.25]), weights([-1.0, 1.0, 0.5]));
    assert_eq!(difference(&a, &b), weights([1.0, -1.0, -0.25]));
    let opposite = Weight::from_bits(i16::MAX);
    assert_eq!(difference(&[opposite], &[-opposite]), [Weight::ONE]);
}

#[test]
fn a_goal_that_the_present_neuron_meets_has_no_nearer_neighbor() {
    let mut bench = Bench::new();
    bench.config.planning.subgoal = Subgoal::NearestCode;
    // Both the last neuron and the second are nothing; the lower stands for the goal, the robot is
    // at the other one.
    bench.situations.set_code_vector(1, &weights([0.0; 4]));
    bench
        .situations
        .set_code_vector(3, &weights([0.0, 0.0, 0.0, 0.01]));
    let goal = Goal::of([
        Component::ANY,
        Component::ANY,
        Component::ANY,
        Component::at_most(Weight::from_num(0.02)),
    ]);
    let plan = bench.plan([0.0, 0.0, 0.0, 0.03], &goal);
    assert_eq!(
        (plan.current_neuron, plan.goal_neuron, plan.why),
        (3, 0, Why::NoNearerNeighbor)
    );
}
