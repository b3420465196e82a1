use super::*;
use crate::controller::{Command, NomadState};
use crate::points::{PointLimits, sector_at};
use crate::som::Grid;
use crate::units::Direction;
use core::num::NonZeroU16;

const AHEAD: usize = 0;

/// No motion of the controller's.
const STILL: Motion = Motion {
    id: 0,
    displacement: Displacement::ZERO,
    speed_mm_s: 0,
};

fn config() -> Config<16> {
    Config {
        shield: None,
        fault_detection: false,
        ..Config::recommended()
    }
}

/// A ring of 16 sensors on a round body.
pub(super) fn ring_body(guard_mm: Option<u16>) -> BodySpec<16> {
    BodySpec {
        most_unseen: 16,
        ..even_body(16, guard_mm)
    }
}

/// So many sensors, evenly spaced on a round body that does not look around.
pub(crate) fn even_body(count: usize, guard_mm: Option<u16>) -> BodySpec<16> {
    let mounts = core::array::from_fn(|sensor| {
        let axis = Bearing::of_place(sensor, count);
        Mount {
            position: Displacement::along(axis, 231),
            axis,
        }
    });
    BodySpec {
        mounts,
        enabled: (0..count).fold(Mask::NONE, Mask::with),
        actuation: Actuation::EXACT,
        points: PointLimits::NOMAD,
        silence_mm: None,
        first_looks: 0,
        most_unseen: u8::MAX,
        guard: guard_mm.and_then(guard),
        babble_margin_mm: 30,
        has_compass: false,
    }
}

/// A guard that keeps this distance, of sensors that tell every range.
fn guard(margin_mm: u16) -> Option<Guard> {
    Some(Guard {
        margin_mm: NonZeroU16::new(margin_mm)?,
        least_range_mm: 0,
    })
}

pub(super) struct Rig {
    pub(super) config: Config<16>,
    pub(super) body: BodySpec<16>,
    turret: VirtualTurret<16, 256, 0>,
    state: NomadState,
    pub(super) ms: u32,
}

impl Rig {
    pub(super) fn new(body: BodySpec<16>) -> Self {
        Self {
            config: config(),
            body,
            turret: VirtualTurret::new(),
            state: NomadState::new(Grid::rectangle(4, 4)),
            ms: 0,
        }
    }

    fn handle(&mut self, event: Event<16>) -> Outputs<16> {
        self.ms += 1;
        let at = Millis::from_ms(self.ms);
        let Self {
            config,
            body,
            turret,
            state,
            ..
        } = self;
        handle(config, body, turret, state, at, event)
    }

    pub(super) fn with_robot<T>(
        &mut self,
        what: impl FnOnce(&mut Robot<'_, NomadState, 16, 16, 256, 0>) -> T,
    ) -> T {
        what(&mut Robot {
            config: &self.config,
            body: &self.body,
            turret: &mut self.turret,
            controller: &mut self.state,
            at: Millis::from_ms(self.ms),
        })
    }

    pub(super) fn command(&mut self, command: Command<16>) {
        assert_eq!(self.handle(Event::Command(command)).refusal, None);
    }

    /// All sensors report; returns the last motion.
    pub(super) fn hear(&mut self, ranges_mm: [Option<u16>; 16]) -> Option<Motion> {
        let mut motion = None;
        for (sensor, range) in (0..).zip(ranges_mm) {
            let range = range.map(Range::from_mm);
            motion = self.handle(Event::Echo { sensor, range }).motion.or(motion);
        }
        motion
    }

    pub(super) fn report(
        &mut self,
        motion: Motion,
        moved: Displacement,
        turned: i32,
        progress: Progress,
    ) {
        let turned = Bearing::from_turns((turned * 65_536 / 360) as u16);
        let _ = self.handle(motion.report(moved, turned, progress));
    }

    /// Explores with a few moves in a wide room and learns.
    pub(super) fn learn(&mut self) {
        self.command(Command::Explore { moves: 20, seed: 3 });
        let mut ranges = [Some(1_500); 16];
        for step in 0.. {
            let Some(motion) = self.hear(ranges) else {
                break;
            };
            ranges.rotate_left(1);
            ranges[step % 16] = Some(700 + 50 * step as u16);
            self.report(motion, motion.displacement, 0, Progress::Ended);
        }
        self.command(Command::Learn);
        for _ in 0..10_000 {
            if self.handle(Event::Tick).mode_changed {
                break;
            }
        }
        assert!(self.state.has_learned());
    }
}

/// The same room heard by a body that has turned: sensor 4 takes the place of sensor 0.
fn turned_by_quarter(ranges: [Option<u16>; 16]) -> [Option<u16>; 16] {
    core::array::from_fn(|sensor| ranges[(sensor + 4) % 16])
}

#[test]
fn a_turned_body_decides_the_same_and_gets_the_motion_in_its_own_frame() {
    let room = core::array::from_fn(|sensor| Some(800 + 100 * sensor as u16));
    let (mut straight, mut turned) = (Rig::new(ring_body(None)), Rig::new(ring_body(None)));
    turned.report(STILL, Displacement::ZERO, 90, Progress::Ended);
    for rig in [&mut straight, &mut turned] {
        rig.command(Command::Explore { moves: 9, seed: 5 });
    }
    let in_world = straight.hear(room).expect("a random move").displacement;
    let on_body = turned.hear(turned_by_quarter(room)).expect("a random move");
    let right = Direction {
        x_q14: 0,
        y_q14: -(1 << 14),
    };
    let expected = in_world.rotated(right);
    let error = on_body.displacement.minus(expected);
    assert!(error.length_mm() <= 2, "{on_body:?} {expected:?}");
    // What was carried out is remembered in the frame of the start.
    turned.report(on_body, on_body.displacement, 0, Progress::Ended);
    turned.hear(turned_by_quarter(room));
    let kept = turned.state.memory().samples()[0].executed;
    assert!(kept.minus(in_world).length_mm() <= 2, "{kept:?}");
}

#[test]
fn what_nobody_has_seen_is_masked() {
    let mut body = ring_body(None);
    body.enabled = Mask::NONE.with(AHEAD).with(8);
    let mut rig = Rig::new(body);
    rig.command(Command::Explore { moves: 9, seed: 5 });
    let motion = rig.hear([Some(900); 16]);
    assert!(motion.is_some());
    let known = Mask::NONE.with(AHEAD).with(8);
    assert_eq!(rig.state.enabled(&rig.config), known);
}

#[test]
fn a_sensor_that_says_nothing_tells_nothing_but_a_certain_one_does() {
    let mut ranges = [Some(900); 16];
    ranges[2] = None;
    for (silence_mm, is_known) in [(None, false), (Some(3_000), true)] {
        let mut body = ring_body(None);
        body.silence_mm = silence_mm.and_then(NonZeroU16::new);
        let mut rig = Rig::new(body);
        rig.command(Command::Explore { moves: 9, seed: 5 });
        rig.hear(ranges);
        assert_eq!(rig.state.enabled(&rig.config).contains(2), is_known);
        assert_eq!(rig.turret.ring()[2], None);
    }
}

#[test]
fn the_guard_ends_a_motion_short_of_what_was_heard() {
    let near = [Some(100); 16];
    for (guard_mm, most_mm) in [(None, 250), (Some(50), 20)] {
        let mut rig = Rig::new(ring_body(guard_mm));
        rig.command(Command::Explore { moves: 9, seed: 5 });
        let motion = rig.hear(near).expect("a random move");
        let length = motion.displacement.length_mm();
        assert!(length <= most_mm, "{guard_mm:?}: {length}");
        assert_eq!(length > 20, guard_mm.is_none());
    }
}

#[test]
fn a_motion_under_way_is_shortened_by_what_shows_up() {
    let mut rig = Rig::new(ring_body(Some(50)));
    rig.config.exploration.shortest_mm = 200;
    rig.command(Command::Explore { moves: 9, seed: 4 });
    let motion = rig.hear([Some(2_000); 16]).expect("a random move");
    let length = motion.displacement.length_mm();
    assert!(length > 100);
    let ahead = motion.displacement.bearing().plus(Bearing::of_place(1, 32));
    let sensor = usize::from(ahead.as_turns() >> 12);
    let sensor_byte = sensor as u8;
    let echo = |mm| Event::Echo {
        sensor: sensor_byte,
        range: Some(Range::from_mm(mm)),
    };
    assert_eq!(rig.handle(echo(1_900)).motion, None);
    let shorter = rig.handle(echo(120)).motion.expect("shortened");
    assert_eq!(shorter.id, motion.id);
    assert!(shorter.displacement.length_mm() < length - 3);
}

/// Slip has taken it a little aside of where it was sent: it goes straight on, and never back.
#[test]
fn a_base_that_rolls_is_shortened_along_its_course() {
    for (length_share, expected) in [(0.3, 40..140), (1.1, 0..1)] {
        let mut rig = Rig::new(ring_body(Some(50)));
        rig.config.exploration.shortest_mm = 200;
        rig.command(Command::Explore { moves: 9, seed: 4 });
        let motion = rig.hear([Some(2_000); 16]).expect("a random move");
        let course = motion.displacement.bearing();
        let rolled_mm = f64::from(motion.displacement.length_mm()) * length_share;
        let aside = Displacement::along(course.plus(Bearing::of_place(1, 4)), 12);
        let moved = Displacement::along(course, rolled_mm as i32).plus(aside);
        rig.report(motion, moved, 0, Progress::Moving);
        let ahead = course.plus(Bearing::of_place(1, 32)).as_turns() >> 12;
        let near = Event::Echo {
            sensor: ahead as u8,
            range: Some(Range::from_mm(150)),
        };
        let way = rig.handle(near).motion.expect("shortened").displacement;
        assert!(expected.contains(&way.length_mm()), "{way:?}");
        let off = way.bearing().minus(course).as_signed_turns();
        assert!(way == Displacement::ZERO || off.abs() < 300, "{off}");
    }
}

/// What its odometry tells is wrong, or it slips: without need it is not sent elsewhere on its way.
#[test]
fn a_base_on_another_course_goes_to_its_end() {
    for guard_mm in [None, Some(50)] {
        let mut rig = Rig::new(ring_body(guard_mm));
        rig.config.exploration.shortest_mm = 200;
        rig.command(Command::Explore { moves: 9, seed: 4 });
        let motion = rig.hear([Some(2_000); 16]).expect("a random move");
        let askew = motion.displacement.bearing().plus(Bearing::of_place(1, 8));
        let moved = Displacement::along(askew, 60);
        rig.report(motion, moved, 0, Progress::Moving);
        assert_eq!(rig.hear([Some(2_000); 16]), None, "{guard_mm:?}");
    }
}

/// The robot is about to roll and sees something near where it thought the way was free.
#[test]
fn a_robot_that_seeks_decides_again_before_it_rolls_at_most_three_times() {
    let mut rig = Rig::new(ring_body(None));
    rig.learn();
    let goal = crate::goal::Goal::avoiding(&rig.config);
    rig.command(Command::Seek(goal));
    let mut motion = rig.hear([Some(3_000); 16]).expect("a step");
    let mut decisions = 0;
    let mut mm = 1_100;
    for _ in 0..5 {
        // The body turns to its way, and the sensor ahead reports something new.
        let bearing = motion.displacement.bearing().as_signed_turns();
        let degrees = i32::from(bearing) * 360 / 65_536;
        rig.report(motion, Displacement::ZERO, degrees, Progress::Steering);
        let mut ranges = [Some(3_000); 16];
        ranges[AHEAD] = Some(mm);
        mm -= 150;
        match rig.hear(ranges) {
            Some(newer) => {
                decisions += 1;
                motion = newer;
            }
            None => break,
        }
    }
    assert_eq!(decisions, 3);
    assert!(rig.state.is_moving());
}

#[test]
fn unknown_sensors_are_ignored() {
    let mut rig = Rig::new(ring_body(None));
    let outputs = rig.handle(Event::Echo {
        sensor: 99,
        range: Some(Range::from_mm(500)),
    });
    assert_eq!(outputs, Outputs::NONE);
    assert!(rig.turret.memory().is_empty());
}

#[test]
fn points_are_forgotten_after_ten_minutes_of_silence() {
    for (silence_ms, left) in [(599_000, 17), (601_000, 1)] {
        let mut rig = Rig::new(ring_body(None));
        rig.hear([Some(900); 16]);
        assert_eq!(rig.turret.memory().len(), 16);
        rig.ms += silence_ms;
        let _ = rig.handle(Event::Echo {
            sensor: 0,
            range: Some(Range::from_mm(800)),
        });
        assert_eq!(rig.turret.memory().len(), left, "{silence_ms} ms");
    }
}

/// A robot that stops during a motion listens to all its sensors again before it decides.
#[test]
fn after_a_stop_a_whole_ring_is_heard_again() {
    let mut rig = Rig::new(ring_body(None));
    rig.command(Command::Explore { moves: 9, seed: 5 });
    assert!(rig.hear([Some(900); 16]).is_some());
    for sensor in 0..15 {
        let range = Some(Range::from_mm(900));
        let _ = rig.handle(Event::Echo { sensor, range });
    }
    rig.command(Command::Stop);
    rig.command(Command::Explore { moves: 9, seed: 5 });
    let last = Event::Echo {
        sensor: 15,
        range: Some(Range::from_mm(900)),
    };
    assert_eq!(rig.handle(last).motion, None);
    assert!(rig.hear([Some(900); 16]).is_some());
}

/// An echo that was under way when the motion ended was heard elsewhere.
#[test]
fn what_was_heard_at_another_place_completes_no_ring() {
    let mut rig = Rig::new(ring_body(None));
    rig.command(Command::Explore { moves: 9, seed: 5 });
    let motion = rig.hear([Some(900); 16]).expect("a random move");
    rig.ms += 100;
    rig.report(motion, motion.displacement, 0, Progress::Ended);
    let range = Some(Range::from_mm(900));
    for sensor in 0..15 {
        assert_eq!(rig.handle(Event::Echo { sensor, range }).motion, None);
    }
    let points = rig.turret.memory().len();
    let last = Event::Echo { sensor: 15, range };
    let _ = rig.handle(Event::Tick);
    let before = Millis::from_ms(rig.ms - 60);
    let late = handle(
        &rig.config,
        &rig.body,
        &mut rig.turret,
        &mut rig.state,
        before,
        last,
    );
    assert_eq!((late.motion, late.stale_ms), (None, Some(60)));
    assert_eq!(rig.turret.memory().len(), points);
    assert!(rig.handle(last).motion.is_some());
}

/// A body with one beam ahead that looks around.
fn one_beam() -> BodySpec<16> {
    BodySpec {
        enabled: Mask::NONE.with(AHEAD),
        most_unseen: 4,
        ..ring_body(None)
    }
}

/// One beam ahead, and nothing known: turns to the left by quarters show all but the last sectors.
#[test]
fn a_robot_with_one_beam_looks_around_before_it_decides() {
    let mut rig = Rig::new(one_beam());
    rig.hear([Some(900); 16]);
    rig.command(Command::Explore { moves: 9, seed: 5 });
    for glance in 0..3 {
        let motion = rig.hear([Some(900); 16]).expect("a glance");
        assert!(!rig.state.is_moving(), "{glance}");
        let way = motion.displacement;
        assert!(way.dx_mm == 0 && (1..=2).contains(&way.dy_mm), "{way:?}");
        // Longer than two rings, which the controller would not wait for a silent ring.
        for _ in 0..6 {
            rig.ms += 500;
            rig.report(motion, Displacement::ZERO, 15, Progress::Steering);
            assert_eq!(rig.handle(Event::Tick).stopped, None);
            assert_eq!(rig.hear([Some(900); 16]), None, "under way");
        }
        let ahead = Displacement::along(Bearing::ZERO, 2);
        rig.report(motion, ahead, 0, Progress::Ended);
    }
    let motion = rig.hear([Some(900); 16]).expect("a random move");
    assert!(rig.state.is_moving() && motion.displacement.length_mm() > 2);
    let known = rig.state.enabled(&rig.config).indices(16).count();
    assert!((12..16).contains(&known), "{known}");
}

#[test]
fn a_robot_that_has_seen_enough_does_not_look_around() {
    let mut rig = Rig::new(BodySpec {
        most_unseen: 4,
        ..ring_body(None)
    });
    rig.command(Command::Explore { moves: 9, seed: 5 });
    assert!(rig.hear([Some(900); 16]).is_some());
    assert!(rig.state.is_moving());
}

/// A glance that the base does not end within the time of a half turn stops the robot.
#[test]
fn a_base_that_does_not_turn_is_not_waited_for() {
    let mut rig = Rig::new(one_beam());
    rig.command(Command::Explore { moves: 9, seed: 5 });
    let motion = rig.hear([Some(900); 16]).expect("a glance");
    let stopped = (0..100).find_map(|_| {
        rig.ms += 100;
        rig.report(motion, Displacement::ZERO, 0, Progress::Steering);
        rig.handle(Event::Tick).stopped
    });
    assert!(stopped.is_some());
}

/// No sensor within 45° of the front: it turns until one looks along its way, and then goes.
#[test]
fn a_robot_that_is_blind_ahead_looks_before_it_goes() {
    let blind = [14, 15, AHEAD, 1, 2];
    for (enabled, looks) in [
        (blind.into_iter().fold(Mask::ALL, Mask::without), 1..=4),
        (Mask::ALL, 0..=0),
    ] {
        let mut rig = Rig::new(ring_body(None));
        rig.learn();
        rig.turret.restart();
        rig.body.enabled = Mask::NONE;
        for sensor in enabled.indices(16) {
            rig.body.enabled = rig.body.enabled.with(sensor);
        }
        let goal = crate::goal::Goal::avoiding(&rig.config);
        rig.command(Command::Seek(goal));
        let mut glances = 0;
        let motion = loop {
            let motion = rig.hear([Some(600); 16]).expect("a motion");
            if rig.state.is_moving() {
                break motion;
            }
            glances += 1;
            assert!(motion.displacement.length_mm() <= 7, "{motion:?}");
            let bearing = motion.displacement.bearing().as_signed_turns();
            let degrees = i32::from(bearing) * 360 / 65_536;
            rig.report(motion, Displacement::ZERO, degrees, Progress::Steering);
            assert_eq!(rig.hear([Some(600); 16]), None, "under way");
            rig.report(motion, Displacement::ZERO, 0, Progress::Ended);
        };
        assert!(looks.contains(&glances), "{glances}");
        assert!(motion.displacement.length_mm() > 7, "{motion:?}");
        let ahead = motion
            .displacement
            .bearing()
            .plus(rig.turret.memory().heading());
        let seen = rig.turret.memory().seen_from_here::<16>(&rig.body.points);
        assert!(sector_at::<16>(ahead).is_some_and(|sector| seen.contains(sector)));
    }
}

/// Eight neighboring sensors see half of the ring: it turns until they have seen the other half.
#[test]
fn where_nothing_is_known_a_body_turns_until_it_has_seen_all() {
    let left = (0..8).fold(Mask::NONE, Mask::with);
    for (enabled, first_looks, expected) in [
        (left, 12, 4..=7),
        (left, 3, 3..=3),
        (left, 0, 0..=0),
        (Mask::ALL, 12, 0..=0),
    ] {
        let mut rig = Rig::new(BodySpec {
            first_looks,
            enabled: Mask::NONE,
            ..ring_body(None)
        });
        for sensor in enabled.indices(16) {
            rig.body.enabled = rig.body.enabled.with(sensor);
        }
        rig.command(Command::Explore { moves: 9, seed: 5 });
        let looks = |rig: &mut Rig| {
            (0..20).find(|_| {
                let motion = rig.hear([Some(900); 16]).expect("a motion");
                if rig.state.is_moving() {
                    rig.report(motion, motion.displacement, 0, Progress::Ended);
                    return true;
                }
                let turn = motion.displacement.bearing().as_signed_turns();
                assert!((4_500..7_000).contains(&turn), "{turn}");
                rig.report(motion, Displacement::ZERO, 30, Progress::Steering);
                assert_eq!(rig.hear([Some(900); 16]), None, "under way");
                rig.report(motion, Displacement::ZERO, 0, Progress::Ended);
                false
            })
        };
        let first = looks(&mut rig).expect("a random move");
        assert!(expected.contains(&first), "{first}");
        let away = Displacement::along(Bearing::ZERO, 500);
        rig.report(STILL, away, 0, Progress::Ended);
        assert_eq!(looks(&mut rig), Some(0), "it knows where it came from");
        // Carried elsewhere while it was off.
        rig.ms += 601_000;
        let _ = rig.handle(Event::Tick);
        rig.command(Command::Explore { moves: 9, seed: 5 });
        assert_eq!(looks(&mut rig), Some(first), "it may be anywhere");
    }
}

/// Nothing is within the reach of its sonars, wherever it looks: it does not look without end, and
/// goes where its user has said that the place may be open.
#[test]
fn where_nothing_is_heard_a_body_looks_around_once() {
    for open_space in [false, true] {
        let mut rig = Rig::new(BodySpec {
            first_looks: 12,
            ..ring_body(None)
        });
        rig.state.expect_open_space(open_space);
        rig.command(Command::Explore { moves: 9, seed: 5 });
        for look in 0..12 {
            let motion = rig.hear([None; 16]).expect("a turn");
            assert!(motion.displacement.length_mm() <= 4, "{look}: {motion:?}");
            rig.report(motion, Displacement::ZERO, 30, Progress::Ended);
        }
        let mut moves = 0;
        while let Some(motion) = rig.hear([None; 16]) {
            assert!(motion.displacement.length_mm() > 4, "{motion:?}");
            rig.report(motion, motion.displacement, 0, Progress::Ended);
            moves += 1;
        }
        assert_eq!(moves, if open_space { 9 } else { 2 });
    }
}
