use super::*;
use crate::controller::Progress;
use std::vec::Vec;

/// Steps of a long way. Miri takes some thousand times as long.
const LONG: u32 = if cfg!(miri) { 20 } else { 5_000 };

/// A robot that goes on and on; each transducer has its own thing before it, now nearer, now
/// farther.
struct Walk {
    detector: Detector<16>,
    config: Config<16>,
    step: u32,
    /// It goes to and fro between two places instead.
    to_and_fro: bool,
}

/// What a transducer in good order hears after so many steps of 250 mm: a range between 1.5 and 2.2
/// m that changes by half the way.
fn heard(sensor: u32, step: u32) -> Option<Range> {
    let phase = (step * 125 + sensor * 450) % 1_400;
    mm(1_500 + phase.min(1_400 - phase) as u16)
}

fn mm(mm: u16) -> Option<Range> {
    Some(Range::from_mm(mm))
}

impl Walk {
    fn new() -> Self {
        let mut config = Config::recommended();
        config.fault_detection = true;
        Self {
            detector: Detector::new(),
            config,
            step: 0,
            to_and_fro: false,
        }
    }

    fn moved(&mut self, dx_mm: i32, dy_mm: i32, progress: Progress) {
        let moved = Displacement::saturating(dx_mm, dy_mm);
        if progress == Progress::Touched {
            self.detector.touched(&self.config, moved);
        }
        self.detector.moved(&self.config, moved, Bearing::ZERO);
    }

    /// Steps with a ring after each; `says` gives what each transducer says, told what it should.
    fn walk(
        &mut self,
        steps: u32,
        says: impl Fn(u8, u32, Option<Range>) -> Option<Range>,
    ) -> Vec<(u32, SensorVerdict)> {
        let mut verdicts = Vec::new();
        for _ in 0..steps {
            let back = self.to_and_fro && self.step % 2 == 1;
            self.step += 1;
            self.moved(
                if back { -250 } else { 250 },
                if back { -30 } else { 30 },
                Progress::Ended,
            );
            for sensor in 0..16 {
                let range = heard(sensor.into(), self.step);
                let said = says(sensor, self.step, range);
                let verdict = self.detector.update(&self.config, sensor, said);
                verdicts.extend(verdict.map(|verdict| (self.step, verdict)));
            }
        }
        verdicts
    }

    /// The same where only transducer 3 says something else.
    fn walk_with(
        &mut self,
        steps: u32,
        says: impl Fn(u32, Option<Range>) -> Option<Range>,
    ) -> Vec<(u32, SensorVerdict)> {
        self.walk(steps, |sensor, step, range| match sensor {
            3 => says(step, range),
            _ => range,
        })
    }

    fn enabled(&self) -> Mask {
        self.detector.enabled(&self.config)
    }

    fn in_order(&mut self, steps: u32) -> Vec<(u32, SensorVerdict)> {
        self.walk(steps, |_, _, range| range)
    }
}

fn verdict(fault: SensorFault) -> SensorVerdict {
    SensorVerdict {
        sensor: 3,
        fault: Some(fault),
    }
}

const BELIEVED: SensorVerdict = SensorVerdict {
    sensor: 3,
    fault: None,
};

/// The only verdict on a transducer that was in good order for 20 steps.
fn found(says: impl Fn(u32, Option<Range>) -> Option<Range>) -> Option<SensorFault> {
    let mut walk = Walk::new();
    assert_eq!(walk.in_order(20), []);
    let verdicts = walk.walk_with(300, says);
    let [(_, verdict)] = verdicts[..] else {
        panic!("{verdicts:?}");
    };
    assert_eq!(verdict.sensor, 3);
    assert!(!walk.enabled().contains(3) && walk.enabled().contains(4));
    verdict.fault
}

#[test]
#[cfg_attr(miri, ignore = "a long way: minutes")]
fn every_kind_of_fault_is_found_and_named() {
    assert_eq!(found(|_, _| None), Some(SensorFault::Dead));
    assert_eq!(found(|_, _| mm(1_750)), Some(SensorFault::Stuck));
    let jump = |step: u32, _| mm((step.wrapping_mul(2_654_435_761) >> 20) as u16 + 200);
    assert_eq!(found(jump), Some(SensorFault::Jumping));
    // Right changes, 1.1 m too near.
    let near = |_, range: Option<Range>| mm(range.map_or(0, Range::as_mm) - 1_100);
    assert_eq!(found(near), Some(SensorFault::Short));
}

#[test]
fn a_ring_in_order_is_believed() {
    let mut walk = Walk::new();
    assert_eq!(walk.in_order(LONG), []);
    assert_eq!(walk.enabled(), Mask::ALL);
}

/// A thing in the lobe's way half of the time, and nothing the other half.
#[test]
#[cfg_attr(miri, ignore = "a long way: minutes")]
fn one_that_hears_now_and_then_is_believed() {
    let mut walk = Walk::new();
    let rare = |step: u32, range: Option<Range>| range.filter(|_| step.is_multiple_of(8));
    assert_eq!(
        walk.walk_with(LONG, rare),
        [(2, verdict(SensorFault::Unheard)), (8, BELIEVED)]
    );
}

#[test]
#[cfg_attr(miri, ignore = "a long way: minutes")]
fn the_same_place_again_proves_nothing() {
    for says in [None, mm(1_750)] {
        let mut walk = Walk::new();
        assert_eq!(walk.in_order(2), []);
        walk.to_and_fro = true;
        assert_eq!(walk.walk_with(LONG, |_, _| says), []);
    }
}

#[test]
#[cfg_attr(miri, ignore = "a long way: minutes")]
fn who_was_never_heard_is_not_believed_before_the_first_echo() {
    let mut walk = Walk::new();
    let dead = walk.walk_with(300, |_, _| None);
    let [(first, unheard), (later, named)] = dead[..] else {
        panic!("{dead:?}");
    };
    assert_eq!(
        (unheard, named),
        (verdict(SensorFault::Unheard), verdict(SensorFault::Dead))
    );
    assert!(first <= 2 && later > 60, "{first} {later}");
    assert_eq!(walk.in_order(1), [(301, BELIEVED)]);
    assert_eq!(walk.enabled(), Mask::ALL);
}

/// In a wide place where only the nearer half of the ring hears anything, everybody is believed but
/// those at its edge.
#[test]
#[cfg_attr(miri, ignore = "a long way: minutes")]
fn silence_among_the_silent_is_no_fault() {
    let mut walk = Walk::new();
    let half = |sensor, _, range: Option<Range>| range.filter(|_| sensor < 8);
    assert_eq!(walk.walk(300, half), []);
}

#[test]
fn who_hears_nothing_where_the_robot_touches_something_is_dead() {
    let mut walk = Walk::new();
    assert_eq!(walk.in_order(20), []);
    assert_eq!(walk.walk_with(1, |_, _| None), []);
    // Transducer 3 looks 67.5° to the left.
    for _ in 0..2 {
        walk.moved(40, 90, Progress::Touched);
    }
    assert_eq!(walk.detector.scores(3).silent, LIMIT);
    assert_eq!(walk.detector.scores(4).silent, 0, "it hears something");
    let verdicts = walk.walk_with(1, |_, _| None);
    assert_eq!(verdicts, [(22, verdict(SensorFault::Dead))]);
    // Where nobody is silent a touch proves nothing.
    let mut walk = Walk::new();
    assert_eq!(walk.in_order(20), []);
    for _ in 0..20 {
        walk.moved(40, 90, Progress::Touched);
    }
    assert_eq!(walk.in_order(1), []);
}

#[test]
#[cfg_attr(miri, ignore = "a long way: minutes")]
fn without_detection_and_without_moves_nothing_is_found() {
    let mut walk = Walk::new();
    walk.config.fault_detection = false;
    assert_eq!(walk.walk_with(400, |_, _| mm(700)), []);
    let mut walk = Walk::new();
    for step in 0..LONG {
        for sensor in 0..16 {
            let range = heard(sensor.into(), step).filter(|_| sensor != 3 || step == 0);
            assert_eq!(walk.detector.update(&walk.config, sensor, range), None);
        }
    }
    assert_eq!(walk.detector.scores(3), Scores::default());
    assert_eq!(walk.detector.update(&walk.config, 99, None), None);
}

#[test]
#[cfg_attr(miri, ignore = "a long way: minutes")]
fn one_that_behaves_again_is_believed_again() {
    for says in [None, mm(1_750), mm(300)] {
        let mut walk = Walk::new();
        assert_eq!(walk.in_order(20), []);
        assert_eq!(walk.walk_with(300, |_, _| says).len(), 1);
        let back = walk.in_order(400);
        assert!(
            matches!(back[..], [(_, verdict)] if verdict == BELIEVED),
            "{says:?}: {back:?}"
        );
        assert_eq!(walk.enabled(), Mask::ALL);
    }
}

#[test]
#[cfg_attr(miri, ignore = "a long way: minutes")]
fn somebody_elses_word_counts_more() {
    let mut walk = Walk::new();
    walk.config.enabled = Mask::ALL.without(3);
    assert_eq!(
        walk.walk_with(400, |_, _| mm(700)),
        [],
        "disbelieved already"
    );
    assert!(!walk.enabled().contains(3), "and not enabled again");
    let mut walk = Walk::new();
    assert!(!walk.walk_with(300, |_, _| mm(700)).is_empty());
    let before = walk.detector.clone();
    walk.detector.trust(Mask::ALL.without(3));
    assert!(
        walk.detector == before,
        "nothing is forgotten of the others"
    );
    assert!(!walk.enabled().contains(3));
    walk.detector.trust(Mask::NONE.with(3));
    assert_eq!(walk.detector.heard, before.heard & !bit(3));
    assert_eq!(walk.walk_with(2, |_, _| mm(700)), [], "it starts anew");
    assert!(walk.enabled().contains(3));
    // Without detection the mask is what was configured.
    assert!(!walk.walk_with(300, |_, _| mm(700)).is_empty() && walk.enabled() != Mask::ALL);
    walk.config.fault_detection = false;
    assert_eq!(walk.enabled(), Mask::ALL);
}

#[test]
#[cfg_attr(miri, ignore = "a long way: minutes")]
fn no_more_than_a_quarter_of_the_ring_is_disbelieved() {
    let mut walk = Walk::new();
    let stuck = |sensor: u8, _, range| match sensor % 2 {
        0 => mm(1_750),
        _ => range,
    };
    assert_eq!(walk.walk(400, stuck).len(), 4);
    let off = (0..16).filter(|&sensor| !walk.enabled().contains(sensor));
    assert_eq!(off.count(), 4);
}

/// Of a ring that hears nothing at every other place, half is not believed.
#[test]
fn no_more_than_half_of_the_ring_waits_for_its_first_echo() {
    let mut walk = Walk::new();
    let silent = |sensor: u8, _, range: Option<Range>| range.filter(|_| sensor % 2 == 1);
    let verdicts = walk.walk(20, silent);
    assert_eq!(verdicts.len(), 8);
    assert!(
        verdicts
            .iter()
            .all(|(_, verdict)| verdict.fault == Some(SensorFault::Unheard))
    );
}

/// The ring turns with the heading: places are still places, but no range is compared with one
/// before the turn.
#[test]
#[cfg_attr(miri, ignore = "a long way: minutes")]
fn turns_keep_the_places_and_forget_the_ranges() {
    let mut walk = Walk::new();
    assert_eq!(walk.in_order(20), []);
    let mut turned = 0;
    for quarter in 0..400_u16 {
        let moved = Displacement::saturating(250, 0);
        walk.detector
            .moved(&walk.config, moved, Bearing::from_turns(16_384));
        turned += 1;
        for sensor in 0..16 {
            let range = if sensor == 3 {
                None
            } else {
                heard(sensor.into(), quarter.into())
            };
            let verdict = walk.detector.update(&walk.config, sensor, range);
            assert_eq!(verdict, None, "{turned}");
        }
    }
    // Round and round the same four places.
    assert!(walk.detector.scores(3).silent < 8);
}

#[test]
fn the_detector_takes_308_bytes() {
    assert_eq!(size_of::<Detector<16>>(), 308);
}

fn said(mm: Option<u16>) -> RangeReading {
    RangeReading::new(mm.map(Range::from_mm))
}

#[test]
fn two_words_differ_by_a_tenth_of_a_meter_or_by_silence() {
    let is_other = |a: RangeReading, b: RangeReading| a.is_other_than(b);
    assert!(
        is_other(said(Some(500)), said(Some(600))) && is_other(said(Some(600)), said(Some(500)))
    );
    assert!(!is_other(said(Some(500)), said(Some(599))));
    assert!(is_other(said(None), said(Some(500))) && !is_other(said(None), said(None)));
    for known in [said(None), said(Some(500))] {
        assert!(!is_other(RangeReading::UNKNOWN, known) && !is_other(known, RangeReading::UNKNOWN));
    }
    assert_eq!(
        (said(Some(0)).range_mm(), said(None).range_mm()),
        (Some(0), None)
    );
}

/// A record that has been told these words, after a look with everybody in order.
fn looked(before: Option<u16>, scores: Scores, now: Option<u16>, look: &Look) -> Scores {
    let mut record = SensorRecord {
        latest: said(now),
        looked: said(before),
        sides: [said(Some(5_000)); 2],
        scores,
        ..SensorRecord::NEW
    };
    record.look(look);
    record.scores
}

/// 200 mm on, at a new place, where both neighbors say something else than before.
const NEW: Look = Look {
    sides: [
        RangeReading(2_000 + RangeReading::LEAST),
        RangeReading(2_100 + RangeReading::LEAST),
    ],
    way: 200,
    is_new: true,
    doubted: false,
};

const TEN: Scores = Scores {
    silent: 10,
    still: 10,
    jumps: 10,
    short: 10,
};

#[test]
fn silence_counts_by_what_the_farther_neighbor_hears() {
    let silent = |mm: u16, is_new| {
        let sides = [said(Some(mm)), said(Some(300))];
        looked(
            Some(900),
            TEN,
            None,
            &Look {
                sides,
                is_new,
                ..NEW
            },
        )
        .silent
    };
    let found = [999, 1_000, 2_999, 3_000].map(|mm| silent(mm, true));
    assert_eq!(found, [14, 11, 11, 10]);
    assert_eq!(silent(500, false), 10, "a place seen before");
    let one = Look {
        sides: [said(Some(500)), said(None)],
        ..NEW
    };
    assert_eq!(
        looked(Some(900), TEN, None, &one).silent,
        10,
        "one neighbor is no witness"
    );
    // An echo ends it at once, or step by step for one that is not believed.
    assert_eq!(looked(Some(900), TEN, Some(900), &NEW).silent, 0);
    let doubted = Look {
        doubted: true,
        ..NEW
    };
    let deep = Scores { silent: 50, ..TEN };
    assert_eq!(looked(Some(900), deep, Some(900), &doubted).silent, 30);
}

#[test]
fn a_range_that_stands_still_counts_where_the_neighbors_change() {
    let still = |now: u16, look: &Look| looked(Some(2_000), TEN, Some(now), look).still;
    let found = [2_000, 2_013, 1_987, 2_014, 1_986].map(|now| still(now, &NEW));
    assert_eq!(found, [18, 18, 18, 0, 0]);
    assert_eq!(
        still(
            2_000,
            &Look {
                is_new: false,
                ..NEW
            }
        ),
        10
    );
    // One of the neighbors stands still as well.
    let sides = [said(Some(5_050)), said(Some(2_100))];
    assert_eq!(still(2_000, &Look { sides, ..NEW }), 10);
    let doubted = Look {
        doubted: true,
        ..NEW
    };
    assert_eq!(still(3_000, &doubted), 2, "not believed: step by step");
    assert_eq!(
        looked(Some(2_000), TEN, None, &NEW).still,
        0,
        "silence is not what it said before"
    );
}

#[test]
fn a_jump_is_more_than_the_way_and_what_is_loose() {
    let jumps = |now: u16, look: &Look| looked(Some(1_600), TEN, Some(now), look).jumps;
    // 200 of way, 50, and a sixteenth of the greater range: of 1600 that is 100, of 1973 it is 123.
    let found = [1_250, 1_249, 1_973, 1_974].map(|now| jumps(now, &NEW));
    assert_eq!(found, [2, 15, 2, 15]);
    let known = Look {
        is_new: false,
        ..NEW
    };
    assert_eq!((jumps(1_249, &known), jumps(1_250, &known)), (10, 2));
    let doubted = Look {
        doubted: true,
        ..known
    };
    assert_eq!(
        jumps(1_250, &doubted),
        10,
        "one that is not believed has to prove it at new places"
    );
    assert_eq!(
        looked(None, TEN, Some(1_249), &NEW).jumps,
        10,
        "nothing to compare with"
    );
}

#[test]
fn a_range_is_short_below_four_fifths_and_by_more_than_three_tenths_of_a_meter() {
    let short = |now: u16, nearest: u16| {
        let sides = [said(Some(nearest)), said(Some(nearest + 700))];
        looked(None, TEN, Some(now), &Look { sides, ..NEW }).short
    };
    assert_eq!((short(1_599, 2_000), short(1_600, 2_000)), (14, 6));
    assert_eq!((short(699, 1_000), short(700, 1_000)), (14, 6));
    let one = Look {
        sides: [said(Some(2_000)), said(None)],
        ..NEW
    };
    assert_eq!(looked(None, TEN, Some(300), &one).short, 10);
}

#[test]
fn scores_stop_at_the_limit_and_name_the_fault() {
    let most = Scores {
        silent: LIMIT,
        still: LIMIT,
        jumps: LIMIT - 1,
        short: LIMIT - 1,
    };
    let after = looked(
        None,
        Scores {
            silent: LIMIT - 1,
            ..most
        },
        None,
        &Look {
            sides: [said(Some(10)); 2],
            ..NEW
        },
    );
    assert_eq!(after.silent, LIMIT);
    let none = Scores::default();
    let fault = |scores: Scores| scores.fault(true);
    assert_eq!(fault(most), Some(SensorFault::Dead));
    assert_eq!(
        fault(Scores {
            still: LIMIT,
            ..none
        }),
        Some(SensorFault::Stuck)
    );
    assert_eq!(
        fault(Scores {
            jumps: LIMIT,
            ..none
        }),
        Some(SensorFault::Jumping)
    );
    assert_eq!(
        fault(Scores {
            short: LIMIT,
            ..none
        }),
        Some(SensorFault::Short)
    );
    let below = Scores {
        silent: LIMIT - 1,
        still: LIMIT - 1,
        jumps: LIMIT - 1,
        short: LIMIT - 1,
    };
    assert_eq!((fault(below), below.worst()), (None, LIMIT - 1));
    assert_eq!(
        (below.fault(false), none.fault(false)),
        (Some(SensorFault::Unheard), None)
    );
    for worst in [
        Scores { short: 3, ..none },
        Scores { still: 3, ..none },
        Scores { jumps: 3, ..none },
    ] {
        assert_eq!(worst.worst(), 3);
    }
}

#[test]
fn cells_are_known_when_they_have_been_left_and_on_a_torus_of_four_meters() {
    let mut places = VisitedCells::NEW;
    let mut enter = |x_mm, y_mm| {
        places.enter(x_mm, y_mm);
        places.is_known
    };
    assert!(!enter(255, 255), "the cell it begins in");
    assert!(!enter(256, 0) && enter(255, 0), "and back");
    assert!(!enter(0, -1) && enter(0, 0));
    assert!(
        !enter(-1, 0) && enter(0, 255) && enter(3_840, 0),
        "before the first is the last"
    );
    assert!(enter(4_096, 4_096), "round the torus");
    // Row by row: half of the cells can be kept, then all is new.
    let mut places = VisitedCells::NEW;
    let cell = |index: i16| (256 * (index % 16), 256 * (index / 16));
    for index in 0..=128 {
        let (x, y) = cell(index);
        places.enter(x, y);
    }
    places.enter(0, 0);
    assert!(!places.is_known, "with the 129th all were forgotten");
    let mut places = VisitedCells::NEW;
    for index in 0..128 {
        let (x, y) = cell(index);
        places.enter(x, y);
    }
    places.enter(0, 0);
    assert!(places.is_known);
}

/// Touched straight ahead: transducers up to 34° from there that hear nothing are under suspicion.
#[test]
fn a_touch_asks_those_who_look_there() {
    let mut walk = Walk::new();
    for sensor in 0..16 {
        let _ = walk.detector.update(&walk.config, sensor, None);
    }
    walk.moved(100, 0, Progress::Touched);
    let silent = |walk: &Walk| {
        (0..16)
            .filter(|s| walk.detector.scores(*s).silent > 0)
            .collect::<Vec<_>>()
    };
    assert_eq!(silent(&walk), [0, 1, 15]);
    assert_eq!(walk.detector.scores(0).silent, TOUCH_WEIGHT);
    walk.moved(0, 0, Progress::Touched);
    assert_eq!(silent(&walk), [0, 1, 15], "no way, no direction");
    assert_eq!(Detector::<16>::default(), Detector::new());
    assert_eq!(walk.detector.scores(16), Scores::default());
}
