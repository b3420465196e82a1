//! Images of robots with other bodies, and places.

use super::*;
use crate::body::MountedSensors;
use crate::fixed::Mask;
use crate::turret::BodySpec;

/// Bytes of a place.
const PLACE: usize = 56;

/// So many bytes, all different.
fn places(count: usize) -> Vec<u8> {
    (0..PLACE * (count + 1)).map(|i| (i % 251) as u8).collect()
}

fn robot<const RECORDS: usize>(
    count: usize,
) -> (
    Mind<20>,
    Box<MountedSensors<16, 16, 8, RECORDS>>,
    BodySpec<16>,
) {
    let mut body = Box::new(MountedSensors::NEW);
    let spec = BodySpec {
        enabled: Mask::from_bits(0xffff),
        actuation: crate::actuation::Actuation::EXACT,
        ..BodySpec::NONE
    };
    body.tell(&spec);
    if count > 0 {
        assert_eq!(body.write_places(0, &places(count)), Ok(()));
    }
    (Mind::full(), body, spec)
}

fn image_of<const RECORDS: usize>(
    mind: &Mind<20>,
    body: &MountedSensors<16, 16, 8, RECORDS>,
) -> Vec<u8> {
    let contents = Contents {
        body,
        config: &mind.config,
        state: &mind.state,
        goal: &mind.goal,
        goals: &mind.goals,
    };
    let mut image = Vec::new();
    let written = contents.write(3, &mut |bytes| {
        image.extend_from_slice(bytes);
        Ok::<_, ()>(())
    });
    assert_eq!(written, Ok(()));
    image
}

fn read_by<B: Body<16>>(mind: &mut Mind<20>, body: &mut B, image: &[u8]) -> Option<ImageError> {
    let mut contents = ContentsMut {
        body,
        config: &mut mind.config,
        state: &mut mind.state,
        goal: &mut mind.goal,
        goals: &mut mind.goals,
    };
    contents.read(&mut reader(image), image.len()).err()
}

fn saved<B: Body<16>>(body: &B) -> Vec<u8> {
    let mut bytes = std::vec![0; body.places_len()];
    assert_eq!(body.read_places(0, &mut bytes), bytes.len());
    bytes
}

#[test]
fn body_and_places_are_written_and_read() {
    for count in [0, 1, 2, 39, 64] {
        let (mind, body, spec) = robot::<64>(count);
        let image = image_of(&mind, &body);
        // Over those that it had.
        let (mut other, mut known, _) = robot::<64>(5);
        assert_eq!(read_by(&mut other, &mut *known, &image), None);
        assert_eq!(known.known(), &spec);
        assert_eq!(known.turret().places().positions().len(), count);
        assert_eq!(saved(&*known), saved(&*body), "{count}");
    }
}

#[test]
fn a_body_with_less_room_for_places_knows_as_many_as_fit() {
    let (mind, body, _) = robot::<64>(64);
    let image = image_of(&mind, &body);
    let (mut other, mut few, _) = robot::<6>(0);
    assert_eq!(read_by(&mut other, &mut *few, &image), None);
    // Two in a record, but for the first one.
    assert_eq!(few.turret().places().positions().len(), 5);
    assert!(other.state.has_learned());
    let (mut other, mut none, _) = robot::<0>(0);
    assert_eq!(read_by(&mut other, &mut *none, &image), None);
    assert!(other.state.has_learned());
    let held = read_by(&mut other, &mut HeldRing, &image);
    assert_eq!(held, Some(ImageError::Dimensions));
}

/// Sealed, but with a goal whose name is none: nothing of it stays.
#[test]
fn an_image_with_invalid_content_leaves_no_places() {
    let (mind, body, _) = robot::<64>(39);
    let mut image = image_of(&mind, &body);
    let name = image.windows(12).position(|bytes| bytes == b"oal-number-0");
    image[name.unwrap()] = 7;
    let (mut other, mut known, _) = robot::<64>(5);
    let fault = read_by(&mut other, &mut *known, &sealed(image));
    assert_eq!(fault, Some(ImageError::Version));
    assert_eq!(known.places_len(), 0);
    assert!(!other.state.has_learned() && other.goals.as_slice().is_empty());
}

#[test]
fn the_largest_image_of_each_body_has_the_room_it_was_given() {
    // Each record of two places has five bytes more, and three zeros.
    let most = max_bytes::<MountedSensors<16, 16, 256, 256>>();
    assert_eq!(most, 8_256 + 3 * 168 + 129 * 120);
    assert_eq!(
        max_bytes::<MountedSensors<16, 16, 256, 0>>(),
        8_256 + 3 * 168
    );
    assert_eq!(max_bytes::<HeldRing>(), 8_256);
    let [(mind, without, _), (_, with, _)] = [robot::<64>(0), robot::<64>(64)];
    let [without, with] = [without, with].map(|body| image_of(&mind, &body).len());
    assert!(with - without <= 33 * 120, "{with} {without}");
}

#[test]
fn whatever_is_changed_in_an_image_with_places_is_noticed() {
    let (mind, body, _) = robot::<64>(39);
    let image = image_of(&mind, &body);
    for index in (0..image.len()).step_by(if cfg!(miri) { 997 } else { 1 }) {
        let mut torn = image.clone();
        torn[index] ^= 0x10;
        let (mut other, mut known, _) = robot::<64>(5);
        let before = known.clone();
        assert!(read_by(&mut other, &mut *known, &torn).is_some(), "{index}");
        assert!(known == before, "{index}");
    }
}
