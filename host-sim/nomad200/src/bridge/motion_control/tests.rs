use super::*;
use crate::{Protocol, RobotLine, SimulatedNomad, StateMask};
use arena::sonar::SonarModel;
use arena::world::{Pose, Shape, World};
use remote::link::Transport;
use std::io;
use std::time::Duration;

/// A robot in this process; each wait for an answer lasts one millisecond of its time.
struct Here(RobotLine);

impl Transport for Here {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.receive(bytes);
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], _: Duration) -> io::Result<usize> {
        self.0.advance(1);
        let answer = self.0.take();
        buffer
            .iter_mut()
            .zip(&answer)
            .for_each(|(to, from)| *to = *from);
        Ok(answer.len())
    }
}

/// A robot `x` m before a wall.
fn robot(x: f64) -> Host {
    let points = vec![Point::new(x, -9.0), Point::new(x, 9.0)];
    let world = World::new("wall", Pose::default(), vec![Shape::Wall { points }]).unwrap();
    let robot = SimulatedNomad::new(world, SonarModel::Ideal, 1);
    let mut host = Host::new(Here(RobotLine::new(robot, Protocol::Direct)));
    let mask = StateMask {
        infrared: 0,
        laser: false,
        ..StateMask::ALL
    };
    host.request(&NomadCommand::Communicate(mask)).unwrap();
    host
}

fn motion(id: u16) -> Motion {
    Motion {
        id,
        displacement: Displacement { dx_mm: 1, dy_mm: 0 },
        speed_mm_s: 508,
    }
}

fn begin(course: &mut MotionControl, host: &mut Host, goal: Point, motion: &Motion) {
    let state = host.state().clone();
    course.begin(host, &state, goal, motion).unwrap();
}

/// Polls the state and follows the motion; returns how it ended, if it has.
fn look(course: &mut MotionControl, host: &mut Host) -> Ended {
    let state = host.request(&NomadCommand::GetState).unwrap().clone();
    if state.bumpers != 0 {
        course.touched(host).unwrap();
    }
    course.follow(host, &state).unwrap()
}

fn look_for(course: &mut MotionControl, host: &mut Host, times: u32) {
    for _ in 0..times {
        assert_eq!(look(course, host), None);
    }
}

fn to_the_end(course: &mut MotionControl, host: &mut Host) -> Progress {
    let ended = (0..10_000).find_map(|_| look(course, host));
    ended.expect("an end within ten seconds")
}

#[test]
fn it_steers_the_nearer_way_and_rolls_to_the_goal_but_never_beyond() {
    for (x, y) in [
        (0.25, 0.0),
        (-0.25, 0.0),
        (0.1, 0.2),
        (-0.1, 0.2),
        (-0.17, -0.17),
        (0.003, 0.2),
    ] {
        let (mut host, mut course) = (robot(5.0), MotionControl::default());
        let goal = Point::new(x, y);
        begin(&mut course, &mut host, goal, &motion(1));
        assert_eq!(to_the_end(&mut course, &mut host), Progress::Ended);
        let state = host.state();
        let here = position(&state.pose);
        assert!(here.distance(goal) < 0.006, "{x} {y}: {here:?}");
        assert!(here.length() <= goal.length() + 0.0013, "{x} {y}: {here:?}");
        // A quarter turn at most, without the turret.
        let steered = state.pose[2].min(3_600 - state.pose[2]);
        assert!(steered <= 900 && state.pose[3] == 0);
        // It ends only once.
        assert_eq!(look(&mut course, &mut host), None);
    }
}

#[test]
fn a_shortened_motion_ends_there_and_one_that_is_stopped_where_it_can() {
    let (mut host, mut course) = (robot(5.0), MotionControl::default());
    begin(&mut course, &mut host, Point::new(1.0, 0.0), &motion(1));
    look_for(&mut course, &mut host, 500);
    begin(&mut course, &mut host, Point::new(0.4, 0.0), &motion(1));
    assert_eq!(to_the_end(&mut course, &mut host), Progress::Ended);
    assert!((position(&host.state().pose).x - 0.4).abs() < 0.004);
    // A late shortening of an ended motion begins nothing.
    begin(&mut course, &mut host, Point::new(0.9, 0.0), &motion(1));
    look_for(&mut course, &mut host, 300);
    // Nearer than the braking distance: it brakes and does not return.
    begin(&mut course, &mut host, Point::new(1.4, 0.0), &motion(2));
    look_for(&mut course, &mut host, 600);
    let (from, speed) = (host.state().pose[0], f64::from(host.state().velocity[0]));
    let near = position(&host.state().pose) + Point::new(0.01, 0.0);
    begin(&mut course, &mut host, near, &motion(2));
    assert_eq!(to_the_end(&mut course, &mut host), Progress::Ended);
    let braked = f64::from(host.state().pose[0] - from);
    assert!((braked - speed * speed / 600.0).abs() < 4.0, "{braked}");
    // Without displacement it stands and reports the end.
    let none = Motion {
        displacement: Displacement::ZERO,
        ..motion(3)
    };
    begin(&mut course, &mut host, Point::default(), &none);
    assert_eq!(to_the_end(&mut course, &mut host), Progress::Ended);
    assert_eq!(course.id(), Some(3));
}

#[test]
fn a_new_direction_waits_until_the_base_stands() {
    let (mut host, mut course) = (robot(5.0), MotionControl::default());
    begin(&mut course, &mut host, Point::new(1.0, 0.0), &motion(1));
    look_for(&mut course, &mut host, 500);
    let goal = position(&host.state().pose) + Point::new(0.0, 0.3);
    begin(&mut course, &mut host, goal, &motion(2));
    let mut steered_rolling = false;
    while look(&mut course, &mut host).is_none() {
        let state = host.state();
        steered_rolling |= state.velocity[0] != 0 && state.velocity[1] != 0;
    }
    assert!(!steered_rolling);
    assert!(position(&host.state().pose).distance(goal) < 0.006);
}

#[test]
fn a_wall_ends_a_motion_as_a_touch_and_a_silent_mind_ends_it_too() {
    let (mut host, mut course) = (robot(0.5), MotionControl::default());
    begin(&mut course, &mut host, Point::new(1.0, 0.0), &motion(1));
    assert_eq!(to_the_end(&mut course, &mut host), Progress::Touched);
    // Away from the wall there is no contact.
    begin(&mut course, &mut host, Point::new(-0.5, 0.0), &motion(2));
    look_for(&mut course, &mut host, 300);
    assert_eq!(course.expire(&mut host), Ok(true));
    assert_eq!(course.expire(&mut host), Ok(false));
    assert_eq!(to_the_end(&mut course, &mut host), Progress::Ended);
    assert!(position(&host.state().pose).x > -0.4);
}

/// The base's own time-out may stop the wheels half-way; they are turned again before the base
/// rolls.
#[test]
fn wheels_that_were_stopped_on_their_way_are_turned_again() {
    let (mut host, mut course) = (robot(5.0), MotionControl::default());
    begin(&mut course, &mut host, Point::new(0.0, 0.25), &motion(1));
    look_for(&mut course, &mut host, 700);
    host.request(&NomadCommand::Stop).unwrap();
    assert_eq!(to_the_end(&mut course, &mut host), Progress::Ended);
    assert!(position(&host.state().pose).distance(Point::new(0.0, 0.25)) < 0.006);
}

/// The line's delays do not count as time of the motion; blocked wheels do.
#[test]
fn it_steers_until_it_is_seen_to_roll_or_to_stand() {
    let (mut host, mut course) = (robot(5.0), MotionControl::default());
    begin(&mut course, &mut host, Point::new(0.0, 0.25), &motion(1));
    let mut said = Vec::new();
    loop {
        let is_steering = course.is_steering(host.state());
        let [rolling, turning, _] = host.state().velocity;
        let seen = (is_steering, rolling != 0, turning != 0);
        if said.last() != Some(&seen) {
            said.push(seen);
        }
        if look(&mut course, &mut host).is_some() {
            break;
        }
    }
    let turns_and_rolls = [
        (true, false, false),
        (true, false, true),
        (true, false, false),
        // It has begun but is too slow to be seen rolling.
        (false, false, false),
        (false, true, false),
        (false, false, false),
    ];
    assert_eq!(said, turns_and_rolls);
    // Braking takes time and is reported.
    begin(&mut course, &mut host, Point::new(0.0, 1.0), &motion(2));
    look_for(&mut course, &mut host, 500);
    assert!(!course.is_steering(host.state()));
    course.expire(&mut host).unwrap();
    look_for(&mut course, &mut host, 1);
    assert!(course.is_steering(host.state()));
    to_the_end(&mut course, &mut host);
    assert!(!course.is_steering(host.state()));
}

#[test]
fn blocked_wheels_do_not_steer() {
    let robot = SimulatedNomad::new(World::random(1), SonarModel::Ideal, 1);
    let robot = robot.with_wheels_blocked_after(0.05);
    let mut host = Host::new(Here(RobotLine::new(robot, Protocol::Direct)));
    let mask = crate::bridge::mask(0);
    host.request(&NomadCommand::Communicate(mask)).unwrap();
    let mut course = MotionControl::default();
    begin(&mut course, &mut host, Point::new(0.25, 0.0), &motion(1));
    look_for(&mut course, &mut host, 5_000);
    // The motor runs, but the base does not move.
    let state = host.state();
    assert_eq!((state.motors & 1, state.velocity), (1, [0; 3]));
    assert!((position(&state.pose).length() - 0.05).abs() < 0.003);
    assert!(!course.is_steering(state));
    course.expire(&mut host).unwrap();
    assert_eq!(to_the_end(&mut course, &mut host), Progress::Ended);
}
