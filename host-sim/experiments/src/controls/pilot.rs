//! A controller whose action map is replaced after it has learned; all else stays as it is.

use super::slot::{MoveSample, Slot, coded, cosine, fit, nearest_fit, pool};
use amp::config::Config;
use amp::controller::{self, Event, Mode, Outputs};
use amp::fixed::{Mask, Weight};
use amp::units::Millis;
use sim::episode::square_grid;
use sim::error::EpisodeError;
use sim::pilot::{InspectableController, LocalController, Pilot, SimState};

/// The controller with another predictor in place of its action map.
pub struct ControlPilot<const NEURONS: usize = 16> {
    mind: LocalController<NEURONS>,
    slot: Slot,
    /// The samples that the slot predicts from; empty where it needs none.
    samples: Vec<MoveSample>,
    has_replaced: bool,
}

impl<const NEURONS: usize> ControlPilot<NEURONS> {
    /// A controller without any knowledge.
    #[must_use]
    pub fn new(config: Config<16>, slot: Slot) -> Self {
        Self {
            mind: LocalController::sized(config, square_grid(NEURONS)),
            slot,
            samples: Vec::new(),
            has_replaced: false,
        }
    }

    /// Fills the slot when learning has ended.
    fn replace(&mut self) {
        self.has_replaced = true;
        let config = self.mind.config();
        let remembered = self.mind.state().memory().samples();
        let slopes = match self.slot {
            Slot::Trained => return,
            Slot::Cosine { gain } => cosine(config, gain),
            Slot::LeastSquares { turned } => fit(pool(config, remembered, turned).iter()),
            Slot::Nearest { turned, .. } => {
                self.samples = pool(config, remembered, turned);
                return;
            }
        };
        self.mind
            .replace_actions(coded(&slopes, square_grid(NEURONS)));
    }

    /// The situation that this event lets the controller decide by, if it does.
    fn decides_by(&self, at: Millis, event: Event<16>) -> Option<[Weight; 16]> {
        let Event::Echo { sensor, .. } = event else {
            return None;
        };
        let state = self.mind.state();
        // Saves most copies of the state: only the last echo of a ring leads to a decision.
        let others = self.mind.enabled().without(sensor.into());
        let seeks = matches!(state.mode(), Mode::Seek { .. });
        if !seeks || state.is_moving() || !state.scan().is_complete(others) {
            return None;
        }
        let mut ahead = state.clone();
        let outputs = controller::handle(self.mind.config(), &mut ahead, at, event);
        outputs.decision.map(|decision| decision.situation)
    }
}

impl<const NEURONS: usize> Pilot for ControlPilot<NEURONS> {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        if let Slot::Nearest { count, .. } = self.slot
            && let Some(situation) = self.decides_by(at, event)
        {
            let slopes = nearest_fit(&self.samples, &situation, count);
            self.mind
                .replace_actions(coded(&slopes, square_grid(NEURONS)));
        }
        let outputs = self.mind.handle(at, event);
        if !self.has_replaced && self.mind.state().has_learned() {
            self.replace();
        }
        outputs
    }
}

impl<const NEURONS: usize> InspectableController for ControlPilot<NEURONS> {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        self.mind.knowledge()
    }

    fn known_at_nest(&mut self) -> Result<Mask, EpisodeError> {
        self.mind.known_at_nest()
    }
}
