//! Episodes and sessions with a node in this process, over good lines and bad ones.

use super::*;
use crate::episode::{Episode, Failure, Setup, run, run_with};
use crate::robot::TurretMode;
use crate::scenes::Behavior;
use crate::settings;
use crate::sonar::SonarModel;
use crate::world::World;
use amp::config::Config;
use amp::controller::Refusal as Refused;
use amp::parameters::{Parameter, ParameterError};
use amp::wire::message::{Clock, Order, Part, Refusal};
use std::time::{Duration, Instant};

pub(super) mod floods;
mod strangers;

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
        set_down: None,
        faults: Vec::new(),
        record: true,
    }
}

fn here(world: &World, setup: &Setup) -> Episode {
    run(world, setup, |_, _, _| {}).unwrap()
}

fn there(session: &mut Session, world: &World, setup: &Setup) -> Result<Episode, Failure> {
    let number = session.number() + 1;
    let mut mind = RemoteMind::start(session, number, &setup.config).map_err(Failure::Link)?;
    run_with(world, setup, &mut mind, |_, _, _| {})
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
    Session::new(Local::new(Config::recommended()))
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
    settings::apply(&mut gaps.config, &["mask=3+14+15", "epochs=3"]).unwrap();
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
        RemoteMind::start(session, number, config)
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
    // Standing still in a new session.
    let hello = teacher.open(500, Clock::Device).unwrap();
    let knowledge = Knowledge::pull(&mut teacher).unwrap();
    assert_eq!(knowledge.fingerprint(), Fingerprint::from(&hello));
    assert_eq!(knowledge.samples(), 100);
    assert_eq!(*knowledge.config(), setup.config);

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("robot.mind");
    knowledge.save(&path).unwrap();
    let read = Knowledge::load(&path).unwrap();
    assert_eq!(read, knowledge);

    let mut pupil = opened(Local::new(Config::touzet()));
    read.push(&mut pupil).unwrap();
    assert_eq!(Knowledge::pull(&mut pupil).unwrap(), knowledge);
    // It has learnt.
    pupil.order(0, Order::Seek).unwrap();
    let refused = Err(LinkError::Refused(Refusal::Moving));
    assert_eq!(Knowledge::pull(&mut pupil), refused);
    assert_eq!(read.push(&mut pupil).map(|()| knowledge), refused);
}

#[test]
fn a_damaged_file_is_refused() {
    let mut session = opened(Local::new(Config::recommended()));
    let sound = Knowledge::pull(&mut session).unwrap().to_bytes();
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
    let most = Refused::Moves { most: 100 };
    assert_eq!(failure, Some(Failure::Refused(most)));
    let refused = |error: LinkError| match error {
        LinkError::Refused(why) => why,
        other => panic!("{other}"),
    };
    let learn = session.order(0, Order::Learn).map_err(refused);
    assert_eq!(learn, Err(Refusal::Command(Refused::NoSamples)));
    let near = session
        .parameter(Parameter::Near, Some(-1))
        .map_err(refused);
    let range = ParameterError::Range(Parameter::Near.spec());
    assert_eq!(near, Err(Refusal::Parameter(range)));
    let bad = session.write_part(Part::Config, &[9; 9]).map_err(refused);
    assert_eq!(bad, Err(Refusal::Config));
}

#[test]
fn frames_lost_on_the_way_there_change_nothing() {
    let world = World::random(6);
    for (every, sonar) in [(2, SonarModel::Ideal), (3, SonarModel::Nomad)] {
        let line = Lossy::new(Local::new(Config::recommended()), every, 0);
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
        let line = Lossy::new(Local::new(Config::recommended()), out, back);
        let setup = setup(sonar, 20, 20);
        let remote = there(&mut Session::new(line), &world, &setup).unwrap();
        assert_same(&remote, &here(&world, &setup));
    }
}

#[test]
fn reading_and_writing_bear_losses_both_ways() {
    for (out, back) in [(3, 0), (0, 3), (5, 4), (4, 7)] {
        let line = Lossy::new(Local::new(Config::recommended()), out, back);
        let mut session = opened(line);
        let set = session.parameter(Parameter::Far, Some(1_500));
        assert_eq!(set.map(|(value, _)| value), Ok(1_500));
        let knowledge = Knowledge::pull(&mut session).unwrap();
        assert_eq!(knowledge.config().encoding.far_mm, 1_500);
        assert_eq!(knowledge.push(&mut session), Ok(()), "{out} {back}");
        assert!(session.counters().unwrap().accepted > 20);
    }
}

#[test]
fn the_same_over_a_socket_in_real_time() {
    let served = Served::start(Config::recommended()).unwrap();
    let mut session = Session::new(Tcp::open(&served.host()).unwrap());
    let (world, setup) = (World::random(1), setup(SonarModel::Ideal, 20, 20));
    let remote = there(&mut session, &world, &setup).unwrap();
    assert_same(&remote, &here(&world, &setup));
    drop(served);
    let began = Instant::now();
    let error = session.counters().unwrap_err();
    assert!(matches!(error, LinkError::Broken { .. }), "{error}");
    assert!(began.elapsed() < Duration::from_secs(1));
}
