//! Episodes and sessions with a node in this process, over good and bad transports.

use super::*;
use amp::config::Config;
use amp::controller::{Command, CommandRefusal as Refused, Event, Outputs, Progress, StopReason};
use amp::parameters::{Parameter, ParameterError};
use amp::units::{Bearing, Displacement, Millis, Range};
use amp::wire::message::{Clock, Refusal, RobotCommand, TransferPart};
use arena::robot::TurretMode;
use arena::robot_model::RobotModel;
use arena::sonar::SonarModel;
use arena::world::World;
use sim::behavior::{Behavior, Tour};
use sim::episode::{Episode, Setup, run, run_with};
use sim::error::EpisodeError;
use sim::pilot::{AgedEcho, LocalController, Pilot as _};
use sim::robot::{AnyRobot, Origin, Ranges};
use sim::settings;
use sim::turret_pilot::SimBody;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

pub(super) mod floods;
mod foreign_frames;
mod saved;
mod twin;

fn setup(sonar: SonarModel, moves: u16, steps: u32) -> Setup {
    Setup {
        config: Config::recommended(),
        preset: "default".into(),
        behavior: Behavior::Avoid,
        explore_moves: moves,
        steps,
        seed: 5,
        sonar,
        turret: TurretMode::Held,
        robot: None,
        set_down: None,
        faults: Vec::new(),
        goal: None,
        second_robot: false,
        record: true,
    }
}

fn here(world: &World, setup: &Setup) -> Episode {
    run(world, setup, |_, _, _| {}).unwrap()
}

fn there(session: &mut Session, world: &World, setup: &Setup) -> Result<Episode, EpisodeError> {
    let number = session.number() + 1;
    let robot = setup.robot.as_ref().map(AnyRobot::told);
    let started = RemoteController::start(session, number, &setup.config, robot.as_ref());
    let mut controller = started.map_err(EpisodeError::from)?;
    run_with(world, setup, &mut controller, |_, _, _| {})
}

/// Sensors anywhere on the body: known, and found by the controller.
#[test]
fn another_robot_is_the_same_at_the_other_end_of_a_link() {
    for (sonar, geometry) in [
        (SonarModel::Ideal, Origin::Known),
        (SonarModel::Nomad, Origin::Learned),
    ] {
        // A device takes its heading to drift.
        let model = RobotModel::builtin("p3dx").unwrap();
        let robot = AnyRobot::new(model, Ranges::Own, true).unwrap();
        assert!(robot.heading_drifts());
        let robot = robot.scrambled(3).with_geometry(geometry).unwrap();
        let setup = Setup {
            config: robot.config(Config::recommended()),
            robot: Some(robot),
            ..setup(sonar, 60, 40)
        };
        let world = World::random(5);
        let node = InProcessNode::<16, SimBody>::of_body(Config::recommended());
        let mut session = Session::new(Box::new(node));
        let far = there(&mut session, &world, &setup).unwrap();
        let near = here(&world, &setup);
        assert_same(&far, &near);
        assert_eq!(far.bearing_errors_deg, near.bearing_errors_deg);
        assert_eq!(
            far.bearing_errors_deg.is_some(),
            geometry == Origin::Learned
        );
    }
}

/// Home after a tour; carried away, with a heading that drifts; and by the goal alone.
#[test]
fn places_lead_a_robot_at_the_other_end_of_a_link_as_here() {
    let tour = Tour::of(60);
    let nest = Behavior::Nest {
        tour,
        is_turned: true,
    };
    for (sonar, ranges, is_led, behavior) in [
        (
            SonarModel::Ideal,
            Ranges::Nomad,
            true,
            Behavior::Home { tour },
        ),
        (SonarModel::Nomad, Ranges::Own, true, nest.clone()),
        (SonarModel::Ideal, Ranges::Nomad, false, nest),
    ] {
        let model = RobotModel::builtin("p3dx").unwrap();
        let robot = AnyRobot::new(model, ranges, true).unwrap().led(is_led);
        let setup = Setup {
            config: robot.config(Config::recommended()),
            robot: Some(robot),
            behavior,
            ..setup(sonar, 40, 80)
        };
        let world = World::random(5);
        let node = InProcessNode::<16, SimBody>::of_body(Config::recommended());
        let mut session = Session::new(Box::new(node));
        let (far, near) = (there(&mut session, &world, &setup), here(&world, &setup));
        assert_same(&far.unwrap(), &near);
        assert!(
            near.report.shortest_m.is_none_or(|m| m > 0.5),
            "{:?}",
            near.report
        );
    }
}

#[test]
fn a_program_for_a_ring_refuses_a_body() {
    let model = RobotModel::builtin("thymio2").unwrap();
    let robot = AnyRobot::new(model, Ranges::Own, true).unwrap();
    let mut session = Session::new(Box::new(InProcessNode::<16>::new(Config::recommended())));
    let started =
        RemoteController::start(&mut session, 1, &Config::recommended(), Some(&robot.told()));
    let refused = started.err();
    assert_eq!(refused, Some(LinkError::Refused(Refusal::Body)));
}

fn assert_same(there: &Episode, here: &Episode) {
    let line = |episode: &Episode| serde_json::to_string(&episode.report).unwrap();
    assert_eq!(line(there), line(here));
    assert!(
        there.recording == here.recording,
        "every step and both maps"
    );
}

fn local() -> Session {
    Session::new(InProcessNode::new(Config::recommended()))
}

fn opened(transport: impl Transport + 'static) -> Session {
    let mut session = Session::new(transport);
    session.open(1, Clock::Host).unwrap();
    session
}

#[test]
fn a_mind_elsewhere_does_the_same_in_one_world_after_the_other() {
    let mut session = local();
    for (world, sonar, steps) in [
        (World::paper().unwrap(), SonarModel::Ideal, 200),
        (World::random(3), SonarModel::Nomad, 40),
        (World::random(4), SonarModel::Ideal, 100),
    ] {
        let setup = setup(sonar, 60, steps);
        let remote = there(&mut session, &world, &setup).unwrap();
        assert_same(&remote, &here(&world, &setup));
    }
}

#[test]
fn the_literal_preset_and_a_ring_with_gaps_do_the_same_too() {
    let world = World::random(2);
    let mut literal = setup(SonarModel::Harsh, 40, 40);
    (literal.config, literal.turret) = (Config::touzet(), TurretMode::Follow);
    let mut gaps = setup(SonarModel::Ideal, 100, 100);
    settings::apply(&mut gaps.config, &["disabled-sensors=3+14+15", "epochs=3"]).unwrap();
    for setup in [literal, gaps] {
        let remote = there(&mut local(), &world, &setup).unwrap();
        assert_same(&remote, &here(&world, &setup));
    }
}

#[test]
fn what_a_mind_had_before_is_named_and_gone() {
    let world = World::random(1);
    let mut session = local();
    let setup = setup(SonarModel::Ideal, 30, 10);
    let replaced = |session: &mut Session, number, config: &Config<16>| {
        RemoteController::start(session, number, config, None)
            .unwrap()
            .replaced()
    };
    assert!(replaced(&mut session, 1, &setup.config).is_empty());
    there(&mut session, &world, &setup).unwrap();
    let mut other = setup.config.clone();
    other.clearance_mm = 500;
    assert_eq!(
        replaced(&mut session, 10, &other),
        ["configuration", "maps", "memory"]
    );
    assert_eq!(replaced(&mut session, 20, &setup.config), ["configuration"]);
}

#[test]
fn knowledge_goes_from_one_mind_to_another_through_a_file() {
    let (world, setup) = (World::random(1), setup(SonarModel::Ideal, 100, 10));
    let mut teacher = local();
    there(&mut teacher, &world, &setup).unwrap();
    // At rest in a new session.
    let hello = teacher.open(500, Clock::Device).unwrap();
    let knowledge = Knowledge::download(&mut teacher).unwrap();
    assert_eq!(knowledge.fingerprint(), Fingerprint::from(&hello));
    assert_eq!(knowledge.samples(), 100);
    assert_eq!(*knowledge.config(), setup.config);

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("robot.mind");
    knowledge.save(&path).unwrap();
    let read = Knowledge::load(&path).unwrap();
    assert_eq!(read, knowledge);

    let mut pupil = opened(InProcessNode::new(Config::touzet()));
    read.upload(&mut pupil).unwrap();
    assert_eq!(Knowledge::download(&mut pupil).unwrap(), knowledge);
    // It has learned.
    pupil.command(0, RobotCommand::Seek).unwrap();
    let refused = Err(LinkError::Refused(Refusal::Moving));
    assert_eq!(Knowledge::download(&mut pupil), refused);
    assert_eq!(read.upload(&mut pupil).map(|()| knowledge), refused);
}

#[test]
fn a_damaged_file_is_refused() {
    let mut session = opened(InProcessNode::new(Config::recommended()));
    let sound = Knowledge::download(&mut session).unwrap().to_bytes();
    assert!(Knowledge::from_bytes(&sound).is_ok());
    for index in 0..sound.len() {
        let mut file = sound.clone();
        file[index] ^= 0x10;
        assert!(Knowledge::from_bytes(&file).is_err(), "byte {index}");
        assert!(
            Knowledge::from_bytes(&sound[..index]).is_err(),
            "{index} bytes"
        );
    }
}

#[test]
fn refusals_come_through() {
    let mut session = local();
    let hundred_and_one = setup(SonarModel::Ideal, 101, 1);
    let failure = there(&mut session, &World::random(1), &hundred_and_one).err();
    let most = Refused::InvalidMoveCount { max: 100 };
    assert_eq!(failure, Some(EpisodeError::Refused(most)));
    let refused = |error: LinkError| match error {
        LinkError::Refused(why) => why,
        other => panic!("{other}"),
    };
    let learn = session.command(0, RobotCommand::Learn).map_err(refused);
    assert_eq!(learn, Err(Refusal::Command(Refused::NoSamples)));
    let near = session
        .parameter(Parameter::Near, Some(-1))
        .map_err(refused);
    let range = ParameterError::OutOfRange(Parameter::Near.spec());
    assert_eq!(near, Err(Refusal::Parameter(range)));
    let bad = session
        .write_part(TransferPart::Config, &[9; 9])
        .map_err(refused);
    assert_eq!(bad, Err(Refusal::Config));
}

#[test]
fn frames_lost_on_the_way_there_change_nothing() {
    let world = World::random(6);
    for (every, sonar) in [(2, SonarModel::Ideal), (3, SonarModel::Nomad)] {
        let line = Lossy::new(InProcessNode::new(Config::recommended()), every, 0);
        let setup = setup(sonar, 20, 20);
        let remote = there(&mut Session::new(line), &world, &setup).unwrap();
        assert_same(&remote, &here(&world, &setup));
    }
}

#[test]
fn frames_lost_on_the_way_back_are_said_again() {
    let world = World::random(6);
    for (out, back, sonar) in [
        (0, 5, SonarModel::Ideal),
        (0, 7, SonarModel::Nomad),
        (0, 50, SonarModel::Ideal),
        (9, 5, SonarModel::Ideal),
    ] {
        let line = Lossy::new(InProcessNode::new(Config::recommended()), out, back);
        let setup = setup(sonar, 20, 20);
        let remote = there(&mut Session::new(line), &world, &setup).unwrap();
        assert_same(&remote, &here(&world, &setup));
    }
}

#[test]
fn reading_and_writing_bear_losses_both_ways() {
    for (out, back) in [(3, 0), (0, 3), (5, 4), (4, 7)] {
        let line = Lossy::new(InProcessNode::new(Config::recommended()), out, back);
        let mut session = opened(line);
        let set = session.parameter(Parameter::Far, Some(1_500));
        assert_eq!(set.map(|(value, _)| value), Ok(1_500));
        let knowledge = Knowledge::download(&mut session).unwrap();
        assert_eq!(knowledge.config().encoding.far_mm, 1_500);
        assert_eq!(knowledge.upload(&mut session), Ok(()), "{out} {back}");
        assert!(session.counters().unwrap().accepted > 20);
    }
}

#[test]
fn the_same_over_a_socket_in_real_time() {
    let served = NodeServer::start(Config::recommended()).unwrap();
    let mut session = Session::new(Tcp::open(&served.host()).unwrap());
    let (world, setup) = (World::random(1), setup(SonarModel::Ideal, 20, 20));
    let remote = there(&mut session, &world, &setup).unwrap();
    assert_same(&remote, &here(&world, &setup));
    drop(served);
    let error = session.counters().unwrap_err();
    assert!(matches!(error, LinkError::Broken { .. }), "{error}");
}

/// Sends the same events to a local and a remote controller and compares their outputs.
struct LocalAndRemote {
    here: LocalController,
    there: RemoteController<Session>,
    /// Number of sends to the remote controller.
    sent: Arc<AtomicU32>,
}

/// Counts the sends.
struct Counted(InProcessNode, Arc<AtomicU32>);

impl Transport for Counted {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.1.fetch_add(1, Ordering::Relaxed);
        self.0.send(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        self.0.receive(buffer, timeout)
    }
}

impl LocalAndRemote {
    fn exploring() -> Self {
        let (config, sent) = (Config::recommended(), Arc::default());
        let line = Counted(InProcessNode::new(config.clone()), Arc::clone(&sent));
        let mut both = Self {
            there: RemoteController::start(Session::new(line), 1, &config, None).unwrap(),
            here: LocalController::new(config),
            sent,
        };
        both.tell(0, Event::Command(Command::Explore { moves: 5, seed: 12 }));
        both
    }

    fn tell(&mut self, at_ms: u32, event: Event<16>) -> Outputs<16> {
        let at = Millis::from_ms(at_ms);
        let outputs = self.there.handle(at, event);
        assert_eq!(self.there.failure(), None);
        assert_eq!(outputs, self.here.handle(at, event));
        outputs
    }

    /// Sends a whole ring of this age; returns whether it caused a decision.
    fn ring(&mut self, at_ms: u32, age_ms: u32) -> bool {
        let at = Millis::from_ms(at_ms);
        let echoes: [_; 16] = std::array::from_fn(|sensor| AgedEcho {
            sensor: sensor as u8,
            range: Some(Range::from_mm(1_500)),
            age_ms,
        });
        let outputs = [
            self.there.echoes(at, &echoes),
            self.here.echoes(at, &echoes),
        ];
        let [there, here] = outputs.map(|(taken, outputs)| (taken, outputs.motion));
        assert_eq!(there, here);
        outputs[0].1.decision.is_some()
    }

    fn sent(&self) -> u32 {
        self.sent.load(Ordering::Relaxed)
    }
}

#[test]
fn an_echo_is_as_old_there_as_here() {
    let mut both = LocalAndRemote::exploring();
    assert!(both.ring(640, 0));
    let ended = Event::Odometry {
        motion: 1,
        moved: Displacement::ZERO,
        turned: Bearing::ZERO,
        progress: Progress::Ended,
    };
    both.tell(1_000, ended);
    for (at_ms, age_ms, counts) in [
        (1_100, 101, false),
        (1_200, 70_000, false),
        (1_300, 300, true),
    ] {
        assert_eq!(both.ring(at_ms, age_ms), counts, "{at_ms} {age_ms}");
    }
}

#[test]
fn time_passes_there_without_a_frame_for_each_tick() {
    let mut both = LocalAndRemote::exploring();
    let before = both.sent();
    for at_ms in (10..=1_280).step_by(10) {
        assert_eq!(both.tell(at_ms, Event::Tick), Outputs::NONE);
    }
    // One in 150 ms.
    assert_eq!(both.sent() - before, 8);
    // Two ring periods after the start.
    let late = Millis::from_ms(1_430);
    let stopped = both.here.handle(late, Event::Tick).stopped;
    assert_eq!(stopped, Some(StopReason::RingIncomplete));
    assert_eq!(both.there.handle(late, Event::Tick), Outputs::NONE);
    let failed = LinkError::Stopped(StopReason::RingIncomplete);
    assert_eq!(both.there.failure(), Some(EpisodeError::from(failed)));
}
