//! Random moves that teach a pilot where its sensors look.

use super::drive::EpisodeRunner;
use crate::error::EpisodeError;
use crate::pilot::Pilot;

impl EpisodeRunner<'_> {
    /// Drives until the pilot knows where its sensors look. Each of its moves is a step.
    pub(super) fn calibrate(&mut self, pilot: &mut impl Pilot) -> Result<(), EpisodeError> {
        let mut last = pilot.calibration_moves_left();
        let mut moved_s = self.body.time_s();
        while let Some(left) = pilot.calibration_moves_left() {
            let result = self.body.advance(pilot);
            if last != Some(left) {
                self.close();
                (last, moved_s) = (Some(left), self.body.time_s());
            }
            self.open.get_or_insert_default();
            self.follow(&result);
            let silent_s = f64::from(Self::MAX_SILENT_RINGS) * self.body.ring_s();
            if self.body.time_s() - moved_s > silent_s {
                return Err(EpisodeError::Silent);
            }
        }
        self.close();
        Ok(())
    }
}
