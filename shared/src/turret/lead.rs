//! A robot that pursues a goal is led by its memory of places.

use super::{RingController, Robot, VirtualTurret};
use crate::places::{Aim, Leg, PlaceLimits, Places};

impl<const SECTORS: usize, const POINTS: usize, const RECORDS: usize>
    VirtualTurret<SECTORS, POINTS, RECORDS>
{
    /// The places. They begin anew where random moves begin.
    #[must_use]
    pub const fn places(&self) -> &Places<RECORDS> {
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
    /// The way to the next place, where the robot is to be led.
    pub(super) fn next_leg(&mut self) -> Option<Leg> {
        let limits = PlaceLimits::of_body(self.config.robot.body_radius_mm);
        let turret = &mut *self.turret;
        turret.places.perceive(&limits, &turret.memory);
        if !turret.is_led || !self.controller.pursues_goal() {
            return None;
        }
        turret.places.lead(&limits, &turret.memory, turret.aim)
    }
}
