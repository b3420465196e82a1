//! What a robot that was set down elsewhere perceives speaks for its guesses, or against them.

use super::Places;
use super::guess::{Guess, QUARTERS, Transform};
use super::locate::nearer_things;
use super::record::Record;
use super::relocate::axes;
use super::stage::Stage;
use crate::memory::SituationBytes;
use crate::units::{Direction, Displacement};

/// What is this much nearer or farther than it should be is something else, millimeters.
const OTHER_MM: u16 = 150;
/// Sectors that must be known here and there.
const MIN_SECTORS: u16 = 8;
/// A view fits a place from this mean on, of what its sectors are off less than [`OTHER_MM`],
/// millimeters. Where the robot is that is about 70, elsewhere about 10.
const FITS_MM: i16 = 40;
/// A score loses one part in so many before another view counts: what fitted long ago counts less.
const LEAK: i16 = 16;
/// A place tells what is perceived this near to it, millimeters.
const AROUND_MM: u16 = 400;
/// A guess moves by so much at a time, along x and y, to where it fits better, millimeters.
const NUDGE_MM: i16 = 50;
/// Positions so far beside a place, along x and y, are guessed as well, millimeters.
const BESIDE_MM: i16 = 150;
/// To compare a view at nine positions takes about so many steps of thinking.
const STEPS_PER_GUESS: u16 = 4;

impl<const SECTORS: usize, const RECORDS: usize> Places<SECTORS, RECORDS> {
    /// Compares what is perceived with what a few guesses expect.
    pub(super) fn follow_guesses(&mut self, first: u16, steps: u16) -> Stage {
        if !self.may_compare() {
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
        let Guess { transform, score } = *self.lost.guesses.get(index)?;
        let position = transform.apply(self.here);
        let score = score - score / LEAK;
        let known = self.known_before().iter();
        let place = known.min_by_key(|record| record.distance_mm(position))?;
        let fit = (place.distance_mm(position) < AROUND_MM)
            .then(|| self.best_fit(axes, place, position, transform.quarters, NUDGE_MM))
            .flatten();
        Some(match fit {
            Some((fit_mm, position)) => Guess {
                transform: Transform::taking(self.here, position, transform.quarters),
                score: score.saturating_add(fit_mm - FITS_MM),
            },
            None => Guess { transform, score },
        })
    }

    /// A few of the places before may be here. After the last one the robot may change its belief.
    pub(super) fn seed_guesses(&mut self, first: u16, steps: u16) -> Stage {
        let axes = axes();
        let quarters = self.lost.quarters;
        let places = self.known_before().len() as u16;
        let last = first
            .saturating_add(steps.div_ceil(STEPS_PER_GUESS))
            .min(places);
        for index in first..last {
            let Some(place) = self.graph.get(index) else {
                continue;
            };
            let fit = self.best_fit(&axes, place, place.at, quarters, BESIDE_MM);
            if let Some((_, position)) = fit.filter(|(fit_mm, _)| *fit_mm >= FITS_MM) {
                let transform = Transform::taking(self.here, position, quarters);
                self.lost.guess(transform, self.here);
            }
        }
        if last < places {
            return Stage::Seeds(last);
        }
        self.end_comparison();
        Stage::Place
    }

    /// Of a position and the eight around it the one where a place's view fits best, and by how
    /// much, for a robot that faces so many right angles farther to the left than it thinks; `None`
    /// where too little is known.
    // Called twice: one copy saves flash.
    #[inline(never)]
    fn best_fit(
        &self,
        axes: &[Direction; SECTORS],
        place: &Record<SECTORS>,
        position: Displacement,
        quarters: u8,
        step_mm: i16,
    ) -> Option<(i16, Displacement)> {
        let mut view = self.view;
        view.rotate_right(SECTORS * usize::from(quarters % QUARTERS) / usize::from(QUARTERS));
        let steps_mm = [0, step_mm, -step_mm];
        let mut best = None;
        for dx_mm in steps_mm {
            for dy_mm in steps_mm {
                let at = position.plus(Displacement { dx_mm, dy_mm });
                let fit_mm = self.fit_mm(axes, place, &view, at)?;
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
        view: &SituationBytes<SECTORS>,
        position: Displacement,
    ) -> Option<i16> {
        let offset = position.minus(place.at);
        let (mut sum_mm, mut sectors) = (0, 0);
        let things = nearer_things(self.encoding, &place.view, view);
        for (axis, nearer_mm) in things.filter_map(|(sector, mm)| Some((axes.get(sector)?, mm))) {
            let expected_mm = axis.along(offset.dx_mm.into(), offset.dy_mm.into());
            let off_mm = (nearer_mm - expected_mm).unsigned_abs();
            sum_mm += OTHER_MM.saturating_sub(off_mm.min(OTHER_MM.into()) as u16);
            sectors += 1;
        }
        (sectors >= MIN_SECTORS).then(|| (sum_mm / sectors) as i16)
    }
}
