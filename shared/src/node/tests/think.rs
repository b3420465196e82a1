//! A body that thinks before it decides, while frames arrive.

use super::*;
use crate::controller::Motion;

/// Thinks for three slices about an echo, and then moves; any other event ends that.
struct Thinker {
    slices_left: u8,
}

impl Body<16> for Thinker {
    const NEW: Self = Self { slices_left: 0 };

    fn handle<const NEURONS: usize, const SAMPLES: usize>(
        &mut self,
        _: &Config<16>,
        _: &mut State<16, NEURONS, SAMPLES>,
        _: Millis,
        event: Event<16>,
    ) -> Outputs<16> {
        match event {
            Event::Echo { .. } => self.slices_left = 3,
            Event::Command(_) => self.slices_left = 0,
            _ => {}
        }
        Outputs::NONE
    }

    fn is_thinking(&self) -> bool {
        self.slices_left > 0
    }

    fn think<const NEURONS: usize, const SAMPLES: usize>(
        &mut self,
        _: &Config<16>,
        _: &mut State<16, NEURONS, SAMPLES>,
        _: Millis,
    ) -> Outputs<16> {
        self.slices_left -= 1;
        let motion = Motion {
            id: 1,
            displacement: Displacement::ZERO,
            speed_mm_s: 100,
        };
        Outputs {
            motion: (self.slices_left == 0).then_some(motion),
            ..Outputs::NONE
        }
    }

    #[cfg(feature = "store")]
    fn to_bytes<'a>(&self, _: &'a mut [u8; MAX_CONFIG]) -> &'a [u8] {
        &[]
    }

    #[cfg(feature = "store")]
    fn replace(&mut self, _: &[u8]) -> bool {
        false
    }
}

struct ThinkingRig(Node<16, 16, 20, Thinker>);

impl ThinkingRig {
    /// A session by the host's clock.
    fn new() -> Self {
        let mut rig = Self(Node::new());
        let start = Millis::from_ms(0);
        let (grid, mut said) = (Grid::rectangle(4, 4), Said::default());
        (rig.0).start(&config(), grid, Identity::default(), start, &mut said);
        rig.send(
            0,
            &HostMessage::Hello(HostHello {
                dimensions: Small::dimensions(),
                clock: Clock::Host,
                open_space: false,
            }),
        );
        rig
    }

    fn send(&mut self, seq: u16, message: &HostMessage<16>) -> Vec<DeviceMessage<16>> {
        let header = Header {
            session: SESSION,
            seq,
        };
        let frame = Frame::pack(header, message).unwrap();
        let bytes = frame.as_bytes().split_last().unwrap().1;
        let mut said = Said::default();
        self.0.frame(Millis::from_ms(0), bytes, &mut said);
        read(&said)
    }

    fn tick(&mut self) -> (bool, Vec<DeviceMessage<16>>) {
        let mut said = Said::default();
        let more = self.0.tick(Millis::from_ms(0), &mut said);
        (more, read(&said))
    }
}

fn scan() -> HostMessage<16> {
    let echo = TimedEcho {
        sensor: 0,
        range_mm: Some(900),
        age_ms: 0,
    };
    HostMessage::Scan {
        at_ms: 100,
        echoes: [echo].into_iter().collect(),
    }
}

fn is_done(message: &DeviceMessage<16>, of: u16) -> bool {
    matches!(message, DeviceMessage::Done { seq } if *seq == of)
}

#[test]
fn an_answer_is_complete_when_the_body_has_thought() {
    let mut rig = ThinkingRig::new();
    assert!(rig.send(1, &scan()).is_empty());
    // Signs of life have no answer, and the frame that is repeated has none yet.
    assert!(rig.send(1, &scan()).is_empty());
    assert!(rig.send(2, &HostMessage::Alive { at_ms: 101 }).is_empty());
    for _ in 0..2 {
        assert_eq!(rig.tick(), (true, Vec::new()));
    }
    let (more, said) = rig.tick();
    assert!(!more);
    let [DeviceMessage::Motion(_), done] = &said[..] else {
        panic!("{said:?}");
    };
    assert!(is_done(done, 1));
    assert_eq!(rig.tick(), (false, Vec::new()));
    // The frame is repeated when it has been answered.
    assert_eq!(rig.send(3, &scan()), []);
    let answer: Vec<_> = (0..3).flat_map(|_| rig.tick().1).collect();
    assert_eq!(answer.len(), 2);
    assert_eq!(rig.send(3, &scan()), answer);
}

#[test]
fn a_frame_is_answered_while_the_body_thinks() {
    let mut rig = ThinkingRig::new();
    rig.send(1, &scan());
    let said = rig.send(2, &HostMessage::Mode);
    let [first, DeviceMessage::Mode(_), second] = &said[..] else {
        panic!("{said:?}");
    };
    assert!(is_done(first, 1) && is_done(second, 2));
    assert!(rig.tick().0);
    let stop = HostMessage::Command {
        at_ms: 102,
        ttl_ms: 500,
        command: RobotCommand::Stop,
    };
    let said = rig.send(3, &stop);
    assert!(is_done(said.last().expect("an answer"), 3));
    assert_eq!(rig.tick(), (false, Vec::new()), "it thinks no more");
}

#[test]
fn what_ends_the_thinking_ends_the_answer() {
    let mut rig = ThinkingRig::new();
    rig.send(1, &scan());
    rig.0.body.slices_left = 0;
    let (more, said) = rig.tick();
    assert!(!more && said.len() == 1 && is_done(&said[0], 1));
    rig.send(2, &scan());
    // A new session has no old answers.
    let hello = HostMessage::Hello(HostHello {
        dimensions: Small::dimensions(),
        clock: Clock::Device,
        open_space: false,
    });
    rig.send(3, &hello);
    while rig.0.body.is_thinking() {
        let (_, said) = rig.tick();
        assert!(said.iter().all(|message| !is_done(message, 2)));
    }
}
