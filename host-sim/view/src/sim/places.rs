//! The memory of places: where it leads the robot, and where it lies in the world.

use super::{Simulator, SimulatorActivity};
use crate::place_frames::{SeenPlaces, heading};
use crate::snapshot::{PartMessage, Rounded, SnapshotPart, Xy};
use crate::source::CommandRefused;
use amp::places::Aim;
use amp::units::Displacement;
use arena::world::Point;
use sim::pilot::Pilot as _;
use std::sync::Arc;

impl Simulator {
    /// Whether its places lead the robot to goals.
    pub(super) fn has_places(&self) -> bool {
        self.controller.inner().led_turret().is_some()
    }

    /// Places begin anew here, with random moves.
    pub(super) fn begin_places(&mut self) {
        self.frames
            .begin(self.body.pose(), self.heading_it_thinks());
    }

    /// The robot was carried here.
    pub(super) fn carry_places(&mut self) {
        self.frames
            .carry(self.body.pose(), self.heading_it_thinks());
    }

    /// After an echo: if the robot was carried it knows by now.
    pub(super) fn settle_places(&mut self) {
        let turret = self.controller.inner().led_turret();
        let begins_anew = turret.is_some_and(|turret| self.frames.settle(turret));
        if begins_anew && let Err(CommandRefused(why)) = self.lead() {
            self.fail(why);
        }
    }

    fn seen_places(&self) -> Option<SeenPlaces<'_>> {
        let turret = self.controller.inner().led_turret()?;
        Some((self.frames).seen(turret, self.body.pose(), heading(turret)))
    }

    /// Tells the robot where its places are to lead it. Without places it finds its way by the goal
    /// alone.
    pub(super) fn lead(&mut self) -> Result<(), CommandRefused> {
        let sought = self.goal.sought();
        let told = sought.filter(|_| !self.goal.is_touring());
        self.controller.seek_sense(told)?;
        let aim = if self.goal.is_touring() {
            self.goal.tour_aim()
        } else if sought.is_some() {
            // What it senses leads it.
            self.sense();
            return Ok(());
        } else if let Some(place) = self.goal.position() {
            Some(Aim::Position(self.frames.to_frame(place)))
        } else if self.goal.is_nest() && self.frames.home().is_some() {
            Some(Aim::Position(Displacement::ZERO))
        } else {
            Some(Aim::Situation)
        };
        Ok(self.controller.lead_if_it_can(aim)?)
    }

    /// Where the goal is, if it is where the random moves began.
    pub(super) fn home(&self) -> Point {
        let nest = self.nest.map(|(_, place)| place);
        let home = self.frames.home().filter(|_| self.goal.is_home());
        home.or(nest).unwrap_or(self.body.pose().position)
    }

    fn heading_it_thinks(&self) -> f64 {
        self.controller.inner().led_turret().map_or(0.0, heading)
    }

    /// Where the robot thinks that it is, if it knows any place.
    pub(super) fn thinks(&self) -> Option<[Rounded; 3]> {
        self.seen_places()?.thinks()
    }

    /// The way that its places lead it, if they do: the next sub-goal comes first.
    pub(super) fn way(&self) -> Option<Vec<Xy>> {
        let stays = self.decision.is_some_and(|decision| decision.at_goal);
        let seeks = self.activity == SimulatorActivity::Seek && self.frames.is_current();
        let turret = self.controller.inner().as_turret()?;
        if !seeks || stays || !turret.state().is_led() {
            return None;
        }
        Some(self.seen_places()?.way())
    }

    /// The places as a part of the snapshot: the last one if nothing has changed.
    pub(super) fn places(&mut self, revision: u64) -> Option<Arc<dyn PartMessage>> {
        let sought = self.goal.sought();
        let controller = self.controller.inner();
        let remembered = sought.map_or_else(Vec::new, |goal| controller.remembered(goal));
        let places = self.seen_places()?.dto(&remembered);
        Some(SnapshotPart::kept(
            &mut self.cache.places,
            "places",
            revision,
            places,
        ))
    }
}
