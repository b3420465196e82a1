use super::*;
use crate::actuation::Actuation;
use crate::controller::{Motion, NomadState, StopReason};
use crate::points::PointLimits;
use crate::som::Grid;
use crate::turret::tests::even_body;
use crate::turret::{Guard, Mount};
use crate::units::{Bearing, Displacement, Range};
use core::num::NonZeroU16;

type Sensors = MountedSensors<16, 16, 256, 0>;

fn spec() -> BodySpec<16> {
    even_body(8, Some(90))
}

struct Rig {
    config: Config<16>,
    body: Sensors,
    state: NomadState,
    ms: u32,
}

impl Rig {
    fn new() -> Self {
        let mut body = Sensors::new();
        body.tell(&spec());
        Self {
            config: Config {
                shield: None,
                fault_detection: false,
                ..Config::recommended()
            },
            body,
            state: NomadState::new(Grid::rectangle(4, 4)),
            ms: 0,
        }
    }

    fn handle(&mut self, event: Event<16>) -> Outputs<16> {
        self.ms += 1;
        let at = Millis::from_ms(self.ms);
        self.body.handle(&self.config, &mut self.state, at, event)
    }

    fn calibrate(&mut self, moves: u16) -> Outputs<16> {
        self.handle(Event::Command(Command::Calibrate {
            moves,
            seed: 3,
            actuators: false,
        }))
    }

    /// All sensors report what differs from one to the next and from move to move.
    fn hear(&mut self) -> Outputs<16> {
        let mut outputs = Outputs::NONE;
        for sensor in 0..8 {
            let mm = 700 + (self.ms * 37 + u32::from(sensor) * 211) % 1_300;
            let range = Some(Range::from_mm(mm as u16));
            let heard = self.handle(Event::Echo { sensor, range });
            outputs.motion = heard.motion.or(outputs.motion);
            outputs.mode_changed |= heard.mode_changed;
        }
        outputs
    }

    fn report(&mut self, motion: Motion, progress: Progress) {
        let turned = motion.displacement.bearing();
        let ahead = Displacement {
            dx_mm: motion.displacement.length_mm() as i16,
            dy_mm: 0,
        };
        self.handle(motion.report(Displacement::ZERO, turned, Progress::Steering));
        self.handle(motion.report(ahead, Bearing::ZERO, progress));
    }

    /// Ticks until the mode changes; returns how many.
    fn think(&mut self) -> u32 {
        (1..10_000)
            .find(|_| self.handle(Event::Tick).mode_changed)
            .expect("it comes to an end")
    }
}

#[test]
fn a_body_moves_at_random_thinks_and_is_idle() {
    let mut rig = Rig::new();
    assert!(rig.calibrate(5).mode_changed);
    for left in (0..5).rev() {
        let motion = rig.hear().motion.expect("a random move");
        assert_eq!(rig.state.mode(), &Mode::Babble { left });
        assert!(rig.state.is_moving());
        // Under way it only listens.
        assert_eq!(rig.hear().motion, None);
        rig.report(motion, Progress::Ended);
    }
    assert!(rig.hear().mode_changed);
    assert_eq!(rig.state.mode(), &Mode::Calibrate);
    assert!(rig.think() > 100);
    assert_eq!(rig.state.mode(), &Mode::Idle);
    let known = rig.body.known();
    assert_eq!(known.enabled, Mask::from_bits(0xFF));
    assert_ne!(known.mounts, spec().mounts);
}

#[test]
fn what_was_heard_at_another_place_begins_no_random_move() {
    let mut rig = Rig::new();
    rig.calibrate(5);
    let motion = rig.hear().motion.expect("a random move");
    rig.ms += 100;
    rig.report(motion, Progress::Ended);
    let range = Some(Range::from_mm(900));
    for sensor in 0..7 {
        assert_eq!(rig.handle(Event::Echo { sensor, range }).motion, None);
    }
    let last = Event::Echo { sensor: 7, range };
    let _ = rig.handle(Event::Tick);
    let before = Millis::from_ms(rig.ms - 60);
    let late = rig.body.handle(&rig.config, &mut rig.state, before, last);
    assert_eq!((late.motion, late.stale_ms), (None, Some(60)));
    assert!(rig.handle(last).motion.is_some());
}

/// A new body is told while the solution of another one is under way.
#[test]
fn what_was_found_of_another_body_is_forgotten() {
    let mut rig = Rig::new();
    rig.calibrate(2);
    while let Some(motion) = rig.hear().motion {
        rig.report(motion, Progress::Ended);
    }
    rig.handle(Event::Tick);
    rig.handle(Event::Command(Command::Stop));
    rig.body.tell(&spec());
    rig.handle(Event::Command(Command::Explore { moves: 2, seed: 1 }));
    while let Some(motion) = rig.hear().motion {
        rig.report(motion, Progress::Ended);
    }
    rig.handle(Event::Command(Command::Learn));
    rig.think();
    assert_eq!(rig.body.known(), &spec());
}

/// Nothing answers, or always from the same distance.
#[test]
fn without_echoes_that_change_no_sensor_is_found() {
    for range in [None, Some(Range::from_mm(900))] {
        let mut rig = Rig::new();
        rig.calibrate(5);
        while *rig.state.mode() != Mode::Calibrate {
            let mut motion = None;
            for sensor in 0..8 {
                let heard = rig.handle(Event::Echo { sensor, range });
                motion = heard.motion.or(motion);
            }
            if let Some(motion) = motion {
                rig.report(motion, Progress::Ended);
            }
        }
        rig.think();
        assert_eq!(rig.state.mode(), &Mode::Stopped(StopReason::NoEchoes));
        assert_eq!(rig.body.known(), &spec());
    }
}

/// The random moves for the maps teach more: learning begins with looking again.
#[test]
fn learning_begins_with_the_sensors() {
    let mut rig = Rig::new();
    rig.calibrate(2);
    while let Some(motion) = rig.hear().motion {
        rig.report(motion, Progress::Ended);
    }
    rig.think();
    let first = rig.body.known().clone();
    rig.handle(Event::Command(Command::Explore { moves: 9, seed: 1 }));
    while let Some(motion) = rig.hear().motion {
        rig.report(motion, Progress::Ended);
    }
    assert_eq!(rig.body.known(), &first);
    rig.handle(Event::Command(Command::Learn));
    let steps = rig.think();
    assert_ne!(rig.body.known(), &first);
    assert!(rig.state.has_learned());
    // What comes next finds the sensors as they are.
    let known = rig.body.known().clone();
    rig.handle(Event::Command(Command::Learn));
    assert!(rig.think() < steps);
    assert_eq!(rig.body.known(), &known);
}

#[test]
fn random_moves_stop_as_all_others_do() {
    for (event, reason) in [
        (Event::Command(Command::Stop), StopReason::Commanded),
        (Event::Alarm(StopReason::LinkLost), StopReason::LinkLost),
    ] {
        let mut rig = Rig::new();
        rig.calibrate(5);
        let motion = rig.hear().motion.expect("a random move");
        let stopped = rig.handle(event);
        assert_eq!(rig.state.mode(), &Mode::Stopped(reason));
        let standing = stopped.motion.expect("it is told to stand");
        assert_eq!(standing.displacement, Displacement::ZERO);
        assert_ne!(standing.id, motion.id);
        assert_eq!(rig.hear().motion, None);
        let resumed = rig.handle(Event::Command(Command::Resume));
        assert_eq!(resumed.refusal, Some(CommandRefusal::NothingToResume));
    }
}

#[test]
fn a_random_move_that_does_not_end_stops_the_robot() {
    let mut rig = Rig::new();
    rig.calibrate(5);
    let motion = rig.hear().motion.expect("a random move");
    let longest_ms = 6_000
        + 2_000 * u32::from(motion.displacement.length_mm()) / u32::from(motion.speed_mm_s)
        + 1_000;
    let began = rig.ms;
    while rig.ms + 1 < began + longest_ms {
        assert_eq!(rig.handle(Event::Tick).stopped, None);
    }
    rig.ms += 2;
    assert_eq!(rig.handle(Event::Tick).stopped, Some(StopReason::Overdue));
}

#[test]
fn a_sensor_that_falls_silent_stops_random_moves() {
    let mut rig = Rig::new();
    rig.calibrate(5);
    let range = Some(Range::from_mm(900));
    let _ = rig.handle(Event::Echo { sensor: 1, range });
    rig.ms += 1_300;
    assert_eq!(
        rig.handle(Event::Tick).stopped,
        Some(StopReason::RingIncomplete)
    );
}

#[test]
fn a_touch_ends_a_random_move_and_the_next_begins() {
    let mut rig = Rig::new();
    rig.calibrate(5);
    rig.hear().motion.expect("a random move");
    let standing = rig.handle(Event::Touched).motion.expect("to stand");
    assert_eq!(standing.displacement, Displacement::ZERO);
    assert!(!rig.state.is_moving());
    assert!(rig.hear().motion.is_some());
}

#[test]
fn no_moves_teach_nothing() {
    let refusal = Rig::new().calibrate(0).refusal;
    assert_eq!(
        refusal,
        Some(CommandRefusal::InvalidMoveCount { max: u16::MAX })
    );
}

/// Echoes reach the controller as they are: the last of sixteen completes its ring.
#[test]
fn without_sensors_it_is_a_ring_on_a_held_turret() {
    let mut rig = Rig::new();
    assert!(rig.body.replace(&[]));
    assert_eq!(rig.calibrate(5).refusal, Some(CommandRefusal::FixedRing));
    rig.handle(Event::Command(Command::Explore { moves: 9, seed: 1 }));
    assert_eq!(rig.hear().motion, None);
    let range = Some(Range::from_mm(900));
    let motions = (8..16).map(|sensor| rig.handle(Event::Echo { sensor, range }).motion);
    assert_eq!(motions.flatten().count(), 1);
}

#[test]
fn a_body_comes_back_from_its_bytes_and_none_from_others() {
    let mut sensors = Sensors::new();
    let mut buffer = [0; MAX_CONFIG];
    assert_eq!(sensors.to_bytes(&mut buffer), &[0_u8; 0]);
    let bytes = spec().to_bytes(&mut buffer).to_vec();
    assert!(sensors.replace(&bytes));
    assert_eq!(sensors.known(), &spec());
    assert_eq!(sensors.to_bytes(&mut buffer), bytes);
    let with = |change: fn(&mut BodySpec<16>)| {
        let mut body = spec();
        change(&mut body);
        let mut buffer = [0; MAX_CONFIG];
        body.to_bytes(&mut buffer).to_vec()
    };
    let bad = [
        bytes[..bytes.len() - 1].to_vec(),
        with(|body| body.enabled = Mask::NONE),
        with(|body| body.enabled = Mask::from_bits(1 << 16)),
        with(|body| body.actuation.length_q12 = 0),
        with(|body| body.actuation.turn_q12 = 0),
    ];
    for bytes in bad {
        assert!(!sensors.replace(&bytes), "{bytes:?}");
        assert_eq!(sensors.known(), &spec());
    }
}

/// The largest body of 32 sensors fits where a configuration does.
#[test]
fn any_body_fits_its_buffer() {
    let axis = Bearing::from_turns(u16::MAX);
    let position = Displacement {
        dx_mm: i16::MIN,
        dy_mm: i16::MIN,
    };
    let body = BodySpec {
        mounts: [Mount { position, axis }; 32],
        enabled: Mask::ALL,
        actuation: Actuation {
            front: axis,
            length_q12: u16::MAX,
            turn_q12: u16::MAX,
        },
        points: PointLimits {
            face_radius_mm: u16::MAX,
            keep_mm: u16::MAX,
            half_cone: axis,
            short_of_echo_mm: u16::MAX,
            nearer_mm: u16::MAX,
            here_mm: u16::MAX,
            near_mm: u16::MAX,
            replan_within_mm: u16::MAX,
            replan_nearer_mm: u16::MAX,
        },
        silence_mm: Some(NonZeroU16::MAX),
        first_looks: u8::MAX,
        most_unseen: u8::MAX,
        guard: Some(Guard {
            margin_mm: NonZeroU16::MAX,
            least_range_mm: u16::MAX,
        }),
        babble_margin_mm: u16::MAX,
        has_compass: false,
    };
    assert_eq!(body.to_bytes(&mut [0; MAX_CONFIG]).len(), 346);
}

/// What is refused changes nothing.
#[test]
fn one_without_places_is_not_set_down() {
    let mut sensors = Sensors::new();
    sensors.tell(&even_body(16, None));
    let before = sensors.clone();
    assert!(!sensors.set_down());
    assert_eq!(sensors, before);
}

#[test]
fn it_takes_17_kilobytes() {
    assert!(size_of::<Sensors>() <= 17_500, "{}", size_of::<Sensors>());
}
