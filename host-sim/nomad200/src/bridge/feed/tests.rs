use super::super::thinking::hear;
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

fn state(x: i32, ms: u32, heard: &[(usize, i32, u32)]) -> State {
    let mut state = State {
        pose: at(x, 0).pose,
        time_ms: ms,
        sonar: [50; 16],
        ..State::default()
    };
    for &(sensor, x, ms) in heard {
        state.sonar_at[sensor] = at(x, ms);
    }
    state
}

#[test]
fn echoes_come_in_the_order_they_were_heard_with_the_way_between() {
    let mut feed = Feed::default();
    feed.begin(&state(0, 1_000, &[]));
    // Rolling along x is to the right of the ring: 100 units are 254 mm.
    let mut now = state(100, 1_100, &[(2, 50, 1_080), (0, 0, 1_040)]);
    now.sonar[2] = 255;
    feed.take(&now, Some(7), Some(Progress::Ended));
    let told: Vec<_> = feed
        .hand_over()
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
        told,
        [
            (40, echo(0, Some(Range::from_mm(1_270)))),
            (80, odometry(-127, Progress::Moving)),
            (80, echo(2, None)),
            (100, odometry(-127, Progress::Ended)),
            (100, Event::Tick),
        ]
    );
    // The same packet again says nothing new.
    feed.take(&now, Some(7), None);
    assert!(feed.hand_over().is_empty());
}

#[test]
fn what_rounding_leaves_over_is_reported_later() {
    let mut feed = Feed::default();
    feed.begin(&state(0, 0, &[]));
    let mut sum = 0;
    for x in 1..=100 {
        feed.take(&state(x, 40 * x as u32, &[]), Some(1), None);
        for happening in feed.hand_over() {
            if let Event::Odometry { moved, .. } = happening.event {
                sum += i32::from(moved.dy_mm);
            }
        }
    }
    assert_eq!(sum, -254);
}

#[test]
fn reports_in_a_row_are_one_and_an_echo_parts_them() {
    let mut feed = Feed::default();
    feed.begin(&state(0, 1_000, &[]));
    for (ms, news) in [
        (1_040, Some(Progress::Steering)),
        (1_080, Some(Progress::Steering)),
    ] {
        feed.take(&state(0, ms, &[]), Some(1), news);
    }
    feed.take(&state(10, 1_120, &[]), Some(1), None);
    feed.take(&state(20, 1_160, &[]), Some(1), None);
    feed.take(&state(30, 1_200, &[(0, 20, 1_170)]), Some(1), None);
    let heard = [(0, 20, 1_170)];
    feed.take(&state(40, 1_240, &heard), Some(1), Some(Progress::Ended));
    let told = feed.hand_over();
    let told: Vec<_> = told
        .iter()
        .map(|h| match h.event {
            Event::Odometry {
                moved, progress, ..
            } => (h.at.as_ms(), moved.dy_mm, Some(progress)),
            _ => (h.at.as_ms(), 0, None),
        })
        .collect();
    assert_eq!(
        told,
        [
            (80, 0, Some(Progress::Steering)),
            (160, -51, Some(Progress::Moving)),
            // The echo, where the robot was then.
            (170, 0, None),
            (200, -25, Some(Progress::Moving)),
            (240, -26, Some(Progress::Ended)),
            // Time passes.
            (240, 0, None),
        ]
    );
}

#[test]
fn a_turret_that_was_turned_is_reported() {
    let mut feed = Feed::default();
    feed.begin(&state(0, 0, &[]));
    let mut turned = state(0, 40, &[]);
    turned.pose[3] = 1_800;
    feed.take(&turned, Some(1), None);
    let told = feed.hand_over();
    let [
        Happening {
            event: Event::Odometry { turned, .. },
            ..
        },
        Happening {
            event: Event::Tick, ..
        },
    ] = told[..]
    else {
        panic!("{told:?}");
    };
    assert_eq!(turned.as_turns(), 16_384);
}

/// When each echo is told, and its age then.
fn echoes(happenings: &[Happening]) -> Vec<(u32, u32)> {
    let is_echo = |h: &&Happening| matches!(h.event, Event::Echo { .. });
    let echoes = happenings.iter().filter(is_echo);
    echoes.map(|h| (h.at.as_ms(), h.age_ms)).collect()
}

#[test]
fn a_pause_of_this_program_is_none_of_the_ring_and_makes_no_echo_younger() {
    let mut feed = Feed::default();
    feed.begin(&state(0, 1_000, &[]));
    let heard = [(3, 0, 60_900), (4, 0, 2_000), (5, 0, 60_500)];
    feed.take(&state(0, 61_000, &heard), None, None);
    // 59 s, 0.5 s and 0.1 s old: the mind's clock has gone on by 200 ms.
    let told = echoes(&feed.hand_over());
    assert_eq!(told, [(0, 58_800), (0, 300), (100, 0)]);
    assert_eq!(feed.now().as_ms(), 200);
}

/// Over a serial line a sonar is asked for every fourth packet.
#[test]
fn an_echo_from_before_the_packet_before_keeps_its_age() {
    let mut feed = Feed::default();
    feed.begin(&state(0, 1_000, &[]));
    feed.take(&state(0, 1_046, &[]), None, None);
    assert_eq!(echoes(&feed.hand_over()), []);
    // 130 ms ago, which is before the mind's time began; said to be heard only 4 ms from now.
    let heard = [(0, 0, 962), (1, 0, 1_050), (2, 0, 1_096)];
    feed.take(&state(0, 1_092, &heard), None, None);
    assert_eq!(echoes(&feed.hand_over()), [(46, 84), (50, 0), (92, 0)]);
}

#[test]
fn what_is_told_after_a_command_is_older_then() {
    let mut feed = Feed::default();
    feed.begin(&state(0, 1_000, &[]));
    feed.take(&state(0, 1_046, &[(0, 0, 1_010)]), None, None);
    feed.take(
        &state(0, 1_092, &[(0, 0, 1_010), (1, 0, 1_090)]),
        None,
        None,
    );
    assert_eq!(feed.now_for_command().as_ms(), 92);
    assert_eq!(echoes(&feed.hand_over()), [(92, 82), (92, 2)]);
}

#[test]
fn time_that_passes_is_told_once() {
    let mut feed = Feed::default();
    feed.begin(&state(0, 1_000, &[]));
    assert!(feed.hand_over().is_empty());
    feed.take(&state(0, 1_046, &[]), None, None);
    feed.take(&state(0, 1_092, &[]), None, None);
    let told = feed.hand_over();
    let [Happening { at, event, .. }] = told[..] else {
        panic!("{told:?}");
    };
    assert_eq!((at.as_ms(), event), (92, Event::Tick));
    assert!(feed.hand_over().is_empty());
}

/// A mind that explores, told by packets what a robot that stays where it is hears.
struct Told {
    feed: Feed,
    mind: LocalController,
    state: State,
    motion: Option<u16>,
}

impl Told {
    /// From the robot's time of 10 s on.
    fn new() -> Self {
        let mut told = Self {
            feed: Feed::default(),
            mind: LocalController::new(Config::recommended()),
            state: state(0, 10_000, &[]),
            motion: None,
        };
        told.feed.begin(&told.state);
        let explore = Command::Explore { moves: 5, seed: 12 };
        let begun = told.mind.handle(told.feed.now(), Event::Command(explore));
        assert!(begun.mode_changed);
        told
    }

    /// A packet at this time; all sonars have been heard once more, if they have. Whether the mind decides.
    fn packet(&mut self, ms: u32, heard_ms: Option<u32>, news: Option<Progress>) -> bool {
        self.state.time_ms = ms;
        if let Some(heard_ms) = heard_ms {
            for place in &mut self.state.sonar_at {
                *place = at(0, heard_ms);
            }
        }
        self.feed.take(&self.state, self.motion, news);
        let thought = hear(&mut self.mind, &self.feed.hand_over());
        assert_eq!(thought.outputs.stopped, None, "{ms}");
        if let Some((_, motion)) = thought.motion {
            self.motion = Some(motion.id);
        }
        thought.outputs.decision.is_some()
    }
}

#[test]
fn an_echo_from_before_the_motions_end_completes_no_ring() {
    let mut told = Told::new();
    assert!(told.packet(10_040, Some(10_030), None));
    assert!(!told.packet(10_140, None, Some(Progress::Ended)));
    // Asked for 46 ms after the end: heard 1 ms before it, then in the very moment.
    assert!(!told.packet(10_186, Some(10_139), None));
    assert!(told.packet(10_232, Some(10_140), None));
}

#[test]
fn an_echo_from_before_a_pause_completes_no_ring() {
    let mut told = Told::new();
    assert!(!told.packet(10_046, None, None));
    // Nobody asked the robot for 5 s. What it heard before is too old, what it heard meanwhile is not.
    assert!(!told.packet(15_046, Some(10_045), None));
    assert!(told.packet(15_092, Some(14_900), None));
}

#[test]
fn the_sonars_asked_for_are_those_heard_longest_ago() {
    let mut feed = Feed::default();
    let mut old = state(0, 10_000, &[]);
    for sensor in 0..16 {
        old.sonar_at[sensor] = at(0, 9_000 + 40 * sensor as u32);
    }
    feed.begin(&old);
    assert_eq!(feed.longest_unheard(4), 0b1111);
    assert_eq!(feed.longest_unheard(16), u16::MAX);
}
