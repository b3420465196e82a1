//! A robot that was set down elsewhere: where among the places that it knew before it is.
//!
//! Until it knows, the places that it finds stand aside of those before, in the same frame. Where a
//! place of before showed what is perceived here, the robot guesses that it is there. It follows
//! each guess as it moves: what it perceives speaks for the guess, or against it. When one is
//! clearly better than all others it believes that one, and goes on comparing until it is certain.

use super::locate::nearer_things;
use super::recent::Recent;
use super::record::Record;
use super::relocate::axes;
use super::stage::Stage;
use super::{Aim, Places};
use crate::goal::Goal;
use crate::units::{Direction, Displacement};
use heapless::Vec;

/// Guesses, at most.
const GUESSES: usize = 24;
/// Positions nearer to each other are the same, millimeters.
const SAME_MM: u32 = 300;
/// What is this much nearer or farther than it should be is something else, millimeters.
const OTHER_MM: u16 = 150;
/// Sectors that must be known here and there.
const MIN_SECTORS: u16 = 8;
/// A view fits a place from this mean on, of what its sectors are off less than [`OTHER_MM`],
/// millimeters. Where the robot is that is about 70, elsewhere about 10.
const FITS_MM: i16 = 40;
/// A guess is believed from this score on; it is the sum of what fits better, millimeters.
const ENOUGH: i16 = 300;
/// The robot is certain from this score on.
const CERTAIN: i16 = 400;
/// A belief is given up at this score.
const WRONG: i16 = -100;
/// A robot that does not get on where it believes to be loses so much of its score.
const DOUBT: i16 = 100;
/// A score loses one part in so many before another view counts: what fitted long ago counts less.
const LEAK: i16 = 16;
/// A view counts after so far, millimeters.
const STRIDE_MM: u16 = 200;
/// A place tells what is perceived this near to it, millimeters.
const AROUND_MM: u16 = 400;
/// A guess moves by so much at a time, along x and y, to where it fits better, millimeters.
const NUDGE_MM: i16 = 50;
/// Positions so far beside a place, along x and y, are guessed as well, millimeters.
const BESIDE_MM: i16 = 150;
/// New places stand this far aside of all before, millimeters.
const ASIDE_MM: i16 = 10_000;
/// With fewer places the robot begins anew: many other rooms would look like those.
const MIN_PLACES: usize = 32;
/// To compare a view at nine positions takes about so many steps of thinking.
const STEPS_PER_GUESS: u16 = 4;

/// Somewhere among the places before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Guess {
    /// From where the robot thinks it is.
    pub(super) shift: Displacement,
    pub(super) score: i16,
}

impl Guess {
    fn is_near(&self, shift: Displacement) -> bool {
        self.shift.minus(shift).is_shorter_than(2 * SAME_MM)
    }

    fn is_here(&self) -> bool {
        self.is_near(Displacement::ZERO)
    }
}

/// What a robot that was set down elsewhere knows of where it is. If it was not, or is certain,
/// only the travel and [`is_resigned`](Self::is_resigned) change, and neither counts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Lost {
    pub(super) guesses: Vec<Guess, GUESSES>,
    pub(super) was_set_down: bool,
    pub(super) believes: bool,
    /// It has been everywhere, and does not know.
    is_resigned: bool,
    /// Places from this one on were found since; 0: it begins anew.
    first: u16,
    /// Where it thinks that it was set down.
    began: Displacement,
    /// Since a view counted, millimeters.
    traveled_mm: u16,
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
    };

    /// Places from this one on may be elsewhere than they seem to be.
    pub(super) fn first_uncertain(&self) -> Option<u16> {
        (self.first > 0).then_some(self.first)
    }

    pub(super) const fn moved(&mut self, length_mm: u16) {
        self.traveled_mm = self.traveled_mm.saturating_add(length_mm);
    }

    /// There is nowhere to go: a belief is doubted, and without one it hopes no more.
    pub(super) fn resign(&mut self) {
        self.is_resigned = !self.believes;
        self.doubt();
    }

    /// It does not get on.
    pub(super) fn doubt(&mut self) {
        if !self.believes {
            return;
        }
        for guess in self.guesses.iter_mut().filter(|guess| guess.is_here()) {
            guess.score = guess.score.saturating_sub(DOUBT);
        }
        self.traveled_mm = STRIDE_MM;
    }

    fn guess(&mut self, shift: Displacement) {
        let is_same = |guess: &Guess| guess.shift.minus(shift).is_shorter_than(SAME_MM);
        if self.guesses.iter().any(is_same) {
            return;
        }
        if let Err(guess) = self.guesses.push(Guess { shift, score: 0 }) {
            let worst = self.guesses.iter_mut().min_by_key(|guess| guess.score);
            if let Some(worst) = worst.filter(|worst| worst.score < 0) {
                *worst = guess;
            }
        }
    }

    fn end_if_certain(&mut self, score: i16) {
        if score >= CERTAIN {
            *self = Self::NOT;
        }
    }

    /// The best guess, if it has half as much again as any that is elsewhere.
    fn clearly_best(&self) -> Option<Guess> {
        let best = self.guesses.iter().max_by_key(|guess| guess.score)?;
        let others = self
            .guesses
            .iter()
            .filter(|guess| !guess.is_near(best.shift));
        let next = others.map(|guess| guess.score).max().unwrap_or(0);
        (best.score >= ENOUGH && next <= best.score / 3 * 2).then_some(*best)
    }
}

impl<const SECTORS: usize, const RECORDS: usize> Places<SECTORS, RECORDS> {
    /// The robot was set down elsewhere, its bearing is known. With enough places it finds out
    /// where among them it is; otherwise it begins anew.
    pub fn set_down(&mut self) {
        let known = self.graph.records().len();
        let known = self.lost.first_uncertain().map_or(known, usize::from);
        if known < MIN_PLACES {
            self.forget();
            self.lost = Lost {
                was_set_down: true,
                is_resigned: true,
                ..Lost::NOT
            };
            return;
        }
        self.stage = Stage::Done;
        self.lost = Lost {
            was_set_down: true,
            // New places need room.
            first: known.min(RECORDS - RECORDS / 8) as u16,
            began: self.here,
            traveled_mm: STRIDE_MM,
            ..Lost::NOT
        };
        self.go_aside();
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

    /// What a robot with this aim is led to. While it does not know where it is it drives around;
    /// where that has not helped it looks for the goal's situation.
    pub(crate) fn aim_while_lost(&self, aim: Aim, goal: &Goal<SECTORS>) -> Aim {
        let is_lost = self.lost.was_set_down && !self.lost.believes;
        match aim {
            Aim::Position(_) if is_lost && self.lost.is_resigned && goal.is_place() => {
                Aim::Situation
            }
            Aim::Position(_) if is_lost && self.lost.first > 0 => Aim::Frontier,
            aim => aim,
        }
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
        self.shift(Displacement { dx_mm, dy_mm: 0 }.minus(self.lost.began));
    }

    /// It is elsewhere than it thought, by so much.
    fn shift(&mut self, shift: Displacement) {
        self.here = self.here.plus(shift);
        self.lost.began = self.lost.began.plus(shift);
        for guess in &mut self.lost.guesses {
            guess.shift = guess.shift.minus(shift);
        }
        self.forget_uncertain();
        (self.frontier, self.frontier_age) = (None, 0);
        (self.target, self.found, self.recent) = (None, None, Recent::NEW);
    }

    /// Forgets the places that may be elsewhere than they seem to be.
    pub(super) fn forget_uncertain(&mut self) {
        self.graph.truncate(self.lost.first);
        self.current = None;
    }

    fn known_before(&self) -> &[Record<SECTORS>] {
        let known = self.graph.records().get(..self.lost.first.into());
        known.unwrap_or(&[])
    }

    /// Compares what is perceived with what a few guesses expect.
    pub(super) fn follow_guesses(&mut self, first: u16, steps: u16) -> Stage {
        if self.lost.traveled_mm < STRIDE_MM {
            return Stage::Place;
        }
        let axes = axes();
        let last = usize::from(first.saturating_add(steps.div_ceil(STEPS_PER_GUESS)));
        for index in first.into()..last {
            if let Some(followed) = self.followed(&axes, index)
                && let Some(guess) = self.lost.guesses.get_mut(index)
            {
                *guess = followed;
            }
        }
        if last < self.lost.guesses.len() {
            Stage::Guesses(last as u16)
        } else {
            Stage::Seeds(0)
        }
    }

    fn followed(&self, axes: &[Direction; SECTORS], index: usize) -> Option<Guess> {
        let Guess { shift, score } = *self.lost.guesses.get(index)?;
        let position = self.here.plus(shift);
        let score = score - score / LEAK;
        let known = self.known_before().iter();
        let place = known.min_by_key(|record| record.distance_mm(position))?;
        let fit = (place.distance_mm(position) < AROUND_MM)
            .then(|| self.best_fit(axes, place, position, NUDGE_MM))
            .flatten();
        Some(match fit {
            Some((fit_mm, position)) => Guess {
                shift: position.minus(self.here),
                score: score.saturating_add(fit_mm - FITS_MM),
            },
            None => Guess { shift, score },
        })
    }

    /// A few of the places before may be here. After the last one the robot believes the best
    /// guess, or gives up its belief.
    pub(super) fn seed_guesses(&mut self, first: u16, steps: u16) -> Stage {
        let axes = axes();
        let last = first
            .saturating_add(steps.div_ceil(STEPS_PER_GUESS))
            .min(self.lost.first);
        for index in first..last {
            let Some(place) = self.graph.get(index) else {
                continue;
            };
            let fit = self.best_fit(&axes, place, place.at, BESIDE_MM);
            if let Some((_, position)) = fit.filter(|(fit_mm, _)| *fit_mm >= FITS_MM) {
                self.lost.guess(position.minus(self.here));
            }
        }
        if last < self.lost.first {
            return Stage::Seeds(last);
        }
        self.lost.traveled_mm = 0;
        self.believe();
        Stage::Place
    }

    pub(super) fn believe(&mut self) {
        match self.lost.clearly_best() {
            Some(guess) if self.lost.believes && guess.is_here() => {
                self.lost.end_if_certain(guess.score);
            }
            Some(guess) => {
                self.lost.believes = true;
                self.shift(guess.shift);
            }
            None if self.lost.believes => {
                let mut here = self.lost.guesses.iter().filter(|guess| guess.is_here());
                if here.all(|guess| guess.score < WRONG) {
                    self.go_aside();
                }
            }
            None => {}
        }
    }

    /// Of a position and the eight around it the one where a place's view fits best, and by how
    /// much; `None` where too little is known.
    // Called twice: one copy saves flash.
    #[inline(never)]
    fn best_fit(
        &self,
        axes: &[Direction; SECTORS],
        place: &Record<SECTORS>,
        position: Displacement,
        step_mm: i16,
    ) -> Option<(i16, Displacement)> {
        let steps_mm = [0, step_mm, -step_mm];
        let mut best = None;
        for dx_mm in steps_mm {
            for dy_mm in steps_mm {
                let at = position.plus(Displacement { dx_mm, dy_mm });
                let fit_mm = self.fit_mm(axes, place, at)?;
                if best.is_none_or(|(best_mm, _)| fit_mm > best_mm) {
                    best = Some((fit_mm, at));
                }
            }
        }
        best
    }

    /// How much nearer things are to where a place's view has them, seen from a position, than
    /// others would be; a mean over the sectors, 0 … 150 mm.
    fn fit_mm(
        &self,
        axes: &[Direction; SECTORS],
        place: &Record<SECTORS>,
        position: Displacement,
    ) -> Option<i16> {
        let offset = position.minus(place.at);
        let (mut sum_mm, mut sectors) = (0, 0);
        let things = nearer_things(self.encoding, &place.view, &self.view);
        for (axis, nearer_mm) in things.filter_map(|(sector, mm)| Some((axes.get(sector)?, mm))) {
            let expected_mm = axis.along(offset.dx_mm.into(), offset.dy_mm.into());
            let off_mm = (nearer_mm - expected_mm).unsigned_abs();
            sum_mm += OTHER_MM.saturating_sub(off_mm.min(OTHER_MM.into()) as u16);
            sectors += 1;
        }
        (sectors >= MIN_SECTORS).then(|| (sum_mm / sectors) as i16)
    }
}
