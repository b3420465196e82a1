//! The four steps of the planner, compared with hand-computed values.

use super::*;
use crate::action_map::Recall;
use crate::config::Planning;
use crate::goal::{Component, GoalFrame};
use crate::robot::RobotSpec;
use crate::som::Grid;
use std::string::ToString as _;

/// Configuration of a robot with four transducers: ahead, left, behind, right.
fn four_sensor_config() -> Config<4> {
    let robot = RobotSpec {
        directions: core::array::from_fn(|sensor| Bearing::of_place(sensor, 4).direction()),
        symmetric: true,
        face_radius_mm: 231,
        body_radius_mm: 269,
        step_mm: 250,
        speed_mm_s: 508,
        braking_mm_s2: 762,
        ring_period_ms: 640,
        steer_ms: 0,
        half_cone: Bearing::ZERO,
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

/// Code vectors: an obstacle ahead, a more distant one ahead, one on the right, none. On the grid
/// of 2 × 2 neurons, 0 and 3 are not neighbors.
const SITUATIONS: [[f64; 4]; 4] = [
    [1.0, 0.0, 0.0, 0.0],
    [0.5, 0.0, 0.0, 0.0],
    [0.0, 0.0, 0.0, 1.0],
    [0.0; 4],
];
/// Moving back decreases the value ahead, moving ahead increases it. Moving left decreases the
/// value on the right, moving right increases it.
const CHANGES: [[f64; 4]; 4] = [
    [-0.5, 0.0, 0.25, 0.0],
    [0.5, 0.0, -0.25, 0.0],
    [0.0, 0.25, 0.0, -0.5],
    [0.0, -0.25, 0.0, 0.5],
];
const ACTIONS: [[f64; 2]; 4] = [[-0.8, 0.0], [0.8, 0.0], [0.0, 0.8], [0.0, -0.8]];

struct PlannerFixture {
    config: Config<4>,
    situations: Som<4, 4>,
    actions: ActionMap<4, 4>,
    course: Displacement,
    cut: bool,
    allowed: Mask,
}

impl PlannerFixture {
    fn new() -> Self {
        let square = Grid::rectangle(2, 2);
        Self {
            config: four_sensor_config(),
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

    fn plan_free(&self, situation: [f64; 4]) -> Plan<4> {
        self.plan(situation, &Goal::free_of_obstacles())
    }
}

fn mm(dx_mm: i16, dy_mm: i16) -> Displacement {
    Displacement { dx_mm, dy_mm }
}

fn is_near(found: Displacement, dx_mm: i16, dy_mm: i16) -> bool {
    found.minus(mm(dx_mm, dy_mm)).length_mm() <= 3
}

/// The paper's four steps: goal neuron, current neuron, subgoal, recall by the difference.
#[test]
fn the_subgoal_is_the_neighbor_nearest_to_the_goal() {
    let mut fixture = PlannerFixture::new();
    for subgoal in [Subgoal::FewestHops, Subgoal::NearestCode] {
        fixture.config.planning.subgoal = subgoal;
        let plan = fixture.plan_free([0.9, 0.0, 0.0, 0.0]);
        assert_eq!((plan.goal_neuron, plan.current_neuron), (3, 0));
        // Both neighbors are one hop from the goal neuron; code vector 1 is nearer to the goal.
        assert_eq!((plan.subgoal_neuron, plan.why), (1, Why::Neighbor));
        // The wanted change leads from the measured situation to the neighbor's code vector.
        assert_eq!(
            plan.wanted,
            difference(&weights(SITUATIONS[1]), &weights([0.9, 0.0, 0.0, 0.0]))
        );
        assert!(!plan.at_goal && plan.recalled && plan.action_neuron == 0);
        assert!(is_near(plan.action, -200, 0), "{:?}", plan.action);
    }
    fixture.config.planning.from_measured = false;
    let plan = fixture.plan_free([0.9, 0.0, 0.0, 0.0]);
    assert_eq!(plan.wanted, weights([-0.5, 0.0, 0.0, 0.0]));
}

#[test]
fn without_a_nearer_neighbor_the_target_is_the_goal() {
    let mut fixture = PlannerFixture::new();
    fixture.config.planning.subgoal = Subgoal::NearestCode;
    // Both neighbors of neuron 0 are farther from the goal than neuron 0.
    fixture
        .situations
        .set_code_vector(1, &weights([1.0, 1.0, 0.0, 0.0]));
    fixture
        .situations
        .set_code_vector(2, &weights([1.0, 0.0, 1.0, 0.0]));
    let plan = fixture.plan_free([0.9, 0.0, 0.0, 0.0]);
    assert_eq!((plan.subgoal_neuron, plan.why), (3, Why::NoNearerNeighbor));
    assert_eq!(
        plan.wanted,
        difference(&[Weight::ZERO; 4], &weights([0.9, 0.0, 0.0, 0.0]))
    );
    // Counted in hops, there is still a nearer neighbor.
    fixture.config.planning.subgoal = Subgoal::FewestHops;
    assert_eq!(fixture.plan_free([0.9, 0.0, 0.0, 0.0]).why, Why::Neighbor);
    // The current neuron is the goal neuron.
    fixture.config.planning.subgoal = Subgoal::NearestCode;
    fixture.situations.set_code_vector(0, &weights([0.0; 4]));
    fixture
        .situations
        .set_code_vector(3, &weights([0.0, 0.0, 0.0, 0.0]));
    let plan = fixture.plan_free([0.0, 0.0, 0.0, 0.1]);
    assert_eq!(
        (plan.goal_neuron, plan.current_neuron, plan.why),
        (0, 0, Why::GoalNeuron)
    );
}

#[test]
fn the_goal_can_be_the_direct_target() {
    let mut fixture = PlannerFixture::new();
    fixture.config.planning.subgoal = Subgoal::Goal;
    let plan = fixture.plan_free([0.0, 0.0, 0.0, 0.75]);
    assert_eq!((plan.subgoal_neuron, plan.why), (3, Why::GoalDirectly));
    assert_eq!(plan.wanted, weights([0.0, 0.0, 0.0, -0.75]));
    assert!(is_near(plan.action, 0, 200), "{:?}", plan.action);
    // With full steps only; with a share of the course added.
    fixture.config.planning.full_steps = true;
    assert!(is_near(
        fixture.plan_free([0.0, 0.0, 0.0, 0.75]).action,
        0,
        250
    ));
    fixture.config.planning.full_steps = false;
    fixture.config.planning.inertia_q8 = 256;
    fixture.course = mm(100, 0);
    let action = fixture.plan_free([0.0, 0.0, 0.0, 0.75]).action;
    assert!(is_near(action, 177, 177), "{action:?}");
}

#[test]
fn with_unmet_only_met_components_cause_no_change() {
    let mut fixture = PlannerFixture::new();
    fixture.config.planning.subgoal = Subgoal::FewestHops;
    let goal = Goal::of([
        Component::equal(Weight::ZERO),
        Component::at_least(Weight::from_num(0.25)),
        Component::ANY,
        Component::equal(Weight::ZERO),
    ]);
    let situation = [1.0, 0.5, 0.0, 0.0];
    let all = fixture.plan(situation, &goal);
    assert_eq!(all.wanted, weights([-0.5, -0.5, 0.0, 0.0]));
    fixture.config.planning.unmet_only = true;
    let unmet = fixture.plan(situation, &goal);
    assert_eq!(unmet.wanted, weights([-0.5, 0.0, 0.0, 0.0]));
}

#[test]
fn at_the_goal_the_course_is_kept_turned_or_straight_ahead() {
    let mut fixture = PlannerFixture::new();
    fixture.course = mm(0, -100);
    let ahead = fixture.plan_free([0.0; 4]);
    assert!(ahead.at_goal && !ahead.recalled && ahead.why == Why::StraightAhead);
    assert_eq!(ahead.action, mm(250, 0));
    fixture.config.planning.at_goal = AtGoal::KeepCourse;
    let kept = fixture.plan_free([0.0; 4]);
    assert!(is_near(kept.action, 0, -250) && kept.why == Why::KeepCourse);
    // After a cut move the course turns by 112.5° to the left.
    fixture.cut = true;
    let turned = fixture.plan_free([0.0; 4]);
    assert_eq!(turned.why, Why::TurnCourse);
    assert!(is_near(turned.action, 231, 96), "{:?}", turned.action);
    // There is no course to keep.
    fixture.course = Displacement::ZERO;
    assert_eq!(fixture.plan_free([0.0; 4]).why, Why::StraightAhead);
    // Within the tolerance, and beyond it.
    fixture.config.planning.tolerance = Weight::from_num(0.125);
    assert!(fixture.plan_free([0.0, 0.1, 0.0, 0.0]).at_goal);
    assert!(!fixture.plan_free([0.0, 0.2, 0.0, 0.0]).at_goal);
}

#[test]
fn with_together_the_action_is_the_mean_of_matching_neurons() {
    let mut fixture = PlannerFixture::new();
    fixture.config.planning.subgoal = Subgoal::Goal;
    fixture.config.planning.together = true;
    // Equal obstacles ahead and on the right: the mean of back and left.
    let plan = fixture.plan_free([0.5, 0.0, 0.0, 0.5]);
    assert!(is_near(plan.action, -100, 100), "{:?}", plan.action);
    // After a cut move only the best neuron counts.
    fixture.cut = true;
    let alone = fixture.plan_free([0.5, 0.0, 0.0, 0.5]);
    assert!(is_near(alone.action, -200, 0), "{:?}", alone.action);
}

/// Two neurons have the same change and opposite actions; their mean of 12 mm has no direction.
#[test]
fn if_matches_cancel_out_the_best_one_is_used() {
    let mut fixture = PlannerFixture::new();
    fixture.config.planning.subgoal = Subgoal::Goal;
    fixture.config.planning.together = true;
    let situation = [0.5, 0.0, 0.0, 0.0];
    let action = |fixture: &mut PlannerFixture, second: f64| {
        fixture.actions = ActionMap::new(
            Grid::rectangle(2, 2),
            [CHANGES[0], CHANGES[0], CHANGES[2], CHANGES[3]].map(weights),
            [[-0.8, 0.0], [second, 0.0], ACTIONS[2], ACTIONS[3]].map(weights),
        );
        fixture.plan_free(situation).action
    };
    let alone = action(&mut fixture, 0.7);
    assert!(is_near(alone, -200, 0), "{alone:?}");
    // A mean of 31 mm, an eighth of a step, has a direction.
    let together = action(&mut fixture, 0.54);
    assert!(is_near(together, -32, 0), "{together:?}");
}

#[test]
fn best_neuron_selects_the_neuron_whose_change_leads_nearest_to_the_goal() {
    let mut fixture = PlannerFixture::new();
    fixture.config.planning.planner = PlannerKind::BestNeuron;
    let free_at = |sensor: usize| {
        let mut components = [Component::ANY; 4];
        components[sensor] = Component::at_most(Weight::ZERO);
        Goal::of(components)
    };
    let plan = fixture.plan([0.6, 0.0, 0.0, 0.0], &free_at(0));
    assert_eq!((plan.why, plan.action_neuron), (Why::LookAhead, 0));
    // A change of -0.5 per 200 mm is -0.625 per full step: 0.6 is reduced to 0.
    assert!(is_near(plan.action, -250, 0), "{:?}", plan.action);
    assert_eq!(plan.wanted[0], Weight::from_num(-0.6));
    let right = fixture.plan([0.0, 0.0, 0.0, 0.6], &free_at(3));
    assert!(is_near(right.action, 0, 250), "{:?}", right.action);
    // Inhibited neurons and neurons with too short an action are excluded.
    fixture.allowed = Mask::NONE.with(0).with(1).with(3);
    fixture.actions = ActionMap::new(
        Grid::rectangle(2, 2),
        CHANGES.map(weights),
        [[-0.1, 0.0], ACTIONS[1], ACTIONS[2], ACTIONS[3]].map(weights),
    );
    let other = fixture.plan_free([0.6, 0.0, 0.0, 0.6]);
    assert!(
        !is_near(other.action, 0, 250) && !is_near(other.action, -250, 0),
        "{:?}",
        other.action
    );
}

/// The goal wants a wall on the right of the direction of travel. The travel sensor is the one for
/// which the wall is on the right.
#[test]
fn the_travel_sensor_fits_the_situation() {
    let mut fixture = PlannerFixture::new();
    fixture.config.planning.planner = PlannerKind::BestHeading;
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
    let travel_sensor = |fixture: &PlannerFixture, situation: [f64; 4], goal: &Goal<4>| {
        let planner = Planner {
            config: &fixture.config,
            situations: &fixture.situations,
            actions: &fixture.actions,
            enabled: fixture.config.enabled,
            allowed: Mask::ALL,
            current: None,
            course: fixture.course,
            cut: false,
        };
        planner.travel_sensor(&weights(situation), goal)
    };
    // The wall at sensor p is on the right when the robot drives towards sensor p + 1.
    for wall in 0..4 {
        let mut situation = [0.0; 4];
        situation[wall] = 0.75;
        assert_eq!(travel_sensor(&fixture, situation, &goal), (wall + 1) % 4);
        // The same without a transducer that has no echo.
        fixture.config.enabled = Mask::ALL.without((wall + 3) % 4);
        assert_eq!(travel_sensor(&fixture, situation, &goal), (wall + 1) % 4);
        fixture.config.enabled = Mask::ALL;
    }
    // With two walls, heading hold selects the one along the course.
    let heading_hold_goal = Goal {
        heading_hold_q16: 6_000,
        ..goal
    };
    fixture.course = mm(0, 100);
    assert_eq!(
        travel_sensor(&fixture, [0.75, 0.0, 0.75, 0.0], &heading_hold_goal),
        1
    );
    fixture.course = mm(0, -100);
    assert_eq!(
        travel_sensor(&fixture, [0.75, 0.0, 0.75, 0.0], &heading_hold_goal),
        3
    );
    // The travel sensor is 0 for goals in the ring's frame and for asymmetric rings.
    assert_eq!(
        travel_sensor(
            &fixture,
            [0.75, 0.0, 0.0, 0.0],
            &Goal {
                frame: GoalFrame::Ring,
                ..goal
            }
        ),
        0
    );
    fixture.config.robot.symmetric = false;
    assert_eq!(travel_sensor(&fixture, [0.75, 0.0, 0.0, 0.0], &goal), 0);
}

#[test]
fn recall_rotates_a_goal_in_the_travel_frame() {
    let fixture = PlannerFixture::new();
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
        config: &fixture.config,
        situations: &fixture.situations,
        actions: &fixture.actions,
        enabled: Mask::ALL,
        allowed: Mask::ALL,
        current: None,
        course: Displacement::ZERO,
        cut: false,
    };
    // For a robot that drives left, the obstacle ahead is on the right.
    let situation = weights([1.0, 0.0, 0.0, 0.0]);
    assert_eq!(planner.travel_sensor(&situation, &goal), 1);
    let plan = planner.plan(&situation, &goal);
    assert_eq!(plan.goal_neuron, 1);
    assert_eq!(plan.wanted[0], Weight::from_num(-0.5));
    // Without a subgoal the target is the goal: 0.5 on the right, 0 ahead.
    let mut config = fixture.config.clone();
    config.planning.subgoal = Subgoal::Goal;
    let planner = Planner {
        config: &config,
        ..planner
    };
    let plan = planner.plan(&weights([0.75, 0.125, 0.0, 0.0]), &goal);
    assert_eq!(plan.wanted, weights([-0.25, -0.125, 0.0, 0.0]));
}

#[test]
fn each_reason_has_its_own_text() {
    let reasons = [
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
    let texts: std::collections::BTreeSet<_> = reasons.iter().map(Why::to_string).collect();
    assert_eq!(texts.len(), reasons.len());
    assert_eq!(Why::LookAhead.to_string(), "look-ahead");
}

/// The plane fitted to all four actions predicts −0.625 ahead per step back.
#[test]
fn best_heading_selects_heading_and_length_of_the_step() {
    let mut fixture = PlannerFixture::new();
    fixture.config.planning.planner = PlannerKind::BestHeading;
    let mut components = [Component::ANY; 4];
    components[0] = Component::at_most(Weight::ZERO);
    let goal = Goal::of(components);
    let plan = fixture.plan([0.9, 0.0, 0.0, 0.0], &goal);
    assert_eq!(
        (plan.why, plan.action_neuron, plan.action),
        (Why::LookAhead, 0, mm(-250, 0))
    );
    assert!(plan.recalled && !plan.at_goal);
    let wanted = plan.wanted[0].to_num::<f64>();
    assert!((wanted + 0.625).abs() < 0.001, "{wanted}");
    // Half a step suffices.
    let half = fixture.plan([0.3, 0.0, 0.0, 0.0], &goal);
    assert_eq!((half.why, half.action), (Why::LookAhead, mm(-125, 0)));
    // At the goal the robot stays.
    let at_goal = fixture.plan([0.0; 4], &goal);
    assert_eq!(
        (at_goal.why, at_goal.action),
        (Why::Stay, Displacement::ZERO)
    );
    assert!(at_goal.at_goal);
    // The expected situation after the step is nearest to neuron 3.
    assert_eq!((plan.current_neuron, half.subgoal_neuron), (0, 3));
}

/// A goal holds if the mean deviation or every deviation is within its tolerance.
#[test]
fn a_goal_holds_by_mean_or_by_every_deviation() {
    let mut fixture = PlannerFixture::new();
    fixture.config.planning.planner = PlannerKind::BestHeading;
    let at_goal = |fixture: &PlannerFixture, tolerance: f64, first: f64| {
        let goal = Goal {
            tolerance: Weight::from_num(tolerance),
            ..Goal::of([Component::equal(Weight::ZERO); 4])
        };
        fixture.plan([first, 0.0, 0.0, 0.0], &goal).at_goal
    };
    fixture.config.planning.tolerance = Weight::from_num(0.125);
    assert!(at_goal(&fixture, 0.0, 0.125) && !at_goal(&fixture, 0.0, 0.25));
    fixture.config.planning.tolerance = Weight::ZERO;
    assert!(at_goal(&fixture, 0.125, 0.25) && !at_goal(&fixture, 0.125, 0.375));
}

#[test]
fn progress_follows_the_course_if_the_goal_allows_any_direction() {
    let mut fixture = PlannerFixture::new();
    fixture.config.planning.planner = PlannerKind::BestHeading;
    let any_situation = Goal {
        progress_q16: 100,
        ..Goal::of([Component::ANY; 4])
    };
    for (course, neuron) in [(mm(0, -100), 3), (mm(0, 70), 2), (mm(-9, 0), 0)] {
        fixture.course = course;
        let plan = fixture.plan([0.2; 4], &any_situation);
        assert_eq!(
            (plan.action, plan.action_neuron),
            (course.with_length(250), neuron)
        );
    }
    // The neuron of this heading is inhibited: two others tie, the first is selected.
    fixture.course = mm(0, -100);
    fixture.allowed = Mask::ALL.without(3);
    assert_eq!(fixture.plan([0.2; 4], &any_situation).action, mm(250, 0));
    fixture.allowed = Mask::NONE;
    let none = fixture.plan([0.2; 4], &any_situation);
    assert_eq!((none.why, none.action), (Why::Stay, Displacement::ZERO));
    // In the travel frame, progress is along the travel sensor, not the course.
    fixture.allowed = Mask::ALL;
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
    // An obstacle at sensor 1 is on the right when the robot drives towards sensor 2.
    assert_eq!(
        fixture.plan([0.0, 1.0, 0.0, 0.0], &travel).action,
        mm(-250, 0)
    );
}

#[test]
fn progress_is_weighed_against_the_deviation() {
    let mut fixture = PlannerFixture::new();
    fixture.config.planning.planner = PlannerKind::BestHeading;
    // The goal allows 0.2 ahead, as measured; a step ahead makes it 0.825: a deviation of 0.39.
    let goal = |progress_q16| Goal {
        progress_q16,
        ..Goal::of([
            Component::at_most(Weight::from_num(0.2)),
            Component::ANY,
            Component::ANY,
            Component::ANY,
        ])
    };
    fixture.course = mm(100, 0);
    // Ahead wins if progress exceeds 0.39 · 65 536 = 25 600.
    assert_eq!(
        fixture.plan([0.2, 0.0, 0.0, 0.0], &goal(26_000)).action,
        mm(250, 0)
    );
    assert_eq!(
        fixture.plan([0.2, 0.0, 0.0, 0.0], &goal(25_200)).action,
        mm(0, 250)
    );
}

#[test]
fn with_straight_a_neuron_along_the_course_is_preferred() {
    let mut fixture = PlannerFixture::new();
    fixture.config.planning.subgoal = Subgoal::Goal;
    let situation = [0.5, 0.0, 0.0, 0.5];
    assert!(is_near(fixture.plan_free(situation).action, -200, 0));
    fixture.course = mm(0, 100);
    fixture.config.planning.straight_q8 = 64;
    assert!(is_near(fixture.plan_free(situation).action, 0, 200));
}

#[test]
fn inertia_adds_a_share_of_the_course_up_to_one_step() {
    let mut fixture = PlannerFixture::new();
    fixture.config.planning.subgoal = Subgoal::Goal;
    fixture.config.planning.inertia_q8 = 64;
    fixture.course = mm(100, 0);
    // A step to the left plus a quarter step ahead, shortened to one step.
    let action = fixture.plan_free([0.0, 0.0, 0.0, 0.75]).action;
    assert!(is_near(action, 60, 242), "{action:?}");
}

#[test]
fn differences_are_clamped_to_one() {
    let (a, b) = (weights([1.0, -1.0, 0.25]), weights([-1.0, 1.0, 0.5]));
    assert_eq!(difference(&a, &b), weights([1.0, -1.0, -0.25]));
    let largest = Weight::from_bits(i16::MAX);
    assert_eq!(difference(&[largest], &[-largest]), [Weight::ONE]);
}

#[test]
fn if_the_current_neuron_meets_the_goal_no_neighbor_is_nearer() {
    let mut fixture = PlannerFixture::new();
    fixture.config.planning.subgoal = Subgoal::NearestCode;
    // Several code vectors meet the goal: the lowest is the goal neuron, the current neuron is the
    // last.
    fixture.situations.set_code_vector(1, &weights([0.0; 4]));
    fixture
        .situations
        .set_code_vector(3, &weights([0.0, 0.0, 0.0, 0.01]));
    let goal = Goal::of([
        Component::ANY,
        Component::ANY,
        Component::ANY,
        Component::at_most(Weight::from_num(0.02)),
    ]);
    let plan = fixture.plan([0.0, 0.0, 0.0, 0.03], &goal);
    assert_eq!(
        (plan.current_neuron, plan.goal_neuron, plan.why),
        (3, 0, Why::NoNearerNeighbor)
    );
}
