use super::*;
use crate::actuation::Actuation;
use std::vec::Vec;

/// Bearings of the sensors, degrees, in no order.
const BEARINGS: [f64; 8] = [88.0, -33.0, 171.0, 5.0, -140.0, 31.0, 120.0, -75.0];
const FACE_M: f64 = 0.23;

/// A room with its walls at x = −2.1, 3.0 and y = −1.5, 2.2 m, and a wall across a part of it.
fn range_mm(x: f64, y: f64, angle: f64) -> f64 {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let (x, y) = (x + FACE_M * cos, y + FACE_M * sin);
    let to = |wall: f64, at: f64, along: f64| {
        let far = (wall - at) / along;
        if far > 0.0 { far } else { f64::INFINITY }
    };
    let walls = [
        to(-2.1, x, cos),
        to(3.0, x, cos),
        to(-1.5, y, sin),
        to(2.2, y, sin),
    ];
    let screen = to(1.4, x, cos);
    let is_hit = (0.4..2.2).contains(&(y + screen * sin));
    let nearest = walls.into_iter().fold(f64::INFINITY, f64::min);
    1e3 * if is_hit { nearest.min(screen) } else { nearest }
}

struct Rig {
    babble: Babble<8>,
    limits: BabbleLimits,
    x: f64,
    y: f64,
    heading: f64,
    dead: Vec<usize>,
    /// What the base takes for 4 096 of a length or a turn, and where it takes its front to be.
    actuation: Actuation,
    moves: u32,
    /// Nothing farther away is heard.
    reach_mm: f64,
    /// Least distance of the body from a wall of the room.
    least_gap_m: f64,
}

impl Rig {
    fn new(moves: u16, seed: u64) -> Self {
        let mut babble = Babble::new();
        babble.begin(moves, seed);
        Self {
            babble,
            limits: BabbleLimits {
                enabled: Mask::from_bits(0xFF),
                longest_mm: 250,
                margin_mm: 70,
                learns_actuation: false,
            },
            x: 0.0,
            y: 0.0,
            heading: 0.4,
            dead: Vec::new(),
            actuation: Actuation::EXACT,
            moves: 0,
            reach_mm: f64::INFINITY,
            least_gap_m: f64::INFINITY,
        }
    }

    fn listen(&mut self, is_moving: bool) -> Option<Displacement> {
        let mut next = None;
        for (sensor, bearing) in BEARINGS.into_iter().enumerate() {
            let mm = range_mm(self.x, self.y, self.heading + bearing.to_radians());
            let is_heard = !self.dead.contains(&sensor) && mm <= self.reach_mm;
            let range = is_heard.then(|| Range::from_mm(mm as u16));
            let heard = self
                .babble
                .hear(&self.limits, sensor, range, is_moving || next.is_some());
            next = heard.or(next);
        }
        next
    }

    fn report(&mut self, ahead_m: f64, turned: f64) {
        self.heading += turned;
        self.x += ahead_m * libm::cos(self.heading);
        self.y += ahead_m * libm::sin(self.heading);
        let gaps = [self.x + 2.1, 3.0 - self.x, self.y + 1.5, 2.2 - self.y];
        let gap_m = gaps.into_iter().fold(f64::INFINITY, f64::min) - FACE_M;
        self.least_gap_m = self.least_gap_m.min(gap_m);
        let told_mm = ahead_m * 1e3 * 4_096.0 / f64::from(self.actuation.length_q12);
        let moved = Displacement::along(self.actuation.front, libm::rint(told_mm) as i32);
        let told = turned * 4_096.0 / f64::from(self.actuation.turn_q12);
        let turned = Bearing::from_turns((told.to_degrees() / 360.0 * 65_536.0) as i32 as u16);
        self.babble.moved(moved, turned);
    }

    /// Turns towards each motion, listening on the way, and goes.
    fn run(&mut self) {
        while let Some(next) = self.listen(false) {
            self.moves += 1;
            let told = next.bearing().minus(self.actuation.front);
            let turn = f64::from(self.actuation.turn_q12) / 4_096.0;
            let mut left =
                turn * f64::from(told.as_signed_turns()) * core::f64::consts::PI / 32_768.0;
            while left.abs() > 1e-9 {
                let turn = left.clamp(-0.26, 0.26);
                self.report(0.0, turn);
                left -= turn;
                assert_eq!(self.listen(true), None);
            }
            let length =
                f64::from(self.actuation.length_q12) / 4_096.0 * f64::from(next.length_mm()) / 1e3;
            self.report(length, 0.0);
            self.babble.move_ended();
        }
        assert_eq!(self.babble.moves_left(), 0);
    }

    /// Errors of the sensors that work, degrees; the others must be known as dead.
    fn errors(&self) -> Vec<f64> {
        self.errors_of(&self.solve(false).bearings)
    }

    fn solve(&self, learns_actuation: bool) -> LearnedBody<8> {
        Solver::solve(self.babble.calibration(), learns_actuation)
    }

    fn errors_of(&self, solved: &[Option<Bearing>; 8]) -> Vec<f64> {
        let pairs = solved.iter().zip(BEARINGS).enumerate();
        let mut errors = Vec::new();
        for (sensor, (bearing, exact)) in pairs {
            assert_eq!(bearing.is_none(), self.dead.contains(&sensor), "{sensor}");
            if let Some(bearing) = bearing {
                let found = f64::from(bearing.as_turns()) / 65_536.0 * 360.0;
                let off = (found - exact).rem_euclid(360.0);
                errors.push(off.min(360.0 - off));
            }
        }
        errors.sort_by(f64::total_cmp);
        errors
    }
}

#[test]
fn a_body_learns_where_its_sensors_look() {
    for seed in 1..=5 {
        let mut rig = Rig::new(40, seed);
        rig.run();
        assert_eq!(rig.moves, 40);
        let errors = rig.errors();
        assert!(errors[4] <= 7.0, "{seed}: {errors:?}");
        // Relative to each other they are known better than to the body's front.
        assert!(errors[7] - errors[0] <= 4.0, "{seed}: {errors:?}");
    }
}

#[test]
fn dead_sensors_are_found_and_the_others_learned() {
    let mut rig = Rig::new(40, 3);
    rig.dead = [1, 4].into();
    rig.run();
    let errors = rig.errors();
    assert!(errors[3] <= 7.0, "{errors:?}");
}

/// The base goes ahead along 120° of its own frame, 1.25 times as far and turns 0.85 times as far
/// as it thinks.
#[test]
fn what_a_wrong_base_does_is_learned_with_the_bearings() {
    for seed in 1..=5 {
        let mut rig = Rig::new(60, seed);
        rig.actuation = Actuation {
            front: Bearing::from_turns(21_845),
            length_q12: 5_120,
            turn_q12: 3_482,
        };
        rig.limits.learns_actuation = true;
        rig.run();
        let learned = rig.solve(true);
        let front = learned.actuation.front.minus(rig.actuation.front);
        assert!(front.as_signed_turns().abs() < 200, "{seed}: {front:?}");
        let turn = f64::from(learned.actuation.turn_q12) / 3_482.0;
        assert!((turn - 1.0).abs() < 0.02, "{seed}: {turn}");
        let length = f64::from(learned.actuation.length_q12) / 5_120.0;
        assert!((length - 1.0).abs() < 0.05, "{seed}: {length}");
        let errors = rig.errors_of(&learned.bearings);
        assert!(errors[4] <= 9.0, "{seed}: {errors:?}");
    }
}

#[test]
fn nothing_is_known_without_moves() {
    let calibration = Calibration::<8>::new();
    assert_eq!(calibration.alive(), Mask::NONE);
    let learned = Solver::solve(&calibration, true);
    assert_eq!(learned.bearings, [None; 8]);
    assert_eq!(learned.actuation, Actuation::EXACT);
}

/// The nearest thing heard may stand anywhere.
#[test]
fn random_moves_end_before_the_nearest_thing() {
    let mut rig = Rig::new(200, 9);
    // In a corner: the walls stand 0.2 m from the body.
    (rig.x, rig.y) = (-2.1 + 0.43, -1.5 + 0.43);
    rig.run();
    // Two of the rays are 57° apart: between them a wall may be nearer than they hear.
    assert!(rig.least_gap_m > -0.03, "{} m", rig.least_gap_m);
}

/// In the open it goes on, and its moves do not count, but not for ever.
#[test]
fn moves_where_nothing_is_heard_do_not_count() {
    let mut rig = Rig::new(5, 3);
    rig.reach_mm = 0.0;
    for silent in 0..64 {
        let next = rig.listen(false).expect("a move");
        let aside = next.bearing().as_signed_turns().unsigned_abs();
        assert!(
            (248..=251).contains(&next.length_mm()),
            "{silent}: {next:?}"
        );
        assert!(aside <= 8_192 + 50, "{silent}: {next:?}");
        assert_eq!(rig.babble.moves_left(), 5);
        rig.babble.move_ended();
    }
    assert!(rig.listen(false).is_some());
    assert_eq!(rig.babble.moves_left(), 4);
}

/// It would end somewhere else, and tell nothing.
#[test]
fn a_turn_once_around_is_not_left_where_nothing_is_heard() {
    let mut rig = Rig::new(20, 3);
    rig.limits.learns_actuation = true;
    for _ in 0..2 {
        assert!(rig.listen(false).is_some());
        rig.babble.move_ended();
    }
    rig.reach_mm = 0.0;
    for left in (12..18).rev() {
        assert_eq!(rig.listen(false).map(Displacement::length_mm), Some(2));
        assert_eq!(rig.babble.moves_left(), left);
        rig.babble.move_ended();
    }
    // A base that goes farther than it thinks has less room.
    let next = rig.listen(false).expect("a move");
    assert!((160..=170).contains(&next.length_mm()), "{next:?}");
    assert_eq!(rig.babble.moves_left(), 12);
}

#[test]
fn two_sensors_that_hear_nothing_are_not_compared() {
    let compared = |before: Option<u16>, after: Option<u16>| {
        let mut calibration = Calibration::<8>::new();
        calibration.hear(0, before.map(Range::from_mm), Geometry::Unknown);
        calibration.moved(Displacement::ZERO, of_degrees(90.0));
        calibration.hear(1, after.map(Range::from_mm), Geometry::Unknown);
        let bins = calibration.dissimilarity.as_flattened().as_flattened();
        bins.iter().filter(|bin| bin.mean().is_some()).count()
    };
    assert_eq!(compared(None, None), 0);
    assert_eq!(compared(None, Some(900)), 1);
    assert_eq!(compared(Some(900), None), 1);
    assert_eq!(compared(Some(900), Some(900)), 1);
}

#[test]
fn a_sensor_that_hears_little_is_not_dead() {
    let mut calibration = Calibration::<8>::new();
    for mm in [700, 900, 600] {
        calibration.hear(0, Some(Range::from_mm(mm)), Geometry::Unknown);
    }
    for _ in 0..300 {
        calibration.hear(0, None, Geometry::Unknown);
        calibration.hear(1, None, Geometry::Unknown);
    }
    assert_eq!(calibration.alive(), Mask::NONE.with(0));
    // Where it is known where they look, one that falls silent has failed.
    let known = KnownBearings {
        bearings: [Some(Bearing::ZERO); 8],
        turn_q12: 4_096,
    };
    for _ in 0..300 {
        calibration.hear(0, None, Geometry::Known(&known));
    }
    assert_eq!(calibration.alive(), Mask::NONE);
}

#[test]
fn slopes_of_any_age_count() {
    let mut slopes = Slopes::<2>::NEW;
    for _ in 0..3_000 {
        slopes.note(0, 496, -255);
    }
    for _ in 0..100 {
        slopes.note(0, 496, 0);
    }
    let told: Vec<_> = slopes.of(0).collect();
    // 2 114 times 31 are halved once.
    assert_eq!(told, [(-0.525, 60_233.0), (0.025, 3_100.0)]);
    slopes.forget(0);
    assert_eq!(slopes.of(0).count(), 0);
}

#[test]
fn a_slope_is_the_change_per_travel_ahead() {
    let mut slopes = Slopes::<2>::NEW;
    let noted = [
        (-100, 50),
        (100, -160),
        // Another surface, too short, too long.
        (100, 160),
        (100, -161),
        (29, 0),
        (501, 0),
    ];
    for (ahead_mm, change_mm) in noted {
        slopes.note(1, ahead_mm, change_mm);
        slopes.note(2, ahead_mm, change_mm);
    }
    let told: Vec<_> = slopes.of(1).collect();
    assert_eq!(told, [(-1.575, 6.0), (-0.475, 6.0)]);
    assert_eq!((slopes.of(0).count(), slopes.of(2).count()), (0, 0));
}

#[test]
fn a_turn_back_is_a_turn_on_of_the_pair_exchanged() {
    for bin in 0..BINS {
        let here = place((3, 5), bin);
        assert_eq!(place((5, 3), BINS - 1 - bin), here);
        assert!(here.2 < 32);
    }
}

#[test]
fn averages_keep_their_bits_and_forget() {
    let mut average = Dissimilarity::NONE;
    assert_eq!(average.mean(), None);
    average.learn(100);
    assert_eq!(average.mean(), Some(50));
    average.learn(u16::MAX);
    assert_eq!(average.mean(), Some(64));
    for _ in 0..200 {
        average.learn(0);
    }
    assert!(average.mean() < Some(8), "{average:?}");
}

#[test]
fn what_is_learned_of_sixteen_sensors_takes_12_kilobytes() {
    assert!(size_of::<Calibration<16>>() <= 12_200);
}

#[test]
fn a_cleared_calibration_is_as_new() {
    let mut rig = Rig::new(40, 3);
    rig.run();
    rig.babble.begin(7, 2);
    let mut fresh = Babble::new();
    fresh.begin(7, 2);
    assert_eq!(rig.babble, fresh);
}

/// Each step of 16 sensors is at most 64 costs and 15 more of 15 pairs.
#[test]
fn a_solution_takes_so_many_steps() {
    let mut rig = Rig::new(40, 3);
    rig.run();
    let mut solver = Solver::new();
    solver.begin(rig.babble.calibration(), false);
    let steps = 1
        + (1..)
            .find(|_| solver.advance(rig.babble.calibration()).is_some())
            .unwrap_or(0);
    assert!((200..=600).contains(&steps), "{steps}");
    assert!(!solver.is_busy());
}

/// What is wrong with a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Wrong {
    Nothing,
    /// Sensor 3 looks elsewhere by so many degrees.
    Turned(f64),
    /// Sensor 3 reads so many times what it should.
    Scaled(f64),
    /// Sensor 5 hears nothing.
    Dead,
}

/// What a body takes for known of where its sensors look.
type Belief = for<'a> fn(&'a KnownBearings<8>) -> Geometry<'a, 8>;
const NOTHING: Belief = |_| Geometry::Unknown;
const ROUGHLY: Belief = |bearings| Geometry::Rough(bearings);
const ALL: Belief = |bearings| Geometry::Known(bearings);

/// The body spins at twenty places; as far as it knows where its sensors looked it thinks that all
/// is as ever.
fn spin(calibration: &mut Calibration<8>, wrong: Wrong, belief: Belief) {
    let bearings = BEARINGS.map(|degrees| Some(of_degrees(degrees)));
    let known = KnownBearings {
        bearings,
        turn_q12: 4_096,
    };
    for place in 0..20 {
        for step in 0..72 {
            for (sensor, degrees) in BEARINGS.into_iter().enumerate() {
                let off = match wrong {
                    Wrong::Turned(degrees) if sensor == 3 => degrees,
                    _ => 0.0,
                };
                let factor = match wrong {
                    Wrong::Scaled(factor) if sensor == 3 => factor,
                    _ => 1.0,
                };
                let heading = f64::from(step * 5 + place * 80);
                let angle = (heading + degrees + off).to_radians();
                let mm = factor * range_mm(0.05 * f64::from(place) - 0.2, 0.0, angle);
                let is_heard = sensor != 5 || wrong != Wrong::Dead;
                let range = is_heard.then(|| Range::from_mm(mm as u16));
                calibration.hear(sensor, range, belief(&known));
            }
            calibration.moved(Displacement::ZERO, of_degrees(5.0));
        }
        // On to the next place, and another heading.
        let ahead = Displacement {
            dx_mm: 50,
            dy_mm: 0,
        };
        calibration.moved(ahead, of_degrees(80.0));
    }
}

#[test]
fn a_sensor_that_tells_something_else_than_others_that_see_the_same_is_noticed() {
    let misfit = |wrong| {
        let mut calibration = Calibration::new();
        spin(&mut calibration, wrong, ALL);
        calibration.misfit(Mask::from_bits(0xFF))
    };
    assert_eq!(misfit(Wrong::Nothing), None);
    assert_eq!(misfit(Wrong::Turned(4.0)), None, "as little as it is known");
    assert_eq!(misfit(Wrong::Turned(60.0)), Some(3));
    assert_eq!(misfit(Wrong::Turned(-150.0)), Some(3));
    assert_eq!(misfit(Wrong::Dead), Some(5));
    assert_eq!(misfit(Wrong::Scaled(1.25)), None, "it is corrected");
}

#[test]
fn a_sensor_that_reads_too_much_or_too_little_is_corrected() {
    let corrected = |factor, mm| {
        let mut calibration = Calibration::new();
        for _ in 0..3 {
            spin(&mut calibration, Wrong::Scaled(factor), ALL);
        }
        let read = Range::from_mm((factor * f64::from(mm)) as u16);
        calibration.corrected(3, read).as_mm()
    };
    for (factor, mm) in [(1.25, 1_000), (1.25, 2_000), (0.8, 1_000), (0.8, 2_000)] {
        let found = corrected(factor, mm);
        assert!(found.abs_diff(mm) < mm / 8, "{factor}: {found} for {mm}");
    }
    assert_eq!(corrected(1.0, 1_000), 1_000);
    assert_eq!(corrected(1.05, 1_000), 1_050, "it may be chance");
    let nothing_heard = Calibration::<8>::new();
    let range = Range::from_mm(1_000);
    assert_eq!(nothing_heard.corrected(3, range), range);
}

/// What sensor 3 reads more than the others, in 1/512 of a logarithm, of what two of them see from
/// the same place.
#[test]
fn readings_of_unequal_sensors_are_compared_as_if_they_were_equal() {
    let dissimilarity = |factor, belief| {
        let mut calibration = Calibration::new();
        spin(&mut calibration, Wrong::Scaled(factor), belief);
        assert_eq!(calibration.misfit(Mask::from_bits(0xFF)), None);
        let others = [0, 1, 2, 4, 5, 6, 7].map(|other| {
            let turn = of_degrees(BEARINGS[other] - BEARINGS[3]);
            let cell = cell(&mut calibration.dissimilarity, (other, 3), turn);
            i32::from(cell.and_then(|cell| cell.mean()).expect("compared"))
        });
        others.iter().sum::<i32>() / 7
    };
    let equal = dissimilarity(1.0, NOTHING);
    let unequal = dissimilarity(1.4, NOTHING);
    let learned = dissimilarity(1.4, ROUGHLY);
    assert!(unequal > equal + 50, "{equal} {unequal}");
    assert!(learned < equal + 15, "{equal} {learned}");
}

#[test]
fn where_bearings_are_known_roughly_no_sensor_is_doubted() {
    let mut calibration = Calibration::new();
    spin(&mut calibration, Wrong::Turned(60.0), ROUGHLY);
    assert_eq!(calibration.misfit(Mask::from_bits(0xFF)), None);
}

#[test]
fn what_is_forgotten_of_one_sensor_is_known_of_the_others() {
    let mut calibration = Calibration::new();
    spin(&mut calibration, Wrong::Turned(60.0), ALL);
    spin(&mut calibration, Wrong::Turned(60.0), NOTHING);
    calibration.forget(3);
    assert_ne!(calibration.misfit(Mask::from_bits(0xFF)), Some(3));
    assert_eq!(calibration.alive(), Mask::from_bits(0xF7));
    let known = |[before, after]: [usize; 2]| {
        let bins = calibration.dissimilarity[before][after];
        bins.iter().any(|cell| cell.mean().is_some())
    };
    assert_eq!([[3, 0], [0, 3], [0, 1]].map(known), [false, false, true]);
    let mut readings = calibration.readings.iter();
    assert!(readings.all(|reading| reading.sensor != 3));
}

/// The others are where they are known to be, and tell where sensor 3 is now.
#[test]
fn a_sensor_that_was_moved_is_found_by_the_others() {
    let bearings = BEARINGS.map(|degrees| Some(of_degrees(degrees)));
    let mut unknown = bearings;
    unknown[3] = None;
    let mut calibration = Calibration::new();
    spin(&mut calibration, Wrong::Turned(60.0), NOTHING);
    let known = KnownBearings {
        bearings: unknown,
        turn_q12: 4_096,
    };
    let mut solver = Solver::new();
    solver.begin_with(&calibration, &known);
    let found = core::iter::repeat_with(|| solver.advance(&calibration)).find_map(|found| found);
    let found = found.expect("it ends").bearings;
    let off = found[3]
        .expect("alive")
        .minus(of_degrees(BEARINGS[3] + 60.0));
    assert!(off.as_signed_turns().abs() < 546, "{off:?}");
    assert_eq!(found.iter().flatten().count(), 1, "the others are known");
}

fn of_degrees(degrees: f64) -> Bearing {
    Bearing::from_turns((degrees / 360.0 * 65_536.0) as i32 as u16)
}
