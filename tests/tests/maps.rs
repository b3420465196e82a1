//! Maps that are learned once serve any goal: a new goal costs no move and no training.

use amp::config::Config;
use amp::controller::{self, Command, Decision, Event, Mode, Outputs};
use amp::fixed::Weight;
use amp::goal::{Component, Goal};
use amp::scan::Situation;
use amp::som::Grid;
use amp::units::Millis;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::World;
use sim::behavior::Behavior;
use sim::episode::{Body, Seeds, perceive};
use sim::pilot::{Pilot, SimState};

/// A controller and, from some moment on, a copy: it gets the same events, and its motions are
/// ignored.
struct TwinController {
    config: Config<16>,
    mind: Box<SimState>,
    twin: Option<Box<SimState>>,
    twins_decision: Option<Decision<16>>,
}

impl Pilot for TwinController {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        if let Some(twin) = &mut self.twin {
            let outputs = controller::handle(&self.config, twin, at, event);
            self.twins_decision = self.twins_decision.or(outputs.decision);
        }
        controller::handle(&self.config, &mut self.mind, at, event)
    }
}

impl TwinController {
    fn send(&mut self, at: Millis, command: Command<16>) -> Outputs<16> {
        let outputs = controller::handle(&self.config, &mut self.mind, at, Event::Command(command));
        assert_eq!(outputs.refusal, None);
        outputs
    }
}

/// Nothing near except for a very near obstacle ahead: almost the opposite of avoiding.
fn touch_ahead(config: &Config<16>) -> Goal<16> {
    let mut goal = Goal::avoiding(config);
    for component in goal.components.iter_mut().take(4) {
        *component = Component::at_least(Weight::ONE);
    }
    goal
}

/// Explores, learns and avoids for `steps` steps in the world.
fn trained<'w>(world: &'w World, steps: usize) -> (TwinController, Body<'w>) {
    let seeds = Seeds::of(1);
    let mut robot = TwinController {
        config: Config::recommended(),
        mind: Box::new(SimState::new(Grid::rectangle(4, 4))),
        twin: None,
        twins_decision: None,
    };
    let mut body = Body::new(world, SonarModel::Ideal, TurretMode::Held, seeds.noise);
    let explore = Command::Explore {
        moves: 100,
        seed: seeds.exploration,
    };
    let _ = robot.send(body.now(), explore);
    while !body.advance(&mut robot).mode_changed {}
    let _ = robot.send(body.now(), Command::Learn);
    while !robot.handle(body.now(), Event::Tick).mode_changed {}
    let avoid = Goal::avoiding(&robot.config);
    let _ = robot.send(body.now(), Command::Seek(avoid));
    for _ in 0..steps {
        let _ = body.advance(&mut robot);
    }
    (robot, body)
}

/// Of 20 next actions, the number that differs when the goal changes to that of `goal`, given the
/// situation before the first move.
fn changed(goal: impl Fn(&Config<16>, &Situation<16>) -> Goal<16>) -> usize {
    let world = World::builtin("paper").expect("a built-in world");
    let mut other_actions = 0;
    for steps in 20..40 {
        let (mut robot, mut body) = trained(&world, steps);
        let before = robot.mind.clone();
        robot.twin = Some(before.clone());
        let (start, config) = (world.start(), &robot.config);
        let (nest, _) = perceive(&world, start, None, SonarModel::Ideal, 1, config);
        let goal = goal(&robot.config, &nest);
        let outputs = robot.send(body.now(), Command::Seek(goal));
        // No move, no change of memory or maps ...
        assert_eq!(outputs.motion, None);
        assert_eq!(*robot.mind.mode(), Mode::Seek { goal });
        assert_eq!(robot.mind.memory(), before.memory());
        assert_eq!(robot.mind.memory().samples().len(), 100);
        assert_eq!(robot.mind.situations(), before.situations());
        assert_eq!(robot.mind.actions(), before.actions());
        // ... and the next decision serves the new goal, from the same situation and maps.
        let decision = body.advance(&mut robot).decision.expect("a decision");
        let twins = robot.twins_decision.expect("the twin decides, too");
        assert_eq!(decision.situation, twins.situation);
        other_actions += usize::from(decision.wanted != twins.wanted);
        let twin = robot.twin.expect("still there");
        assert_eq!(robot.mind.memory(), twin.memory());
        assert_eq!(robot.mind.memory(), before.memory());
        assert_eq!(robot.mind.situations(), twin.situations());
        assert_eq!(robot.mind.actions(), twin.actions());
    }
    other_actions
}

#[test]
fn a_new_goal_costs_no_move_and_no_training() {
    let changed = changed(|config, _| touch_ahead(config));
    assert!(changed >= 18, "{changed} of 20 actions changed");
}

#[test]
fn every_behavior_is_had_at_once_from_the_same_memory() {
    for name in Behavior::NAMES {
        let behavior: Behavior = name.parse().expect(name);
        let changed = changed(|config, nest| behavior.goal(config, nest));
        match behavior {
            Behavior::Avoid => assert_eq!(changed, 0, "the same goal, the same actions"),
            _ => assert!(changed >= 10, "{name}: {changed} of 20 actions changed"),
        }
    }
}
