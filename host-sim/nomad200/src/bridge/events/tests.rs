use super::super::worker::deliver;
use super::*;
use amp::config::Config;
use amp::controller::Command;
use sim::pilot::{LocalController, Pilot as _};

/// A robot at x (0.1 in), its turret a quarter turn to the left, at `ms`.
fn at(x: i32, ms: u32) -> PosData {
    PosData {
        pose: [x, 0, 0, 900],
        sensed_ms: ms,
        ..PosData::default()
    }
}

fn state(x: i32, ms: u32, echoes: &[(usize, i32, u32)]) -> NomadReadings {
    let mut state = NomadReadings {
        pose: at(x, 0).pose,
        time_ms: ms,
        sonar: [50; 16],
        ..NomadReadings::default()
    };
    for &(sensor, x, ms) in echoes {
        state.sonar_at[sensor] = at(x, ms);
    }
    state
}

#[test]
fn echoes_are_delivered_in_order_with_odometry_between_them() {
    let mut queue = EventQueue::default();
    queue.begin(&state(0, 1_000, &[]));
    // Rolling along x is a motion to the right of the ring: 100 units are 254 mm.
    let mut now = state(100, 1_100, &[(2, 50, 1_080), (0, 0, 1_040)]);
    now.sonar[2] = 255;
    queue.add_state(&now, Some(7), Some(Progress::Ended));
    let delivered: Vec<_> = queue
        .take_events()
        .iter()
        .map(|h| (h.at.as_ms(), h.event))
        .collect();
    let odometry = |dy_mm, progress| Event::Odometry {
        motion: 7,
        moved: Displacement { dx_mm: 0, dy_mm },
        turned: Bearing::ZERO,
        progress,
    };
    let echo = |sensor, range| Event::Echo { sensor, range };
    assert_eq!(
        delivered,
        [
            (40, echo(0, Some(Range::from_mm(1_270)))),
            (80, odometry(-127, Progress::Moving)),
            (80, echo(2, None)),
            (100, odometry(-127, Progress::Ended)),
            (100, Event::Tick),
        ]
    );
    // The same packet again is no news.
    queue.add_state(&now, Some(7), None);
    assert!(queue.take_events().is_empty());
}

#[test]
fn what_rounding_leaves_over_is_reported_later() {
    let mut queue = EventQueue::default();
    queue.begin(&state(0, 0, &[]));
    let mut sum = 0;
    for x in 1..=100 {
        queue.add_state(&state(x, 40 * x as u32, &[]), Some(1), None);
        for event in queue.take_events() {
            if let Event::Odometry { moved, .. } = event.event {
                sum += i32::from(moved.dy_mm);
            }
        }
    }
    assert_eq!(sum, -254);
}

#[test]
fn reports_in_a_row_are_one_and_an_echo_parts_them() {
    let mut queue = EventQueue::default();
    queue.begin(&state(0, 1_000, &[]));
    for (ms, news) in [
        (1_040, Some(Progress::Steering)),
        (1_080, Some(Progress::Steering)),
    ] {
        queue.add_state(&state(0, ms, &[]), Some(1), news);
    }
    queue.add_state(&state(10, 1_120, &[]), Some(1), None);
    queue.add_state(&state(20, 1_160, &[]), Some(1), None);
    queue.add_state(&state(30, 1_200, &[(0, 20, 1_170)]), Some(1), None);
    let new_echoes = [(0, 20, 1_170)];
    queue.add_state(
        &state(40, 1_240, &new_echoes),
        Some(1),
        Some(Progress::Ended),
    );
    let delivered = queue.take_events();
    let delivered: Vec<_> = delivered
        .iter()
        .map(|h| match h.event {
            Event::Odometry {
                moved, progress, ..
            } => (h.at.as_ms(), moved.dy_mm, Some(progress)),
            _ => (h.at.as_ms(), 0, None),
        })
        .collect();
    assert_eq!(
        delivered,
        [
            (80, 0, Some(Progress::Steering)),
            (160, -51, Some(Progress::Moving)),
            // The echo, with the robot's position at that time.
            (170, 0, None),
            (200, -25, Some(Progress::Moving)),
            (240, -26, Some(Progress::Ended)),
            // A tick.
            (240, 0, None),
        ]
    );
}

#[test]
fn a_turret_that_was_turned_is_reported() {
    let mut queue = EventQueue::default();
    queue.begin(&state(0, 0, &[]));
    let mut turned = state(0, 40, &[]);
    turned.pose[3] = 1_800;
    queue.add_state(&turned, Some(1), None);
    let delivered = queue.take_events();
    let [
        TimedEvent {
            event: Event::Odometry { turned, .. },
            ..
        },
        TimedEvent {
            event: Event::Tick, ..
        },
    ] = delivered[..]
    else {
        panic!("{delivered:?}");
    };
    assert_eq!(turned.as_turns(), 16_384);
}

/// Delivery time and age of each echo.
fn echoes(events: &[TimedEvent]) -> Vec<(u32, u32)> {
    let is_echo = |h: &&TimedEvent| matches!(h.event, Event::Echo { .. });
    let echoes = events.iter().filter(is_echo);
    echoes.map(|h| (h.at.as_ms(), h.age_ms)).collect()
}

#[test]
fn a_pause_of_this_program_is_none_of_the_ring_and_makes_no_echo_younger() {
    let mut queue = EventQueue::default();
    queue.begin(&state(0, 1_000, &[]));
    let new_echoes = [(3, 0, 60_900), (4, 0, 2_000), (5, 0, 60_500)];
    queue.add_state(&state(0, 61_000, &new_echoes), None, None);
    // 59 s, 0.5 s and 0.1 s old; the controller's clock has advanced by 200 ms.
    let delivered = echoes(&queue.take_events());
    assert_eq!(delivered, [(0, 58_800), (0, 300), (100, 0)]);
    assert_eq!(queue.now().as_ms(), 200);
}

/// Over a serial line every fourth packet has a given sonar.
#[test]
fn an_echo_from_before_the_packet_before_keeps_its_age() {
    let mut queue = EventQueue::default();
    queue.begin(&state(0, 1_000, &[]));
    queue.add_state(&state(0, 1_046, &[]), None, None);
    assert_eq!(echoes(&queue.take_events()), []);
    // 130 ms ago, before the controller's time began; and 4 ms in the future.
    let new_echoes = [(0, 0, 962), (1, 0, 1_050), (2, 0, 1_096)];
    queue.add_state(&state(0, 1_092, &new_echoes), None, None);
    assert_eq!(echoes(&queue.take_events()), [(46, 84), (50, 0), (92, 0)]);
}

#[test]
fn events_queued_before_a_command_become_older() {
    let mut queue = EventQueue::default();
    queue.begin(&state(0, 1_000, &[]));
    queue.add_state(&state(0, 1_046, &[(0, 0, 1_010)]), None, None);
    queue.add_state(
        &state(0, 1_092, &[(0, 0, 1_010), (1, 0, 1_090)]),
        None,
        None,
    );
    assert_eq!(queue.now_for_command().as_ms(), 92);
    assert_eq!(echoes(&queue.take_events()), [(92, 82), (92, 2)]);
}

#[test]
fn elapsed_time_is_reported_once() {
    let mut queue = EventQueue::default();
    queue.begin(&state(0, 1_000, &[]));
    assert!(queue.take_events().is_empty());
    queue.add_state(&state(0, 1_046, &[]), None, None);
    queue.add_state(&state(0, 1_092, &[]), None, None);
    let delivered = queue.take_events();
    let [TimedEvent { at, event, .. }] = delivered[..] else {
        panic!("{delivered:?}");
    };
    assert_eq!((at.as_ms(), event), (92, Event::Tick));
    assert!(queue.take_events().is_empty());
}

/// A controller that explores with the packets of a robot at rest.
struct ExploringRobot {
    events: EventQueue,
    controller: LocalController,
    state: NomadReadings,
    motion: Option<u16>,
}

impl ExploringRobot {
    /// The robot's time starts at 10 s.
    fn new() -> Self {
        let mut exploration = Self {
            events: EventQueue::default(),
            controller: LocalController::new(Config::recommended()),
            state: state(0, 10_000, &[]),
            motion: None,
        };
        exploration.events.begin(&exploration.state);
        let explore = Command::Explore { moves: 5, seed: 12 };
        let begun = exploration
            .controller
            .handle(exploration.events.now(), Event::Command(explore));
        assert!(begun.mode_changed);
        exploration
    }

    /// Delivers a packet; `sensed_ms` = all sonars have a new echo of this time. Returns whether
    /// the controller decides.
    fn packet(&mut self, ms: u32, sensed_ms: Option<u32>, progress: Option<Progress>) -> bool {
        self.state.time_ms = ms;
        if let Some(sensed_ms) = sensed_ms {
            for place in &mut self.state.sonar_at {
                *place = at(0, sensed_ms);
            }
        }
        self.events.add_state(&self.state, self.motion, progress);
        let result = deliver(&mut self.controller, &self.events.take_events());
        assert_eq!(result.outputs.stopped, None, "{ms}");
        if let Some((_, motion)) = result.motion {
            self.motion = Some(motion.id);
        }
        result.outputs.decision.is_some()
    }
}

#[test]
fn an_echo_from_before_the_motions_end_completes_no_ring() {
    let mut exploration = ExploringRobot::new();
    assert!(exploration.packet(10_040, Some(10_030), None));
    assert!(!exploration.packet(10_140, None, Some(Progress::Ended)));
    // 46 ms after the end: echoes from 1 ms before it, then from that moment.
    assert!(!exploration.packet(10_186, Some(10_139), None));
    assert!(exploration.packet(10_232, Some(10_140), None));
}

#[test]
fn an_echo_from_before_a_pause_completes_no_ring() {
    let mut exploration = ExploringRobot::new();
    assert!(!exploration.packet(10_046, None, None));
    // No packet for 5 s. Echoes from before are too old; echoes from meanwhile are not.
    assert!(!exploration.packet(15_046, Some(10_045), None));
    assert!(exploration.packet(15_092, Some(14_900), None));
}

#[test]
fn the_requested_sonars_are_those_with_the_oldest_echoes() {
    let mut queue = EventQueue::default();
    let mut old = state(0, 10_000, &[]);
    for sensor in 0..16 {
        old.sonar_at[sensor] = at(0, 9_000 + 40 * sensor as u32);
    }
    queue.begin(&old);
    assert_eq!(queue.oldest_sonars(4), 0b1111);
    assert_eq!(queue.oldest_sonars(16), u16::MAX);
}
