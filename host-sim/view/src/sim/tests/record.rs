//! Goals shown on the page.

use super::super::Simulator;
use super::{decide, educate, simulator};
use crate::command::{CommandOutcome, PageCommand};
use crate::source::{CommandRefused, ViewSource as _};
use amp::goal::GoalFrame;
use arena::sonar::SonarModel;
use remote::link::ControllerPlace;
use sim::behavior::Behavior;
use sim::goal_file::GoalFile;

fn chosen(simulator: &mut Simulator, name: &str) {
    let name = name.to_owned();
    let behavior = PageCommand::Behavior { name, tour: None };
    simulator.execute(&behavior).unwrap();
}

#[test]
fn what_is_recorded_becomes_the_goal() {
    let mut simulator = simulator(SonarModel::Ideal);
    educate(&mut simulator);
    chosen(&mut simulator, "wall-right");
    simulator.execute(&PageCommand::Seek).unwrap();
    assert_eq!(simulator.snapshot().now.shown, None);
    simulator
        .execute(&PageCommand::Record { on: true })
        .unwrap();
    decide(&mut simulator, 41);
    // The last step is still under way.
    assert_eq!(simulator.snapshot().now.shown, Some((true, 40)));
    simulator
        .execute(&PageCommand::Record { on: false })
        .unwrap();
    decide(&mut simulator, 5);
    assert_eq!(simulator.snapshot().now.shown, Some((false, 40)));
    simulator.execute(&PageCommand::GoalShown).unwrap();
    let goal = simulator.snapshot().now.goal;
    assert_eq!(goal.name, "shown in 40 steps");
    // It is pursued at once, and can be saved.
    let Ok(CommandOutcome::File(file)) = simulator.execute(&PageCommand::SaveGoal) else {
        panic!("no file");
    };
    let saved = GoalFile::read(&file.text.unwrap(), "goal.toml")
        .unwrap()
        .goal;
    assert_eq!(saved.frame, GoalFrame::Travel);
    assert!(saved.progress_q16 > 0);
    // The wall on the right matters.
    assert!(saved.components[12].weight > 0, "{:?}", saved.components);
    let before = simulator.seeking.distance_m;
    decide(&mut simulator, 40);
    let went_m = simulator.seeking.distance_m - before;
    assert!(went_m > 6.0 && simulator.seeking.contacts == 0, "{went_m}");
}

/// A step in which the robot is carried away shows nothing.
#[test]
fn a_step_that_was_interrupted_is_not_shown() {
    let mut simulator = simulator(SonarModel::Ideal);
    educate(&mut simulator);
    simulator.execute(&PageCommand::Seek).unwrap();
    simulator
        .execute(&PageCommand::Record { on: true })
        .unwrap();
    decide(&mut simulator, 3);
    let to = simulator.body.pose().position + arena::world::Point::new(0.1, 0.1);
    simulator
        .execute(&PageCommand::MoveRobot { x: to.x, y: to.y })
        .unwrap();
    decide(&mut simulator, 3);
    // Of six decisions the one before the carrying and the last have not ended.
    assert_eq!(simulator.snapshot().now.shown, Some((true, 4)));
}

#[test]
fn too_little_shown_and_other_robots_are_refused() {
    let mut simulator = simulator(SonarModel::Ideal);
    educate(&mut simulator);
    simulator
        .execute(&PageCommand::Record { on: true })
        .unwrap();
    let Err(CommandRefused(why)) = simulator.execute(&PageCommand::GoalShown) else {
        panic!("it was accepted");
    };
    assert!(why.contains("nothing was perceived"), "{why}");
    simulator
        .execute(&PageCommand::Record { on: true })
        .unwrap();
    simulator.execute(&PageCommand::Seek).unwrap();
    decide(&mut simulator, 6);
    let Err(CommandRefused(why)) = simulator.execute(&PageCommand::GoalShown) else {
        panic!("it was accepted");
    };
    assert!(why.contains("at least 10 moves, not 5"), "{why}");
    let start = super::places::start(SonarModel::Ideal, Behavior::Avoid);
    let mut other = Simulator::new(start, ControllerPlace::Host, None).unwrap();
    assert!(other.execute(&PageCommand::Record { on: true }).is_err());
    assert!(!other.abilities().show);
}
