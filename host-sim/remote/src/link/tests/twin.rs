//! The controller in this process beside a device with a memory of places.

use super::*;
use crate::log;
use amp::body::MountedSensors;
use amp::wire::message::DeviceMessage;
use amp::wire::{Frame, Receiver, Report, frame};
use sim::pilot::Pilot;
use sim::robot::MAX_BEAMS;

/// A body without places, as in firmware with the feature `any-body` alone.
type Placeless = MountedSensors<16, MAX_BEAMS, 256, 0>;

fn device() -> InProcessNode<16, SimBody> {
    InProcessNode::of_body(Config::recommended())
}

fn setup_of(behavior: Behavior) -> Setup {
    let model = RobotModel::builtin("p3dx").unwrap();
    let robot = AnyRobot::new(model, Ranges::Nomad, true).unwrap();
    Setup {
        config: robot.config(Config::recommended()),
        robot: Some(robot),
        behavior,
        ..setup(SonarModel::Nomad, 40, 60)
    }
}

fn controller(session: Session, setup: &Setup) -> RemoteController<Session> {
    let robot = setup.robot.as_ref().map(AnyRobot::told);
    RemoteController::start(session, 1, &setup.config, robot.as_ref()).unwrap()
}

/// In another modality as well, and the log of the device is replayed by the one in this process.
#[test]
fn a_device_is_logged_and_led_to_what_it_senses_as_the_controller_in_this_process() {
    let scent = "scent:strongest".parse().unwrap();
    let Behavior::Sense { goal, .. } = scent else {
        panic!("{scent:?}");
    };
    let tour = Tour::of(60);
    for behavior in [Behavior::Sense { goal, tour }, Behavior::Home { tour }] {
        let setup = setup_of(behavior);
        let world = World::builtin("office").unwrap();
        let near = here(&world, &setup);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("device.mcap");
        let pilot = controller(Session::new(device()), &setup);
        let far = log::run(&world, &setup, pilot, &path).unwrap();
        assert_same(&far, &near);
        let log = log::read(&path).unwrap();
        let replayed = log::replay(&log, |_| {}).unwrap();
        assert_eq!(replayed.difference, None);
        assert!(replayed.decisions > 100, "{}", replayed.decisions);
    }
}

#[test]
fn a_device_without_places_has_no_twin_and_seeks_nothing_in_another_modality() {
    let setup = setup_of(Behavior::Avoid);
    let node = InProcessNode::<16, Placeless>::of_body(Config::recommended());
    let mut placeless = controller(Session::new(node), &setup);
    assert!(placeless.twin().is_none());
    let goal = "scent:strongest".parse().unwrap();
    assert_eq!(
        placeless.seek_sense(Some(goal)),
        Err(EpisodeError::NoPlaces)
    );
    assert_eq!(placeless.seek_sense(None), Ok(()));
    let with_places = controller(Session::new(device()), &setup);
    assert!(with_places.twin().is_some());
    let ring = InProcessNode::<16>::new(Config::recommended());
    let ring = RemoteController::start(Session::new(ring), 1, &setup.config, None).unwrap();
    assert!(ring.twin().is_none());
}

/// A device whose motions are one millimeter longer than they should be from the tenth on.
struct Deviating {
    device: InProcessNode<16, SimBody>,
    receiver: Receiver,
    motions: u32,
}

impl Transport for Deviating {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.device.send(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        let mut one = [0];
        loop {
            if self.device.receive(&mut one, timeout)? == 0 {
                return Ok(0);
            }
            let Some(received) = self.receiver.push(one[0]) else {
                continue;
            };
            let (header, mut report) = frame::unpack::<Report<16>>(received).unwrap();
            if let DeviceMessage::Motion(motion) = &mut report.message {
                self.motions += 1;
                motion.dx_mm += i16::from(self.motions >= 10);
            }
            let frame = Frame::pack(header, &report).unwrap();
            return io::Read::read(&mut frame.as_bytes(), buffer);
        }
    }
}

#[test]
fn a_device_that_decides_otherwise_is_noticed() {
    let setup = setup_of(Behavior::Avoid);
    let deviating = Deviating {
        device: device(),
        receiver: Receiver::new(),
        motions: 0,
    };
    let mut pilot = controller(Session::new(deviating), &setup);
    let ended = run_with(&World::random(5), &setup, &mut pilot, |_, _, _| {});
    let Err(EpisodeError::Link(why)) = ended else {
        panic!("it was not noticed");
    };
    assert!(
        why.contains("s the controller decided otherwise than this program does"),
        "{why}"
    );
}
