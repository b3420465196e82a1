//! What a robot senses beside ranges.

use super::Body;
use crate::senses::{NOISE, Readings};
use arena::noise::Noise;
use arena::sonar::SonarModel;
use arena::sources::Sensed;

impl Body<'_> {
    /// The same robot with this seed for what it senses beside ranges.
    #[must_use]
    pub fn sensing(mut self, seed: u64) -> Self {
        self.sense_noise = Noise::new(seed);
        self
    }

    /// What can be perceived beside ranges where it is.
    #[must_use]
    pub fn sensed(&self) -> Sensed {
        self.world.sensed(self.pose().position, self.time_s)
    }

    /// What its sensors read of that. They are as exact as its sonars.
    pub fn read(&mut self) -> Readings {
        let sensed = self.sensed();
        let is_exact = self.ring.model() == SonarModel::Ideal;
        let noise = &mut self.sense_noise;
        Readings::of(&sensed, || match is_exact {
            true => 1.0,
            false => 1.0 + NOISE * noise.normal(),
        })
    }
}
