use super::*;
use proptest::prelude::*;

fn request(kind: u16, numbers: &[i32]) -> Request {
    Request::of(&ServerMessage {
        kind,
        numbers: numbers.to_vec(),
    })
}

/// Derived by hand.
#[test]
fn messages_are_big_endian() {
    let message = ServerMessage {
        kind: 12,
        numbers: vec![100, -50, 0],
    };
    let bytes = [
        0, 12, 0, 3, 0, 0, 0, 100, 0xff, 0xff, 0xff, 0xce, 0, 0, 0, 0,
    ];
    assert_eq!(message.to_bytes(), bytes);
    let mut stream = bytes[..15].to_vec();
    assert_eq!(ServerMessage::take_from(&mut stream), None);
    stream.extend([0, 0xff]);
    assert_eq!(ServerMessage::take_from(&mut stream), Some(message));
    assert_eq!(stream, [0xff]);
}

#[test]
fn requests_are_the_robots_commands() {
    let robot = |command| Request::Robot(command);
    assert_eq!(
        request(12, &[100, -50, 70_000]),
        robot(NomadCommand::Velocity([100, -50, i16::MAX]))
    );
    let ct = request(16, &[0xff, 0xff, 0xff, 0xff, 0xff, 0b1101, 0b10]);
    let wanted = StateMask {
        attached: WITH_SONAR,
        ..StateMask::ALL
    };
    assert_eq!(ct, robot(NomadCommand::Communicate(wanted)));
    let mv = [
        (AxisMode::Relative, 5),
        (AxisMode::Ignore, 0),
        (AxisMode::Limp, 0),
    ];
    assert_eq!(
        request(43, &[2, 5, 0, 0, 3, 0]),
        robot(NomadCommand::Move(mv))
    );
    // Too few numbers, an unknown mode, an unknown type, obstacles.
    for (kind, numbers) in [
        (12, &[1, 2][..]),
        (43, &[99, 0, 0, 0, 0, 0]),
        (7, &[]),
        (50, &[1]),
    ] {
        assert_eq!(request(kind, numbers), Request::Unknown);
    }
    assert_eq!(request(102, &[1, 4_711]), Request::Connect);
}

#[test]
fn a_state_is_the_librarys_vector_and_what_follows_it() {
    let state = NomadReadings {
        sonar: [77; 16],
        bumpers: 3,
        pose: [1, -2, 3, 4],
        velocity: [5, -6, 7],
        motors: 1,
        compass: 900,
        time_ms: 1_000,
        ..NomadReadings::default()
    };
    let message = answer(Kind::Gs as u8, &state, &StateMask::ALL, 2);
    let numbers = &message.numbers;
    assert_eq!((message.kind, numbers.len()), (STATE, 46 + 3));
    assert_eq!((numbers[0], numbers[17], numbers[32]), (20, 77, 77));
    assert_eq!(numbers[33..46], [3, 1, -2, 3, 4, 5, -6, 7, 1, 0, 900, 0, 0]);
    assert_eq!(numbers[46], 1_000);
    let mask = StateMask {
        attached: WITH_SONAR | WITH_BUMPER,
        ..StateMask::ALL
    };
    let longer = answer(Kind::Vm as u8, &state, &mask, 1);
    assert_eq!(longer.numbers.len(), 46 + 17 * 9 + 3);
    let sonar = answer(Kind::GetSn as u8, &state, &mask, 1);
    assert_eq!((sonar.kind, sonar.numbers.len()), (SONAR, 16 + 16 * 9 + 1));
    assert_eq!(answer(Kind::Nak as u8, &state, &mask, 1).kind, ERROR);
}

proptest! {
    #[test]
    fn any_message_comes_back_and_is_a_request(kind: u16, numbers in prop::collection::vec(any::<i32>(), 0..40)) {
        let message = ServerMessage { kind, numbers };
        let mut bytes = message.to_bytes();
        let back = ServerMessage::take_from(&mut bytes);
        prop_assert!(bytes.is_empty());
        let _ = Request::of(&message);
        prop_assert_eq!(back, Some(message));
    }
}
