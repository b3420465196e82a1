//! What was said and lost on the way is said again, unless it is over.

use super::*;

#[test]
fn the_latest_answer_is_said_again_byte_for_byte() {
    let mut rig = Rig::ready(Clock::Host);
    rig.command(RobotCommand::Seek);
    let counters = rig.packed(&HostMessage::Counters);
    let echoes = (0..16).map(|sensor| TimedEcho {
        sensor,
        range_mm: Some(900),
        age_ms: 0,
    });
    let mut at_ms = rig.at_ms() + 200;
    let alive = rig.packed(&HostMessage::Alive { at_ms });
    let scan = rig.packed(&HostMessage::Scan {
        at_ms,
        echoes: echoes.collect(),
    });
    let say = |rig: &mut Rig, frames: &[&Vec<u8>]| {
        let mut said = Said::default();
        for frame in frames {
            rig.node.frame(Millis::from_ms(rig.now), frame, &mut said);
        }
        said.0
    };
    say(&mut rig, &[&counters]);
    let first = say(&mut rig, &[&alive, &scan]);
    assert_eq!(first.len(), 3, "decision, motion, done");
    let state = rig.node.state.clone();
    assert_eq!(say(&mut rig, &[&alive, &scan]), first);
    assert!(rig.node.state == state);
    // Not what was said before.
    assert!(say(&mut rig, &[&counters]).is_empty());
    // Renewals of the motion belong to the next answer.
    let mut burst = Vec::new();
    for _ in 0..3 {
        at_ms += 200;
        burst.push(rig.packed(&HostMessage::Alive { at_ms }));
    }
    burst.push(rig.packed(&HostMessage::Counters));
    let burst: Vec<_> = burst.iter().collect();
    let first = say(&mut rig, &burst);
    assert_eq!(first.len(), 5);
    assert_eq!(say(&mut rig, &burst), first);
    // An answer that is too long to be kept is only confirmed.
    for name in ["a", "b", "c", "d", "e", "f"] {
        let name = crate::goal::Name::new(name).unwrap();
        rig.send(HostMessage::SaveGoal { name });
    }
    let goals = rig.packed(&HostMessage::ListGoals);
    assert_eq!(rig.raw(&goals).len(), 8);
    assert!(matches!(rig.raw(&goals)[..], [DeviceMessage::Done { .. }]));
}

/// With the numbers it had: a host whose answer was lost misses none.
#[test]
fn a_stop_that_comes_again_is_answered_as_it_was() {
    let mut rig = Rig::ready(Clock::Device);
    rig.move_on();
    let (at_ms, ttl_ms, command) = (rig.at_ms(), 1_000, RobotCommand::Stop);
    let stop = rig.packed(&HostMessage::Command {
        at_ms,
        ttl_ms,
        command,
    });
    let [first, again] = [(); 2].map(|()| {
        let mut said = Said::default();
        rig.node.frame(Millis::from_ms(rig.now), &stop, &mut said);
        said.0
    });
    assert_eq!(first.len(), 3, "motion, mode, done");
    assert_eq!(again, first);
}

#[test]
fn no_motion_is_said_again_after_a_stop() {
    let mut rig = Rig::ready(Clock::Device);
    rig.command(RobotCommand::Seek);
    let echoes = (0..16).map(|sensor| TimedEcho {
        sensor,
        range_mm: Some(900),
        age_ms: 0,
    });
    let scan = HostMessage::Scan {
        at_ms: rig.at_ms(),
        echoes: echoes.collect(),
    };
    let scan = rig.packed(&scan);
    assert!(motion(&rig.raw(&scan)).is_some());
    rig.now += 250;
    assert!(motion(&rig.tick().1).is_some(), "a renewal");
    assert!(motion(&rig.raw(&scan)).is_some());
    rig.now += 60;
    let said = rig.tick().1;
    assert!(said.contains(&DeviceMessage::Mode(ModeReport::Stopped(
        StopReason::LinkLost
    ))));
    assert!(matches!(rig.raw(&scan)[..], [DeviceMessage::Done { .. }]));
}

/// A mode that changes without a motion, and a motion in the same mode.
#[test]
fn an_answer_that_something_has_overtaken_is_only_confirmed() {
    let mut rig = Rig::with_ring();
    rig.send(HostMessage::Source(Source::Ring));
    let explore = HostMessage::Command {
        at_ms: rig.at_ms(),
        ttl_ms: 1_000,
        command: RobotCommand::Explore { moves: 5, seed: 1 },
    };
    let explore = rig.packed(&explore);
    let first = rig.raw(&explore);
    let exploring = DeviceMessage::Mode(ModeReport::Explore { left: 5 });
    assert!(first.contains(&exploring), "{first:?}");
    assert_eq!(rig.raw(&explore), first);
    rig.now += 200;
    let said = rig.own_ring(2_000);
    assert!(
        motion(&said).is_some()
            && !said
                .iter()
                .any(|said| matches!(said, DeviceMessage::Mode(_)))
    );
    assert!(matches!(
        rig.raw(&explore)[..],
        [DeviceMessage::Done { .. }]
    ));
    // It stands, and its ring stays incomplete.
    let mut rig = Rig::ready(Clock::Device);
    rig.command(RobotCommand::Stop);
    let seek = HostMessage::Command {
        at_ms: rig.at_ms(),
        ttl_ms: 9_000,
        command: RobotCommand::Seek,
    };
    let seek = rig.packed(&seek);
    let first = rig.raw(&seek);
    assert!(first.contains(&DeviceMessage::Mode(ModeReport::Seek)));
    rig.now += SILENCE_MS + 1;
    let said = rig.tick().1;
    assert!(is_stopped(&said, StopReason::LinkLost) && motion(&said).is_none());
    assert!(matches!(rig.raw(&seek)[..], [DeviceMessage::Done { .. }]));
}

#[test]
fn a_hello_that_comes_again_is_answered_and_changes_nothing() {
    let mut rig = Rig::new(Clock::Device);
    let before = rig.node.state.clone();
    let dimensions = Small::dimensions();
    let hello = HostMessage::<16>::Hello(HostHello {
        dimensions,
        clock: Clock::Device,
        open_space: false,
    });
    let header = Header {
        session: SESSION,
        seq: 1,
    };
    let frame = Frame::pack(header, &hello).unwrap();
    let hello = frame.as_bytes().split_last().unwrap().1;
    let again = rig.raw(hello);
    assert!(matches!(again[..], [DeviceMessage::Hello(_)]), "{again:?}");
    assert!(rig.node.state == before);
    assert_eq!(rig.node.counters().accepted, 1);
    // With another frame between them it is a new host, though session and number are the old ones.
    rig.command(RobotCommand::Explore { moves: 5, seed: 1 });
    rig.now += 200;
    assert!(motion(&rig.ring(900)).is_some());
    let said = rig.raw(hello);
    assert!(is_stopped(&said, StopReason::LinkLost));
    assert!(matches!(said.last(), Some(DeviceMessage::Hello(_))));
    // It is heard from its second frame on.
    rig.seq = 1;
    assert!(
        rig.send(HostMessage::Mode)
            .contains(&DeviceMessage::Done { seq: 2 })
    );
    let stopped = rig.command(RobotCommand::Stop);
    assert!(stopped.contains(&DeviceMessage::Done { seq: 3 }));
    assert!(is_stopped(&stopped, StopReason::Commanded));
    // Session 0 is nobody's.
    let header = Header { session: 0, seq: 1 };
    let hello = HostMessage::<16>::Hello(HostHello {
        dimensions,
        clock: Clock::Device,
        open_space: false,
    });
    let frame = Frame::pack(header, &hello).unwrap();
    let said = rig.raw(frame.as_bytes().split_last().unwrap().1);
    assert_eq!(refusal(&said), Some(Refusal::Incompatible(dimensions)));
}
