use super::super::tests::even_body;
use super::super::{BodySpec, handle, think};
use super::*;
use crate::config::Config;
use crate::controller::{Mode, Motion, NomadState, Progress, StopReason};
use crate::goal::Goal;
use crate::som::Grid;
use crate::units::{Bearing, Displacement, Millis, Range};

/// A robot with a memory of places, events and slices.
struct Rig {
    config: Config<16>,
    body: BodySpec<16>,
    turret: VirtualTurret<16, 256, 64>,
    state: NomadState,
    ms: u32,
}

impl Rig {
    /// It has learned, pursues a goal and is led.
    fn new(guard_mm: Option<u16>) -> Self {
        let mut rig = Self {
            config: Config {
                shield: None,
                fault_detection: false,
                ..Config::recommended()
            },
            body: even_body(16, guard_mm),
            turret: VirtualTurret::new(),
            state: NomadState::new(Grid::rectangle(4, 4)),
            ms: 0,
        };
        rig.command(Command::Explore { moves: 20, seed: 3 });
        let mut ranges = [1_500; 16];
        for step in 0.. {
            rig.ring(ranges);
            let Some(motion) = rig.think_to_the_end().motion else {
                break;
            };
            ranges.rotate_left(1);
            ranges[step % 16] = 700 + 50 * step as u16;
            rig.report(motion, motion.displacement, Progress::Ended);
        }
        rig.command(Command::Learn);
        while !rig.handle(Event::Tick).mode_changed {}
        rig.turret.lead_to(Some(Aim::Frontier));
        rig.command(Command::Seek(Goal::avoiding(&rig.config)));
        rig
    }

    fn handle(&mut self, event: Event<16>) -> Outputs<16> {
        self.ms += 1;
        let at = Millis::from_ms(self.ms);
        let (config, body) = (&self.config, &self.body);
        handle(config, body, &mut self.turret, &mut self.state, at, event)
    }

    fn command(&mut self, command: Command<16>) {
        assert_eq!(self.handle(Event::Command(command)).refusal, None);
    }

    fn report(&mut self, motion: Motion, moved: Displacement, progress: Progress) {
        let _ = self.handle(motion.report(moved, Bearing::ZERO, progress));
    }

    /// All sensors report; the last motion.
    fn ring(&mut self, ranges_mm: [u16; 16]) -> Option<Motion> {
        let mut motion = None;
        for (sensor, mm) in (0..).zip(ranges_mm) {
            let range = Some(Range::from_mm(mm));
            motion = self.handle(Event::Echo { sensor, range }).motion.or(motion);
        }
        motion
    }

    fn slice(&mut self) -> Outputs<16> {
        let (config, body) = (&self.config, &self.body);
        let at = Millis::from_ms(self.ms);
        think(config, body, &mut self.turret, &mut self.state, at)
    }

    fn think_to_the_end(&mut self) -> Outputs<16> {
        let mut outputs = Outputs::NONE;
        while self.turret.is_thinking() {
            assert_eq!(outputs, Outputs::NONE, "with the last slice alone");
            outputs = self.slice();
        }
        outputs
    }
}

#[test]
fn it_decides_when_it_has_thought() {
    let mut rig = Rig::new(None);
    assert_eq!(rig.ring([2_000; 16]), None);
    assert!(rig.turret.is_thinking());
    let outputs = rig.think_to_the_end();
    assert!(outputs.motion.is_some() && outputs.decision.is_some());
    assert_eq!(rig.slice(), Outputs::NONE);
    assert!(rig.turret.places().positions().len() > 0);
}

/// It stands where it heard what sensor 0 now hears no more.
#[test]
fn silence_counts_while_it_looks_for_a_position_alone() {
    let position = Aim::Position(Displacement::along(Bearing::ZERO, 9_000));
    for (aim, counts) in [(Aim::Frontier, false), (position, true)] {
        let mut rig = Rig::new(None);
        rig.turret.lead_to(Some(aim));
        rig.ring([2_000; 16]);
        let motion = rig.think_to_the_end().motion.expect("a move");
        rig.report(motion, Displacement::ZERO, Progress::Ended);
        let heard = rig.turret.memory().len();
        let silent = Event::Echo {
            sensor: 0,
            range: None,
        };
        let _ = rig.handle(silent);
        assert_eq!(rig.turret.memory().len() < heard, counts, "{aim:?}");
    }
}

/// One that thinks hears three more rings, and time passes.
#[test]
fn whatever_it_hears_while_it_thinks_it_decides_once() {
    let mut rig = Rig::new(None);
    rig.ring([2_000; 16]);
    for _ in 0..3 {
        assert_eq!(rig.slice(), Outputs::NONE);
        assert_eq!(rig.ring([2_000; 16]), None);
        assert_eq!(rig.handle(Event::Tick), Outputs::NONE);
    }
    let slices = |rig: &mut Rig| (1..).find(|_| rig.slice().motion.is_some());
    let left = slices(&mut rig);
    assert!(!rig.turret.is_thinking());
    let mut undisturbed = Rig::new(None);
    undisturbed.ring([2_000; 16]);
    let all = slices(&mut undisturbed);
    assert_eq!(left.map(|left| left + 3), all);
    assert_eq!(rig.turret.motion, undisturbed.turret.motion);
    // What it heard before its motion does not count to the ring on the way.
    assert_eq!(rig.turret.fresh, undisturbed.turret.fresh);
}

#[test]
fn one_that_is_stopped_commanded_or_alarmed_thinks_no_more() {
    let seek = Command::Seek(Goal::free_of_obstacles());
    for event in [
        Event::Command(Command::Stop),
        Event::Command(seek),
        Event::Command(Command::Explore { moves: 3, seed: 1 }),
        Event::Alarm(StopReason::LinkLost),
    ] {
        let mut rig = Rig::new(None);
        rig.ring([2_000; 16]);
        let _ = rig.slice();
        let outputs = rig.handle(event);
        assert!(outputs.refusal.is_none() && outputs.mode_changed);
        assert!(!rig.turret.is_thinking(), "{event:?}");
        assert_eq!(rig.slice(), Outputs::NONE);
        // The next ring is thought about again, if it is to go on.
        rig.ring([2_000; 16]);
        let goes_on = !matches!(rig.state.mode(), Mode::Stopped(_));
        assert_eq!(rig.think_to_the_end().motion.is_some(), goes_on);
    }
}

#[test]
fn a_refused_command_ends_nothing() {
    let mut rig = Rig::new(None);
    rig.ring([2_000; 16]);
    let none = Command::Explore { moves: 0, seed: 1 };
    assert!(rig.handle(Event::Command(none)).refusal.is_some());
    assert!(rig.turret.is_thinking());
    assert!(rig.think_to_the_end().motion.is_some());
}

/// Something near shows up ahead of one that is about to roll.
fn sees_something(rig: &mut Rig) -> Motion {
    rig.ring([3_000; 16]);
    let motion = rig.think_to_the_end().motion.expect("a step");
    let way = motion.displacement.bearing();
    let ahead = usize::from(way.plus(Bearing::of_place(1, 32)).as_turns() >> 12);
    let mut ranges = [3_000; 16];
    for sector in [15, 0, 1] {
        ranges[(ahead + sector) % 16] = 700;
    }
    rig.report(motion, Displacement::ZERO, Progress::Steering);
    // It faces its way.
    rig.turret.memory.carry(Displacement::ZERO, way);
    ranges.rotate_left(ahead);
    rig.ring(ranges);
    motion
}

#[test]
fn one_on_its_way_goes_on_with_its_motion_until_it_has_thought() {
    let mut rig = Rig::new(Some(50));
    let motion = sees_something(&mut rig);
    assert!(rig.turret.is_thinking() && rig.state.is_moving());
    // Its guard still shortens it.
    let sensor = 0;
    let range = Some(Range::from_mm(60));
    let shorter = rig.handle(Event::Echo { sensor, range }).motion;
    let shorter = shorter.expect("shortened");
    assert_eq!(shorter.id, motion.id);
    let newer = rig.think_to_the_end().motion.expect("another");
    assert_ne!(newer.id, motion.id);
}

#[test]
fn one_whose_motion_ends_hears_a_whole_ring_before_it_thinks_again() {
    let mut rig = Rig::new(None);
    let motion = sees_something(&mut rig);
    assert!(rig.turret.is_thinking());
    rig.report(motion, motion.displacement, Progress::Ended);
    assert!(!rig.turret.is_thinking());
    rig.ring([2_000; 16]);
    assert!(rig.think_to_the_end().motion.is_some());
}

#[test]
fn one_that_faces_elsewhere_goes_on_where_it_was_going() {
    let mut rig = Rig::new(None);
    rig.ring([2_000; 16]);
    let motion = rig.think_to_the_end().motion.expect("it goes");
    let left = |rig: &Rig| {
        let in_frame = rig.turret.motion.expect("it goes").displacement;
        in_frame.rotated(
            Bearing::ZERO
                .minus(rig.turret.memory().heading())
                .direction(),
        )
    };
    let before = left(&rig);
    assert!(before.minus(motion.displacement).is_shorter_than(3));
    rig.turret.turn_frame(Bearing::of_place(3, 10));
    assert!(left(&rig).minus(before).is_shorter_than(3));
    let course = rig.turret.motion.expect("it goes").displacement.bearing();
    let off = course.minus(rig.turret.course).as_signed_turns();
    assert!(off.unsigned_abs() < 200, "{off}");
}

/// Told so, or silent for ten minutes: what was heard before stands elsewhere, and so do its places.
#[test]
fn one_that_was_carried_begins_anew() {
    for (is_told, silence_ms) in [(true, 0), (false, 600_000), (false, 0)] {
        let mut rig = Rig::new(None);
        let places = rig.turret.places().positions().len();
        assert!((2..32).contains(&places), "{places}");
        rig.command(Command::Stop);
        if is_told {
            rig.turret.set_down();
        }
        rig.ms += silence_ms;
        let range = Some(Range::from_mm(900));
        let _ = rig.handle(Event::Echo { sensor: 0, range });
        let knows_it = is_told || silence_ms > 0;
        let left = rig.turret.places().positions().len();
        assert_eq!(left, if knows_it { 0 } else { places }, "{is_told}");
        assert_eq!(rig.turret.memory().len() == 1, knows_it, "{is_told}");
    }
}

/// A robot that is led there; its first motion.
fn led(aim: Aim) -> (Rig, Motion) {
    let mut rig = Rig::new(None);
    rig.turret.lead_to(Some(aim));
    rig.ring([1_500; 16]);
    let motion = rig.think_to_the_end().motion.expect("a motion");
    (rig, motion)
}

/// The same, and it has begun to roll.
fn rolling(aim: Aim) -> (Rig, Motion) {
    let (mut rig, motion) = led(aim);
    rig.report(motion, Displacement::ZERO, Progress::Moving);
    (rig, motion)
}

impl Rig {
    /// So many echoes at rest until it thinks.
    fn echoes_until_it_thinks(&mut self) -> usize {
        let range = Some(Range::from_mm(1_500));
        let mut sensors = (0..16).cycle();
        let thinks = |sensor| {
            let _ = self.handle(Event::Echo { sensor, range });
            self.turret.is_thinking()
        };
        1 + sensors.position(thinks).unwrap_or(usize::MAX)
    }
}

const FAR: Aim = Aim::Position(Displacement {
    dx_mm: 9_000,
    dy_mm: 0,
});

#[test]
fn on_a_new_way_what_was_heard_while_the_base_rolled_counts() {
    for (aim, needed) in [(FAR, 1), (Aim::Frontier, 16)] {
        let (mut rig, motion) = rolling(aim);
        rig.ring([1_500; 16]);
        rig.report(motion, motion.displacement, Progress::Ended);
        assert_eq!(rig.echoes_until_it_thinks(), needed, "{aim:?}");
        // The decision after that begins anew.
        let motion = rig.think_to_the_end().motion.expect("a motion");
        rig.report(motion, motion.displacement, Progress::Ended);
        assert_eq!(rig.echoes_until_it_thinks(), 16, "{aim:?}");
    }
    // Nor does a ring while it steers: it has not moved.
    let (mut rig, motion) = led(FAR);
    rig.ring([1_500; 16]);
    rig.report(motion, motion.displacement, Progress::Ended);
    assert_eq!(rig.echoes_until_it_thinks(), 16);
    // Sensors that were not heard on the way are heard at rest.
    let (mut rig, motion) = rolling(FAR);
    for sensor in 6..16 {
        let range = Some(Range::from_mm(1_500));
        let _ = rig.handle(Event::Echo { sensor, range });
    }
    rig.report(motion, motion.displacement, Progress::Ended);
    assert_eq!(rig.echoes_until_it_thinks(), 6);
    // After a stop all are heard again.
    let (mut rig, _) = rolling(FAR);
    rig.ring([1_500; 16]);
    rig.command(Command::Stop);
    rig.command(Command::Resume);
    assert_eq!(rig.echoes_until_it_thinks(), 16);
}
