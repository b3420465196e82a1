use super::*;
use crate::mask::tests::masks;
use proptest::prelude::*;

fn number() -> impl Strategy<Value = i32> {
    -32_767..=32_767
}

fn long() -> impl Strategy<Value = i32> {
    -i32::MAX..=i32::MAX
}

fn place() -> impl Strategy<Value = PosData> {
    let longs = (prop::array::uniform4(long()), prop::array::uniform3(long()));
    (longs, any::<u32>(), any::<u32>()).prop_map(|((pose, velocity), pose_ms, sensed_ms)| PosData {
        pose,
        velocity,
        pose_ms,
        sensed_ms,
    })
}

fn states() -> impl Strategy<Value = NomadReadings> {
    let rings = (
        prop::array::uniform16(0..16_u8),
        any::<[u8; 16]>(),
        0..1_u32 << 24,
    );
    let motion = (
        prop::array::uniform4(number()),
        prop::array::uniform3(number()),
        any::<[u16; 3]>(),
    );
    let rest = (
        any::<(u16, u8, u32, u8, u8)>(),
        prop::collection::vec(any::<u16>(), 0..20),
    );
    let places = (
        prop::array::uniform16(place()),
        prop::array::uniform16(place()),
        [place(), place(), place()],
    );
    (rings, motion, rest, places).prop_map(|(rings, motion, rest, places)| {
        let (infrared, sonar, bumpers) = rings;
        let (pose, velocity, acceleration) = motion;
        let ((compass, motors, time_ms, cpu_voltage, motor_voltage), laser) = rest;
        let (infrared_at, sonar_at, [bumpers_at, laser_at, compass_at]) = places;
        NomadReadings {
            infrared,
            sonar,
            bumpers,
            pose,
            velocity,
            acceleration,
            compass,
            laser,
            motors,
            time_ms,
            cpu_voltage,
            motor_voltage,
            infrared_at,
            sonar_at,
            bumpers_at,
            laser_at,
            compass_at,
        }
    })
}

proptest! {
    #[test]
    fn a_state_comes_back_under_every_mask(state in states(), mask in masks()) {
        let payload = state.to_payload(&mask);
        let mut there = NomadReadings::default();
        prop_assert_eq!(there.take_payload(&mask, &payload), Ok(()));
        // A decoded packet encodes to the same bytes.
        prop_assert_eq!(there.to_payload(&mask), payload.clone());
        // Readings outside the mask keep their values.
        let mut over = state.clone();
        prop_assert_eq!(over.take_payload(&mask, &payload), Ok(()));
        prop_assert_eq!(over, state);
        let short = payload.get(1..).unwrap_or(&[]);
        prop_assert!(there.take_payload(&mask, short).is_err());
        let long = [&payload[..], &[0]].concat();
        prop_assert!(there.take_payload(&mask, &long).is_err());
    }

    #[test]
    fn every_group_comes_back(state in states(), mask in masks()) {
        for group in ReadingGroup::ALL {
            let payload = state.to_group(group, &mask);
            let mut there = NomadReadings::default();
            prop_assert_eq!(there.take_group(group, &mask, &payload), Ok(()));
            prop_assert_eq!(there.to_group(group, &mask), payload.clone());
            let mut over = state.clone();
            prop_assert_eq!(over.take_group(group, &mask, &payload), Ok(()));
            prop_assert_eq!(&over, &state);
        }
    }

    #[test]
    fn any_bytes_are_a_state_or_refused(payload in prop::collection::vec(any::<u8>(), 0..200), mask in masks()) {
        let mut state = NomadReadings::default();
        let _ = state.take_payload(&mask, &payload);
        for group in ReadingGroup::ALL {
            let _ = state.take_group(group, &mask, &payload);
        }
    }
}

/// Derived by hand.
#[test]
fn readings_have_their_order_and_their_bytes() {
    let state = NomadReadings {
        infrared: std::array::from_fn(|i| i as u8),
        sonar: std::array::from_fn(|i| 100 + i as u8),
        bumpers: 1 << 19 | 1,
        pose: [-10, 20, 900, 3_599],
        velocity: [200, -450, 1],
        compass: 1_800,
        motors: 5,
        time_ms: 0x0102_0304,
        cpu_voltage: 250,
        motor_voltage: 251,
        ..NomadReadings::default()
    };
    // Infrared 0, 1 and 15; sonar 8; no laser.
    let mask = StateMask {
        infrared: 0x8003,
        sonar: 1 << 8,
        laser: false,
        ..StateMask::ALL
    };
    let expected = [
        0x10, 0x0f, 108, 0x08, 0, 1, 0x0a, 0x80, 20, 0, 0x84, 3, 0x0f, 0x0e, 200, 0, 0xc2, 0x81, 1,
        0, 0x08, 0x07, 5, 4, 3, 2, 1, 250, 251,
    ];
    assert_eq!(state.to_payload(&mask), expected);
    let everything = state.to_payload(&StateMask::ALL);
    assert_eq!(everything.len(), 8 + 16 + 3 + 8 + 6 + 2 + 2 + 7);
    let sonars = state.to_group(ReadingGroup::Sonar, &StateMask::NONE);
    assert_eq!(sonars.len(), 20);
    let placed = StateMask {
        attached: WITH_SONAR,
        ..StateMask::NONE
    };
    assert_eq!(
        state.to_group(ReadingGroup::Sonar, &placed).len(),
        20 + 16 * 36
    );
    assert_eq!(
        state.to_group(ReadingGroup::Laser, &StateMask::NONE),
        [0, 0, 0, 0, 4, 3, 2, 1]
    );
}
