//! A robot that was set down elsewhere and turned.

use super::lost::{CLOSET, HOME};
use super::*;
use crate::places::guess::Transform;
use std::boxed::Box;
use std::vec::Vec;

impl<const RECORDS: usize> Walker<'_, RECORDS> {
    /// It takes its front to be farther to the left by this from now on: in its frame the world
    /// has turned.
    fn turn(&mut self, turn: Bearing) {
        let angle = f64::from(turn.as_turns()) / 65_536.0 * core::f64::consts::TAU;
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        let turned = |x: f64, y: f64| (x * cos - y * sin, x * sin + y * cos);
        let before = self.position();
        let walls = self.walls.iter().map(|[ax, ay, bx, by]| {
            let ((ax, ay), (bx, by)) = (turned(*ax, *ay), turned(*bx, *by));
            [ax, ay, bx, by]
        });
        self.walls = Box::leak(Vec::from_iter(walls).into_boxed_slice());
        self.points.turn_frame(turn);
        // Its beams are given in its frame.
        self.points.correct_heading(Bearing::ZERO.minus(turn));
        self.stand_at(turned(before.0, before.1));
    }

    pub(super) fn turn_by(&mut self, degrees: f64) {
        let turns = (degrees / 360.0 * 65_536.0) as i32;
        self.turn(Bearing::from_turns(turns as u16));
    }

    /// A decision and its step; the leg, if there is one.
    fn step_turned(&mut self, aim: Aim) -> Option<Leg> {
        self.hear();
        let position = self.position();
        let aim = self.places.aim_while_lost(aim, &self.goal);
        let leg = self.think(Purpose::Lead(aim));
        self.stand_at(position);
        let turn = self.places.take_turn();
        self.turn(turn);
        if turn.as_signed_turns().unsigned_abs() > 1_000 {
            // It thinks again.
            return leg;
        }
        let step = leg?.way.shortened(250);
        // It goes beside what is in its way.
        let aside = [0, 1, 7, 2, 6].map(|eighth| Bearing::of_place(eighth, 8).direction());
        let mut steps = aside.map(|aside| step.rotated(aside)).into_iter();
        if let Some(step) = steps.find(|step| !self.would_touch(*step)) {
            self.points.moved(&PointLimits::NOMAD, step, Bearing::ZERO);
            self.places.moved(step);
        }
        leg
    }

    /// How far it is from where it thinks it is, and by how much it faces elsewhere, degrees.
    fn error(&self, start: (f64, f64)) -> (f64, f64) {
        // The first wall leads along the x axis.
        let [ax, ay, bx, by] = self.walls[0];
        let angle = libm::atan2(by - ay, bx - ax);
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        let start = (start.0 * cos - start.1 * sin, start.0 * sin + start.1 * cos);
        let off_mm = libm::hypot(self.start.0 - start.0, self.start.1 - start.1);
        (off_mm, angle.to_degrees().abs())
    }
}

const START: (f64, f64) = (-1_000.0, -1_400.0);

/// Has been everywhere, without a compass.
pub(super) fn who_knows() -> Walker<'static> {
    let mut walker = Walker::<256>::new(&CLOSET, START);
    while walker.step_turned(Aim::Frontier).is_some() {}
    let (off_mm, off_deg) = walker.error(START);
    assert!(off_mm < 120.0 && off_deg < 3.0, "{off_mm} {off_deg}");
    walker
}

/// Such a one was set down there, turned.
fn set_down(x: f64, y: f64, degrees: f64) -> Walker<'static> {
    let mut walker = who_knows();
    walker.set_down(x, y);
    walker.turn_by(degrees);
    walker
}

#[test]
fn it_finds_out_where_it_is_and_which_way_it_faces_and_goes_home() {
    for (x, y, degrees) in [
        (1_500.0, 1_500.0, 90.0),
        (800.0, -1_000.0, -120.0),
        (-1_400.0, 900.0, 200.0),
        (1_500.0, 0.0, 30.0),
    ] {
        finds_itself(&mut set_down(x, y, degrees), degrees);
    }
}

/// One that was set down finds out where it is and which way it faces.
pub(super) fn finds_itself(walker: &mut Walker<'_>, degrees: f64) {
    let mut steps = 0;
    while walker.places.lost.first_uncertain().is_some() {
        walker.step_turned(HOME);
        steps += 1;
        assert!(steps < 300, "{degrees}: {:?}", walker.error(START));
    }
    let (off_mm, off_deg) = walker.error(START);
    assert!(
        off_mm < 150.0 && off_deg < 4.0,
        "{degrees}: {off_mm} mm, {off_deg}°"
    );
}

#[test]
fn slices_of_any_length_find_the_same_heading() {
    let [one, other] = [1, u16::MAX].map(|slice| {
        let mut walker = set_down(800.0, -1_000.0, 120.0);
        walker.slice = slice;
        for _ in 0..20 {
            walker.step_turned(HOME);
        }
        assert!(walker.places.compass.is_aligned());
        walker.places
    });
    assert_eq!(one, other);
}

#[test]
fn who_has_been_everywhere_and_found_nothing_looks_for_its_heading_anew() {
    let mut walker = set_down(800.0, -1_000.0, 120.0);
    let mut aligned = Vec::new();
    // What it perceives fits nowhere.
    for _ in 0..500 {
        walker.places.lost.guesses.clear();
        walker.step_turned(HOME);
        aligned.push(walker.places.compass.is_aligned());
    }
    let changes = aligned.windows(2).filter(|pair| pair[0] != pair[1]).count();
    assert!(!aligned[0]);
    assert!(changes >= 3, "{changes}");
}

#[test]
fn who_has_found_nothing_for_30_m_looks_for_its_heading_anew() {
    let mut walker = set_down(800.0, -1_000.0, 120.0);
    while !walker.places.compass.is_aligned() {
        walker.step_turned(HOME);
    }
    for (way_m, is_aligned) in [(29, true), (30, false)] {
        let before = walker.places.lost.clone();
        for _ in 0..way_m {
            walker.places.moved(to(500, 0));
            walker.places.moved(to(-500, 0));
        }
        walker.places.lost.guesses.clear();
        walker.think(Purpose::Perceive);
        assert_eq!(walker.places.compass.is_aligned(), is_aligned, "{way_m} m");
        walker.places.lost = before;
    }
}

#[test]
fn who_gets_a_compass_compares_what_it_perceives_at_once() {
    let mut walker = set_down(800.0, -1_000.0, 0.0);
    walker.step_turned(HOME);
    assert!(walker.places.lost.guesses.is_empty());
    walker.places.trust_heading(true);
    walker.step_turned(HOME);
    assert!(!walker.places.lost.guesses.is_empty());
}

#[test]
fn who_is_not_certain_at_its_goal_goes_away_and_back_three_times() {
    for has_compass in [false, true] {
        let mut walker = set_down(800.0, -1_000.0, 0.0);
        walker.places.trust_heading(has_compass);
        walker.places.lost.believes = true;
        walker.places.here = Displacement::ZERO;
        let goal = walker.goal;
        let mut aims = Vec::new();
        for _ in 0..10 {
            let aim = walker.places.aim_while_lost(HOME, &goal);
            let Aim::Position(end) = aim else {
                panic!("{aim:?}");
            };
            aims.push(end);
            walker.places.here = end;
        }
        let farthest = walker.places.positions().map(Displacement::length_mm).max();
        let away = aims.iter().filter(|end| Some(end.length_mm()) == farthest);
        let expected = if has_compass { 0 } else { 3 };
        assert_eq!(away.count(), expected);
        let home = aims.iter().filter(|end| **end == Displacement::ZERO);
        assert_eq!(home.count(), 10 - expected);
    }
}

#[test]
fn a_guess_stays_where_it_is_when_another_one_is_believed() {
    let all = (0..4).map(|quarters| Transform {
        quarters,
        shift: to(700 * i16::from(quarters), -300),
    });
    let here = to(120, 450);
    for believed in all.clone() {
        for guess in all.clone() {
            let left = guess.after(&believed);
            assert_eq!(left.apply(believed.apply(here)), guess.apply(here));
            assert_eq!((believed.quarters + left.quarters) % 4, guess.quarters);
        }
        assert!(believed.after(&believed) == Transform::IDENTITY);
        let taking = Transform::taking(here, believed.apply(here), believed.quarters);
        assert!(taking == believed);
    }
    // To the left: ahead becomes to the left.
    assert_eq!(to(200, 100).turned_left(1), to(-100, 200));
}
