use super::*;
use crate::command::Reset;
use arena::sonar::SonarModel;
use remote::link::{InProcessNode, Session};
use sim::behavior::{Behavior, Tour};
use sim::episode;
use sim::pilot::LocalController;

mod device;
mod places;
mod record;
mod senses;

fn start(sonar: SonarModel) -> SimulatorStart {
    let config = Config::recommended();
    SimulatorStart {
        world: World::builtin("room").unwrap(),
        named: "room".to_owned(),
        setup: Setup {
            config: config.clone(),
            preset: "default".to_owned(),
            behavior: Behavior::Avoid,
            explore_moves: 40,
            steps: 60,
            seed: 3,
            sonar,
            turret: TurretMode::Held,
            robot: None,
            set_down: None,
            faults: Vec::new(),
            goal: None,
            second_robot: false,
            record: true,
        },
        whole: config,
        presets: vec![PresetChoice {
            name: "touzet",
            config: Config::touzet(),
            turret: TurretMode::Follow,
        }],
    }
}

fn simulator(sonar: SonarModel) -> Simulator {
    Simulator::new(start(sonar), ControllerPlace::Host, None).unwrap()
}

fn rest(simulator: &mut Simulator) {
    while simulator.step() != StepOutcome::Idle {}
}

fn educate(simulator: &mut Simulator) {
    for command in [PageCommand::Explore, PageCommand::Learn] {
        simulator.execute(&command).unwrap();
        rest(simulator);
    }
}

/// Runs for `count` decisions; returns the place of each.
fn decide(simulator: &mut Simulator, count: usize) -> Vec<Point> {
    let mut places = Vec::new();
    while places.len() < count {
        let before = simulator.body.pose().position;
        match simulator.step() {
            StepOutcome::Took { whole: true, .. } => places.push(before),
            StepOutcome::Took { .. } => {}
            StepOutcome::Idle => panic!("it stands: {:?}", simulator.failure),
        }
    }
    places
}

#[test]
fn viewers_do_not_change_the_decisions_of_an_episode() {
    for sonar in [SonarModel::Ideal, SonarModel::Nomad] {
        let start = start(sonar);
        let mut controller = LocalController::new(start.setup.config.clone());
        let run =
            episode::run_with(&start.world, &start.setup, &mut controller, |_, _, _| {}).unwrap();
        let recorded = run.recording.unwrap().seeking;
        for watched in [false, true] {
            let mut simulator = simulator(sonar);
            simulator.execute(&PageCommand::Explore).unwrap();
            while simulator.step() != StepOutcome::Idle {
                if watched {
                    let _ = simulator.snapshot().into_parts();
                }
            }
            simulator.execute(&PageCommand::Learn).unwrap();
            rest(&mut simulator);
            simulator.execute(&PageCommand::Seek).unwrap();
            let mut places = Vec::new();
            for _ in 0..recorded.len() {
                places.extend(decide(&mut simulator, 1));
                if watched {
                    let _ = simulator.snapshot().into_parts();
                }
            }
            let wanted: Vec<_> = recorded.iter().map(|step| step.pose.position).collect();
            assert_eq!(places, wanted, "{sonar:?}, watched: {watched}");
        }
    }
}

#[test]
fn a_stop_stands_and_can_be_gone_on_from() {
    let mut simulator = simulator(SonarModel::Nomad);
    simulator.execute(&PageCommand::Explore).unwrap();
    decide(&mut simulator, 5);
    simulator.execute(&PageCommand::Stop).unwrap();
    rest(&mut simulator);
    let stood = simulator.body.pose();
    assert_eq!(simulator.step(), StepOutcome::Idle);
    assert_eq!(simulator.body.pose(), stood);
    assert!(simulator.snapshot().now.resumes);
    simulator.execute(&PageCommand::Resume).unwrap();
    rest(&mut simulator);
    // The interrupted move leaves no sample and is repeated.
    let samples = simulator
        .controller
        .pilot()
        .cached_state()
        .unwrap()
        .memory()
        .samples()
        .len();
    assert_eq!((samples, simulator.activity), (40, SimulatorActivity::Idle));
}

#[test]
fn what_makes_no_sense_is_refused_and_changes_nothing() {
    let mut simulator = simulator(SonarModel::Ideal);
    for command in [
        PageCommand::Learn,
        PageCommand::Seek,
        PageCommand::Resume,
        PageCommand::GoalNeuron { neuron: 3 },
        PageCommand::Behavior {
            name: "seek:/etc/passwd".to_owned(),
            tour: None,
        },
        PageCommand::LoadMind {
            hex: "00".to_owned(),
        },
        PageCommand::GoalFile {
            text: "situation = [1]".to_owned(),
        },
        PageCommand::Sonar {
            number: 16,
            on: true,
        },
        PageCommand::MoveRobot { x: 99.0, y: 0.0 },
        PageCommand::MoveRobot {
            x: f64::NAN,
            y: 0.0,
        },
        PageCommand::MoveShape {
            shape: 999,
            x: 0.0,
            y: 0.0,
        },
        PageCommand::Reset(Reset {
            world: Some("/etc/hostname".to_owned()),
            ..Reset::default()
        }),
    ] {
        let refused = simulator.execute(&command);
        assert!(refused.is_err(), "{command:?}");
        assert_eq!(simulator.activity, SimulatorActivity::Idle, "{command:?}");
        assert_eq!(simulator.step(), StepOutcome::Idle, "{command:?}");
    }
    for number in 0..15 {
        let off = PageCommand::Sonar { number, on: false };
        simulator.execute(&off).unwrap();
    }
    let last = PageCommand::Sonar {
        number: 15,
        on: false,
    };
    assert!(simulator.execute(&last).is_err());
}

#[test]
fn a_neuron_and_a_place_become_goals() {
    let mut simulator = simulator(SonarModel::Ideal);
    educate(&mut simulator);
    simulator
        .execute(&PageCommand::GoalNeuron { neuron: 5 })
        .unwrap();
    simulator.execute(&PageCommand::Seek).unwrap();
    decide(&mut simulator, 3);
    let goal = simulator.snapshot().now.goal;
    assert_eq!((goal.neuron, goal.name.as_str()), (Some(5), "neuron N6"));
    // Captured here and pursued from elsewhere: the robot returns.
    simulator.execute(&PageCommand::Stop).unwrap();
    let here = simulator.body.pose().position;
    simulator.execute(&PageCommand::GoalHere).unwrap();
    let Ok(CommandOutcome::File(file)) = simulator.execute(&PageCommand::SaveGoal) else {
        panic!("no file");
    };
    assert!(file.text.unwrap().contains("situation"));
    let way = Point::new(0.0, 0.0) - here;
    let to = here + way * (0.8 / way.length());
    simulator
        .execute(&PageCommand::MoveRobot { x: to.x, y: to.y })
        .unwrap();
    simulator.execute(&PageCommand::Seek).unwrap();
    decide(&mut simulator, 60);
    let off = simulator.body.pose().position.distance(here);
    assert!(off < 0.3, "{off} m away");
}

/// A behavior and a neuron; a nest is found where the robot is.
#[test]
fn any_goal_is_saved_and_loaded() {
    let mut simulator = simulator(SonarModel::Ideal);
    educate(&mut simulator);
    let goal = |simulator: &mut Simulator, command: &PageCommand| {
        simulator.execute(command).unwrap();
        simulator.goal.goal(&simulator.config, &simulator.nest())
    };
    let named = |name: &str| PageCommand::Behavior {
        name: name.to_owned(),
        tour: None,
    };
    let chosen = [
        named("wall-right"),
        named("follow"),
        PageCommand::GoalNeuron { neuron: 5 },
    ];
    for command in chosen {
        let before = goal(&mut simulator, &command);
        let Ok(CommandOutcome::File(file)) = simulator.execute(&PageCommand::SaveGoal) else {
            panic!("no file");
        };
        simulator.execute(&named("avoid")).unwrap();
        let text = file.text.unwrap();
        let loaded = goal(&mut simulator, &PageCommand::GoalFile { text });
        assert_eq!(loaded, before, "{command:?}");
    }
    simulator.execute(&named("nest")).unwrap();
    assert!(simulator.execute(&PageCommand::SaveGoal).is_err());
}

#[test]
fn an_obstacle_is_met_where_it_was_put_and_never_on_the_robot() {
    let mut start = start(SonarModel::Ideal);
    start.world = World::random(4);
    let mut simulator = Simulator::new(start, ControllerPlace::Host, None).unwrap();
    let robot = simulator.body.pose().position;
    let shapes = simulator.body.world().shapes();
    let index = shapes
        .iter()
        .position(|shape| matches!(shape, arena::world::Shape::Box { .. }));
    let shape = index.expect("a box");
    let before = simulator.body.look();
    let on_it = PageCommand::MoveShape {
        shape,
        x: robot.x,
        y: robot.y,
    };
    assert!(simulator.execute(&on_it).is_err());
    assert_eq!(simulator.body.look(), before);
    let ahead = PageCommand::MoveShape {
        shape,
        x: robot.x + 0.9,
        y: robot.y,
    };
    simulator.execute(&ahead).unwrap();
    let range = simulator.body.look()[0].unwrap();
    assert!(range < 0.6, "{range} m");
}

#[test]
fn a_mind_comes_back_from_its_file() {
    let mut one = simulator(SonarModel::Ideal);
    educate(&mut one);
    let Ok(CommandOutcome::File(file)) = one.execute(&PageCommand::SaveMind) else {
        panic!("no file");
    };
    let hex = file.hex.unwrap();
    let mut other = simulator(SonarModel::Ideal);
    other
        .execute(&PageCommand::LoadMind { hex: hex.clone() })
        .unwrap();
    let Ok(CommandOutcome::File(again)) = other.execute(&PageCommand::SaveMind) else {
        panic!("no file");
    };
    // The generator continues after saving: only seed and checksum differ.
    let again = again.hex.unwrap();
    assert_eq!(again.len(), hex.len());
    let bytes = again.as_bytes().chunks(2).zip(hex.as_bytes().chunks(2));
    let different = bytes.filter(|(one, other)| one != other).count();
    assert!(different <= 8 + 4, "{different} bytes are not the same");
    other.execute(&PageCommand::Seek).unwrap();
    decide(&mut other, 5);
}

#[test]
fn a_new_start_is_one_with_another_seed_and_preset() {
    let mut simulator = simulator(SonarModel::Ideal);
    educate(&mut simulator);
    let reset = Reset {
        seed: Some(9),
        preset: Some("touzet".to_owned()),
        world: Some("random:4".to_owned()),
    };
    simulator.execute(&PageCommand::Reset(reset)).unwrap();
    let setup = &simulator.start.setup;
    assert_eq!((setup.seed, setup.turret), (9, TurretMode::Follow));
    assert_eq!(simulator.start.named, "random:4");
    assert!(simulator.execute(&PageCommand::Seek).is_err());
    educate(&mut simulator);
    simulator.execute(&PageCommand::Seek).unwrap();
    decide(&mut simulator, 5);
}

#[test]
fn a_mind_at_the_end_of_a_link_decides_the_same() {
    let mut places = Vec::new();
    for remote in [false, true] {
        let start = start(SonarModel::Ideal);
        let place = if remote {
            let local = InProcessNode::new(start.setup.config.clone());
            ControllerPlace::Link(Box::new(Session::new(local)), "local".to_owned())
        } else {
            ControllerPlace::Host
        };
        let mut simulator = Simulator::new(start, place, None).unwrap();
        educate(&mut simulator);
        simulator.execute(&PageCommand::Seek).unwrap();
        places.push(decide(&mut simulator, 20));
        simulator.execute(&PageCommand::Stop).unwrap();
        let shield = PageCommand::Shield { on: false };
        simulator.execute(&shield).unwrap();
        simulator.execute(&PageCommand::Resume).unwrap();
        places.push(decide(&mut simulator, 5));
    }
    assert_eq!(places[..2], places[2..]);
}

#[test]
fn a_chain_is_pursued_to_its_last_goal_and_can_be_gone_on_with() {
    let mut simulator = simulator(SonarModel::Ideal);
    educate(&mut simulator);
    let chain = |name: &str| PageCommand::Behavior {
        name: name.to_owned(),
        tour: None,
    };
    let unknown = simulator.execute(&chain("avoid,seek:/etc/passwd"));
    assert!(unknown.is_err());
    simulator.execute(&chain("avoid,avoid")).unwrap();
    simulator.execute(&PageCommand::Seek).unwrap();
    let mut parts = std::collections::BTreeSet::new();
    while simulator.step() != StepOutcome::Idle {
        parts.insert(simulator.snapshot().now.goal.part);
    }
    assert_eq!(parts.into_iter().collect::<Vec<_>>(), [Some(0), Some(1)]);
    let now = simulator.snapshot().now;
    assert_eq!(now.mode, "stopped");
    assert!(now.note.unwrap().contains("the last goal is reached"));
    // Each part ends when its goal has held in twenty decisions.
    assert!(simulator.seeking.goal_steps >= 40);
    simulator.execute(&PageCommand::Resume).unwrap();
    decide(&mut simulator, 5);
    assert_eq!(simulator.snapshot().now.note, None);
}

/// A decision that was taken for the goal before does not count for the next one.
#[test]
fn the_next_goal_of_a_chain_is_reached_by_its_own_decisions() {
    let mut simulator = simulator(SonarModel::Ideal);
    educate(&mut simulator);
    let chain = PageCommand::Behavior {
        name: "avoid,nest".to_owned(),
        tour: None,
    };
    simulator.execute(&chain).unwrap();
    simulator.execute(&PageCommand::Seek).unwrap();
    while simulator.activity == SimulatorActivity::Seek && simulator.seeking.steps < 1_000 {
        decide(&mut simulator, 1);
    }
    let nest = simulator.nest.unwrap().1;
    let off = simulator.body.pose().position.distance(nest);
    assert!(off < 0.4, "{off} m away");
}

#[test]
fn a_log_with_several_starts_plays_from_one_to_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let start = start(SonarModel::Ideal);
    let mut simulator = Simulator::new(start, ControllerPlace::Host, Some(&path)).unwrap();
    educate(&mut simulator);
    simulator.execute(&PageCommand::Seek).unwrap();
    decide(&mut simulator, 30);
    let to = PageCommand::MoveRobot { x: 0.3, y: 0.0 };
    simulator.execute(&to).unwrap();
    decide(&mut simulator, 30);
    let knew = simulator.execute(&PageCommand::SaveMind).unwrap();
    let reset = Reset {
        seed: Some(9),
        world: Some("random:4".to_owned()),
        ..Reset::default()
    };
    simulator.execute(&PageCommand::Reset(reset)).unwrap();
    educate(&mut simulator);
    let knows = simulator.execute(&PageCommand::SaveMind).unwrap();
    let place = simulator.snapshot().now.pose;
    simulator.end().unwrap();

    let log = remote::log::read(&path).unwrap();
    let mut recorded = crate::WatchedLog::new(&log).unwrap();
    while recorded.step() != StepOutcome::Idle {}
    let now = recorded.snapshot().now;
    assert_eq!((now.why, now.mode, now.trail[0]), (None, "idle", 2));
    // 40 moves twice, and the decisions in between.
    assert_eq!(now.at, Some(140));
    assert_eq!(recorded.execute(&PageCommand::SaveMind), Ok(knows));
    let off = (0..3).map(|axis| (now.pose[axis].0 - place[axis].0).abs());
    assert!(off.fold(0.0, f64::max) < 1e-6, "{:?}", now.pose);
    // Back across the restart, to the last decision of the first start.
    recorded.execute(&PageCommand::Jump { to: 100 }).unwrap();
    let now = recorded.snapshot().now;
    assert_eq!((now.mode, now.at, now.trail[0]), ("seek", Some(100), 0));
    assert_eq!(recorded.execute(&PageCommand::SaveMind), Ok(knew));
}
