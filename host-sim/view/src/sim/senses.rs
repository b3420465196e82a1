//! What can be perceived beside ranges: the robot's sensors, and sources that can be moved.

use super::Simulator;
use crate::snapshot::{Rounded, SensedDto};
use crate::source::CommandRefused;
use arena::noise::Noise;
use arena::sources::hex;
use arena::world::Point;
use sim::episode::{Seeds, with_missing_sources};
use sim::pilot::Pilot as _;

impl Simulator {
    /// The robot senses what is where it is.
    pub(super) fn sense(&mut self) {
        if self.body.world().sources().is_empty() {
            return;
        }
        let readings = self.body.read();
        self.controller.sense(self.body.now(), &readings);
    }

    /// Adds what the goal seeks, if the world has none.
    pub(super) fn add_missing_sources(&mut self) -> Result<(), CommandRefused> {
        let Some(behavior) = self.goal.as_behavior() else {
            return Ok(());
        };
        let noise = Noise::new(Seeds::of(self.start.setup.seed).sources);
        let radius_m = self.body.radius_m();
        if let Some(world) = with_missing_sources(self.body.world(), behavior, radius_m, noise)? {
            self.replace_world(world);
        }
        Ok(())
    }

    /// Moves a source, counted as in [`source_dtos`](crate::dto::source_dtos).
    pub(super) fn move_source(&mut self, index: usize, to: Point) -> Result<(), CommandRefused> {
        let world = self.body.world();
        let mut sources = world.sources().clone();
        let floor = sources.floor.iter_mut().map(|patch| &mut patch.center);
        let scents = sources.scents.iter_mut().map(|scent| &mut scent.position);
        let lights = sources.lights.iter_mut().map(|light| &mut light.position);
        match floor.chain(scents).chain(lights).nth(index) {
            Some(place) => *place = to,
            None => return Err(format!("there is no source {index}").into()),
        }
        let world = world.clone().with_sources(sources)?;
        self.replace_world(world);
        Ok(())
    }

    /// What can be perceived where the robot is, if there is anything.
    pub(super) fn sensed(&self) -> Option<SensedDto> {
        if self.body.world().sources().is_empty() {
            return None;
        }
        let sensed = self.body.sensed();
        Some(SensedDto {
            scent: Rounded(sensed.scent),
            light: Rounded(sensed.light),
            floor: hex(sensed.floor),
        })
    }
}
