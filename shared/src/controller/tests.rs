use super::*;
use crate::fixed::{Mask, Weight};
use crate::goal::Component;
use crate::goal::Goal;
use crate::planner::Why;
use crate::scan::Aligned;
use crate::units::Range;
use crate::units::{Bearing, Displacement};
use std::vec::Vec;

mod large_maps;
mod online;
mod supervise;
mod ways;

type Robot = State<16, 16, 20>;
type Out = Outputs<16>;

/// A robot in a square room of 4 m × 4 m, its ring held; ranges along the axes of the transducers.
struct Bench {
    config: Config<16>,
    state: Robot,
    /// Place in the room, millimeters from its middle.
    x: i32,
    y: i32,
    time: u32,
    log: Vec<Out>,
}

const HALF_ROOM_MM: i32 = 2_000;

/// Random moves of a robot that is made ready. Miri takes some thousand times as long.
const MOVES: u16 = if cfg!(miri) { 6 } else { 20 };

impl Bench {
    /// Everything is learned, also where a ray passes a corner of this room.
    fn new(mut config: Config<16>) -> Self {
        config.learning.largest_change_mm = 10_000;
        if cfg!(miri) {
            // Some thousand times slower.
            config.learning.epochs = 2;
        }
        Self {
            config,
            state: Robot::new(Grid::rectangle(4, 4)),
            x: 0,
            y: 0,
            time: 0,
            log: Vec::new(),
        }
    }

    fn send(&mut self, event: Event<16>) -> Out {
        let out = handle(
            &self.config,
            &mut self.state,
            Millis::from_ms(self.time),
            event,
        );
        self.log.push(out);
        out
    }

    fn range_mm(&self, sensor: usize) -> i32 {
        let axis = self.config.robot.directions[sensor];
        let to_wall = |place: i32, part: i16| {
            let part = i32::from(part);
            if part == 0 {
                return i32::MAX;
            }
            let wall = if part > 0 {
                HALF_ROOM_MM
            } else {
                -HALF_ROOM_MM
            };
            ((wall - place) << 14) / part
        };
        let from_center = to_wall(self.x, axis.x_q14).min(to_wall(self.y, axis.y_q14));
        (from_center - i32::from(self.config.robot.face_radius_mm)).max(0)
    }

    /// One ring at standstill.
    fn ring(&mut self) -> Out {
        self.time += 640;
        let mut last = Out::NONE;
        for sensor in 0..16 {
            let range = Some(Range::from_mm(self.range_mm(sensor) as u16));
            last = self.send(Event::Echo {
                sensor: sensor as u8,
                range,
            });
        }
        last
    }

    /// Carries a motion out as far as the walls allow and reports it.
    fn execute(&mut self, motion: Motion) {
        let limit = HALF_ROOM_MM - i32::from(self.config.robot.body_radius_mm);
        let wanted = (
            self.x + i32::from(motion.displacement.dx_mm),
            self.y + i32::from(motion.displacement.dy_mm),
        );
        let touched = wanted.0.abs() > limit || wanted.1.abs() > limit;
        let moved = if touched {
            Displacement::ZERO
        } else {
            motion.displacement
        };
        self.x += i32::from(moved.dx_mm);
        self.y += i32::from(moved.dy_mm);
        self.send(Event::Odometry {
            motion: motion.id,
            moved,
            turned: Bearing::ZERO,
            progress: if touched {
                Progress::Touched
            } else {
                Progress::Ended
            },
        });
    }

    fn step(&mut self) -> Out {
        let out = self.ring();
        if let Some(motion) = out.motion {
            self.execute(motion);
        }
        out
    }

    fn explore(&mut self, moves: u16) {
        self.send(Event::Command(Command::Explore { moves, seed: 7 }));
        let mut steps = 0..=moves;
        assert!(steps.any(|_| self.step().mode_changed), "it never ends");
    }

    /// What is heard from here on is not the first that the robot hears.
    fn has_looked_around(&mut self) {
        let way = Displacement::along(Bearing::ZERO, 100);
        self.state.shield.moved(way, Bearing::ZERO);
    }

    fn learn(&mut self) {
        let out = self.send(Event::Command(Command::Learn));
        assert_eq!(out.refusal, None);
        let mut ticks = 0..10_000;
        assert!(
            ticks.any(|_| self.send(Event::Tick).mode_changed),
            "it never ends"
        );
    }

    fn ready(config: Config<16>) -> Self {
        let mut bench = Self::new(config);
        // Near a wall, so that there is something to learn.
        bench.x = 1_300;
        bench.explore(MOVES);
        bench.learn();
        bench
    }
}

#[test]
fn commands_that_cannot_be_carried_out_are_refused() {
    let mut bench = Bench::new(Config::recommended());
    let mut refusal = |command| bench.send(Event::Command(command)).refusal;
    assert_eq!(refusal(Command::Learn), Some(CommandRefusal::NoSamples));
    let goal = Goal::free_of_obstacles();
    assert_eq!(
        refusal(Command::Seek(goal)),
        Some(CommandRefusal::NotLearned)
    );
    let explore = |moves| Command::Explore { moves, seed: 1 };
    assert_eq!(
        refusal(explore(0)),
        Some(CommandRefusal::InvalidMoveCount { max: 20 })
    );
    assert_eq!(
        refusal(explore(21)),
        Some(CommandRefusal::InvalidMoveCount { max: 20 })
    );
    assert_eq!(bench.state.mode(), &Mode::Idle);
}

#[test]
fn exploring_remembers_each_move() {
    let mut bench = Bench::new(Config::recommended());
    bench.explore(20);
    assert_eq!(bench.state.mode(), &Mode::Idle);
    let samples = bench.state.memory().samples();
    assert_eq!(samples.len(), 20);
    assert!(
        samples
            .windows(2)
            .all(|pair| pair[0].after == pair[1].before)
    );
    assert!(
        samples
            .iter()
            .any(|sample| sample.executed != Displacement::ZERO)
    );
    let longest = samples.iter().map(|s| s.commanded.length_mm()).max();
    assert!(
        longest.is_some_and(|mm| (200..=251).contains(&mm)),
        "{longest:?}"
    );
}

/// The robot stands still, and one range gets shorter.
#[test]
fn what_meets_another_surface_is_no_part_of_the_sample() {
    let unknown = |largest_mm, jump_mm: u16| {
        let mut bench = Bench::new(Config::recommended());
        bench.config.learning.largest_change_mm = largest_mm;
        bench.send(Event::Command(Command::Explore { moves: 1, seed: 1 }));
        let motion = bench.ring().motion.expect("a motion");
        bench.execute(Motion {
            displacement: Displacement::ZERO,
            ..motion
        });
        bench.time += 640;
        for sensor in 0..16 {
            let jump_mm = if sensor == 5 { jump_mm } else { 0 };
            let range = Some(Range::from_mm(bench.range_mm(sensor) as u16 - jump_mm));
            let sensor = sensor as u8;
            bench.send(Event::Echo { sensor, range });
        }
        let [sample] = *bench.state.memory().samples() else {
            panic!("one sample")
        };
        [sample.before, sample.after].map(|bytes| {
            let places = bytes.iter().enumerate();
            let unknown = places.filter(|(_, byte)| **byte == u8::MAX);
            unknown.map(|(place, _)| place).collect::<Vec<_>>()
        })
    };
    assert_eq!(unknown(300, 310), [[5], [5]]);
    assert_eq!(unknown(300, 290), [[0; 0]; 2]);
    assert_eq!(unknown(320, 310), [[0; 0]; 2]);
}

/// Transducer 0 hears nothing of what the body meets ahead.
#[test]
fn the_detector_is_told_of_contacts_and_of_nothing_else() {
    let ahead = Displacement::along(Bearing::ZERO, 100);
    for (progress, touched) in [
        (Progress::Moving, false),
        (Progress::Ended, false),
        (Progress::Touched, true),
    ] {
        let mut bench = Bench::new(Config::recommended());
        bench.ring();
        let (sensor, range) = (0, None);
        bench.send(Event::Echo { sensor, range });
        let mut detector = bench.state.detector.clone();
        bench.send(Event::Odometry {
            motion: 0,
            moved: ahead,
            turned: Bearing::ZERO,
            progress,
        });
        if touched {
            detector.touched(&bench.config, ahead);
        }
        detector.moved(&bench.config, ahead, Bearing::ZERO);
        assert!(bench.state.detector == detector, "{progress:?}");
    }
}

#[test]
fn learning_takes_the_ticks_it_should_and_stands_still() {
    let mut bench = Bench::new(Config::recommended());
    bench.explore(20);
    bench.log.clear();
    bench.learn();
    let presentations = 20 * usize::from(bench.config.learning.epochs);
    let slice = usize::from(bench.config.learning.slice);
    // The first sixteen in slices of half the size.
    let ticks = 32 / slice + (presentations - 16).div_ceil(slice);
    assert_eq!(bench.log.len(), 1 + ticks);
    assert!(bench.log.iter().all(|out| out.motion.is_none()));
}

#[test]
fn the_maps_do_not_depend_on_the_slices() {
    let learned = |slice| {
        let mut config = Config::recommended();
        config.learning.slice = slice;
        let state = Bench::ready(config).state;
        (state.situations, state.actions)
    };
    let whole = learned(16);
    for slice in [0, 1, 3, 4, 7, u16::MAX] {
        assert!(learned(slice) == whole, "{slice}");
    }
}

#[test]
fn the_same_events_give_the_same_state() {
    let run = || {
        let mut bench = Bench::ready(Config::recommended());
        bench.send(Event::Command(Command::Seek(Goal::free_of_obstacles())));
        for _ in 0..50 {
            bench.step();
        }
        (bench.state, bench.log)
    };
    assert!(run() == run());
}

#[test]
fn a_new_goal_acts_within_one_step_and_costs_no_memory() {
    let mut bench = Bench::ready(Config {
        online: None,
        ..Config::recommended()
    });
    (bench.x, bench.y) = (1_300, 0);
    bench.send(Event::Command(Command::Seek(Goal::free_of_obstacles())));
    let away = bench.ring().motion.expect("a motion");
    bench.execute(away);
    (bench.x, bench.y) = (1_300, 0);
    let before = bench.state.memory().clone();
    let mut components = [Component::ANY; 16];
    components[0] = Component::at_least(Weight::ONE);
    bench.send(Event::Command(Command::Seek(Goal::of(components))));
    let towards = bench.ring().motion.expect("a motion");
    assert!(away.displacement.dx_mm < 0 && towards.displacement.dx_mm > 0);
    assert_eq!(bench.state.memory(), &before);
}

#[test]
fn an_echo_in_the_way_shortens_the_motion_under_way() {
    let mut bench = Bench::new(Config::recommended());
    bench.config.exploration.shortest_mm = 200;
    bench.send(Event::Command(Command::Explore { moves: 20, seed: 3 }));
    let motion = bench.ring().motion.expect("a motion");
    let bearing = motion.displacement.bearing();
    let sensor = (bearing.as_turns().wrapping_add(2_048) >> 12) as u8;
    bench.time += 40;
    let far = bench.send(Event::Echo {
        sensor,
        range: Some(Range::from_mm(2_000)),
    });
    assert_eq!(far.motion, None);
    let near = bench.send(Event::Echo {
        sensor,
        range: Some(Range::from_mm(100)),
    });
    let shortened = near.motion.expect("a shorter motion");
    assert_eq!(shortened.id, motion.id);
    assert!(shortened.displacement.length_mm() < motion.displacement.length_mm());
}

#[test]
fn only_the_end_of_the_present_motion_begins_a_new_ring() {
    let mut bench = Bench::new(Config::recommended());
    bench.send(Event::Command(Command::Explore { moves: 20, seed: 3 }));
    let motion = bench.ring().motion.expect("a motion");
    let report = |id, progress| Event::Odometry {
        motion: id,
        moved: Displacement::ZERO,
        turned: Bearing::ZERO,
        progress,
    };
    bench.send(report(motion.id.wrapping_sub(1), Progress::Ended));
    assert_eq!(bench.ring().decision, None);
    bench.send(report(motion.id, Progress::Moving));
    assert_eq!(bench.ring().decision, None);
    bench.send(report(motion.id, Progress::Ended));
    assert!(bench.ring().decision.is_some());
}

#[test]
fn stop_stops_a_motion_under_way() {
    let mut bench = Bench::new(Config::recommended());
    bench.send(Event::Command(Command::Explore { moves: 20, seed: 3 }));
    let motion = bench.ring().motion.expect("a motion");
    let stop = bench
        .send(Event::Command(Command::Stop))
        .motion
        .expect("a stop");
    assert_eq!(stop.displacement, Displacement::ZERO);
    assert_ne!(stop.id, motion.id);
    assert_eq!(bench.state.mode(), &Mode::Stopped(StopReason::Commanded));
    assert_eq!(bench.ring().motion, None);
}

#[test]
fn a_move_cut_short_rests_its_neuron() {
    let mut bench = Bench::ready(Config {
        shield: None,
        online: None,
        ..Config::recommended()
    });
    bench.config.planning.inhibition = 2;
    // The goal asks for a wall on every side: the robot runs into the corner and is held there.
    let components = [Component::equal(Weight::ONE); 16];
    bench.send(Event::Command(Command::Seek(Goal::of(components))));
    (bench.x, bench.y) = (1_731, 1_731);
    let mut neurons = Vec::new();
    for _ in 0..6 {
        let plan = bench.ring();
        let decision = plan
            .decision
            .and_then(|decision| decision.plan)
            .expect("a plan");
        assert_ne!(decision.why, Why::KeepCourse);
        neurons.push(decision.action_neuron);
        // Nothing moves, whatever is asked for.
        let id = plan.motion.map_or(0, |motion| motion.id);
        bench.send(Event::Odometry {
            motion: id,
            moved: Displacement::ZERO,
            turned: Bearing::ZERO,
            progress: Progress::Touched,
        });
    }
    // The first two rest while the third is asked; then the first one has rested for two decisions.
    let three: std::collections::BTreeSet<_> = neurons[..3].iter().collect();
    assert_eq!((three.len(), &neurons[..3]), (3, &neurons[3..]));
}

#[test]
fn while_the_ring_turns_the_executed_move_stays_in_the_frame_of_the_decision() {
    let mut bench = Bench::new(Config::recommended());
    bench.send(Event::Command(Command::Explore { moves: 1, seed: 3 }));
    let motion = bench.ring().motion.expect("a motion");
    let quarter = Bearing::from_turns(1 << 14);
    let report = |dx_mm, turned, progress| Event::Odometry {
        motion: motion.id,
        moved: Displacement { dx_mm, dy_mm: 0 },
        turned,
        progress,
    };
    bench.send(report(100, quarter, Progress::Moving));
    // The ring's x axis now points along what was y at the decision.
    bench.send(report(50, Bearing::ZERO, Progress::Ended));
    bench.ring();
    let executed = bench
        .state
        .memory()
        .samples()
        .first()
        .map(|sample| sample.executed);
    assert_eq!(
        executed,
        Some(Displacement {
            dx_mm: 100,
            dy_mm: 50
        })
    );
}

#[test]
fn the_paper_sized_state_fits_eight_and_a_half_kilobytes() {
    // The graph of traversed situations has its own bound.
    #[cfg(feature = "graph")]
    let size = size_of::<NomadState>() - size_of::<crate::graph::TraversedGraph<16>>();
    #[cfg(not(feature = "graph"))]
    let size = size_of::<NomadState>();
    assert!(size <= 8_704, "{size} bytes");
}

#[test]
fn wild_events_do_not_panic() {
    let mut bench = Bench::ready(Config::recommended());
    bench.send(Event::Command(Command::Seek(Goal::free_of_obstacles())));
    let wild = Displacement {
        dx_mm: i16::MIN,
        dy_mm: i16::MAX,
    };
    for sensor in [0, 15, 16, 31, 32, 255] {
        for range in [
            None,
            Some(Range::from_mm(0)),
            Some(Range::from_mm(u16::MAX)),
        ] {
            bench.time = bench.time.wrapping_mul(7).wrapping_sub(1);
            bench.send(Event::Echo { sensor, range });
            bench.send(Event::Odometry {
                motion: bench.state.motion_id,
                moved: wild,
                turned: Bearing::from_turns(u16::from(sensor) << 8),
                progress: Progress::Touched,
            });
            bench.ring();
        }
    }
}

#[test]
fn a_stop_of_a_robot_that_does_nothing_leaves_nothing_to_resume() {
    let mut bench = Bench::new(Config::recommended());
    let resume = |bench: &mut Bench| bench.send(Event::Command(Command::Resume)).refusal;
    bench.send(Event::Command(Command::Stop));
    assert_eq!(resume(&mut bench), Some(CommandRefusal::NothingToResume));
    bench.send(Event::Command(Command::Explore { moves: 20, seed: 3 }));
    assert_eq!(resume(&mut bench), Some(CommandRefusal::NothingToResume));
    // A second stop does not forget what the first one interrupted.
    bench.send(Event::Command(Command::Stop));
    bench.send(Event::Command(Command::Stop));
    assert_eq!(resume(&mut bench), None);
    assert_eq!(bench.state.mode(), &Mode::Explore { left: 20 });
    // Alarms stop whoever may move, and nobody else.
    bench.send(Event::Alarm(StopReason::LinkLost));
    assert_eq!(bench.state.mode(), &Mode::Stopped(StopReason::LinkLost));
    let again = bench.send(Event::Alarm(StopReason::RingIncomplete));
    assert!(!again.mode_changed);
    assert_eq!(bench.state.mode(), &Mode::Stopped(StopReason::LinkLost));
}

#[test]
fn maps_may_start_anywhere_and_learn_what_was_asked_for_in_the_order_recorded() {
    let learned = |start, order, taught| {
        let mut config = Config::recommended();
        config.learning.augment_rotations = false;
        config.learning.epochs = 2;
        (config.learning.start, config.learning.order) = (start, order);
        config.learning.learn_from = taught;
        Bench::ready(config).state
    };
    use crate::config::{Initialization, LearnFrom, SampleOrder};
    let values = |state: &Robot| {
        let all = state.situations().code().as_flattened();
        all.iter()
            .all(|value| (0..=1 << 29).contains(&value.to_bits()))
    };
    let random = learned(
        Initialization::Random,
        SampleOrder::Recorded,
        LearnFrom::Executed,
    );
    assert!(
        random
            == learned(
                Initialization::Random,
                SampleOrder::Recorded,
                LearnFrom::Executed
            )
    );
    for (start, order, taught) in [
        (
            Initialization::Samples,
            SampleOrder::Recorded,
            LearnFrom::Executed,
        ),
        (
            Initialization::Random,
            SampleOrder::Random,
            LearnFrom::Executed,
        ),
        (
            Initialization::Plane,
            SampleOrder::Recorded,
            LearnFrom::Commanded,
        ),
    ] {
        let other = learned(start, order, taught);
        assert!(other.situations() != random.situations() && values(&other));
    }
    // What was carried out and what was asked for are the same until a wall was in the way.
    let executed = learned(
        Initialization::Plane,
        SampleOrder::Recorded,
        LearnFrom::Executed,
    );
    let commanded = learned(
        Initialization::Plane,
        SampleOrder::Recorded,
        LearnFrom::Commanded,
    );
    let samples = executed.memory().samples().iter();
    let cut = samples.filter(|s| s.commanded != s.executed).count();
    assert_eq!(cut > 0, executed.actions() != commanded.actions());
    assert!(executed.situations() == commanded.situations());
}

#[test]
#[cfg_attr(miri, ignore = "sixty decisions: minutes")]
fn a_place_that_is_not_found_is_searched_for_elsewhere() {
    let mut bench = Bench::ready(Config::recommended());
    (bench.x, bench.y) = (0, 0);
    // Nothing in this room looks like it.
    let components = core::array::from_fn(|place| {
        let value = if place % 2 == 0 {
            Weight::ONE
        } else {
            Weight::ZERO
        };
        Component::equal(value)
    });
    bench.send(Event::Command(Command::Seek(Goal::place(components))));
    let avoiding = Goal::avoiding(&bench.config);
    let mut whys = Vec::new();
    for _ in 0..60 {
        let plan = bench.step().decision.and_then(|decision| decision.plan);
        let plan = plan.expect("a plan");
        if plan.why == Why::Wander {
            let map = bench.state.situations();
            let deviation = |k: &u8| avoiding.distance(&map.code_vector((*k).into()), Mask::ALL);
            assert_eq!(Some(plan.goal_neuron), (0..16).min_by_key(deviation));
        }
        whys.push((plan.why, plan.at_goal));
    }
    let wanders = whys.iter().filter(|(why, _)| *why == Why::Wander).count();
    let patience = bench.config.planning.wander.expect("it may").patience;
    assert!(
        whys[..usize::from(patience)]
            .iter()
            .all(|(why, _)| *why != Why::Wander)
    );
    assert!(wanders >= 30 && wanders < whys.len(), "{wanders}");
    assert!(whys.iter().all(|(_, at_goal)| !at_goal));
}

/// Who goes on and on has no place to look for, and a wall to follow is nowhere else.
#[test]
fn only_a_place_is_searched_for() {
    let following = Goal {
        frame: crate::goal::GoalFrame::Travel,
        ..Goal::place([Component::equal(Weight::ONE); 16])
    };
    for goal in [Goal::free_of_obstacles(), following] {
        let mut bench = Bench::ready(Config::recommended());
        bench.send(Event::Command(Command::Seek(goal)));
        for _ in 0..if cfg!(miri) { 3 } else { 60 } {
            let plan = bench.step().decision.and_then(|decision| decision.plan);
            assert_ne!(plan.map(|plan| plan.why), Some(Why::Wander));
        }
    }
}

#[test]
fn parts_are_written_while_the_robot_stands_and_where_they_fit() {
    let mut bench = Bench::new(Config::recommended());
    let write =
        |bench: &mut Bench, part, offset, bytes: &[u8]| bench.state.write_part(part, offset, bytes);
    let length = bench.state.part_len(StatePart::Actions);
    let four = [1, 0, 0, 0];
    assert_eq!(
        write(&mut bench, StatePart::Actions, length - 4, &four),
        Ok(())
    );
    // Beyond the end, not at a value's beginning, not whole values.
    for (offset, bytes) in [
        (length, &four[..]),
        (usize::MAX - 3, &four),
        (2, &four),
        (0, &four[..3]),
    ] {
        let refused = write(&mut bench, StatePart::Actions, offset, bytes);
        assert_eq!(refused, Err(TransferError::OutOfBounds), "{offset}");
    }
    // Samples follow one another, whole, and no more than there is room for.
    let sample = [7; Robot::SAMPLE_BYTES];
    assert_eq!(write(&mut bench, StatePart::Memory, 0, &sample), Ok(()));
    for (offset, bytes) in [
        (0, &sample[..10]),
        (2 * sample.len(), &sample),
        (sample.len(), &[7; 20 * Robot::SAMPLE_BYTES]),
    ] {
        let refused = write(&mut bench, StatePart::Memory, offset, bytes);
        assert_eq!(refused, Err(TransferError::OutOfBounds), "{offset}");
    }
    assert_eq!(bench.state.memory().samples().len(), 1);
    bench.send(Event::Command(Command::Explore { moves: 20, seed: 3 }));
    let busy = write(&mut bench, StatePart::Actions, 0, &four);
    assert_eq!(busy, Err(TransferError::Busy));
    let words =
        [TransferError::Busy, TransferError::OutOfBounds].map(|error| std::format!("{error}"));
    assert_eq!(words[0], "the robot explores, learns or seeks");
    assert_eq!(words[1], "the piece does not fit where it says");
}

#[test]
fn random_moves_have_all_lengths_and_the_shield_has_some_drawn_anew() {
    let lengths = |shortest_mm, draws| {
        let mut config = Config::recommended();
        config.exploration = crate::config::Exploration { shortest_mm, draws };
        let mut bench = Bench::new(config);
        // In a corner: three quarters of all ways are barred.
        (bench.x, bench.y) = (1_640, 1_640);
        bench.has_looked_around();
        bench.explore(20);
        let samples = bench.state.memory().samples().iter();
        let cut = |sample: &&crate::memory::Sample<16>| {
            sample.executed.length_mm() < sample.commanded.length_mm() / 2
        };
        let cuts = samples.clone().filter(cut).count();
        let commanded: Vec<_> = samples.map(|sample| sample.commanded.length_mm()).collect();
        (commanded, cuts)
    };
    let (any, cuts) = lengths(0, 8);
    assert!(
        any.iter().any(|mm| *mm < 60) && any.iter().any(|mm| *mm > 200),
        "{any:?}"
    );
    let (long, many) = lengths(240, 0);
    assert!(long.iter().all(|mm| (239..=251).contains(mm)), "{long:?}");
    assert!(cuts < 4 && many > cuts, "{cuts} {many}");
}

#[test]
fn the_first_maps_are_spread_over_the_plane() {
    let mut config = Config::recommended();
    config.learning.epochs = 1;
    let mut bench = Bench::new(config);
    bench.explore(20);
    bench.send(Event::Command(Command::Learn));
    let bits = |k| {
        bench
            .state
            .actions()
            .actions()
            .code_vector(k)
            .map(Weight::to_bits)
    };
    let third = 8_192 / 3;
    assert_eq!(
        [0, 3, 12, 15].map(bits),
        [
            [-8_192, -8_192],
            [8_192, -8_192],
            [-8_192, 8_192],
            [8_192, 8_192]
        ]
    );
    assert_eq!([5, 10].map(bits), [[-third, -third], [third, third]]);
    let changes = bench.state.actions().changes().code();
    assert!(
        changes
            .as_flattened()
            .iter()
            .all(|value| value.to_bits() == 0)
    );
}

#[test]
fn a_map_that_starts_anywhere_has_values_of_either_sign_where_there_are_such() {
    let mut config = Config::recommended();
    config.learning.start = crate::config::Initialization::Random;
    let mut bench = Bench::new(config);
    bench.explore(20);
    bench.send(Event::Command(Command::Learn));
    let spread = |code: &[crate::fixed::Weight32]| {
        let bits = code.iter().map(|value| value.to_bits() >> 16);
        (bits.clone().min().unwrap_or(0), bits.max().unwrap_or(0))
    };
    let (least, most) = spread(bench.state.situations().code().as_flattened());
    assert!(
        (0..400).contains(&least) && (7_800..8_192).contains(&most),
        "{least} {most}"
    );
    let (least, most) = spread(bench.state.actions().changes().code().as_flattened());
    assert!(
        (-8_192..-7_800).contains(&least) && (7_800..8_192).contains(&most),
        "{least} {most}"
    );
    let (least, most) = spread(bench.state.actions().actions().code().as_flattened());
    assert!(
        (-8_192..-6_000).contains(&least) && (6_000..8_192).contains(&most),
        "{least} {most}"
    );
}

#[test]
fn a_turned_sample_teaches_the_same_move_seen_from_another_transducer() {
    let mut bench = Bench::new(Config::recommended());
    bench.config.learning.epochs = 200;
    bench.x = 1_300;
    // One move only, and so one direction.
    bench.explore(1);
    bench.learn();
    let actions = bench.state.actions().actions().code().iter();
    let quadrants: std::collections::BTreeSet<_> = actions
        .map(|action| action.map(|part| part.to_bits() > 0))
        .collect();
    assert_eq!(quadrants.len(), 4);
}

/// The last displacement, unless there was none; where the maps are recalled none is a course as
/// well.
#[test]
fn who_stays_keeps_the_course_while_looking_ahead() {
    let aside = Displacement {
        dx_mm: 0,
        dy_mm: 100,
    };
    for (config, kept) in [
        (Config::recommended(), aside),
        (Config::probing(), Displacement::ZERO),
    ] {
        // Maps that know nothing: no action brings anything.
        let mut bench = Bench::new(config);
        bench.state.learned = true;
        bench.state.course = Tracked::new(aside);
        let goal = Goal::place([Component::equal(Weight::ONE); 16]);
        bench.send(Event::Command(Command::Seek(goal)));
        let decision = bench.ring().decision.expect("a decision");
        assert_eq!(decision.wanted, Displacement::ZERO);
        assert_eq!(bench.state.course.now(), kept);
    }
}

/// Something is wanted 0.5 m behind to the right, and it is nearer: the robot backs away from it
/// and looks along it.
#[test]
#[cfg_attr(miri, ignore = "four robots made ready: minutes")]
fn who_follows_looks_along_the_way_whichever_way_the_robot_goes() {
    let course = |frame, progress_q16| {
        let mut bench = Bench::ready(Config::recommended());
        (bench.x, bench.y) = (1_700, 0);
        let near = bench.config.encoding.value(Some(Range::from_mm(500)));
        let mut components = [Component::ANY; 16];
        components[9] = Component::equal(near);
        bench.send(Event::Command(Command::Seek(Goal {
            frame,
            progress_q16,
            ..Goal::of(components)
        })));
        let decision = bench.ring().decision.expect("a decision");
        // Transducer 13 hears it best.
        let (x, y) = bench.config.robot.directions[4].times(250);
        (
            bench.state.course.now(),
            Displacement::saturating(x, y),
            decision.wanted,
        )
    };
    use crate::goal::GoalFrame;
    let (course_along, along, wanted) = course(GoalFrame::Travel, 0);
    assert_ne!(along, wanted);
    assert_eq!(course_along, along);
    for (frame, progress_q16) in [
        (GoalFrame::Travel, 1),
        (GoalFrame::Ring, 0),
        (GoalFrame::Ring, 1),
    ] {
        let (course, along, wanted) = course(frame, progress_q16);
        assert_ne!(along, wanted, "{frame:?} {progress_q16}");
        assert_eq!(course, wanted, "{frame:?} {progress_q16}");
    }
}

/// A move of which half was carried out, rounded down, was not cut.
#[test]
fn a_move_is_cut_below_half() {
    let pending = |mm: i16| Pending::<2> {
        before: Aligned([Weight::ZERO; 2]),
        commanded: Displacement {
            dx_mm: 0,
            dy_mm: 251,
        },
        executed: Displacement {
            dx_mm: mm,
            dy_mm: 0,
        },
        remaining: Tracked::ZERO,
        turned: Bearing::ZERO,
        speed_mm_s: 0,
    };
    assert!(pending(124).was_cut() && !pending(125).was_cut());
}
