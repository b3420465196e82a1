//! The controller in this process that is told what a device is told.
//!
//! A link carries decisions and motions, not what the robot's points and places are at each moment.
//! Device and host run the same crate and decide the same to the bit, so these are read here, and
//! every decision is compared.

use super::LinkError;
use amp::config::Config;
use amp::controller::{Event, Outputs};
use amp::places::Aim;
use amp::units::Millis;
use sim::error::EpisodeError;
use sim::pilot::{AgedEcho, Pilot as _};
use sim::robot::ToldRobot;
use sim::senses::{Readings, SenseGoal};
use sim::turret_pilot::TurretController;

/// More ticks than learning and finding the sensors take.
const MAX_TICKS: u32 = 1_000_000;

/// The twin of a controller at the end of a link whose places lead it.
pub(super) struct Twin {
    controller: Box<TurretController>,
    /// Where it is led.
    aim: Option<Aim>,
}

impl Twin {
    /// A twin of a controller that was told this of its robot, without any knowledge.
    pub fn new(config: &Config<16>, robot: &ToldRobot) -> Self {
        Self {
            controller: Box::new(TurretController::told(config.clone(), robot)),
            aim: None,
        }
    }

    /// The controller.
    pub fn controller(&self) -> &TurretController {
        &self.controller
    }

    /// Replaces the configuration and keeps the knowledge.
    pub fn configure(&mut self, config: &Config<16>) {
        self.controller.configure(config.clone());
    }

    /// Takes an event to which the device gave this answer. A tick on which the device learned, or
    /// found its sensors, is as many as that takes.
    ///
    /// # Errors
    /// [`LinkError::DecidesOtherwise`].
    pub fn follow(
        &mut self,
        at: Millis,
        event: Event<16>,
        answer: &Outputs<16>,
    ) -> Result<(), LinkError> {
        let mut outputs = match event {
            // They come from the device's side of the link, which reports what they change.
            Event::Alarm(_) | Event::Touched => return Ok(()),
            event => self.controller.handle(at, event),
        };
        for _ in 0..MAX_TICKS {
            if event != Event::Tick || outputs.mode_changed || !self.controller.thinks() {
                break;
            }
            outputs = self.controller.handle(at, Event::Tick);
        }
        compare(at, &outputs, answer)
    }

    /// As [`follow`](Self::follow), with echoes.
    ///
    /// # Errors
    /// As there.
    pub fn follow_echoes(
        &mut self,
        at: Millis,
        echoes: &[AgedEcho],
        answer: &Outputs<16>,
    ) -> Result<(), LinkError> {
        let (_, outputs) = self.controller.echoes(at, echoes);
        compare(at, &outputs, answer)
    }

    /// The device is led there.
    pub fn lead_to(&mut self, aim: Option<Aim>) {
        self.aim = aim;
        // A controller in this process takes every aim.
        let _ = self.controller.lead_to(aim);
    }

    /// What else the robot's sensors read, where it is now. Returns where it is to be led from now
    /// on, if that is elsewhere than before.
    pub fn sense(&mut self, at: Millis, readings: &Readings) -> Option<Aim> {
        let aim = self.controller.perceive(at, readings);
        aim.filter(|aim| Some(*aim) != self.aim)
    }

    /// From now on this is looked for in another modality.
    ///
    /// # Errors
    /// When its places do not lead it.
    pub fn seek_sense(&mut self, goal: Option<SenseGoal>) -> Result<(), EpisodeError> {
        self.controller.seek_sense(goal)
    }
}

/// Compares what the twin answers with what the device did, as far as the link tells it.
fn compare(at: Millis, twin: &Outputs<16>, device: &Outputs<16>) -> Result<(), LinkError> {
    let told = |outputs: &Outputs<16>| {
        (
            outputs.decision,
            outputs.motion,
            outputs.mode_changed,
            outputs.refusal,
        )
    };
    if told(twin) == told(device) {
        return Ok(());
    }
    Err(LinkError::DecidesOtherwise { at })
}
