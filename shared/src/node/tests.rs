use super::*;
use crate::controller::{CommandRefusal, Decision, Outputs, Progress};
use crate::faults::SensorFault;
use crate::fixed::{Mask, Weight, Weight32};
use crate::goal::Component;
use crate::link::SILENCE_MS;
use crate::parameters::{Parameter, ParameterError};
use crate::places::Aim;
use crate::som::kernels::{Group, Kernels};
use crate::units::{Displacement, Range};
use crate::wire::frame::{self, Frame};
use crate::wire::message::{
    Clock, DeviceMessage, FlashError, FlashOperation, GoalSpec, HostHello, HostMessage, LogEvent,
    ModeReport, Refusal, Report, RobotCommand, Source, TimedEcho, TransferPart,
};
use std::vec::Vec;

mod again;
mod document;
mod safety;
mod think;

type Small = Node<16, 16, 20>;

#[derive(Default)]
struct Said(Vec<Vec<u8>>);

impl FrameSink for Said {
    fn send(&mut self, frame: &[u8]) -> bool {
        self.0.push(frame.to_vec());
        true
    }
}

/// A host with a node; the robot stands in the middle of a square room and its ring hears what the
/// test wants.
struct Rig {
    node: Small,
    seq: u16,
    /// Device's time.
    now: u32,
    /// Host's time less the device's.
    ahead: u32,
}

const SESSION: u16 = 5;

/// Random moves of a robot that is made ready. Miri takes some thousand times as long.
const MOVES: u16 = if cfg!(miri) { 6 } else { 20 };

/// The recommended one; in Miri it learns for two epochs only.
fn config() -> Config<16> {
    let mut config = Config::recommended();
    if cfg!(miri) {
        config.learning.epochs = 2;
    }
    config
}

impl Rig {
    fn new(clock: Clock) -> Self {
        let mut rig = Self {
            node: Node::new(),
            seq: 0,
            now: 10_000,
            ahead: 70_000,
        };
        let mut said = Said::default();
        rig.node.start(
            &config(),
            Grid::rectangle(4, 4),
            Identity::default(),
            Millis::from_ms(0),
            &mut said,
        );
        assert_eq!(said.0.len(), 1);
        let dimensions = Small::dimensions();
        let said = rig.send(HostMessage::Hello(HostHello {
            dimensions,
            clock,
            open_space: false,
        }));
        assert!(matches!(said[..], [DeviceMessage::Hello(_)]));
        rig
    }

    fn raw(&mut self, bytes: &[u8]) -> Vec<DeviceMessage<16>> {
        let mut said = Said::default();
        self.node.frame(Millis::from_ms(self.now), bytes, &mut said);
        read(&said)
    }

    fn packed(&mut self, message: &HostMessage<16>) -> Vec<u8> {
        self.seq = self.seq.wrapping_add(1);
        let header = Header {
            session: SESSION,
            seq: self.seq,
        };
        let frame = Frame::pack(header, message).unwrap();
        frame.as_bytes().split_last().unwrap().1.to_vec()
    }

    fn send(&mut self, message: HostMessage<16>) -> Vec<DeviceMessage<16>> {
        let bytes = self.packed(&message);
        self.raw(&bytes)
    }

    fn at_ms(&self) -> u32 {
        self.now + self.ahead
    }

    fn command(&mut self, command: RobotCommand<16>) -> Vec<DeviceMessage<16>> {
        let at_ms = self.at_ms();
        self.send(HostMessage::Command {
            at_ms,
            ttl_ms: 1_000,
            command,
        })
    }

    fn tick(&mut self) -> (bool, Vec<DeviceMessage<16>>) {
        let mut said = Said::default();
        let more = self.node.tick(Millis::from_ms(self.now), &mut said);
        (more, read(&said))
    }

    /// A whole ring that hears `range_mm` everywhere, plus 10 mm per place.
    fn ring(&mut self, range_mm: u16) -> Vec<DeviceMessage<16>> {
        let echoes = (0..16_u8).map(|sensor| TimedEcho {
            sensor,
            range_mm: Some(range_mm + 10 * u16::from(sensor)),
            age_ms: 10 * (15 - u16::from(sensor)),
        });
        let at_ms = self.at_ms();
        self.send(HostMessage::Scan {
            at_ms,
            echoes: echoes.collect(),
        })
    }

    fn carried_out(&mut self, command: MotionCommand) -> Vec<DeviceMessage<16>> {
        let at_ms = self.at_ms();
        self.send(HostMessage::Odometry {
            at_ms,
            motion: command.id,
            dx_mm: command.dx_mm,
            dy_mm: command.dy_mm,
            turned: 0,
            progress: Progress::Ended,
        })
    }

    /// Rounds of ring and motion until no motion comes; returns the decisions.
    fn rounds(&mut self, most: usize) -> Vec<Decision<16>> {
        let mut decisions = Vec::new();
        for round in 0..most {
            self.now += 200;
            let said = self.ring(600 + 100 * (round as u16 % 7));
            decisions.extend(said.iter().find_map(|said| match said {
                DeviceMessage::Decision(decision) => Some(*decision),
                _ => None,
            }));
            let Some(command) = motion(&said) else { break };
            self.now += 150;
            self.carried_out(command);
        }
        decisions
    }

    /// Sets the robot moving towards its goal.
    fn move_on(&mut self) {
        self.command(RobotCommand::Seek);
        self.now += 200;
        assert!(motion(&self.ring(900)).is_some());
        assert!(self.node.state.is_moving());
    }

    fn ready(clock: Clock) -> Self {
        let mut rig = Self::new(clock);
        let (moves, seed) = (MOVES, 9);
        assert!(refusal(&rig.command(RobotCommand::Explore { moves, seed })).is_none());
        assert_eq!(rig.rounds(100).len(), usize::from(MOVES));
        assert!(refusal(&rig.command(RobotCommand::Learn)).is_none());
        let mut ticks = 0..10_000;
        assert!(ticks.any(|_| !rig.tick().0), "it never ends");
        rig
    }
}

fn read(said: &Said) -> Vec<DeviceMessage<16>> {
    let one = |bytes: &Vec<u8>| {
        let (_, coded) = bytes.split_last().unwrap();
        let (_, report) = frame::unpack::<Report<16>>(coded).unwrap();
        report.message
    };
    said.0.iter().map(one).collect()
}

fn refusal(said: &[DeviceMessage<16>]) -> Option<Refusal> {
    said.iter().find_map(|said| match said {
        DeviceMessage::Refusal { reason, .. } => Some(*reason),
        _ => None,
    })
}

fn motion(said: &[DeviceMessage<16>]) -> Option<MotionCommand> {
    said.iter().find_map(|said| match said {
        DeviceMessage::Motion(command) => Some(*command),
        _ => None,
    })
}

fn is_stopped(said: &[DeviceMessage<16>], why: StopReason) -> bool {
    said.contains(&DeviceMessage::Mode(ModeReport::Stopped(why)))
}

#[test]
fn a_mind_behind_the_link_is_the_mind() {
    let mut rig = Rig::ready(Clock::Host);
    rig.command(RobotCommand::Goal(GoalSpec::Avoid));
    rig.command(RobotCommand::Seek);
    let most = if cfg!(miri) { 5 } else { 50 };
    let decisions = rig.rounds(most);
    assert_eq!(decisions.len(), most);
    assert!(decisions.iter().all(|decision| decision.plan.is_some()));
    // The same events to the controller itself.
    let config = config();
    let mut state = State::<16, 16, 20>::new(Grid::rectangle(4, 4));
    let mut now = 80_000;
    let mut at = |event, now| controller::handle(&config, &mut state, Millis::from_ms(now), event);
    let rounds = |at: &mut dyn FnMut(Event<16>, u32) -> Outputs<16>, now: &mut u32, most| {
        let mut all = Vec::new();
        for round in 0..most {
            *now += 200;
            let mut motion = None;
            for sensor in 0..16_u8 {
                let mm = 600 + 100 * (round as u16 % 7) + 10 * u16::from(sensor);
                let range = Some(Range::from_mm(mm));
                let heard = *now - 10 * (15 - u32::from(sensor));
                let out = at(Event::Echo { sensor, range }, heard);
                all.extend(out.decision);
                motion = motion.or(out.motion);
            }
            let Some(command) = motion else { break };
            *now += 150;
            let moved = command.displacement;
            let odometry = Event::Odometry {
                motion: command.id,
                moved,
                turned: crate::units::Bearing::ZERO,
                progress: Progress::Ended,
            };
            at(odometry, *now);
        }
        all
    };
    use crate::controller::Command;
    let (moves, seed) = (MOVES, 9);
    let explore = Command::Explore { moves, seed };
    at(Event::Command(explore), now);
    rounds(&mut at, &mut now, 100);
    at(Event::Command(Command::Learn), now);
    let mut ticks = 0..10_000;
    assert!(ticks.any(|_| at(Event::Tick, now).mode_changed));
    at(Event::Command(Command::Seek(Goal::avoiding(&config))), now);
    assert_eq!(rounds(&mut at, &mut now, most), decisions);
    assert!(state.situations() == rig.node.state().situations());
    assert!(state.actions() == rig.node.state().actions());
}

#[test]
fn a_silent_host_stops_the_robot_until_it_resumes() {
    let mut rig = Rig::ready(Clock::Device);
    rig.command(RobotCommand::Seek);
    rig.now += 200;
    let command = motion(&rig.ring(900)).unwrap();
    assert_ne!((command.dx_mm, command.dy_mm), (0, 0));
    let since = rig.now;
    let mut renewals = 0;
    let lost = loop {
        rig.now += 10;
        assert!(rig.now - since < 2_000, "it never stops");
        let (_, said) = rig.tick();
        renewals += usize::from(motion(&said) == Some(command));
        if is_stopped(&said, StopReason::LinkLost) {
            let stop = motion(&said).unwrap();
            assert!((stop.dx_mm, stop.dy_mm) == (0, 0) && stop.id != command.id);
            break rig.now - since;
        }
    };
    assert_eq!((lost, renewals), (SILENCE_MS + 10, 1));
    assert!(!rig.node.is_linked() && rig.node.counters().link_losses == 1);
    rig.now += 5_000;
    assert!(rig.tick().1.is_empty());
    assert!(motion(&rig.ring(900)).is_none(), "it stays stopped");
    let said = rig.command(RobotCommand::Resume);
    assert!(said.contains(&DeviceMessage::Mode(ModeReport::Seek)));
    rig.now += 200;
    assert!(motion(&rig.ring(900)).is_some());
    let again = refusal(&rig.command(RobotCommand::Resume));
    assert_eq!(
        again,
        Some(Refusal::Command(CommandRefusal::NothingToResume))
    );
}

#[test]
fn by_the_hosts_clock_only_its_own_silence_counts() {
    let mut rig = Rig::ready(Clock::Host);
    rig.command(RobotCommand::Seek);
    rig.now += 200;
    assert!(motion(&rig.ring(900)).is_some());
    // The device's clock runs on; the host is just slow.
    let host = rig.at_ms();
    rig.now += 100_000;
    assert!(rig.tick().1.is_empty());
    let mut alive = |at_ms| rig.send(HostMessage::Alive { at_ms });
    assert!(alive(host + 150).is_empty());
    assert!(motion(&alive(host + 300)).is_some(), "renewed");
    assert!(is_stopped(&alive(host + 601), StopReason::LinkLost));
}

#[test]
fn an_incomplete_ring_stops_the_robot() {
    let mut rig = Rig::ready(Clock::Device);
    rig.command(RobotCommand::Seek);
    let began = rig.now;
    let period = u32::from(rig.node.config().robot.ring_period_ms);
    let stopped = loop {
        rig.now += 10;
        assert!(rig.now - began < 9_000, "it never stops");
        let at_ms = rig.at_ms();
        rig.send(HostMessage::Scan {
            at_ms,
            echoes: [3, 4]
                .map(|sensor| TimedEcho {
                    sensor,
                    range_mm: None,
                    age_ms: 0,
                })
                .into_iter()
                .collect(),
        });
        let (_, said) = rig.tick();
        assert!(motion(&said).is_none());
        if is_stopped(&said, StopReason::RingIncomplete) {
            break rig.now - began;
        }
    };
    assert_eq!(stopped, 2 * period + 10);
}

#[test]
fn old_repeated_strange_and_late_frames_do_nothing() {
    let mut rig = Rig::ready(Clock::Device);
    let before = rig.node.clone();
    let at_ms = rig.at_ms();
    let seek = HostMessage::Command {
        at_ms,
        ttl_ms: 100,
        command: RobotCommand::Seek,
    };
    let late = rig.packed(&seek);
    rig.now += 101;
    let said = rig.raw(&late);
    assert_eq!(refusal(&said), Some(Refusal::Expired { age_ms: 101 }));
    assert_eq!(rig.raw(&late), said);
    rig.now += 10;
    let alive = rig.packed(&HostMessage::Counters);
    rig.raw(&alive);
    assert!(rig.raw(&late).is_empty());
    let header = Header {
        session: SESSION + 1,
        seq: 1,
    };
    let frame = Frame::pack(header, &seek).unwrap();
    assert!(rig.raw(frame.as_bytes().split_last().unwrap().1).is_empty());
    let mut broken = rig.packed(&seek);
    broken[4] ^= 0x10;
    assert!(rig.raw(&broken).is_empty() && rig.raw(&[1, 2, 3]).is_empty());
    assert!(rig.node.state == before.state);
    let (now, was) = (rig.node.counters(), before.counters());
    let counted = |count: fn(&Counters) -> u32| count(now) - count(was);
    assert_eq!(
        [
            counted(|c| c.accepted),
            counted(|c| c.replayed),
            counted(|c| c.wrong_session)
        ],
        [2, 2, 1]
    );
    assert_eq!(
        [
            counted(|c| c.expired),
            counted(|c| c.crc_errors),
            counted(|c| c.malformed)
        ],
        [1, 1, 1]
    );
}

#[test]
fn another_protocol_is_refused_and_the_session_stays() {
    let mut rig = Rig::new(Clock::Device);
    let mut dimensions = Small::dimensions();
    dimensions.protocol += 1;
    let hello: HostMessage<16> = HostMessage::Hello(HostHello {
        dimensions,
        clock: Clock::Device,
        open_space: false,
    });
    let header = Header {
        session: 99,
        seq: 1,
    };
    let frame = Frame::pack(header, &hello).unwrap();
    let said = rig.raw(frame.as_bytes().split_last().unwrap().1);
    assert_eq!(
        refusal(&said),
        Some(Refusal::Incompatible(Small::dimensions()))
    );
    assert!(rig.send(HostMessage::Counters).len() == 2);
    // A node that has just started has no session at all.
    let mut fresh = Small::new();
    let mut said = Said::default();
    let bytes = rig.packed(&HostMessage::Counters);
    fresh.frame(Millis::from_ms(0), &bytes, &mut said);
    assert_eq!(refusal(&read(&said)), Some(Refusal::NoSession));
}

#[test]
fn a_new_host_stops_what_the_old_one_started() {
    let mut rig = Rig::ready(Clock::Device);
    rig.command(RobotCommand::Seek);
    rig.now += 200;
    assert!(motion(&rig.ring(900)).is_some());
    let dimensions = Small::dimensions();
    let hello: HostMessage<16> = HostMessage::Hello(HostHello {
        dimensions,
        clock: Clock::Host,
        open_space: false,
    });
    let header = Header {
        session: SESSION + 1,
        seq: 1,
    };
    let frame = Frame::pack(header, &hello).unwrap();
    let said = rig.raw(frame.as_bytes().split_last().unwrap().1);
    assert!(is_stopped(&said, StopReason::LinkLost));
    assert!(matches!(said.last(), Some(DeviceMessage::Hello(_))));
}

#[test]
fn what_is_known_can_be_carried_to_another_node() {
    let mut rig = Rig::ready(Clock::Host);
    let mut other = Rig::new(Clock::Host);
    assert!(rig.node.maps_crc() != other.node.maps_crc());
    for part in [
        TransferPart::Config,
        TransferPart::Situations,
        TransferPart::Changes,
        TransferPart::Actions,
        TransferPart::Memory,
    ] {
        let mut offset = 0;
        loop {
            let said = rig.send(HostMessage::Read { part, offset });
            let Some(DeviceMessage::Chunk { total, bytes, .. }) = said.first() else {
                panic!("{said:?}");
            };
            let end = offset + bytes.len() as u16;
            assert!(end > offset, "{part:?} {offset}");
            let last = end == *total;
            let write = HostMessage::Write {
                part,
                offset,
                bytes: bytes.clone(),
                last,
            };
            assert_eq!(refusal(&other.send(write)), None, "{part:?} {offset}");
            if last {
                break;
            }
            offset = end;
        }
    }
    let sums = |node: &Small| [node.config_crc(), node.maps_crc(), node.memory_crc()];
    assert_eq!(sums(&rig.node), sums(&other.node));
    assert!(rig.node.state().situations() == other.node.state().situations());
    assert_eq!(
        refusal(&other.command(RobotCommand::Seek)),
        None,
        "the maps count as learned"
    );
    let busy = HostMessage::Write {
        part: TransferPart::Memory,
        offset: 0,
        bytes: heapless::Vec::new(),
        last: true,
    };
    assert_eq!(refusal(&other.send(busy)), Some(Refusal::Moving));
    other.command(RobotCommand::Stop);
    assert_eq!(refusal(&other.command(RobotCommand::Forget)), None);
    let fresh = Rig::new(Clock::Host).node;
    assert_eq!(sums(&other.node), sums(&fresh));
}

/// A ring on a held turret has none.
#[test]
fn a_body_without_places_is_led_nowhere() {
    let mut rig = Rig::ready(Clock::Host);
    for (aim, why) in [
        (Some(Aim::Frontier), Some(Refusal::NoPlaces)),
        (Some(Aim::Situation), Some(Refusal::NoPlaces)),
        (None, None),
    ] {
        assert_eq!(refusal(&rig.command(RobotCommand::Lead(aim))), why);
    }
    let carried = rig.command(RobotCommand::SetDown);
    assert_eq!(refusal(&carried), Some(Refusal::NoPlaces));
    assert_eq!(refusal(&rig.command(RobotCommand::Seek)), None);
    let carried = rig.command(RobotCommand::SetDown);
    assert_eq!(refusal(&carried), Some(Refusal::Moving), "it drives");
}

#[test]
fn goals_can_be_what_is_perceived_or_any_situation() {
    let mut rig = Rig::ready(Clock::Host);
    rig.now += 100;
    rig.ring(1_000);
    assert_eq!(
        refusal(&rig.command(RobotCommand::Goal(GoalSpec::Perceived))),
        None
    );
    let scan = rig.node.state().scan();
    let here = rig.node.config().encoding.situation(scan);
    assert_eq!(rig.node.goal, Goal::perceived(&here));
    let bytes = core::array::from_fn(|i| if i < 8 { 255 } else { 127 });
    rig.command(RobotCommand::Goal(GoalSpec::Situation(bytes)));
    let [any, wanted] = [rig.node.goal.components[0], rig.node.goal.components[8]];
    assert_eq!(any, Component::ANY);
    assert_eq!(
        (wanted.low, wanted.high.to_num::<f64>()),
        (wanted.high, 0.5)
    );
    let mut fresh = Rig::new(Clock::Host);
    let unheard = refusal(&fresh.command(RobotCommand::Goal(GoalSpec::Perceived)));
    assert_eq!(unheard, Some(Refusal::NoSituation));
}

#[test]
fn a_renewed_motion_is_the_same_and_a_shortened_one_a_revision() {
    let mut rig = Rig::ready(Clock::Device);
    rig.command(RobotCommand::Seek);
    rig.now += 200;
    let command = motion(&rig.ring(1_500)).unwrap();
    assert_eq!((command.revision, command.ttl_ms), (0, MOTION_TTL_MS));
    rig.now += RENEWAL_MS - 1;
    assert_eq!(rig.tick().1, []);
    rig.now += 1;
    assert_eq!(rig.tick().1, [DeviceMessage::Motion(command)]);
    rig.now += 100;
    // Something is suddenly very near all around.
    let shortened = motion(&rig.ring(60)).unwrap();
    assert_eq!((shortened.id, shortened.revision), (command.id, 1));
    let length = |command: MotionCommand| command.motion().displacement.length_mm();
    assert!(length(shortened) < length(command));
    assert_eq!(shortened.motion().displacement, Displacement::ZERO);
}

#[test]
fn a_full_way_out_is_counted() {
    struct Full;
    impl FrameSink for Full {
        fn send(&mut self, _: &[u8]) -> bool {
            false
        }
    }
    let mut rig = Rig::new(Clock::Device);
    let bytes = rig.packed(&HostMessage::Counters);
    let sent = rig.node.counters().sent;
    rig.node.frame(Millis::from_ms(rig.now), &bytes, &mut Full);
    assert_eq!(
        (rig.node.counters().dropped, rig.node.counters().sent),
        (2, sent)
    );
}

#[test]
fn parameters_are_read_at_any_time_and_set_while_standing() {
    let mut rig = Rig::ready(Clock::Host);
    let ask = |rig: &mut Rig, parameter, value| {
        let said = rig.send(HostMessage::Parameter { parameter, value });
        match said[..] {
            [
                DeviceMessage::Parameter { value, .. },
                DeviceMessage::Done { .. },
            ] => Ok(value),
            [
                DeviceMessage::Refusal { reason, .. },
                DeviceMessage::Done { .. },
            ] => Err(reason),
            _ => panic!("{said:?}"),
        }
    };
    assert_eq!(ask(&mut rig, Parameter::Step, None), Ok(250));
    assert_eq!(ask(&mut rig, Parameter::Step, Some(200)), Ok(200));
    assert_eq!(rig.node.config().robot.step_mm, 200);
    let spec = Parameter::Step.spec();
    let beyond = Refusal::Parameter(ParameterError::OutOfRange(spec));
    assert_eq!(ask(&mut rig, Parameter::Step, Some(5)), Err(beyond));
    rig.command(RobotCommand::Seek);
    assert_eq!(
        ask(&mut rig, Parameter::Step, Some(100)),
        Err(Refusal::Moving)
    );
    assert_eq!(ask(&mut rig, Parameter::Step, None), Ok(200));
}

#[test]
fn the_mode_is_told_when_asked() {
    let mut rig = Rig::ready(Clock::Host);
    let mut ask = || rig.send(HostMessage::Mode);
    assert_eq!(ask()[0], DeviceMessage::Mode(ModeReport::Idle));
    rig.command(RobotCommand::Seek);
    assert_eq!(
        rig.send(HostMessage::Mode)[0],
        DeviceMessage::Mode(ModeReport::Seek)
    );
}

#[test]
fn echoes_come_from_the_source_that_was_chosen() {
    let mut rig = Rig::ready(Clock::Device);
    let choose = |rig: &mut Rig, source| refusal(&rig.send(HostMessage::Source(source)));
    assert_eq!(choose(&mut rig, Source::Ring), Some(Refusal::NoRing));
    assert_eq!(rig.node.source(), Source::Link);
    rig.node.identity.ring = true;
    assert_eq!(choose(&mut rig, Source::Ring), None);
    assert_eq!(rig.node.source(), Source::Ring);
    rig.command(RobotCommand::Seek);
    assert!(
        motion(&rig.ring(900)).is_none(),
        "the link's echoes do not count"
    );
    assert_eq!(choose(&mut rig, Source::Link), Some(Refusal::Moving));
    rig.command(RobotCommand::Stop);
    assert_eq!(choose(&mut rig, Source::Link), None);
    rig.command(RobotCommand::Seek);
    rig.now += 200;
    assert!(motion(&rig.ring(900)).is_some());
}

#[test]
fn a_goal_given_while_seeking_is_pursued_at_once() {
    let mut rig = Rig::ready(Clock::Host);
    rig.command(RobotCommand::Seek);
    let mut components = [Component::ANY; 16];
    components[4] = Component::at_least(Weight::ONE);
    let goal = Goal::of(components);
    let said = rig.command(RobotCommand::Goal(GoalSpec::Components(goal)));
    assert!(said.contains(&DeviceMessage::Mode(ModeReport::Seek)));
    assert_eq!(rig.node.state.mode(), &Mode::Seek { goal });
    // While standing it is only kept.
    rig.command(RobotCommand::Stop);
    let said = rig.command(RobotCommand::Goal(GoalSpec::Avoid));
    assert!(matches!(said[..], [DeviceMessage::Done { .. }]));
    assert_eq!(rig.node.goal, Goal::avoiding(rig.node.config()));
}

#[test]
fn sound_frames_without_a_message_and_what_the_device_counts_are_counted() {
    let mut rig = Rig::ready(Clock::Host);
    let header = Header {
        session: SESSION,
        seq: rig.seq + 1,
    };
    let unknown = Frame::pack(header, &200_u8).unwrap();
    assert!(
        rig.raw(unknown.as_bytes().split_last().unwrap().1)
            .is_empty()
    );
    rig.node.device_counters().overruns = 3;
    rig.node.set_oversized(4);
    let said = rig.send(HostMessage::Counters);
    let [DeviceMessage::Counters(counters), _] = said[..] else {
        panic!("{said:?}");
    };
    let counted = (
        counters.unknown,
        counters.device.overruns,
        counters.oversized,
    );
    assert_eq!(counted, (1, 3, 4));
    assert_eq!(Small::default().counters(), &Counters::NONE);
}

fn image(node: &Small) -> Vec<u8> {
    let mut image = Vec::new();
    let _ = node.contents().write(3, &mut |bytes| {
        image.extend_from_slice(bytes);
        Ok::<_, ()>(())
    });
    image
}

fn recall(node: &mut Small, image: &[u8]) -> Result<(), crate::store::ImageError> {
    let mut read = |at: usize, out: &mut [u8]| {
        out.copy_from_slice(&image[at..at + out.len()]);
        true
    };
    node.recall(&mut read, image.len())
}

#[test]
fn a_node_that_recalls_goes_on_as_any_other_that_does() {
    let mut rig = Rig::ready(Clock::Host);
    rig.command(RobotCommand::Seek);
    let _ = rig.rounds(30);
    rig.command(RobotCommand::Stop);
    let saved = image(&rig.node);
    let sums = |node: &Small| [node.config_crc(), node.maps_crc(), node.memory_crc()];
    let known = sums(&rig.node);
    // The one that saved it, and one that has just been switched on; at the same time by the host's
    // clock.
    let mut other = Rig::new(Clock::Host);
    assert_ne!(sums(&other.node), known);
    other.now = rig.now;
    let decisions: Vec<_> = [&mut rig, &mut other]
        .map(|rig| {
            recall(&mut rig.node, &saved).unwrap();
            assert_eq!(sums(&rig.node), known);
            assert_eq!(refusal(&rig.command(RobotCommand::Seek)), None);
            rig.rounds(60)
        })
        .into();
    assert_eq!(decisions[0].len(), 60);
    assert_eq!(decisions[0], decisions[1]);
    // Not that of a moving one.
    assert!(image(&rig.node) != saved);
}

#[test]
fn goals_are_kept_by_name_and_saved() {
    let mut rig = Rig::new(Clock::Host);
    let name = |text| crate::goal::Name::new(text).unwrap();
    let situation = GoalSpec::Situation([100; 16]);
    rig.command(RobotCommand::Goal(situation));
    let nest = rig.node.goal;
    assert_eq!(
        refusal(&rig.send(HostMessage::SaveGoal { name: name("nest") })),
        None
    );
    rig.command(RobotCommand::Goal(GoalSpec::Avoid));
    let avoid = rig.node.goal;
    let none = crate::goal::Name::NONE;
    assert_eq!(
        refusal(&rig.send(HostMessage::SaveGoal { name: none })),
        Some(Refusal::InvalidGoalName)
    );
    let saved = image(&rig.node);
    let mut other = Rig::new(Clock::Host);
    recall(&mut other.node, &saved).unwrap();
    let said = other.send(HostMessage::ListGoals);
    let goal = |name, goal| DeviceMessage::Goal { name, goal };
    assert_eq!(said[..2], [goal(none, avoid), goal(name("nest"), nest)]);
    other.command(RobotCommand::Goal(GoalSpec::Saved(name("nest"))));
    assert_eq!(other.node.goal, nest);
    let gone = HostMessage::DeleteGoal { name: name("nest") };
    assert_eq!(refusal(&other.send(gone.clone())), None);
    assert_eq!(refusal(&other.send(gone)), Some(Refusal::NoSuchGoal));
    let unknown = RobotCommand::Goal(GoalSpec::Saved(name("nest")));
    assert_eq!(refusal(&other.command(unknown)), Some(Refusal::NoSuchGoal));
    rig.command(RobotCommand::Forget);
    assert_eq!(
        rig.send(HostMessage::ListGoals).len(),
        2,
        "the present goal, and done"
    );
}

#[test]
fn the_flash_is_asked_for_at_standstill_and_answered_when_it_is_done() {
    let mut rig = Rig::ready(Clock::Device);
    rig.command(RobotCommand::Seek);
    let moving = refusal(&rig.send(HostMessage::Flash(FlashOperation::Save)));
    assert_eq!(moving, Some(Refusal::Moving));
    assert_eq!(rig.node.flash_task(), None);
    rig.command(RobotCommand::Stop);
    let save = rig.packed(&HostMessage::Flash(FlashOperation::Save));
    assert!(rig.raw(&save).is_empty());
    assert_eq!(rig.node.flash_task(), Some(FlashOperation::Save));
    let mut said = Said::default();
    let now = Millis::from_ms(rig.now);
    rig.node.announce_pause(5_000, now, &mut said);
    // No sign of life for five seconds, as was said.
    rig.now += 5_000;
    let now = Millis::from_ms(rig.now);
    rig.node.flash_done(Err(FlashError::Failed), now, &mut said);
    let failed = Some(Refusal::Flash(FlashError::Failed));
    assert_eq!(refusal(&read(&said)), failed);
    assert!(matches!(
        read(&said)[..],
        [
            DeviceMessage::Busy { ms: 5_000 },
            _,
            DeviceMessage::Done { .. }
        ]
    ));
    assert_eq!(rig.node.flash_task(), None);
    rig.now += SILENCE_MS;
    assert!(rig.tick().1.is_empty() && rig.node.is_linked());
    // The answer was lost: it comes again, and nothing is saved once more.
    assert_eq!(rig.raw(&save), read(&said));
    assert_eq!(rig.node.flash_task(), None);
}

impl Rig {
    /// One whose mind has a ring of its own.
    fn with_ring() -> Self {
        let mut rig = Self::new(Clock::Device);
        rig.node.prepare(
            &Config::recommended(),
            Grid::rectangle(4, 4),
            Identity {
                ring: true,
                ..Identity::default()
            },
        );
        let dimensions = Small::dimensions();
        let clock = Clock::Device;
        let said = rig.send(HostMessage::Hello(HostHello {
            dimensions,
            clock,
            open_space: false,
        }));
        assert!(matches!(said[..], [DeviceMessage::Hello(_)]), "{said:?}");
        rig
    }

    /// The chip's own ring hears `range_mm` everywhere.
    fn own_ring(&mut self, range_mm: u16) -> Vec<DeviceMessage<16>> {
        let (mut said, now) = (Said::default(), Millis::from_ms(self.now));
        for sensor in 0..16 {
            let range = Some(Range::from_mm(range_mm));
            self.node.ring_echo(sensor, range, 40, now, &mut said);
        }
        read(&said)
    }
}

#[test]
fn echoes_come_from_where_the_session_listens() {
    let mut rig = Rig::with_ring();
    rig.ahead = 0;
    let explore = RobotCommand::Explore { moves: 5, seed: 1 };
    rig.command(explore.clone());
    rig.now += 200;
    assert_eq!(rig.own_ring(2_000), [], "it listens to the link");
    assert!(motion(&rig.ring(2_000)).is_some());
    rig.command(RobotCommand::Stop);
    rig.send(HostMessage::Source(Source::Ring));
    rig.command(explore);
    rig.now += 200;
    assert!(motion(&rig.ring(2_000)).is_none(), "it listens to its ring");
    assert!(motion(&rig.own_ring(2_000)).is_some());
}

#[test]
fn a_chip_without_a_ring_has_none_to_listen_to() {
    let mut rig = Rig::new(Clock::Device);
    let said = rig.send(HostMessage::Source(Source::Ring));
    assert_eq!(refusal(&said), Some(Refusal::NoRing));
    // By the host's clock nothing would supervise its motions while the host is silent.
    let mut rig = Rig::with_ring();
    rig.send(HostMessage::Hello(HostHello {
        dimensions: Small::dimensions(),
        clock: Clock::Host,
        open_space: false,
    }));
    let said = rig.send(HostMessage::Source(Source::Ring));
    assert_eq!(refusal(&said), Some(Refusal::NoRing));
}

/// Transducer 3 hears nothing between near things until it does.
impl Rig {
    /// A ring whose transducer 3 says something else; what is noted of it.
    fn notices(&mut self, third: Option<u16>) -> Vec<LogEvent> {
        let at_ms = self.at_ms();
        let echoes = (0..16).map(|sensor| TimedEcho {
            sensor,
            range_mm: if sensor == 3 { third } else { Some(700) },
            age_ms: 0,
        });
        let echoes = echoes.collect();
        let said = self.send(HostMessage::Scan { at_ms, echoes });
        let logged = said.into_iter().filter_map(|said| match said {
            DeviceMessage::Log(notice) => Some(notice),
            _ => None,
        });
        logged.collect()
    }

    fn set(&mut self, parameter: Parameter, value: i32) {
        let value = Some(value);
        self.send(HostMessage::Parameter { parameter, value });
    }

    /// Transducer 3 has never been heard, at two places.
    fn disbelieving() -> Self {
        let mut rig = Self::new(Clock::Host);
        rig.set(Parameter::FaultDetection, 1);
        assert_eq!(rig.notices(None), []);
        let at_ms = rig.at_ms();
        rig.send(HostMessage::Odometry {
            at_ms,
            motion: 0,
            dx_mm: 250,
            dy_mm: 0,
            turned: 0,
            progress: Progress::Ended,
        });
        let fault = SensorFault::Unheard;
        assert_eq!(
            rig.notices(None),
            [LogEvent::SensorDisabled { sensor: 3, fault }]
        );
        rig
    }
}

#[test]
fn the_host_is_told_whom_the_mind_believes() {
    let mut rig = Rig::disbelieving();
    assert_eq!(
        rig.notices(Some(700)),
        [LogEvent::SensorEnabled { sensor: 3 }]
    );
}

#[test]
fn who_writes_the_mask_of_the_believed_trusts_them_again() {
    let mut rig = Rig::disbelieving();
    let enabled = |rig: &Rig| rig.node.state.enabled(&rig.node.config);
    rig.set(Parameter::Epochs, 50);
    assert_eq!(enabled(&rig), Mask::ALL.without(3));
    let mask = Parameter::Enabled.get(&rig.node.config);
    rig.set(Parameter::Enabled, mask);
    assert_eq!(enabled(&rig), Mask::ALL);
}

/// Kernels that are never called here.
static KERNELS: Kernels = Kernels {
    candidates: {
        extern "C" fn candidates(
            _: &[[Weight32; 16]; 16],
            _: &[i32; 16],
            _: &[Weight; 16],
            _: i32,
        ) -> u32 {
            0
        }
        candidates
    },
    update: {
        extern "C" fn update(
            _: &mut [[Weight32; 16]; 16],
            _: &mut [i32; 16],
            _: &[Weight; 16],
            _: &[Group; 2],
        ) {
        }
        update
    },
};

#[test]
fn the_processors_kernels_reach_both_maps_and_frames_too_long_are_counted() {
    let mut node = Node::<16, 16, 20>::default();
    assert!(!node.state().situations().has_kernels());
    node.use_kernels(&KERNELS);
    let state = node.state();
    assert!(state.situations().has_kernels());
    assert!(state.actions().changes().has_kernels());
    node.set_oversized(7);
    assert_eq!(node.counters().oversized, 7);
    assert!(!node.is_linked());
}
