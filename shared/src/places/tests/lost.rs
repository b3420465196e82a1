//! A robot that was set down elsewhere.

use super::*;
use crate::places::guess::{Guess, Transform};
use crate::places::lost::Lost;

/// Two rooms that are mirror images of each other but for a closet.
pub(super) const CLOSET: [[f64; 4]; 7] = [
    TWO_ROOMS[0],
    TWO_ROOMS[1],
    TWO_ROOMS[2],
    TWO_ROOMS[3],
    TWO_ROOMS[4],
    [1_200.0, -2_000.0, 1_200.0, -1_200.0],
    [1_200.0, -1_200.0, 2_000.0, -1_200.0],
];
pub(super) const HOME: Aim = Aim::Position(Displacement::ZERO);

/// Has been everywhere. It pursues something that was perceived nowhere.
pub(super) fn who_knows(walls: &Walls) -> Walker<'_, 256> {
    let mut walker = Walker::<256>::new(walls, (-1_000.0, -1_400.0));
    walker.places.trust_heading(true);
    while walker.step(Aim::Frontier).is_some() {}
    walker
}

impl<const RECORDS: usize> Walker<'_, RECORDS> {
    pub(super) fn set_down(&mut self, x: f64, y: f64) {
        self.points.forget();
        self.places.set_down();
        self.stand_at((x, y));
    }

    /// What it thinks of its position does not move it.
    pub(super) fn stand_at(&mut self, (x, y): (f64, f64)) {
        let here = self.places.here();
        self.start = (x - f64::from(here.dx_mm), y - f64::from(here.dy_mm));
    }

    /// A decision and its step.
    pub(super) fn step_lost(&mut self, aim: Aim) -> Option<Leg> {
        self.hear();
        let position = self.position();
        let aim = self.places.aim_while_lost(aim, &self.goal);
        let leg = self.think(Purpose::Lead(aim));
        self.stand_at(position);
        let step = leg?.way.shortened(250);
        self.points.moved(&PointLimits::NOMAD, step, Bearing::ZERO);
        self.places.moved(step);
        assert!(self.clearance_mm() > BODY_MM, "it touches the wall");
        leg
    }

    /// How far it is from where it thinks it is, in the frame of a start at this position.
    pub(super) fn error_mm(&self, (x, y): (f64, f64)) -> f64 {
        libm::hypot(self.start.0 - x, self.start.1 - y)
    }
}

#[test]
fn it_finds_out_where_it_is_and_goes_home() {
    for (x, y) in [(1_500.0, 1_500.0), (800.0, -1_000.0), (-1_400.0, 900.0)] {
        let mut walker = who_knows(&CLOSET);
        let known = walker.places.positions().len() as u16;
        walker
            .places
            .begin(ENCODING, walker.view(), Purpose::Perceive);
        walker.set_down(x, y);
        assert!(!walker.places.is_thinking());
        assert_eq!(walker.places.aside(), Some((walker.places.here(), known)));
        goes_home(&mut walker);
    }
}

/// One that was set down finds out where it is, and goes home.
pub(super) fn goes_home(walker: &mut Walker<'_, 256>) {
    let start = (-1_000.0, -1_400.0);
    let mut steps = 0;
    while walker.places.aside().is_some() {
        walker.step_lost(HOME);
        steps += 1;
        assert!(steps < 30, "{:?}", walker.start);
    }
    assert!(walker.error_mm(start) < 120.0, "{:?}", walker.start);
    while walker
        .step_lost(HOME)
        .is_some_and(|leg| !leg.is_last || leg.way != Displacement::ZERO)
    {
        steps += 1;
        assert!(steps < 90, "{:?}", walker.start);
    }
    assert!(walker.error_mm(start) < 60.0, "{:?}", walker.start);
    assert!(walker.places.lost.first_uncertain().is_none());
}

#[test]
fn slices_of_any_length_find_the_same() {
    let [one, other] = [1, u16::MAX].map(|slice| {
        let mut walker = who_knows(&CLOSET);
        walker.set_down(800.0, -1_000.0);
        walker.slice = slice;
        for _ in 0..12 {
            walker.step_lost(HOME);
        }
        walker.places
    });
    assert_eq!(one, other);
}

#[test]
fn where_it_has_never_been_it_drives_around_and_looks_for_the_situation_then() {
    const CORRIDOR: [[f64; 4]; 4] = [
        [-3_500.0, -600.0, 3_500.0, -600.0],
        [3_500.0, -600.0, 3_500.0, 600.0],
        [3_500.0, 600.0, -3_500.0, 600.0],
        [-3_500.0, 600.0, -3_500.0, -600.0],
    ];
    let walker = &mut Walker {
        walls: &CORRIDOR,
        ..who_knows(&TWO_ROOMS)
    };
    walker.set_down(0.0, 0.0);
    let aim = |walker: &mut Walker<'_>| walker.places.aim_while_lost(HOME, &walker.goal);
    assert_eq!(aim(walker), Aim::Frontier);
    let mut steps = 0;
    while aim(walker) == Aim::Frontier {
        walker.step_lost(HOME);
        assert!(walker.places.aside().is_some());
        steps += 1;
        assert!(steps < 400);
    }
    assert_eq!(aim(walker), Aim::Situation);
    let avoid = Goal {
        progress_q16: 1,
        ..walker.goal
    };
    assert_eq!(walker.places.aim_while_lost(HOME, &avoid), Aim::Frontier);
}

#[test]
fn with_few_places_it_begins_anew() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    walker.go_to(to(0, 1_500));
    walker.set_down(1_000.0, 0.0);
    assert_eq!(walker.places.positions().len(), 0);
    assert_eq!(walker.places.aside(), None);
    let goal = walker.goal;
    assert_eq!(walker.places.aim_while_lost(HOME, &goal), Aim::Situation);
    // A position counts from where it was set down.
    let avoid = Goal {
        progress_q16: 1,
        ..goal
    };
    assert_eq!(walker.places.aim_while_lost(HOME, &avoid), HOME);
    walker.places.forget();
    assert_eq!(walker.places.aim_while_lost(HOME, &goal), HOME);
}

/// One guess that the robot is where it thinks it is, with this score, and another one.
fn believing(score: i16, other: i16) -> Places<16, 256> {
    let mut places = who_knows(&CLOSET).places;
    places.set_down();
    places.lost.believes = true;
    let guesses = [(to(0, 0), score), (to(900, 0), other)].into_iter();
    let guess = |(shift, score)| Guess {
        transform: Transform { quarters: 0, shift },
        score,
    };
    places.lost.guesses = guesses.map(guess).collect();
    places.believe();
    places
}

#[test]
fn a_belief_is_kept_until_it_is_wrong_or_certain() {
    let is_certain = |places: &Places<16, 256>| places.lost == Lost::NOT;
    assert!(is_certain(&believing(400, 260)));
    for (score, other) in [(390, 0), (400, 280), (-90, 0)] {
        let kept = believing(score, other);
        assert!(kept.lost.believes && !is_certain(&kept), "{score}");
    }
    assert!(!believing(-110, 0).lost.believes);
    // Another guess is clearly better: the robot is there.
    let moved = believing(60, 300);
    assert!(moved.lost.believes);
    assert_eq!(moved.here.minus(believing(60, 290).here), to(900, 0));
}

#[test]
fn after_a_wrong_belief_it_is_where_it_has_gone_since_it_was_set_down() {
    let mut places = believing(60, 0);
    places.lost.believes = false;
    let began = places.aside().expect("it is lost").0;
    places.moved(to(500, 0));
    for (score, here) in [(300, to(1_400, 0)), (-400, to(500, 0))] {
        places.lost.guesses[1].score = score;
        places.believe();
        assert_eq!(places.here(), began.plus(here), "{score}");
    }
    assert_eq!(places.aside().map(|aside| aside.0), Some(began));
}

#[test]
fn a_robot_that_does_not_get_on_doubts() {
    let mut doubting = believing(150, 0);
    doubting.lost.doubt(doubting.here);
    let scores = doubting.lost.guesses.iter().map(|guess| guess.score);
    assert!(scores.eq([50, 0]));
}

#[test]
fn a_full_memory_forgets_what_it_found_since() {
    let mut walker = Walker::<40>::new(&CLOSET, (-1_000.0, -1_400.0));
    walker.places.trust_heading(true);
    while walker.places.positions().len() < 40 {
        walker.step(Aim::Frontier);
    }
    walker.set_down(800.0, -1_000.0);
    assert_eq!(walker.places.positions().len(), 35);
    let (mut before, mut full) = (35, 0);
    for _ in 0..60 {
        // What it perceives fits nowhere.
        walker.places.lost.guesses.clear();
        walker.step_lost(HOME);
        let count = walker.places.positions().len();
        assert!((35..=40).contains(&count), "{count}");
        full += usize::from(count < before);
        before = count;
    }
    assert!(full > 0);
}

#[test]
fn no_place_is_linked_to_one_that_was_forgotten() {
    let mut graph = Graph::<16, 16>::NEW;
    for x in 0..4 {
        graph.place_at(&LIMITS, to(1_000 * x, 0), &[255; 16]);
    }
    for (one, other) in [(0, 1), (1, 2), (0, 3)] {
        graph.went(one, other);
    }
    for (one, other) in [(0, 2), (1, 0), (2, 3)] {
        graph.block(one, other, 9);
    }
    graph.truncate(2);
    assert_eq!(graph.records().len(), 2);
    for (_, record) in graph.numbered() {
        assert!(record.links().all(|link| link < 2));
    }
    let blocked = std::vec::Vec::from_iter(graph.blocked());
    assert_eq!(blocked, [(0, 1)]);
}

/// What looks alike is guessed as long as there is room, and then instead of what does not fit.
#[test]
fn sixty_four_places_may_look_alike() {
    let mut lost = Lost::NOT;
    let here = Displacement::ZERO;
    let guess = |index: usize| Transform::taking(here, to(400 * index as i16, 0), 0);
    for index in 0..66 {
        lost.guess(guess(index), here);
        // Already guessed.
        lost.guess(guess(index / 2), here);
    }
    assert_eq!(lost.guesses.len(), 64);
    let has = |lost: &Lost, index| lost.guesses.iter().any(|g| g.transform == guess(index));
    assert!((0..64).all(|index| has(&lost, index)) && !has(&lost, 65));
    lost.guesses[20].score = -1;
    lost.guess(guess(65), here);
    assert!(has(&lost, 65) && !has(&lost, 20));
    assert_eq!(lost.guesses.len(), 64);
}
