//! A mind with a body and places, saved and written to another device.

use super::*;
use amp::body::Body as _;
use sim::senses::SavedSenses;
use sim::sim_controller::SimController;

fn device() -> Session {
    let node = InProcessNode::<16, SimBody>::of_body(Config::recommended());
    Session::new(node)
}

/// A robot after its random moves, a tour and its way home.
fn robot() -> (World, Setup) {
    let model = RobotModel::builtin("p3dx").unwrap();
    let robot = AnyRobot::new(model, Ranges::Nomad, true).unwrap();
    let setup = Setup {
        config: robot.config(Config::recommended()),
        robot: Some(robot),
        behavior: Behavior::Home {
            tour: Tour::of(100),
        },
        ..setup(SonarModel::Nomad, 40, 120)
    };
    (World::random(5), setup)
}

/// A device after that, at rest, and what it knows.
fn taught(world: &World, setup: &Setup) -> (Session, Knowledge) {
    let mut teacher = device();
    there(&mut teacher, world, setup).unwrap();
    teacher.open(500, Clock::Device).unwrap();
    let knowledge = Knowledge::download(&mut teacher).unwrap();
    (teacher, knowledge)
}

fn places(body: &SimBody) -> Vec<u8> {
    let mut bytes = vec![0; body.places_len()];
    assert_eq!(body.read_places(0, &mut bytes), bytes.len());
    bytes
}

#[test]
fn body_and_places_go_from_one_device_to_another_through_a_file() {
    let (world, setup) = robot();
    let (mut teacher, knowledge) = taught(&world, &setup);
    // The same as here, and where the robot is.
    let mut mind = SimController::new(&setup.config, setup.robot.as_ref());
    run_with(&world, &setup, &mut mind, |_, _, _| {}).unwrap();
    let here = Knowledge::of_controller(&mind);
    let (far, near) = (knowledge.body().unwrap(), here.body().unwrap());
    assert_eq!(far.known(), near.known());
    let saved = places(far);
    assert!(saved.len() > 56 * 33, "{} bytes", saved.len());
    let told = near.turret().places();
    assert!(far.turret().places().positions().eq(told.positions()));
    let read = teacher.read_part(TransferPart::Places).unwrap();
    assert_eq!(read, places(near));

    let read = Knowledge::from_bytes(&knowledge.to_bytes()).unwrap();
    assert_eq!(read, knowledge);
    let mut pupil = device();
    pupil.open(1, Clock::Host).unwrap();
    read.upload(&mut pupil).unwrap();
    let again = Knowledge::download(&mut pupil).unwrap();
    assert_eq!(again.to_bytes(), knowledge.to_bytes());
    // Places change while it drives.
    pupil.command(0, RobotCommand::Seek).unwrap();
    let refused = knowledge.clone().read_body(&mut pupil);
    assert_eq!(refused, Err(LinkError::Refused(Refusal::Moving)));
    pupil.command(0, RobotCommand::Stop).unwrap();
    // It knows none of it any more.
    pupil.command(0, RobotCommand::Forget).unwrap();
    let forgotten = pupil.read_part(TransferPart::Places).unwrap();
    assert!(forgotten.is_empty());
}

/// What was perceived beside ranges follows the image.
#[test]
fn senses_are_read_from_a_file_whole_or_not_at_all() {
    let (_, setup) = robot();
    let world = World::builtin("office").unwrap();
    let setup = Setup {
        behavior: "scent:strongest".parse().unwrap(),
        ..setup
    };
    let mut mind = SimController::new(&setup.config, setup.robot.as_ref());
    run_with(&world, &setup, &mut mind, |_, _, _| {}).unwrap();
    let sound = Knowledge::of_controller(&mind).to_bytes();
    let senses = |mind: &SimController| mind.as_turret().unwrap().senses().saved();
    let read = |file: &[u8]| {
        let mut other = SimController::new(&setup.config, setup.robot.as_ref());
        let knowledge = Knowledge::from_bytes(file).unwrap();
        knowledge.give_to(&mut other, Millis::from_ms(7));
        senses(&other)
    };
    assert_eq!(read(&sound), senses(&mind));

    let image = sound.windows(4).rposition(|four| four == b"AMPM").unwrap();
    assert!(sound.len() > image + 500, "{} bytes", sound.len() - image);
    let why = |file: &[u8]| Knowledge::from_bytes(file).unwrap_err();
    for index in image..sound.len() {
        let mut file = sound.clone();
        file[index] ^= 0x10;
        assert!(why(&file).contains("bytes after its end") || index >= image + 4);
        let cut = why(&sound[..index.max(image + 1)]);
        assert!(cut.contains("end") || cut.contains("damaged"), "{cut}");
    }
    assert_eq!(
        why(&sound[..sound.len() - 1]),
        "what it perceived beside ranges is damaged"
    );
    // Sound in itself, and too long.
    let mut long = sound[image..sound.len() - 4].to_vec();
    long.push(0);
    let crc = amp::wire::CRC.checksum(&long);
    let file = [&sound[..image], &long, &crc.to_le_bytes()].concat();
    assert!(why(&file).contains("damaged"));
    assert_eq!(read(&sound[..image]), SavedSenses::default());
}

#[test]
fn a_program_without_places_takes_the_rest() {
    let (world, setup) = robot();
    let (_, knowledge) = taught(&world, &setup);
    // Of any body, but without places.
    type Forgetful = amp::body::MountedSensors<16, 16, 256, 0>;
    let node = InProcessNode::<16, Forgetful>::of_body(Config::recommended());
    let mut pupil = opened(node);
    knowledge.upload(&mut pupil).unwrap();
    let again = Knowledge::download(&mut pupil).unwrap();
    assert_eq!(again.fingerprint(), knowledge.fingerprint());
    assert!(places(again.body().unwrap()).is_empty());
    // For a ring on a held turret.
    let mut ring = local();
    there(
        &mut ring,
        &World::random(1),
        &super::setup(SonarModel::Ideal, 20, 4),
    )
    .unwrap();
    ring.open(500, Clock::Device).unwrap();
    let before = Knowledge::download(&mut ring).unwrap();
    let refused = Err(LinkError::Refused(Refusal::Body));
    assert_eq!(knowledge.upload(&mut ring), refused);
    assert_eq!(Knowledge::download(&mut ring), Ok(before.clone()));
    let written = ring.write_part(TransferPart::Places, &places(knowledge.body().unwrap()));
    assert_eq!(written, Err(LinkError::Refused(Refusal::NoPlaces)));
    assert_eq!(ring.read_part(TransferPart::Places), Ok(Vec::new()));
    // It has no places that change while it drives.
    ring.command(0, RobotCommand::Seek).unwrap();
    assert_eq!(before.clone().read_body(&mut ring), Ok(()));
}
