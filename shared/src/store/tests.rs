use super::*;
use crate::fixed::Weight;
use crate::goal::{Component, GoalFrame, MAX_NAMED_GOALS};
use crate::som::Grid;
use proptest::prelude::*;
use std::boxed::Box;
use std::string::String;
use std::vec::Vec;

mod body;

/// A mind with these many samples at most.
#[derive(Debug, Clone, PartialEq)]
struct Mind<const SAMPLES: usize> {
    config: Config<16>,
    state: Box<State<16, 16, SAMPLES>>,
    goal: Goal<16>,
    goals: NamedGoals<16>,
}

impl<const SAMPLES: usize> Mind<SAMPLES> {
    fn fresh() -> Self {
        let config = Config::recommended();
        Self {
            state: Box::new(State::new(Grid::rectangle(4, 4))),
            goal: Goal::avoiding(&config),
            goals: NamedGoals::new(),
            config,
        }
    }

    /// As full as can be, with the longest numbers.
    fn full() -> Self {
        let mut mind = Self::fresh();
        mind.config.clearance_mm = u16::MAX;
        for part in PARTS {
            let length = match part {
                StatePart::Memory => SAMPLES * State::<16, 16, SAMPLES>::SAMPLE_BYTES,
                _ => mind.state.part_len(part),
            };
            let bytes: Vec<u8> = (0..length).map(|i| (i * 7 + i / 251) as u8).collect();
            mind.state.write_part(part, 0, &bytes).unwrap();
        }
        mind.state.seed(u64::MAX);
        let component = Component {
            low: Weight::MIN,
            high: Weight::MIN,
            weight: 255,
        };
        mind.goal = Goal {
            frame: GoalFrame::Travel,
            progress_q16: u16::MAX,
            heading_hold_q16: u16::MAX,
            cap: Weight::MIN,
            tolerance: Weight::MIN,
            ..Goal::of([component; 16])
        };
        for number in 0..MAX_NAMED_GOALS {
            let name: String = std::format!("goal-number-{number}");
            let name = Name::new(&name[name.len() - 12..]).unwrap();
            let goal = mind.goal;
            mind.goals.save(NamedGoal { name, goal }).unwrap();
        }
        mind
    }

    fn image(&self, generation: u32) -> Vec<u8> {
        let contents = Contents {
            body: &HeldRing,
            config: &self.config,
            state: &self.state,
            goal: &self.goal,
            goals: &self.goals,
        };
        let mut image = Vec::new();
        let written = contents.write(generation, &mut |bytes| {
            assert!(bytes.len() <= MAX_RECORD && bytes.len().is_multiple_of(WORD));
            image.extend_from_slice(bytes);
            Ok::<_, ()>(())
        });
        assert_eq!(written, Ok(()));
        image
    }

    fn read(&mut self, image: &[u8]) -> Result<ImageInfo, ImageError> {
        self.read_from(&mut reader(image), image.len())
    }

    fn read_from(
        &mut self,
        read: &mut dyn FnMut(usize, &mut [u8]) -> bool,
        most: usize,
    ) -> Result<ImageInfo, ImageError> {
        let mut contents = ContentsMut {
            body: &mut HeldRing,
            config: &mut self.config,
            state: &mut self.state,
            goal: &mut self.goal,
            goals: &mut self.goals,
        };
        contents.read(read, most)
    }
}

fn reader(image: &[u8]) -> impl FnMut(usize, &mut [u8]) -> bool {
    move |at, out| {
        let bytes = image.get(at..at + out.len());
        bytes.is_some_and(|bytes| {
            out.copy_from_slice(bytes);
            true
        })
    }
}

fn checked(image: &[u8]) -> Result<ImageInfo, ImageError> {
    check(&mut reader(image), image.len())
}

/// Puts the right checksum at the end of a changed image.
fn sealed(mut image: Vec<u8>) -> Vec<u8> {
    let end = image.len() - 8;
    let crc = CRC.checksum(&image[..end]).to_le_bytes();
    image[end + 2..end + 6].copy_from_slice(&crc);
    image
}

#[test]
fn what_is_written_is_read() {
    let full = Mind::<100>::full();
    let mut learning = Mind::<100>::fresh();
    learning
        .state
        .write_part(StatePart::Memory, 0, &[9; 120])
        .unwrap();
    for mind in [Mind::fresh(), learning, full] {
        let image = mind.image(41);
        let found = ImageInfo {
            generation: 41,
            bytes: image.len(),
        };
        assert_eq!(checked(&image), Ok(found));
        // Over whatever was there.
        for mut other in [Mind::fresh(), Mind::full()] {
            assert_eq!(other.read(&image), Ok(found));
            let seeded = other.state.next_seed().is_some();
            assert_eq!(seeded, mind.state.next_seed().is_some());
            assert_eq!(other.image(41).len(), image.len());
            assert_eq!((&other.config, &other.goal), (&mind.config, &mind.goal));
            assert!(other.goals == mind.goals && other.state.memory() == mind.state.memory());
            assert!(other.state.situations() == mind.state.situations());
            assert!(other.state.actions() == mind.state.actions());
            assert_eq!(other.state.has_learned(), mind.state.has_learned());
        }
    }
}

/// Randomness goes on from the image, the same way each time.
#[test]
fn two_minds_that_read_the_same_image_are_the_same() {
    let image = Mind::<100>::full().image(1);
    let [mut one, mut other] = [Mind::<100>::fresh(), Mind::full()];
    one.read(&image).unwrap();
    other.read(&image).unwrap();
    assert!(one == other);
}

#[test]
fn the_largest_image_has_the_room_it_was_given() {
    let mind = Mind::<100>::full();
    let bytes = mind.image(u32::MAX).len();
    // A configuration of the longest numbers has another record at most.
    let mut buffer = [0; MAX_CONFIG];
    let told = mind.config.to_bytes(&mut buffer).len();
    let most = bytes + (MAX_CONFIG - told) + 12;
    std::println!("{bytes} bytes, with the longest configuration {most} at most");
    assert!((MAX_NOMAD - 64..=MAX_NOMAD).contains(&most), "{most}");
}

#[test]
fn whatever_is_cut_or_changed_is_no_image_and_changes_nothing() {
    let image = Mind::<20>::full().image(7);
    let before = Mind::<20>::fresh();
    let mut mind = before.clone();
    // Miri takes some thousand times as long.
    for index in (0..image.len()).step_by(if cfg!(miri) { 997 } else { 1 }) {
        let mut torn = image.clone();
        torn[index] ^= 0x10;
        assert!(mind.read(&torn).is_err(), "byte {index}");
        assert!(checked(&image[..index]).is_err());
        assert!(mind == before, "byte {index}");
    }
    // Old bytes behind it do not matter.
    let longer = [&image[..], &[0x55; 300]].concat();
    assert_eq!(checked(&longer).map(|found| found.bytes), Ok(image.len()));
    assert_eq!(checked(&[0xff; 600]), Err(ImageError::Torn));
}

#[test]
fn nothing_is_read_beyond_the_room_it_was_given() {
    let image = Mind::<20>::full().image(7);
    for most in (0..image.len()).step_by(if cfg!(miri) { 997 } else { 1 }) {
        let mut whole = reader(&image);
        let mut read = |at: usize, out: &mut [u8]| {
            assert!(at + out.len() <= most, "{at} of {most}");
            whole(at, out)
        };
        let fault = if most < WORD {
            ImageError::Source
        } else {
            ImageError::Torn
        };
        assert_eq!(check(&mut read, most), Err(fault));
    }
}

#[test]
fn other_versions_and_robots_are_known_as_such() {
    let image = Mind::<20>::full().image(7);
    let mut mind = Mind::<20>::fresh();
    // "AMPS", a length, the kind, the layout.
    let mut later = image.clone();
    assert_eq!(later[4..8], [15, kind::HEAD, LAYOUT as u8, 0]);
    later[6] = 2;
    let later = sealed(later);
    assert_eq!(checked(&later).map(|found| found.generation), Ok(7));
    assert_eq!(mind.read(&later), Err(ImageError::Version));
    let hundred = Mind::<100>::full().image(7);
    assert_eq!(mind.read(&hundred), Err(ImageError::Dimensions));
    let mut few = Mind::<100>::fresh();
    assert!(few.read(&image).is_ok(), "a larger memory takes fewer");
    // Sealed, but its goals have names that are none.
    let name = image.windows(12).position(|bytes| bytes == b"oal-number-0");
    let mut strange = image.clone();
    strange[name.unwrap()] = 7;
    assert_eq!(mind.read(&sealed(strange)), Err(ImageError::Version));
    assert!(!mind.state.has_learned() && mind.state.memory().samples().is_empty());
}

#[test]
fn saved_types_have_a_grammar_of_their_own() {
    let text = include_str!("../wire/schema.txt");
    let saved = &text[text.find("\nConfig ").unwrap()..];
    assert!(saved.contains("\nGoal ") && !saved.contains("HostMessage"));
    assert_eq!(GRAMMAR, CRC.checksum(saved.as_bytes()));
}

#[test]
fn an_image_of_another_grammar_is_not_read() {
    let image = Mind::<20>::full().image(3);
    assert_eq!(image[8..12], GRAMMAR.to_le_bytes());
    // Of protocol version 1, whose configuration was shorter.
    let former = 0x1113_3147_u32;
    for (grammar, expected) in [(GRAMMAR, Ok(())), (former, Err(ImageError::Version))] {
        let mut image = image.clone();
        image[8..12].copy_from_slice(&grammar.to_le_bytes());
        let mut mind = Mind::<20>::fresh();
        assert_eq!(mind.read(&sealed(image)).map(|_| ()), expected);
        assert_eq!(mind.state.has_learned(), expected.is_ok());
    }
}

proptest! {
    #[test]
    fn any_bytes_are_an_image_or_not(
        start in 0_usize..700,
        bytes in prop::collection::vec(any::<u8>(), 0..64),
    ) {
        let mut image = Mind::<20>::full().image(3);
        for (place, byte) in image[start..].iter_mut().zip(&bytes) {
            *place = *byte;
        }
        let mut mind = Mind::<20>::fresh();
        let _ = mind.read(&image);
        let _ = mind.read(&sealed(image));
    }
}

#[test]
fn each_fault_has_words_of_its_own() {
    let faults = [
        ImageError::Source,
        ImageError::Torn,
        ImageError::Version,
        ImageError::Dimensions,
    ];
    let words = faults.map(|fault| std::format!("{fault}"));
    assert_eq!(words[0], "it cannot be read");
    assert_eq!(words[1], "it is cut off or damaged");
    assert!(words[2].contains("another version") && words[3].contains("other sonars"));
}

/// A source that fails at the first, the second, the third … read.
#[test]
fn a_source_that_fails_is_said_to_and_changes_nothing() {
    let image = Mind::<20>::full().image(7);
    for fails in 0..20 {
        let (mut reads, mut whole) = (0, reader(&image));
        let mut read = |at: usize, out: &mut [u8]| {
            reads += 1;
            whole(at, out) && reads <= fails
        };
        let mut mind = Mind::<20>::fresh();
        let fault = mind.read_from(&mut read, image.len());
        assert!(
            fault == Err(ImageError::Source) && mind == Mind::fresh(),
            "{fails}"
        );
    }
}
