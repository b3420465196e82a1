use super::*;
use crate::controller::{Command, Progress};
use crate::goal::Goal;
use crate::turret::tests::{Rig, ring_body};
use crate::units::Range;
use core::num::NonZeroU16;
use std::vec::Vec;

/// What a robot is allowed that stands: it hears these ranges so often and wants to go this way.
struct Standing(Rig);

impl Standing {
    fn new(margin_mm: u16, least_range_mm: u16) -> Self {
        let mut body = ring_body(None);
        body.guard = NonZeroU16::new(margin_mm).map(|margin_mm| Guard {
            margin_mm,
            least_range_mm,
        });
        Self(Rig::new(body))
    }

    /// All sensors hear something at 2 m but for these.
    fn hears(&mut self, near: &[(usize, u16)]) -> &mut Self {
        let mut ranges = [Some(2_000); 16];
        for (sensor, mm) in near {
            ranges[*sensor] = Some(*mm);
        }
        self.0.hear(ranges);
        self
    }

    /// How far it may go where this sensor looks, of 250 mm.
    fn allowed_mm(&mut self, sensor: usize) -> u16 {
        self.allowed_to_mm(Bearing::of_place(sensor, 16))
    }

    fn allowed_to_mm(&mut self, bearing: Bearing) -> u16 {
        self.allowed_of(Displacement::along(bearing, 250))
    }

    fn allowed_of(&mut self, way: Displacement) -> u16 {
        self.0.with_robot(|robot| robot.guarded(way).length_mm())
    }

    fn moves(&mut self, by: Displacement) {
        let still = Motion {
            id: 0,
            displacement: Displacement::ZERO,
            speed_mm_s: 0,
        };
        self.0.report(still, by, 0, Progress::Ended);
    }
}

/// The body's radius is 269, the margin 50, the faces are at 231, and the cone's chord is nearer.
#[test]
fn a_way_ends_at_the_margin_wherever_in_a_cone_a_thing_stands() {
    let mut robot = Standing::new(50, 0);
    robot.hears(&[(0, 300)]);
    let ahead = robot.allowed_mm(0);
    assert!((193..=212).contains(&ahead), "{ahead}");
    // 12° beside the axis it may stand as well.
    let beside = robot.allowed_to_mm(Bearing::of_place(1, 30));
    assert!(beside < 215, "{beside}");
    assert!(robot.allowed_mm(8) >= 249);
}

/// The robot has gone back since: from there its cone holds all of the arc.
#[test]
fn one_echo_from_beyond_opens_no_way_and_a_second_does() {
    let mut robot = Standing::new(50, 0);
    robot.hears(&[(0, 80)]);
    robot.moves(Displacement::along(Bearing::ZERO, -500));
    let way = Displacement::along(Bearing::ZERO, 700);
    let mut allowed = || robot.hears(&[]).allowed_of(way);
    let (after_one, after_two) = (allowed(), allowed());
    assert!((450..=500).contains(&after_one), "{after_one}");
    assert!(after_two >= 699, "{after_two}");
}

/// An infrared sensor that hears nothing sees that nothing is there. A sonar that now hears from
/// elsewhere does not.
#[test]
fn silence_opens_a_way_for_what_sees_free_space() {
    for (silence_mm, is_open) in [(None, false), (Some(1_500), true)] {
        let mut robot = Standing::new(50, 0);
        robot.0.body.silence_mm = silence_mm.and_then(NonZeroU16::new);
        robot.hears(&[(0, 80)]);
        robot.moves(Displacement::along(Bearing::ZERO, -500));
        robot.0.hear([None; 16]);
        robot.0.hear([None; 16]);
        let way = Displacement::along(Bearing::ZERO, 700);
        assert_eq!(robot.allowed_of(way) >= 699, is_open, "{silence_mm:?}");
        // Where it saw free space there is no thing.
        let far = Displacement::along(Bearing::of_place(8, 16), 1_700);
        robot.0.config.robot.step_mm = 2_000;
        robot.0.hear([None; 16]);
        assert!(robot.allowed_of(far) >= 1_699, "{silence_mm:?}");
    }
}

/// From almost where it was heard the same thing would be heard again.
#[test]
fn silence_of_a_sonar_opens_a_way_that_was_closed_from_here() {
    let mut robot = Standing::new(50, 0);
    robot.hears(&[(0, 80)]);
    robot.moves(Displacement::along(Bearing::ZERO, -250));
    let way = Displacement::along(Bearing::ZERO, 700);
    robot.0.hear([None; 16]);
    robot.0.hear([None; 16]);
    let before = robot.allowed_of(way);
    let ahead = Beam {
        mount: Displacement::along(Bearing::ZERO, 231),
        axis: Bearing::ZERO,
        range: Range::from_mm(3_000),
        is_echo: false,
    };
    // As where it looks for a position.
    let mut allowed = || {
        robot.0.with_robot(|robot| {
            let ray = robot.turret.memory.ray(&ahead);
            robot.hear_nothing(&ray);
            robot.guarded(way).length_mm()
        })
    };
    let (after_one, after_two) = (allowed(), allowed());
    assert!((200..=250).contains(&before), "{before}");
    assert_eq!(after_one, before);
    assert!(after_two >= 699, "{after_two}");
}

/// A beam from the side has shown half of the cone free, twice.
#[test]
fn what_was_shown_free_stays_free_when_the_rest_is_heard_again() {
    let mut robot = Standing::new(50, 0);
    let ahead = |robot: &mut Standing| robot.allowed_of(Displacement::along(Bearing::ZERO, 700));
    robot.hears(&[(0, 500)]);
    let before = ahead(&mut robot);
    robot.moves(Displacement::along(Bearing::of_place(4, 16), 330));
    robot.hears(&[]).hears(&[]);
    robot.moves(Displacement::along(Bearing::of_place(12, 16), 330));
    let shown = ahead(&mut robot);
    robot.hears(&[(0, 500)]);
    assert!(shown > before + 10, "{shown} mm, {before} mm before");
    assert_eq!(ahead(&mut robot), shown);
}

/// What stood at 580 mm has gone back by 35 mm.
#[test]
fn a_small_body_tells_near_things_apart() {
    for (short_of_echo_mm, opens) in [(30, false), (4, true)] {
        let mut robot = Standing::new(50, 0);
        robot.0.body.points.short_of_echo_mm = short_of_echo_mm;
        robot.hears(&[(0, 80)]);
        robot.moves(Displacement::along(Bearing::ZERO, -500));
        robot.hears(&[(0, 615)]).hears(&[(0, 615)]);
        let allowed = robot.allowed_of(Displacement::along(Bearing::ZERO, 700));
        assert_eq!(allowed > 510, opens, "{short_of_echo_mm}: {allowed}");
    }
}

/// It hears its shortest range all the while that it comes nearer.
#[test]
fn what_is_heard_at_the_shortest_range_may_be_nearer() {
    for (least_range_mm, most_mm) in [(0, 80), (153, 0)] {
        let mut robot = Standing::new(50, least_range_mm);
        let allowed = robot.hears(&[(0, 150)]).allowed_mm(0);
        assert!(allowed <= most_mm && (allowed > 0) == (most_mm > 0));
    }
}

/// Things on both sides within its margin: it may leave between them, and come no nearer to either.
#[test]
fn a_robot_between_two_near_things_goes_along_them() {
    let mut robot = Standing::new(50, 0);
    robot.hears(&[(4, 60), (12, 60)]);
    assert!(robot.allowed_mm(0) >= 249 && robot.allowed_mm(8) >= 249);
    for sensor in [2, 4, 6, 10, 12, 14] {
        assert_eq!(robot.allowed_mm(sensor), 0, "{sensor}");
    }
}

#[test]
fn what_was_heard_near_stays_where_it_is_and_is_forgotten_elsewhere() {
    let mut robot = Standing::new(50, 0);
    robot.hears(&[(0, 300)]);
    robot.moves(Displacement::along(Bearing::ZERO, 100));
    let nearer = robot.allowed_mm(0);
    assert!((93..=112).contains(&nearer), "{nearer}");
    // Ten minutes without an echo.
    robot.0.ms += 601_000;
    robot.hears(&[]);
    assert!(robot.allowed_mm(0) >= 249);
}

#[test]
fn what_was_heard_near_turns_with_a_robot_that_faces_elsewhere() {
    let mut robot = Standing::new(50, 0);
    robot.hears(&[(0, 80)]);
    let turn = Bearing::of_place(4, 16);
    robot.0.with_robot(|robot| robot.turn_frame(turn));
    assert!(robot.allowed_mm(0) >= 249);
    assert_eq!(robot.allowed_mm(4), 0);
    // The same thing, as it is heard now, and another one.
    robot.hears(&[(0, 80), (8, 60)]);
    let open = [0, 4, 8, 12].map(|sector| robot.allowed_mm(sector) >= 249);
    assert_eq!(open, [true, false, true, false]);
}

/// It takes another way each time that all are closed.
#[test]
fn a_robot_that_seeks_takes_a_detour_where_its_way_is_closed() {
    let mut robot = Standing::new(50, 0);
    robot.0.learn();
    robot.hears(&[(0, 80)]);
    let way = Displacement::along(Bearing::ZERO, 250);
    let detour = |robot: &mut Standing| {
        let way = robot.0.with_robot(|robot| robot.guarded_or_detour(way));
        (way.length_mm(), way.bearing())
    };
    assert_eq!(detour(&mut robot).0, 0, "random moves take none");
    robot.0.command(Command::Seek(Goal::free_of_obstacles()));
    let (length_mm, bearing) = detour(&mut robot);
    assert!(length_mm >= 249);
    assert_ne!(bearing, Bearing::ZERO);
    // Open behind it alone, where no detour leads at first.
    let near: Vec<(usize, u16)> = (0..6).chain(11..16).map(|sensor| (sensor, 60)).collect();
    robot.hears(&near);
    let lengths: Vec<u16> = (0..20).map(|_| detour(&mut robot).0).collect();
    let closed = lengths
        .iter()
        .take_while(|length_mm| **length_mm == 0)
        .count();
    assert!((4..=16).contains(&closed), "{lengths:?}");
}

#[test]
fn the_least_of_three_distances_at_contacts_is_the_radius_within_limits() {
    let radii = |distances_mm: &[u16], told_mm| {
        let mut hull = Hull::NEW;
        for distance_mm in distances_mm {
            hull.touched(*distance_mm);
        }
        hull.radius_mm(told_mm)
    };
    assert_eq!(radii(&[], 200), 200);
    assert_eq!(radii(&[260, 255], 200), 200, "two are not enough");
    assert_eq!(radii(&[260, 255, 290], 200), 255);
    assert_eq!(radii(&[260, 255, 290, 250], 200), 250);
    assert_eq!(radii(&[150, 255, 290], 200), 200, "as it was told");
    assert_eq!(radii(&[260; 300], 200), 260);
    assert_eq!(radii(&[900, 1_200, 3_000], 200), 400, "things unseen");
}
