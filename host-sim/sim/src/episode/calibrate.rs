//! Random moves that teach a controller where its sensors look.

use super::Seeds;
use super::drive::EpisodeRunner;
use super::setup::Setup;
use crate::error::EpisodeError;
use crate::pilot::Pilot;
use amp::controller::Event;

impl EpisodeRunner<'_> {
    /// Drives until the controller knows where its sensors look, if it is not told. Each of its
    /// moves is a step.
    pub(super) fn calibrate(
        &mut self,
        pilot: &mut impl Pilot,
        setup: &Setup,
    ) -> Result<(), EpisodeError> {
        let seed = Seeds::of(setup.seed).exploration.wrapping_add(1);
        let robot = setup.robot.as_ref();
        let calibration = robot.and_then(|robot| robot.calibration(setup.explore_moves, seed));
        let Some(calibration) = calibration else {
            return Ok(());
        };
        self.command(pilot, calibration)?;
        let mut moved_s = self.body.time_s();
        let mut motion = self.body.motion_id();
        loop {
            let result = self.body.advance(pilot);
            pilot.failure().map_or(Ok(()), Err)?;
            if let Some(reason) = result.stopped {
                return Err(EpisodeError::Stopped(reason));
            }
            if motion != self.body.motion_id() {
                motion = self.body.motion_id();
                self.close();
                self.open.get_or_insert_default();
                moved_s = self.body.time_s();
            }
            self.follow(&result);
            if result.mode_changed {
                break;
            }
            let silent_s = f64::from(Self::MAX_SILENT_RINGS) * self.body.ring_s();
            if self.body.time_s() - moved_s > silent_s {
                return Err(EpisodeError::Silent);
            }
        }
        self.close();
        self.think(pilot)
    }

    /// Lets time pass until the controller has worked something out.
    pub(super) fn think(&mut self, controller: &mut impl Pilot) -> Result<(), EpisodeError> {
        loop {
            let outputs = controller.handle(self.body.now(), Event::Tick);
            controller.failure().map_or(Ok(()), Err)?;
            if let Some(reason) = outputs.stopped {
                return Err(EpisodeError::Stopped(reason));
            }
            if outputs.mode_changed {
                return Ok(());
            }
        }
    }
}
