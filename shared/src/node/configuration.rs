//! The node's configuration: the only place that writes it, and only while the robot stands.
//!
//! It is written at the start, by an upload, by a parameter and by a saved image. What belongs to a
//! session (open space, the source of echoes, the clock) is not part of it.

use super::{Identity, Node};
use crate::body::Body;
use crate::config::Config;
use crate::goal::Goal;
use crate::parameters::{Parameter, ParameterError};
use crate::som::Grid;
use crate::store::{ContentsMut, ImageError};

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize, B: Body<SENSORS>>
    Node<SENSORS, NEURONS, SAMPLES, B>
{
    /// The first half of [`start`](Self::start), for a device that reads a saved image before the
    /// hello.
    pub fn prepare(&mut self, config: &Config<SENSORS>, grid: Grid, identity: Identity) {
        self.config.clone_from(config);
        self.state.set_grid(grid);
        self.identity = identity;
        self.goal = Goal::avoiding(&self.config);
    }

    /// Replaces configuration, body, maps, memory, places and goals by those of a saved image; for
    /// a node that stands still.
    ///
    /// # Errors
    /// [`ImageError`]; nothing has changed then, see [`ContentsMut::read`].
    pub fn recall(
        &mut self,
        read: &mut dyn FnMut(usize, &mut [u8]) -> bool,
        most: usize,
    ) -> Result<(), ImageError> {
        let mut contents = ContentsMut {
            config: &mut self.config,
            body: &mut self.body,
            state: &mut self.state,
            goal: &mut self.goal,
            goals: &mut self.goals,
        };
        contents.read(read, most)?;
        self.underway = None;
        Ok(())
    }

    /// Replaces the configuration by an uploaded one.
    pub(super) fn replace_config(&mut self, config: Config<SENSORS>) {
        self.config = config;
        self.state.trust(self.config.enabled);
    }

    /// Changes one value of the configuration.
    pub(super) fn set_parameter(
        &mut self,
        parameter: Parameter,
        value: i32,
    ) -> Result<(), ParameterError> {
        parameter.set(&mut self.config, value)?;
        if parameter == Parameter::Enabled {
            self.state.trust(self.config.enabled);
        }
        Ok(())
    }
}
