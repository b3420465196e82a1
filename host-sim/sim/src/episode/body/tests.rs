use super::units::millimeters;
use super::*;
use crate::episode::drive_pilot;
use crate::pilot::LocalController;
use amp::config::Config;
use amp::controller::{Command, Decision, Outputs, StopReason};
use amp::fixed::Weight;
use amp::goal::Goal;
use arena::noise::Noise;
use arena::world::Shape;
use std::f64::consts::PI;

const SONARS: [SonarModel; 2] = [SonarModel::Ideal, SonarModel::Nomad];

/// Commands the same motion again and again.
struct StraightPilot {
    way_mm: i16,
    motions: u16,
}

impl StraightPilot {
    /// Slower than the leader. With the ideal sonars a motion ends within its ring.
    fn new(sonar: SonarModel, sense: i16) -> Self {
        let long_mm = if sonar == SonarModel::Ideal {
            30
        } else {
            1_000
        };
        Self {
            way_mm: sense * long_mm,
            motions: 0,
        }
    }
}

impl Pilot for StraightPilot {
    fn handle(&mut self, _: Millis, event: Event<16>) -> Outputs<16> {
        if !matches!(event, Event::Echo { sensor: 15, .. }) {
            return Outputs::NONE;
        }
        self.motions += 1;
        let displacement = Displacement {
            dx_mm: self.way_mm,
            dy_mm: 0,
        };
        let motion = Motion {
            id: self.motions,
            displacement,
            speed_mm_s: 50,
        };
        let decision = Decision {
            situation: [Weight::ZERO; 16],
            plan: None,
            wanted: displacement,
            allowed: displacement,
            at_goal: false,
        };
        Outputs {
            decision: Some(decision),
            motion: (self.way_mm != 0).then_some(motion),
            ..Outputs::NONE
        }
    }
}

fn hall() -> World {
    let walls = Shape::room(Point::new(9.0, 9.0));
    World::new("hall", Pose::default(), vec![walls]).unwrap()
}

/// A robot that faces a leader 0.9 m ahead, which drives straight at it.
fn rammed(world: &World, sonar: SonarModel) -> Body<'_> {
    let mut body = Body::new(world, sonar, TurretMode::Held, 1);
    let leader = Leader::blind(Point::new(0.9, 0.0), PI);
    let crowded = world.with_post(leader.position(), COLLISION_RADIUS_M);
    body.leader = Some((leader, crowded));
    body
}

#[test]
fn who_goes_towards_a_thing_closes_the_gap() {
    let to = |x, y| collision(Point::new(0.5, 0.0), Point::new(x, y));
    for (x, y) in [(0.1, 0.0), (0.01, 0.1), (0.01, -0.1)] {
        assert_eq!(to(x, y), Collision::ByRobot, "{x} {y}");
    }
    for (x, y) in [(0.0, 0.0), (-0.1, 0.0), (-0.01, 0.1), (0.0, 0.1)] {
        assert_eq!(to(x, y), Collision::ByOther, "{x} {y}");
    }
}

/// The robot touches nothing itself before that.
#[test]
fn a_leader_that_rams_the_robot_differs_from_a_robot_that_rolls_into_it() {
    let world = hall();
    for sonar in SONARS {
        for (sense, by) in [
            (1, Collision::ByRobot),
            (0, Collision::ByOther),
            (-1, Collision::ByOther),
        ] {
            let mut body = rammed(&world, sonar);
            let mut pilot = StraightPilot::new(sonar, sense);
            let first = (0..1_000).find_map(|_| {
                let result = body.advance(&mut pilot);
                let touched = result.moved.is_some_and(|moved| moved.touched);
                assert!(!touched, "{sonar:?} {sense}");
                result.collision
            });
            assert_eq!(first, Some(by), "{sonar:?} {sense}");
            let way = body.pose().position.x * f64::from(sense);
            assert!(way > 0.05 || sense == 0, "{sonar:?} {sense}: {way}");
        }
    }
}

/// Contacts count only the robot's own touches. They are counted until the robots meet, because
/// then the robot is stuck.
#[test]
fn metrics_count_both_kinds_of_touch_separately() {
    let world = hall();
    for (sonar, sense, steps, counted) in [
        (SonarModel::Ideal, 1, 3, (1, 0)),
        (SonarModel::Nomad, 1, 3, (1, 0)),
        (SonarModel::Ideal, 0, 4, (0, 1)),
        (SonarModel::Nomad, 0, 4, (0, 1)),
    ] {
        let mut pilot = StraightPilot::new(sonar, sense);
        let body = rammed(&world, sonar);
        let metrics = drive_pilot(&world, &mut pilot, body, steps).unwrap();
        let touches = (metrics.contacts, metrics.touched_by);
        assert_eq!(touches, counted, "{sonar:?} {sense}");
    }
}

/// A controller whose base reports that it moves but gets nowhere.
struct Blocked(LocalController);

impl Pilot for Blocked {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        let event = match event {
            Event::Odometry { motion, turned, .. } => Event::Odometry {
                motion,
                moved: Displacement::ZERO,
                turned,
                progress: Progress::Moving,
            },
            other => other,
        };
        self.0.handle(at, event)
    }
}

#[test]
fn a_motion_that_does_not_end_stops_the_robot() {
    for (sonar, turret) in [
        (SonarModel::Ideal, TurretMode::Held),
        (SonarModel::Nomad, TurretMode::Held),
        (SonarModel::Nomad, TurretMode::Follow),
    ] {
        let world = World::random(1);
        let mut body = Body::new(&world, sonar, turret, 1);
        let mut pilot = Blocked(LocalController::new(Config::recommended()));
        let explore = Command::Explore { moves: 9, seed: 3 };
        let _ = pilot.handle(body.now(), Event::Command(explore));
        let decided_s = loop {
            let result = body.advance(&mut pilot);
            if result.decision.is_some() {
                break result.time_s;
            }
            assert_eq!(result.stopped, None);
        };
        let (stopped, after_s) = loop {
            let result = body.advance(&mut pilot);
            if let Some(reason) = result.stopped {
                break (reason, body.time_s() - decided_s);
            }
            assert!(body.time_s() < decided_s + 5.0);
        };
        assert_eq!(stopped, StopReason::Overdue);
        // The first move is 80 mm at half speed: 0.63 s, plus a second, plus one step at most.
        assert!(after_s > 1.6 && after_s < 2.4, "{after_s}");
    }
}

/// Drives for this many decisions; nothing may stop the robot.
fn decide(body: &mut Body<'_>, pilot: &mut LocalController, count: u32) {
    let (turret, began_s) = (body.turret, body.time_s());
    let mut decisions = 0;
    while decisions < count {
        let result = body.advance(pilot);
        assert_eq!(result.stopped, None, "{turret:?} after {decisions}");
        decisions += u32::from(result.decision.is_some());
        assert!(
            body.time_s() - began_s < 10.0 * f64::from(count),
            "{turret:?}"
        );
    }
}

/// Includes half turns, the longest steering that the robot's description allows.
#[test]
fn a_base_that_works_is_never_overdue() {
    for turret in [TurretMode::Held, TurretMode::Follow] {
        for seed in 1..=4 {
            let world = World::random(seed);
            let mut body = Body::new(&world, SonarModel::Nomad, turret, seed);
            let mut pilot = LocalController::new(Config::recommended());
            let explore = Command::Explore {
                moves: 100,
                seed: 3,
            };
            let _ = pilot.handle(body.now(), Event::Command(explore));
            decide(&mut body, &mut pilot, 100);
            while !body.advance(&mut pilot).mode_changed {}
            let _ = pilot.handle(body.now(), Event::Command(Command::Learn));
            while !pilot.handle(body.now(), Event::Tick).mode_changed {}
            let avoid = Goal::avoiding(&Config::recommended());
            let _ = pilot.handle(body.now(), Event::Command(Command::Seek(avoid)));
            decide(&mut body, &mut pilot, 200);
        }
    }
}

#[test]
fn millimeters_are_rounded_and_saturated() {
    let plain = |m: f64| Displacement::saturating(libm::rint(m * 1e3) as i32, 0).dx_mm;
    let mut noise = Noise::new(3);
    let drawn = (0..100_000).map(|_| noise.uniform_in(-0.05, 0.05));
    let halves = (-70_000..70_000).map(|half| f64::from(half) / 2e3);
    let edges = [
        0.0,
        -0.0,
        32.767,
        32.7675,
        -32.7685,
        1e9,
        -1e300,
        f64::INFINITY,
    ];
    for m in drawn.chain(halves).chain(edges) {
        assert_eq!(millimeters(m), plain(m), "{m}");
    }
}

/// Sums the turns that it is told, and goes straight on.
#[derive(Default)]
struct TurnCounter {
    turned_deg: f64,
    motions: u16,
}

impl Pilot for TurnCounter {
    fn handle(&mut self, _: Millis, event: Event<16>) -> Outputs<16> {
        if let Event::Odometry { turned, .. } = event {
            self.turned_deg += f64::from(turned.as_signed_turns()) * 360.0 / 65_536.0;
        }
        let motion = matches!(event, Event::Echo { sensor: 15, .. }).then(|| {
            self.motions += 1;
            Motion {
                id: self.motions,
                displacement: Displacement {
                    dx_mm: 500,
                    dy_mm: 0,
                },
                speed_mm_s: 500,
            }
        });
        Outputs {
            motion,
            ..Outputs::NONE
        }
    }
}

/// After 4 m a drift of 3° per square root of a meter is 6° on average; 64 robots tell it to 1°.
#[test]
fn a_heading_drifts_and_the_odometry_does_not_know() {
    use crate::robot::{AnyRobot, Ranges};
    use arena::robot_model::RobotModel;

    let world = hall();
    let model = RobotModel {
        heading_drift: 3.0_f64.to_radians(),
        ..RobotModel::builtin("p3dx").unwrap()
    };
    let drifts = |sonar| {
        let robot = AnyRobot::new(model.clone(), Ranges::Own, false).unwrap();
        let squares = (0..64).map(|seed| {
            let mut body = Body::of_robot(&world, &robot, sonar, seed);
            let mut pilot = TurnCounter::default();
            while body.pose().position.length() < 4.0 {
                let _ = body.advance(&mut pilot);
            }
            let true_deg = body.pose().heading.to_degrees();
            (true_deg - pilot.turned_deg).powi(2)
        });
        (squares.sum::<f64>() / 64.0).sqrt()
    };
    let noisy = drifts(SonarModel::Nomad);
    assert!((4.5..7.5).contains(&noisy), "{noisy}");
    let exact = drifts(SonarModel::Ideal);
    assert!(exact < 0.1, "{exact}");
}
