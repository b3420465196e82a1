use super::*;
use crate::behavior::Behavior;
use crate::robot::{AnyRobot, Ranges};
use amp::config::Config;
use arena::robot::TurretMode;
use arena::robot_model::RobotModel;
use arena::sonar::SonarModel;
use arena::world::Shape;

/// A hall of 6 m × 4 m with a box in its middle, around which there are two ways. The robot begins
/// on the left and faces up.
fn hall() -> World {
    let corners = [
        (-3.0, -2.0),
        (3.0, -2.0),
        (3.0, 2.0),
        (-3.0, 2.0),
        (-3.0, -2.0),
    ];
    let walls = Shape::Wall {
        points: corners.map(|(x, y)| Point::new(x, y)).into(),
    };
    let middle = Shape::Box {
        center: Point::default(),
        size: Point::new(1.0, 1.0),
        angle: 0.0,
    };
    let start = Pose::new(Point::new(-2.0, -1.2), std::f64::consts::FRAC_PI_2);
    World::new("hall", start, vec![walls, middle]).expect("a world")
}

fn go(plan: &ErrandPlan) -> (Vec<Errand>, Option<EpisodeError>) {
    let model = RobotModel::builtin("p3dx").expect("a built-in robot");
    let robot = AnyRobot::new(model, Ranges::Nomad, true).expect("16 sensors");
    let config = robot.config(Config::recommended());
    let setup = Setup {
        config: config.clone(),
        preset: "default".to_owned(),
        behavior: Behavior::Avoid,
        explore_moves: 100,
        steps: 1,
        seed: 1,
        sonar: SonarModel::Ideal,
        faults: Vec::new(),
        goal: None,
        second_robot: false,
        turret: TurretMode::Held,
        robot: Some(robot.clone()),
        set_down: None,
        record: false,
    };
    let mut controller = TurretController::new(config, &robot);
    errands(&hall(), &setup, &mut controller, plan).expect("it drives")
}

fn plan() -> ErrandPlan {
    ErrandPlan {
        places: vec![Point::new(2.0, -1.2)],
        period: Period::Round,
        periods: 6,
        steps: 300,
        obstacle: None,
    }
}

#[test]
fn it_goes_to_each_place_and_home_in_each_round() {
    let (errands, stopped) = go(&plan());
    assert_eq!(stopped, None);
    let order: Vec<_> = errands.iter().map(|e| (e.period, e.place)).collect();
    let wanted = (0..6).flat_map(|round| [(round, 0), (round, 1)]);
    assert_eq!(order, wanted.collect::<Vec<_>>());
    for errand in &errands {
        assert!(errand.is_there && errand.has_ended, "{errand:?}");
        assert!(errand.error_m < 0.1 && errand.contacts == 0, "{errand:?}");
        assert!(!errand.is_obstructed && errand.known > 5, "{errand:?}");
        // From one end of the hall to the other, past the box.
        let shortest_m = errand.shortest_m.expect("a way");
        assert!((3.2..4.6).contains(&shortest_m), "{errand:?}");
        assert!(errand.distance_m < 2.0 * shortest_m, "{errand:?}");
    }
}

#[test]
fn what_stands_in_the_way_comes_and_goes() {
    let (errands, stopped) = go(&ErrandPlan {
        obstacle: Some(Obstacle {
            center: Point::new(0.0, -1.2),
            radius_m: 0.5,
            every: 2,
        }),
        ..plan()
    });
    assert_eq!(stopped, None);
    for errand in &errands {
        assert_eq!(errand.is_obstructed, [2, 3].contains(&errand.period));
        assert!(errand.is_there, "{errand:?}");
        // It has to go around on the other side.
        let shortest_m = errand.shortest_m.expect("a way");
        assert_eq!(shortest_m > 4.9, errand.is_obstructed, "{errand:?}");
    }
    // At the end it goes the short way again.
    let last = errands.last().expect("errands");
    assert!(last.distance_m < 4.9, "{last:?}");
}

#[test]
fn nothing_appears_where_the_robot_stands() {
    let (errands, _) = go(&ErrandPlan {
        obstacle: Some(Obstacle {
            // Near home, where each round begins.
            center: Point::new(-2.0, -0.9),
            radius_m: 0.2,
            every: 1,
        }),
        periods: 2,
        ..plan()
    });
    let obstructed: Vec<_> = errands.iter().map(|e| e.is_obstructed).collect();
    assert_eq!(obstructed, [false, false, false, true]);
}

#[test]
fn hours_end_when_their_time_is_over() {
    let (errands, _) = go(&ErrandPlan {
        period: Period::Hour,
        periods: 2,
        ..plan()
    });
    let took_s: f64 = errands.iter().map(|errand| errand.took_s).sum();
    assert!((7_200.0..7_400.0).contains(&took_s), "{took_s}");
    let in_second = errands.iter().filter(|errand| errand.period == 1);
    assert!(in_second.count() * 3 > errands.len());
    assert!(errands.iter().all(|errand| errand.period < 2));
}
