//! Arcs that are passed over change nothing.

use super::*;
use proptest::prelude::*;

fn arc((x, y, turns, range, age): (i16, i16, u16, u16, u32), now: Millis) -> Arc {
    let range = Some(Range::from_mm(range));
    Arc {
        face: Displacement { dx_mm: x, dy_mm: y },
        axis: Bearing::from_turns(turns).direction(),
        range,
        latest: range,
        at: Millis::from_ms(now.as_ms().wrapping_sub(age)),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]
    #[test]
    fn the_way_is_as_long_as_by_every_arc_alone(
        arcs in prop::collection::vec((-900_i16..900, -900_i16..900, any::<u16>(), prop_oneof![0_u16..1_500, any::<u16>()], 0_u32..900_000), 1..24),
        wanted in (-300_i16..=300, -300_i16..=300), half_lobe in prop_oneof![Just(2_731_u16), any::<u16>()],
        approach_mm_s in prop_oneof![Just(0_u16), 0_u16..200], limit in 0_i32..1_000,
    ) {
        let mut config = Config::recommended();
        config.shield = Some(Shielding {
            half_lobe: Bearing::from_turns(half_lobe),
            approach_mm_s,
            ..Shielding::nomad200()
        });
        let shielding = config.shield.as_ref().unwrap();
        let now = Millis::from_ms(1_000_000);
        let wanted = Displacement { dx_mm: wanted.0, dy_mm: wanted.1 };
        prop_assume!(wanted != Displacement::ZERO);
        let arcs: std::vec::Vec<Arc> = arcs.into_iter().map(|parts| arc(parts, now)).collect();
        let lobe = Lobe::of(shielding.half_lobe);
        let way = Way::new(&config, shielding, lobe, wanted, i32::from(wanted.length_mm()), now);
        let kept = arcs.iter().filter(|arc| now.since(arc.at) <= shielding.forget_ms);
        let exact = kept.fold(limit, |distance, arc| {
            arc.range.map_or(distance, |range| way.until(arc, i32::from(range.as_mm()), limit).min(distance))
        });
        prop_assert_eq!(way.until_any(&arcs, limit), exact);
    }
}

#[test]
fn who_stands_meets_nothing() {
    let config = Config::recommended();
    let mut shield = Shield::<16>::new();
    for sensor in 0..16 {
        let echo = Echo {
            range: Some(Range::from_mm(0)),
            at: Millis::from_ms(5),
        };
        shield.hear(&config, sensor, echo);
    }
    let allowed = |wanted| shield.allow(&config, wanted, Millis::from_ms(6));
    let standing = allowed(Displacement::ZERO);
    assert_eq!((standing.distance_mm, standing.speed_mm_s), (0, 507));
    assert_eq!(
        allowed(Displacement {
            dx_mm: 250,
            dy_mm: 0
        })
        .distance_mm,
        0
    );
}

/// A ring in the open; transducer 4, which looks to the left, is not believed.
#[test]
fn the_ways_along_a_blind_gap_are_closed() {
    let mut config = Config::recommended();
    let mut shield = Shield::<16>::new();
    for sensor in 0..16 {
        let echo = Echo {
            range: None,
            at: Millis::from_ms(5),
        };
        shield.hear(&config, sensor, echo);
    }
    let now = Millis::from_ms(6);
    let to = |degrees: i32| {
        let turns = (degrees * 65_536 / 360).rem_euclid(65_536) as u16;
        Displacement::along(Bearing::from_turns(turns), 250)
    };
    let distance =
        |config: &Config<16>, degrees| shield.allow(config, to(degrees), now).distance_mm;
    let open = [0, 61, 90, 119, 270].map(|degrees| distance(&config, degrees));
    assert!(open.iter().all(|mm| *mm >= 249), "{open:?}");
    config.believed = Mask::ALL.without(4);
    for degrees in [61, 75, 90, 105, 119] {
        assert_eq!(distance(&config, degrees), 0, "{degrees}");
    }
    for degrees in [0, 59, 121, 180, 270] {
        assert!(distance(&config, degrees) >= 249, "{degrees}");
    }
    // A motion that was allowed before is asked about by those who hear something new.
    let guard = shield.allow_by(&config, to(90), now, Mask::NONE.with(3));
    assert!(guard.distance_mm >= 249);
}
