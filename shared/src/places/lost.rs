//! A robot that was set down elsewhere: where among the places that it knew before it is.
//!
//! Until it knows, the places that it finds stand aside of those before, in the same frame. Where a
//! place of before showed what is perceived here, the robot guesses that it is there. It follows
//! each guess as it moves: what it perceives speaks for the guess, or against it. When one is
//! clearly better than all others it believes that one, and goes on comparing until it is certain.
//!
//! Without a compass it may face anywhere. The walls tell its heading but for right angles; each
//! guess is one of the four headings as well. That is less to go by: a robot that has come to its
//! goal and is not certain goes away and back before it stays.

use super::guess::{Guess, QUARTERS, SAME_MM, Transform};
use super::recent::Recent;
use super::record::Record;
use super::stage::Stage;
use super::{Aim, NOWHERE, Places};
use crate::goal::Goal;
use crate::units::{Bearing, Displacement};
use heapless::Vec;

/// Guesses, at most. Mazes and halls have dozens of places that look alike: if the right one has no
/// room a wrong one is believed.
const GUESSES: usize = 64;
/// A guess is believed from this score on, if it is clearly the best; the score is the sum of what
/// fits better, millimeters.
pub const BELIEVED: i16 = 300;
/// The robot is certain from this score on.
const CERTAIN: i16 = 400;
/// Times that it goes away and back to make sure.
const DETOURS: u8 = 3;
/// Without a belief the heading is looked for anew after so far, millimeters.
const ASKEW_MM: u16 = 30_000;
/// A belief is given up at this score.
const WRONG: i16 = -100;
/// A robot that does not get on where it believes to be loses so much of its score.
const DOUBT: i16 = 100;
/// A view counts after so far, millimeters.
const STRIDE_MM: u16 = 200;
/// New places stand this far aside of all before, millimeters.
const ASIDE_MM: i16 = 10_000;
/// With fewer places the robot begins anew: many other rooms would look like those.
const MIN_PLACES: usize = 32;

/// What a robot that was set down elsewhere knows of where it is. If it was not, or is certain,
/// only the travel and [`is_resigned`](Self::is_resigned) change, and neither counts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Lost {
    pub(super) guesses: Vec<Guess, GUESSES>,
    was_set_down: bool,
    pub(super) believes: bool,
    /// It has been everywhere, and does not know.
    is_resigned: bool,
    /// Places from this one on were found since; 0: it begins anew.
    first: u16,
    /// Where it thinks that it was set down.
    began: Displacement,
    /// Since a view counted, millimeters.
    traveled_mm: u16,
    /// Since it found its heading, or began to believe, millimeters.
    since_mm: u16,
    /// To make sure it goes to this place, and back.
    detour: Option<u16>,
    detours: u8,
    /// Next it guesses that it faces so many right angles farther to the left.
    pub(super) quarters: u8,
}

impl Lost {
    pub(super) const NOT: Self = Self {
        guesses: Vec::new(),
        was_set_down: false,
        believes: false,
        is_resigned: false,
        first: 0,
        began: Displacement::ZERO,
        traveled_mm: 0,
        since_mm: 0,
        detour: None,
        detours: 0,
        quarters: 0,
    };

    /// Places from this one on may be elsewhere than they seem to be.
    pub(super) fn first_uncertain(&self) -> Option<u16> {
        (self.first > 0).then_some(self.first)
    }

    pub(super) const fn moved(&mut self, length_mm: u16) {
        self.traveled_mm = self.traveled_mm.saturating_add(length_mm);
        self.since_mm = self.since_mm.saturating_add(length_mm);
    }

    /// There is nowhere to go: a belief is doubted, and without one it hopes no more.
    pub(super) fn resign(&mut self, here: Displacement) {
        self.is_resigned = !self.believes;
        self.doubt(here);
    }

    /// It does not get on.
    pub(super) fn doubt(&mut self, here: Displacement) {
        if !self.believes {
            return;
        }
        for guess in &mut self.guesses {
            if guess.is_here(here) {
                guess.score = guess.score.saturating_sub(DOUBT);
            }
        }
        self.traveled_mm = STRIDE_MM;
    }

    pub(super) fn guess(&mut self, transform: Transform, here: Displacement) {
        let is_same = |guess: &Guess| guess.transform.is_near(&transform, here, SAME_MM);
        if self.guesses.iter().any(is_same) {
            return;
        }
        if let Err(guess) = self.guesses.push(Guess {
            transform,
            score: 0,
        }) {
            let worst = self.guesses.iter_mut().min_by_key(|guess| guess.score);
            if let Some(worst) = worst.filter(|worst| worst.score < 0) {
                *worst = guess;
            }
        }
    }

    fn end_if_certain(&mut self, score: i16) {
        if score >= CERTAIN {
            self.end();
        }
    }

    /// It knows where it is. In place: the constant with all guesses would take flash.
    // One copy in the program.
    #[inline(never)]
    pub(super) fn end(&mut self) {
        self.guesses.clear();
        (self.was_set_down, self.believes, self.is_resigned) = (false, false, false);
        (self.first, self.began) = (0, Displacement::ZERO);
        (self.traveled_mm, self.since_mm) = (0, 0);
        (self.detour, self.detours, self.quarters) = (None, 0, 0);
    }

    /// The best guess, if it has half as much again as any that is elsewhere.
    fn clearly_best(&self, here: Displacement) -> Option<Guess> {
        let best = self.guesses.iter().max_by_key(|guess| guess.score)?;
        let is_other =
            |guess: &&Guess| !guess.transform.is_near(&best.transform, here, 2 * SAME_MM);
        let others = self.guesses.iter().filter(is_other);
        let next = others.map(|guess| guess.score).max().unwrap_or(0);
        (best.score >= BELIEVED && next <= best.score / 3 * 2).then_some(*best)
    }
}

impl<const SECTORS: usize, const RECORDS: usize> Places<SECTORS, RECORDS> {
    /// The robot was set down elsewhere; without a compass it may face anywhere. With enough places
    /// it finds out where among them it is; otherwise it begins anew.
    pub fn set_down(&mut self) {
        let known = self.known_for_good().len();
        if known < MIN_PLACES {
            self.forget();
            (self.lost.was_set_down, self.lost.is_resigned) = (true, true);
            return;
        }
        self.stage = Stage::Done;
        self.lost.end();
        self.lost.was_set_down = true;
        // New places need room.
        self.lost.first = known.min(RECORDS - RECORDS / 8) as u16;
        (self.lost.began, self.lost.traveled_mm) = (self.here, STRIDE_MM);
        self.go_aside();
        if !self.has_compass {
            self.compass.forget_heading();
        }
    }

    /// Where it was set down in the frame of the start, and the first of the places that it has
    /// found since, as long as these stand aside of those before.
    #[must_use]
    pub fn aside(&self) -> Option<(Displacement, u16)> {
        let first = self.lost.first_uncertain();
        first
            .filter(|_| !self.lost.believes)
            .map(|first| (self.lost.began, first))
    }

    /// Where among its places a robot that was set down elsewhere may be, from the start, and the
    /// score of each guess: what speaks for it, [`BELIEVED`] to be believed; below 0, what speaks
    /// against it.
    pub fn guesses(&self) -> impl Iterator<Item = (Displacement, i16)> {
        let guesses = self.lost.guesses.iter();
        guesses.map(|guess| (guess.transform.apply(self.here), guess.score))
    }

    /// What a robot with this aim is led to. While it does not know where it is it drives around;
    /// where that has not helped it looks for the goal's situation.
    pub(crate) fn aim_while_lost(&mut self, aim: Aim, goal: &Goal<SECTORS>) -> Aim {
        let is_lost = self.lost.was_set_down && !self.lost.believes;
        match aim {
            Aim::Position(position) if self.lost.believes && !self.has_compass => {
                Aim::Position(self.with_detour(position))
            }
            Aim::Position(_) if is_lost && self.lost.is_resigned && goal.is_place() => {
                Aim::Situation
            }
            Aim::Position(_) if is_lost && self.lost.first > 0 => Aim::Frontier,
            aim => aim,
        }
    }

    /// A robot that has come to a position, and is not certain, goes to the farthest place and back
    /// before it stays.
    fn with_detour(&mut self, position: Displacement) -> Displacement {
        let is_here = |end: Displacement| end.minus(self.here).is_shorter_than(SAME_MM);
        let end_of = |detour: Option<u16>| Some(self.graph.get(detour?)?.at);
        if let Some(end) = end_of(self.lost.detour).filter(|end| !is_here(*end)) {
            return end;
        }
        let was_away = self.lost.detour.take().is_some();
        if was_away || self.lost.detours >= DETOURS || !is_here(position) {
            return position;
        }
        let places = self.known_before().iter().zip(0..NOWHERE);
        let farthest = places.max_by_key(|(place, _)| place.distance_mm(self.here));
        self.lost.detour = farthest.map(|(_, index)| index);
        self.lost.detours += 1;
        end_of(self.lost.detour).unwrap_or(position)
    }

    /// From now on places stand aside of those of before.
    fn go_aside(&mut self) {
        let xs = || self.known_before().iter().map(|record| record.at.dx_mm);
        let (least, most) = (xs().min().unwrap_or(0), xs().max().unwrap_or(0));
        // Where there is more room in the frame.
        let dx_mm = if least.saturating_add(most) < 0 {
            most.saturating_add(ASIDE_MM)
        } else {
            least.saturating_sub(ASIDE_MM)
        };
        self.lost.believes = false;
        let aside = Displacement { dx_mm, dy_mm: 0 };
        self.jump(Transform::taking(self.lost.began, aside, 0));
    }

    /// Which way a robot faces that was set down elsewhere, but for right angles: after a while the
    /// walls tell it. One that has found nothing for long, or has been everywhere, may have been
    /// told wrong.
    pub(super) fn find_heading_anew(&mut self) {
        if self.lost.first == 0 {
            return;
        }
        let is_long = self.lost.is_resigned || self.lost.since_mm >= ASKEW_MM;
        if let Some(turn) = self.compass.align() {
            self.begin_aside(turn);
        } else if self.compass.is_aligned() && !self.lost.believes && is_long {
            self.compass.forget_heading();
            self.begin_aside(Bearing::ZERO);
        }
    }

    /// What it has found since it was set down stands askew: it faces this much farther to the
    /// left.
    fn begin_aside(&mut self, turn: Bearing) {
        self.turn = self.turn.plus(turn);
        let way = self.here.minus(self.lost.began);
        self.lost.began = self.here.minus(way.rotated(turn.direction()));
        (self.lost.since_mm, self.lost.is_resigned) = (0, false);
        self.lost.guesses.clear();
        self.jump(Transform::IDENTITY);
    }

    /// It is elsewhere than it thought. What it has found since it was set down is forgotten.
    fn jump(&mut self, transform: Transform) {
        self.here = transform.apply(self.here);
        self.lost.began = transform.apply(self.lost.began);
        for guess in &mut self.lost.guesses {
            guess.transform = guess.transform.after(&transform);
        }
        let turn = Bearing::of_place(transform.quarters.into(), QUARTERS.into());
        self.turn = self.turn.plus(turn);
        self.forget_uncertain();
        (self.frontier, self.frontier_age) = (None, 0);
        (self.target, self.found, self.recent) = (None, None, Recent::NEW);
    }

    /// Forgets the places that may be elsewhere than they seem to be.
    pub(super) fn forget_uncertain(&mut self) {
        self.graph.truncate(self.lost.first);
        self.current = None;
    }

    /// All places but those of which it does not know where they are.
    pub(super) fn known_for_good(&self) -> &[Record<SECTORS>] {
        match self.lost.first_uncertain() {
            Some(_) => self.known_before(),
            None => self.graph.records(),
        }
    }

    pub(super) fn known_before(&self) -> &[Record<SECTORS>] {
        let known = self.graph.records().get(..self.lost.first.into());
        known.unwrap_or(&[])
    }

    /// Believes a guess that is clearly the best, or gives up its belief.
    pub(super) fn believe(&mut self) {
        let here = self.here;
        match self.lost.clearly_best(here) {
            Some(guess) if self.lost.believes && guess.is_here(here) => {
                self.lost.end_if_certain(guess.score);
            }
            Some(guess) => {
                (self.lost.believes, self.lost.since_mm) = (true, 0);
                self.lost.detour = None;
                self.jump(guess.transform);
            }
            None if self.lost.believes => {
                let mut believed = self.lost.guesses.iter().filter(|guess| guess.is_here(here));
                if believed.all(|guess| guess.score < WRONG) {
                    self.go_aside();
                }
            }
            None => {}
        }
    }

    /// A view has been compared with all that is known: another one counts after a while.
    pub(super) fn end_comparison(&mut self) {
        self.lost.traveled_mm = 0;
        if !self.has_compass {
            self.lost.quarters = (self.lost.quarters + 1) % QUARTERS;
        }
        self.believe();
    }

    /// Whether a view counts by now.
    pub(super) const fn may_compare(&self) -> bool {
        self.lost.traveled_mm >= STRIDE_MM
    }
}
