//! Steps of a robot that stands and thinks: it learns its maps, or finds where its sensors look.

use super::{Simulator, SimulatorActivity, StepOutcome};
use amp::controller::Event;
use sim::error::EpisodeError;
use sim::pilot::Pilot as _;

/// Ticks of learning per step of the view, and the simulated duration of such a step, seconds.
const LEARNING: (u32, f64) = (50, 0.04);

impl Simulator {
    pub(super) fn think(&mut self) -> StepOutcome {
        let (ticks, took_s) = LEARNING;
        let now = self.body.now();
        let mut whole = false;
        for _ in 0..ticks {
            self.learning += 1;
            let outputs = self.controller.handle(now, Event::Tick);
            whole = outputs.mode_changed;
            self.check_controller();
            if let Some(reason) = outputs.stopped {
                self.fail(EpisodeError::Stopped(reason).to_string());
            }
            if whole || self.failure.is_some() {
                break;
            }
        }
        if whole && self.activity == SimulatorActivity::Calibrate {
            self.is_calibrated = true;
            if let Err(refused) = self.explore() {
                self.fail(refused.0);
            }
        } else if whole {
            (self.activity, self.learned) = (SimulatorActivity::Idle, true);
        }
        self.cache.knowledge.invalidate_maps();
        self.controller.pilot().invalidate_cache(whole);
        StepOutcome::Took { took_s, whole }
    }
}
