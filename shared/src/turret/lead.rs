//! A robot that pursues a goal is led by its memory of places. To find the way takes longer than an
//! event may wait: it is done in slices, and the decision comes with the last one.

use super::{RingController, Robot, VirtualTurret};
#[cfg(feature = "store")]
use crate::controller::TransferError;
use crate::controller::{Command, Event, Outputs};
use crate::memory::{self, SituationBytes};
use crate::places::{Aim, PlaceLimits, Places, Purpose, SLICE};
use crate::units::{Bearing, Displacement, Millis};
use core::task::Poll;

/// After so long without an echo nothing is known any more, milliseconds: travel alone does not
/// tell that a robot was carried elsewhere while it was off.
const FORGET_MS: u32 = 600_000;
/// A heading drifts by no more from decision to decision, turns: 11°.
const MOST_DRIFT: u16 = 1 << 11;

impl<const SECTORS: usize, const POINTS: usize, const RECORDS: usize>
    VirtualTurret<SECTORS, POINTS, RECORDS>
{
    /// The places. They begin anew where random moves begin.
    #[must_use]
    pub const fn places(&self) -> &Places<SECTORS, RECORDS> {
        &self.places
    }

    /// Whether it has to think on before it decides.
    #[must_use]
    pub fn is_thinking(&self) -> bool {
        RECORDS > 0 && self.places.is_thinking()
    }

    /// The way that it was led last, as of [`Places::plan`]; nothing if it is not to be led.
    /// [`State::is_led`](crate::controller::State::is_led) tells whether it is led now.
    pub fn plan(&self) -> impl Iterator<Item = Displacement> {
        let aim = self.is_led.then_some(self.aim);
        aim.into_iter().flat_map(|aim| self.places.plan(aim))
    }

    /// As [`Places::trust_heading`].
    pub const fn trust_heading(&mut self, has_compass: bool) {
        self.places.trust_heading(has_compass);
    }

    /// The robot was carried elsewhere, and maybe turned: with the next echo it knows, as after ten
    /// minutes without one.
    pub const fn set_down(&mut self) {
        self.was_set_down = true;
    }

    /// Something was heard. A robot that was carried, or heard nothing for long, does not know
    /// where it is.
    pub(super) fn hear_at(&mut self, at: Millis) {
        let is_silent = at.after(self.heard_at) >= FORGET_MS;
        if core::mem::take(&mut self.was_set_down) || is_silent {
            self.memory.forget();
            self.places.set_down();
            (self.first_looks, self.knows_place) = (0, false);
        }
        self.heard_at = at;
    }

    /// As [`Places::write_saved`]; the robot may be anywhere then.
    ///
    /// # Errors
    /// As there.
    #[cfg(feature = "store")]
    pub fn write_places(&mut self, offset: usize, bytes: &[u8]) -> Result<(), TransferError> {
        self.places.write_saved(offset, bytes)?;
        if offset == 0 && !bytes.is_empty() {
            self.set_down();
        }
        Ok(())
    }

    /// From now on a robot that pursues a goal is led there; `None`: it finds its way by the goal
    /// alone.
    pub const fn lead_to(&mut self, aim: Option<Aim>) {
        self.is_led = aim.is_some();
        if let Some(aim) = aim {
            self.aim = aim;
        }
    }

    /// The robot faces this much farther to the left than it thought: all that it heard stands
    /// there as well, and it goes there.
    fn turn_frame(&mut self, turn: Bearing) {
        self.memory.turn_frame(turn);
        self.course = self.course.plus(turn);
        if let Some(motion) = &mut self.motion {
            motion.displacement = motion.displacement.rotated(turn.direction());
        }
    }
}

impl<C, const SECTORS: usize, const BEAMS: usize, const POINTS: usize, const RECORDS: usize>
    Robot<'_, C, SECTORS, BEAMS, POINTS, RECORDS>
where
    C: RingController<SECTORS>,
{
    /// A command; places begin anew with random moves, and what was tried with another goal.
    pub(super) fn command(&mut self, command: Command<SECTORS>) -> Outputs<SECTORS> {
        let outputs = self.control(Event::Command(command));
        if outputs.refusal.is_none() {
            match command {
                Command::Explore { .. } => self.turret.places.forget(),
                Command::Seek(_) => self.turret.places.seek_anew(),
                _ => {}
            }
        }
        outputs
    }

    /// Begins to think about the ring that it is to decide on.
    pub(super) fn begin_to_think(&mut self) {
        let turret = &mut *self.turret;
        let situation = turret
            .last_ring
            .map(|range| self.config.encoding.value(range));
        let view = memory::to_bytes(&situation, turret.known);
        turret.places.locate(self.config.encoding, &view);
        let purpose = self.purpose(&view);
        self.turret
            .places
            .begin(self.config.encoding, view, purpose);
    }

    /// What its places are to do. To a situation it is led where it comes no nearer by itself.
    fn purpose(&mut self, view: &SituationBytes<SECTORS>) -> Purpose {
        let turret = &mut *self.turret;
        let Some(goal) = self.controller.goal().filter(|_| turret.is_led) else {
            return Purpose::Perceive;
        };
        match turret.places.aim_while_lost(turret.aim, goal) {
            Aim::Situation if !goal.is_place() => Purpose::Perceive,
            Aim::Situation if turret.places.is_found(goal, view) => Purpose::Stay,
            Aim::Situation if !self.controller.is_stuck() => Purpose::Search,
            aim => Purpose::Lead(aim),
        }
    }

    pub(super) fn looks_for_position(&self) -> bool {
        self.turret.places.looks_for_position() || self.controller.looks_for_position()
    }

    /// As [`VirtualTurret::turn_frame`], and what its guard keeps.
    pub(super) fn turn_frame(&mut self, turn: Bearing) {
        self.turret.turn_frame(turn);
        self.controller.shield().turn_frame(turn);
    }

    /// Thinks on; with the last slice it decides.
    pub(super) fn think(&mut self) -> Outputs<SECTORS> {
        let limits = PlaceLimits::of_body(self.kept_free_mm());
        let turret = &mut *self.turret;
        let goal = self.controller.goal();
        let thought = turret.places.think(&limits, &turret.memory, goal, SLICE);
        let turn = turret.places.take_turn();
        if turn.as_signed_turns().unsigned_abs() > MOST_DRIFT {
            self.turn_frame(turn);
            // What it thought was about a ring that is askew.
            return self.decide();
        }
        turret.memory.correct_heading(turn);
        match thought {
            Poll::Pending => Outputs::NONE,
            Poll::Ready(leg) => self.decide_on(leg),
        }
    }
}

#[cfg(test)]
mod tests;
