//! A robot that pursues a goal is led by its memory of places.

use super::{RingController, Robot, VirtualTurret};
use crate::controller::{Command, Event, Outputs};
use crate::fixed::Mask;
use crate::memory;
use crate::places::{Aim, Leg, PlaceLimits, Places};
use crate::units::Range;

impl<const SECTORS: usize, const POINTS: usize, const RECORDS: usize>
    VirtualTurret<SECTORS, POINTS, RECORDS>
{
    /// The places. They begin anew where random moves begin.
    #[must_use]
    pub const fn places(&self) -> &Places<SECTORS, RECORDS> {
        &self.places
    }

    /// From now on a robot that pursues a goal is led there; `None`: it finds its way by the goal
    /// alone.
    pub const fn lead_to(&mut self, aim: Option<Aim>) {
        self.is_led = aim.is_some();
        if let Some(aim) = aim {
            self.aim = aim;
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

    /// The way to the next place, where the robot is to be led.
    pub(super) fn next_leg(&mut self, ring: &[Option<Range>; SECTORS], known: Mask) -> Option<Leg> {
        // A robot without places has no code for them.
        if RECORDS == 0 {
            return None;
        }
        let limits = PlaceLimits::of_body(self.kept_free_mm());
        let turret = &mut *self.turret;
        let situation = ring.map(|range| self.config.encoding.value(range));
        let view = memory::to_bytes(&situation, known);
        turret.places.locate(self.config.encoding, &view);
        turret.places.perceive(&limits, &turret.memory, view);
        let goal = self.controller.goal().filter(|_| turret.is_led)?;
        if turret.aim == Aim::Situation {
            if !goal.is_place() {
                return None;
            }
            // It is led where it comes no nearer by itself.
            let is_here = turret.places.is_found(goal, &view);
            if is_here || !self.controller.is_stuck() {
                turret.places.searched(is_here);
                return is_here.then_some(Leg::HERE);
            }
        }
        (turret.places).lead(&limits, &turret.memory, turret.aim, goal)
    }
}
