use super::*;
use crate::Packet;
use crate::mask::tests::masks;
use arena::sonar::FIRING_ORDER;
use proptest::prelude::*;

/// Numbers that fit sign and 15 bits.
fn number() -> impl Strategy<Value = i16> + Clone {
    -i16::MAX..=i16::MAX
}

fn three() -> impl Strategy<Value = [i16; 3]> {
    [number(), number(), number()]
}

fn commands() -> impl Strategy<Value = NomadCommand> {
    let mode = prop::sample::select(AxisMode::ALL.to_vec());
    let axis = (mode, number());
    let groups = prop::sample::select(ReadingGroup::ALL.to_vec());
    let bytes = prop::collection::vec(any::<u8>(), 0..200);
    let text = prop::collection::vec(1..=255_u8, 0..200);
    let opaque = [Kind::SetupLs, Kind::AddObs, Kind::PlaceRobot, Kind::Special];
    prop_oneof![
        any::<[u16; 3]>().prop_map(NomadCommand::Accelerations),
        any::<[u16; 3]>().prop_map(NomadCommand::Speeds),
        three().prop_map(NomadCommand::Relative),
        three().prop_map(NomadCommand::Absolute),
        three().prop_map(NomadCommand::Velocity),
        [axis.clone(), axis.clone(), axis].prop_map(NomadCommand::Move),
        masks().prop_map(NomadCommand::Communicate),
        prop::sample::select(vec![
            NomadCommand::GetState,
            NomadCommand::Stop,
            NomadCommand::Limp,
            NomadCommand::Zero
        ]),
        text.prop_map(NomadCommand::Talk),
        [number(), number()].prop_map(NomadCommand::DefinePosition),
        [number(), number()].prop_map(NomadCommand::DefineAngles),
        any::<(u8, [u8; 16])>()
            .prop_map(|(history, order)| NomadCommand::ConfigureInfrared { history, order }),
        any::<(u8, [u8; 16])>()
            .prop_map(|(rate, order)| NomadCommand::ConfigureSonar { rate, order }),
        any::<u8>().prop_map(NomadCommand::ConfigureCompass),
        any::<[u8; 6]>().prop_map(NomadCommand::ConfigureLaser),
        any::<[u8; 3]>().prop_map(NomadCommand::ConfigureSegments),
        any::<u8>().prop_map(NomadCommand::ConfigureTimeout),
        any::<(u8, u16)>().prop_map(|(port, baud)| NomadCommand::ConfigureSerial { port, baud }),
        groups.prop_map(NomadCommand::Get),
        any::<([bool; 3], u8)>()
            .prop_map(|(axes, timeout_s)| NomadCommand::WaitForStop { axes, timeout_s }),
        (prop::sample::select(opaque.to_vec()), bytes)
            .prop_map(|(kind, payload)| NomadCommand::Opaque(kind, payload)),
    ]
}

proptest! {
    #[test]
    fn every_command_comes_back(command in commands()) {
        prop_assert_eq!(NomadCommand::from_packet(&command.to_packet()), Ok(command));
    }

    #[test]
    fn any_payload_is_a_command_or_refused(kind: u8, payload in prop::collection::vec(any::<u8>(), 0..40)) {
        let packet = Packet { kind, payload };
        if let Ok(command) = NomadCommand::from_packet(&packet) {
            prop_assert_eq!(NomadCommand::from_packet(&command.to_packet()), Ok(command));
        }
    }
}

/// Derived by hand from the client library's packets.
#[test]
fn commands_have_the_librarys_bytes() {
    let order = FIRING_ORDER.map(|sensor| sensor as u8);
    let cases: [(NomadCommand, &[u8]); 5] = [
        (
            NomadCommand::Velocity([100, -50, 0]),
            &[1, 8, 0, 5, 0x64, 0, 0x32, 0x80, 0, 0, 0x24, 0x5c],
        ),
        (
            NomadCommand::ConfigureSonar { rate: 15, order },
            &[
                0x01, 0x13, 0x00, 0x0f, 0x0f, 0x00, 0x02, 0x0f, 0x01, 0x0e, 0x03, 0x0d, 0x04, 0x0c,
                0x05, 0x0b, 0x06, 0x0a, 0x07, 0x09, 0x08, 0xaa, 0x5c,
            ],
        ),
        (
            NomadCommand::Talk(b"hi".to_vec()),
            &[1, 5, 0, 11, b'h', b'i', 0, 0xe2, 0x5c],
        ),
        (
            NomadCommand::WaitForStop {
                axes: [true, false, true],
                timeout_s: 20,
            },
            &[1, 6, 0, 31, 1, 0, 1, 20, 0x3c, 0x5c],
        ),
        (
            NomadCommand::Move([
                (AxisMode::Relative, -1),
                (AxisMode::Ignore, 0),
                (AxisMode::Velocity, 300),
            ]),
            &[
                1, 14, 0, 43, 2, 0, 1, 0x80, 0, 0, 0, 0, 1, 0, 0x2c, 0x01, 0xeb, 0x5c,
            ],
        ),
    ];
    for (command, bytes) in cases {
        assert_eq!(command.to_packet().to_bytes(), bytes, "{command:?}");
    }
}

#[test]
fn what_is_no_command_is_said() {
    let refused = |kind: u8, payload: &[u8]| {
        let payload = payload.to_vec();
        NomadCommand::from_packet(&Packet { kind, payload })
            .unwrap_err()
            .to_string()
    };
    assert_eq!(refused(42, &[]), "there is no command 42");
    assert_eq!(refused(8, &[]), "NAK is an answer, not a command");
    assert_eq!(refused(5, &[0; 5]), "Vm: 5 bytes where the message takes 6");
    assert_eq!(refused(7, &[0]), "Gs: 1 bytes where the message takes 0");
    assert_eq!(
        refused(43, &[9, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]),
        "an axis has no mode 9"
    );
}
