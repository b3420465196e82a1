use super::*;
use crate::units::Bearing;

const LIMITS: PointLimits = PointLimits {
    face_radius_mm: 230,
    ..PointLimits::NOMAD
};

fn degrees(angle: f64) -> Bearing {
    Bearing::from_turns((angle / 360.0 * 65_536.0).round() as i32 as u16)
}

fn way(dx_mm: i16, dy_mm: i16) -> Displacement {
    Displacement { dx_mm, dy_mm }
}

/// A beam from the face of a round body.
fn beam(angle: f64, range_mm: u16) -> Beam {
    let axis = degrees(angle);
    Beam {
        mount: Displacement::along(axis, 230),
        axis,
        range: Range::from_mm(range_mm),
        is_echo: true,
    }
}

fn heard(beams: &[(f64, u16)]) -> PointMemory<64> {
    let mut memory = PointMemory::new();
    for (angle, range_mm) in beams {
        memory.hear(&LIMITS, &beam(*angle, *range_mm));
    }
    memory
}

fn ranges(memory: &PointMemory<64>) -> [Option<u16>; 16] {
    memory
        .ring::<16>(&LIMITS)
        .0
        .map(|range| range.map(Range::as_mm))
}

/// Nearest within a cone of 25° in a square room of half side 2 m around the center, from a face of
/// 230 mm.
fn square_room_mm(angle: f64) -> f64 {
    let along = |angle: f64| {
        let (sin, cos) = (libm::sin(angle.to_radians()), libm::cos(angle.to_radians()));
        2_000.0 / sin.abs().max(cos.abs()) - 230.0
    };
    let cone = (-25..=25).map(|half_degrees| along(angle + f64::from(half_degrees) / 2.0));
    cone.fold(f64::INFINITY, f64::min)
}

#[test]
fn one_beam_that_turns_around_fills_the_ring() {
    let mut memory = PointMemory::<256>::new();
    let step = 7.5;
    for turn in 0..48 {
        let range_mm = square_room_mm(step * f64::from(turn)) as u16;
        memory.hear(&LIMITS, &beam(0.0, range_mm));
        memory.moved(&LIMITS, Displacement::ZERO, degrees(step));
    }
    let (ring, known) = memory.ring::<16>(&LIMITS);
    assert!(known.covers(16));
    for (sector, range) in ring.into_iter().enumerate() {
        // A beam looked along the axis.
        let exact = square_room_mm(22.5 * sector as f64);
        let found = f64::from(range.expect("known").as_mm());
        assert!((found - exact).abs() < 8.0, "{sector}: {found} for {exact}");
    }
}

#[test]
fn a_point_keeps_its_place_as_the_robot_turns_and_moves() {
    let mut memory = heard(&[(0.0, 770)]);
    memory.moved(&LIMITS, Displacement::ZERO, degrees(90.0));
    assert_eq!(ranges(&memory)[0], Some(770));
    // Half a meter to the left, which is ahead now: the point lies 1 m along x and 0.5 m to the
    // right.
    memory.moved(&LIMITS, way(500, 0), Bearing::ZERO);
    let found = ranges(&memory);
    let expected = [(15, Some(888)), (14, None), (0, None)];
    for (sector, range) in expected {
        assert_eq!(found[sector], range, "{sector}");
    }
}

#[test]
fn far_points_from_elsewhere_tell_only_what_is_not_seen_from_here() {
    let mut memory = heard(&[(0.0, 3_000), (80.0, 500)]);
    memory.moved(&LIMITS, way(0, -300), Bearing::ZERO);
    let found = |memory: &PointMemory<64>| (ranges(memory)[0], ranges(memory)[4]);
    assert_eq!(found(&memory), (Some(3_013), Some(796)));
    memory.moved(&LIMITS, way(0, -10), Bearing::ZERO);
    assert_eq!(found(&memory), (Some(3_014), Some(806)));
    // Both sectors are heard from here: the far point no longer counts, the near one does.
    memory.hear(&LIMITS, &beam(0.0, 4_000));
    memory.hear(&LIMITS, &beam(100.0, 1_500));
    assert_eq!(found(&memory), (Some(4_000), Some(806)));
    memory.moved(&LIMITS, way(0, -200), Bearing::ZERO);
    assert_eq!(found(&memory), (Some(4_004), Some(1_697)));
}

/// To and fro, hundreds of millimeters.
fn travel(memory: &mut PointMemory<64>, limits: &PointLimits, mm: i16) {
    for leg in 0..mm / 100 {
        let step = if leg % 2 == 0 { 100 } else { -100 };
        memory.moved(limits, way(step, 0), Bearing::ZERO);
    }
}

#[test]
fn points_last_for_six_meters_of_travel() {
    // The travel is kept in few bits, which wrap.
    for before_mm in [0, 5_000, 16_300, 20_000, 32_000] {
        let mut memory = heard(&[]);
        travel(&mut memory, &LIMITS, before_mm);
        memory.hear(&LIMITS, &beam(180.0, 500));
        travel(&mut memory, &LIMITS, 5_900);
        assert_eq!(memory.len(), 1, "{before_mm}");
        travel(&mut memory, &LIMITS, 200);
        assert!(memory.is_empty(), "{before_mm}");
    }
}

#[test]
fn points_that_are_to_last_for_longer_than_16_meters_last() {
    let limits = PointLimits {
        keep_mm: 16_320,
        ..LIMITS
    };
    let mut memory = heard(&[(180.0, 500)]);
    travel(&mut memory, &limits, 30_000);
    assert_eq!(memory.len(), 1);
}

#[test]
fn a_beam_shows_no_place_free_that_it_does_not_reach() {
    let mut draw = 1_u32;
    let mut any = |most: u32| {
        draw = draw.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (draw >> 8) % most
    };
    let mut carved = 0;
    for _ in 0..20_000 {
        let mut bearing = || Bearing::from_turns(any(65_536) as u16);
        let (axis, heard, from) = (bearing(), bearing(), bearing());
        let half_cone = degrees(1.0 + f64::from(any(25)));
        let arc = Arc::new(heard.direction(), any(1_000) as i32);
        let offset = Displacement::along(from, any(4_000) as i32);
        let beam = FreeBeam {
            face: Displacement::ZERO,
            axis: axis.direction(),
            half_cone: half_cone.direction(),
            length_mm: any(5_000) as i32,
            may_be_stray: false,
            is_silent: false,
        };
        // The plain way: each place by itself.
        let mut by_place = arc;
        let from_face = beam
            .axis
            .components(offset.dx_mm.into(), offset.dy_mm.into());
        let is_left = by_place.carve_places(from_face, &beam);
        let mut at_once = arc;
        assert_eq!(at_once.carve(offset, &beam, || true), is_left);
        assert_eq!(at_once, by_place);
        carved += usize::from(by_place != arc);
    }
    assert!(carved > 500, "{carved}");
}

#[test]
fn a_point_goes_when_a_beam_went_free_through_its_whole_arc() {
    let after = |angle, range_mm| {
        let mut memory = heard(&[(0.0, 1_000)]);
        memory.hear(&LIMITS, &beam(angle, range_mm));
        memory.len()
    };
    assert_eq!(after(0.0, 2_000), 1);
    assert_eq!(after(1.0, 2_000), 1);
    assert_eq!(after(5.0, 2_000), 2, "a part of it is left");
    assert_eq!(after(0.0, 1_030), 2, "not clearly beyond");
    assert_eq!(after(0.0, 1_040), 1);
    assert_eq!(after(180.0, 2_000), 2, "the other way");
}

#[test]
fn a_point_goes_when_several_beams_went_free_through_its_arc() {
    let after = |angles: &[f64]| {
        let mut memory = heard(&[(0.0, 1_000)]);
        for angle in angles {
            memory.hear(&LIMITS, &beam(*angle, 2_000));
        }
        memory.len() - angles.len()
    };
    // A beam from 2.5° to the right on, and one up to that.
    assert_eq!(after(&[10.0]), 1);
    assert_eq!(after(&[10.0, 10.0]), 1, "the same part of it");
    assert_eq!(after(&[10.0, -10.0]), 0);
}

/// A wall at a distance of 1 m on the left: of it a beam askew hears what is nearest in its cone.
#[test]
fn a_point_heard_elsewhere_stands_where_beams_have_left_it() {
    let mut memory = heard(&[(45.0, 992)]);
    memory.moved(&LIMITS, way(865, 0), Bearing::ZERO);
    assert_near(ranges(&memory)[4], Some(635));
    memory.hear(&LIMITS, &beam(90.0, 770));
    memory.moved(&LIMITS, way(30, 0), Bearing::ZERO);
    assert_near(ranges(&memory)[4], Some(769));
}

#[test]
fn a_point_heard_from_here_stays_on_its_axis() {
    let mut memory = heard(&[(9.0, 1_000), (-1.0, 2_000)]);
    assert_near(ranges(&memory)[1], None);
    // From elsewhere it is seen to stand farther to the left.
    memory.moved(&LIMITS, way(-310, 0), Bearing::ZERO);
    assert_near(ranges(&memory)[1], Some(1_307));
    memory.moved(&LIMITS, way(310, 0), Bearing::ZERO);
    assert_near(ranges(&memory)[1], None);
    assert_near(ranges(&memory)[0], Some(1_000));
}

/// Ranges of places that were calculated without rounding.
fn assert_near(found: Option<u16>, expected: Option<u16>) {
    let is_near = match (found, expected) {
        (Some(found), Some(expected)) => found.abs_diff(expected) <= 3,
        _ => found == expected,
    };
    assert!(is_near, "{found:?} is not {expected:?}");
}

#[test]
fn a_full_memory_drops_what_was_heard_first() {
    let mut memory = PointMemory::<3>::new();
    for (angle, range_mm) in [(0.0, 500), (90.0, 600), (180.0, 700), (270.0, 800)] {
        memory.hear(&LIMITS, &beam(angle, range_mm));
    }
    let (ring, known) = memory.ring::<4>(&LIMITS);
    let mm = ring.map(|range| range.map(Range::as_mm));
    assert_eq!(mm, [None, Some(600), Some(700), Some(800)]);
    assert_eq!(known, Mask::from_bits(0b1110));
}

#[test]
fn a_point_near_a_border_belongs_to_two_sectors() {
    let of = |angle| sectors_at::<16>(degrees(angle)).map(|view| view.sector);
    assert_eq!(of(0.0), [Some(0), None]);
    assert_eq!(of(9.9), [Some(0), None]);
    assert_eq!(of(10.1), [Some(0), Some(1)]);
    assert_eq!(of(12.4), [Some(1), Some(0)]);
    assert_eq!(of(12.6), [Some(1), None]);
    assert_eq!(of(-10.1), [Some(0), Some(15)]);
    assert_eq!(of(-12.4), [Some(15), Some(0)]);
    assert_eq!(of(349.9), [Some(0), Some(15)]);
    assert_eq!(
        sectors_at::<0>(Bearing::ZERO).map(|view| view.sector),
        [None, None]
    );
    let is_central = |angle| sectors_at::<16>(degrees(angle))[0].is_central;
    assert_eq!(
        [-6.0, -5.0, 0.0, 5.0, 6.0].map(is_central),
        [false, true, true, true, false]
    );
}

#[test]
fn the_way_ends_where_the_disc_touches_a_point() {
    let memory = heard(&[(0.0, 1_770)]);
    let free = |x, y, radius_mm| memory.free_from_mm(way(0, 0), way(x, y), radius_mm);
    assert_eq!(free(3_000, 0, 300), 1_700);
    assert_eq!(free(1_000, 0, 300), 1_000, "the point is farther");
    assert_eq!(free(-3_000, 0, 300), 3_000, "it is behind");
    assert_eq!(free(0, 0, 300), 0);
    // Past the point at 0.6 of the radius: the chord is 0.8 of it.
    let memory = heard(&[(90.0, 0)]);
    assert_eq!(memory.free_from_mm(way(0, 0), way(1_000, 0), 229), 1_000);
    let mut memory = memory;
    memory.moved(&LIMITS, way(-1_000, 50), Bearing::ZERO);
    assert_eq!(memory.free_from_mm(way(0, 0), way(2_000, 0), 300), 760);
}

/// A post left of the axis, and a beam that sees past it on the right.
#[test]
fn a_beam_that_saw_past_a_thing_frees_what_is_beside_it() {
    let mut memory = heard(&[(0.0, 1_770)]);
    let beside = way(2_500, -250);
    let likely = |memory: &PointMemory<64>| memory.likely_free_mm(way(0, 0), beside, 300);
    assert_eq!(
        (memory.free_from_mm(way(0, 0), beside, 300), likely(&memory)),
        (1_766, 1_766)
    );
    memory.hear(&LIMITS, &beam(-8.0, 3_000));
    assert_eq!(
        (memory.free_from_mm(way(0, 0), beside, 300), likely(&memory)),
        (1_766, 2_512)
    );
    // It stands in the way straight ahead still.
    assert!(memory.likely_free_mm(way(0, 0), way(2_500, 0), 300) < 1_800);
}

#[test]
fn the_nearest_point_is_looked_for_ahead_only() {
    let memory = heard(&[(0.0, 770), (80.0, 300), (180.0, 100)]);
    assert_eq!(memory.nearest_mm(degrees(0.0)), Some(530));
    assert_eq!(memory.nearest_mm(degrees(-20.0)), Some(1_000));
    assert_eq!(memory.nearest_mm(degrees(180.0)), Some(330));
    assert_eq!(heard(&[]).nearest_mm(degrees(0.0)), None);
}

#[test]
fn free_space_is_no_thing_and_contradicts_what_lies_before_its_end() {
    let free = Beam {
        is_echo: false,
        ..beam(0.0, 1_000)
    };
    let mut memory = heard(&[(0.0, 900)]);
    memory.hear(&LIMITS, &free);
    let is_known = |memory: &PointMemory<64>| memory.ring::<16>(&LIMITS).1.contains(0);
    assert_eq!((ranges(&memory)[0], is_known(&memory)), (None, true));
    assert_eq!(memory.free_from_mm(way(0, 0), way(2_000, 0), 300), 2_000);
    memory.moved(&LIMITS, way(310, 0), Bearing::ZERO);
    assert!(!is_known(&memory), "seen from elsewhere");
}

#[test]
fn an_echo_at_the_sensors_face_is_a_thing() {
    let memory = heard(&[(0.0, 0)]);
    assert_eq!(ranges(&memory)[0], Some(0));
    assert_eq!(memory.nearest_mm(degrees(0.0)), Some(230));
}

#[test]
fn extreme_ranges_and_moves_do_no_harm() {
    let mut memory = PointMemory::<4>::new();
    for range_mm in [0, 65_534, 32_767, 1] {
        memory.hear(&LIMITS, &beam(45.0, range_mm));
    }
    memory.moved(&LIMITS, way(i16::MIN, i16::MIN), degrees(180.0));
    memory.moved(&LIMITS, way(i16::MAX, i16::MAX), degrees(180.0));
    let _ = memory.ring::<16>(&LIMITS);
    assert!(memory.free_from_mm(way(0, 0), way(i16::MIN, i16::MIN), u16::MAX) <= 46_341);
    memory.forget();
    assert_eq!(
        (memory.len(), memory.ring::<16>(&LIMITS).1),
        (0, Mask::NONE)
    );
}

/// On a smooth wall heard from the side an echo goes astray.
#[test]
fn silence_frees_what_was_heard_in_almost_the_same_direction() {
    let left_after = |aside_mm, may_be_stray| {
        let mut memory = heard(&[(0.0, 1_000)]);
        memory.moved(&LIMITS, way(0, aside_mm), Bearing::ZERO);
        let at = memory.points.first().expect("heard").at;
        let ray = memory.ray(&Beam {
            mount: Displacement::ZERO,
            axis: at.bearing(),
            range: Range::from_mm(3_000),
            is_echo: false,
        });
        memory.hear_nothing(LIMITS.half_cone, &ray, may_be_stray);
        memory.len()
    };
    assert_eq!(left_after(0, false), 0);
    assert_eq!(left_after(650, false), 0);
    assert_eq!(left_after(-650, false), 0);
    assert_eq!(left_after(800, false), 1);
    assert_eq!(left_after(0, true), 1, "once alone it shows nothing");
}

/// Somebody passes before a wall.
#[test]
fn an_echo_that_ends_motions_frees_nothing_beyond_it() {
    let lobe = Lobe {
        half: degrees(15.0),
        half_free: degrees(8.75),
        reach_mm: 2_000,
        similar_mm: 60,
        short_of_echo_mm: 60,
        short_of_echo_part: 32,
        doubts_free: true,
    };
    let beam = |range_mm| Beam {
        mount: Displacement {
            dx_mm: 231,
            dy_mm: 0,
        },
        axis: Bearing::ZERO,
        range: Range::from_mm(range_mm),
        is_echo: true,
    };
    let mut memory = PointMemory::<8>::new();
    memory.hear_near(&lobe, &beam(600));
    let wall = memory.clone();
    for _ in 0..3 {
        memory.hear_near(&lobe, &beam(300));
    }
    assert_eq!(memory.len(), 2);
    assert_eq!(memory.points.first(), wall.points.first());
}

#[test]
fn what_was_heard_turns_with_a_robot_that_faces_elsewhere() {
    let mut memory = heard(&[(0.0, 900), (90.0, 600), (200.0, 1_200)]);
    let before = ranges(&memory);
    memory.turn_frame(degrees(90.0));
    assert_eq!(memory.heading(), degrees(90.0));
    let mut turned = before;
    turned.rotate_right(4);
    let pairs = ranges(&memory).into_iter().zip(turned);
    for (now, expected) in pairs {
        assert_eq!(now.is_some(), expected.is_some());
        let off_mm = now.unwrap_or(0).abs_diff(expected.unwrap_or(0));
        assert!(off_mm <= 8, "{now:?} {expected:?}");
    }
    // In the body's frame all is where it was.
    memory.hear(&LIMITS, &beam(0.0, 700));
    assert_eq!(ranges(&memory)[4], Some(700));
}
