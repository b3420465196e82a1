//! A log as a demonstration: what the robot perceived at each decision with a goal, and where it
//! went.

use super::channel;
use super::read::LogFile;
use super::record::{EventKind, EventRecord};
use super::replayer::Replayer;
use amp::controller::Outputs;
use amp::fixed::Mask;
use amp::units::{Bearing, Displacement};
use files::error::BadInput;
use sim::demonstration::{Demonstration, DemonstrationRecorder, ShownStep};
use sim::sim_controller::SimController;

/// The steps of a log, and the controller at its end.
pub struct LoggedDemonstration {
    shown: Vec<ShownStep>,
    replayer: Replayer,
}

impl LoggedDemonstration {
    /// Replays a log.
    ///
    /// # Errors
    /// When a message does not match its channel.
    pub fn of(log: &LogFile) -> Result<Self, BadInput> {
        let mut replayer = Replayer::new(log.setup());
        let mut steps = Steps::default();
        for message in log.messages() {
            let refuse = |why| BadInput::file(log.path(), why);
            match message.topic.as_str() {
                // The robot began anew; what it had learned before is gone.
                channel::SETUP => {
                    replayer = Replayer::new(&message.content().map_err(refuse)?);
                    steps = Steps::default();
                }
                channel::EVENT => {
                    let record: EventRecord = message.content().map_err(refuse)?;
                    steps.event(&record.event);
                    let known = replayer.controller().enabled();
                    let decided = replayer.apply(&record, |outputs| steps.decision(outputs, known));
                    decided.map_err(refuse)?;
                }
                _ => {}
            }
        }
        let shown = steps.recorder.into_shown();
        Ok(Self { shown, replayer })
    }

    /// All decisions with a goal that the robot carried out.
    #[must_use]
    pub fn shown(&self) -> &[ShownStep] {
        &self.shown
    }

    /// The controller at the end of the log.
    #[must_use]
    pub fn controller(&self) -> &SimController {
        self.replayer.controller()
    }

    /// As a demonstration.
    #[must_use]
    pub fn demonstration(&self) -> Demonstration<'_> {
        Demonstration {
            shown: &self.shown,
            actions: self.controller().state().actions(),
            step_mm: self.controller().config().robot.step_mm,
        }
    }
}

/// Adds up the odometry between two decisions.
#[derive(Default)]
struct Steps {
    recorder: DemonstrationRecorder,
    /// Displacement since the last decision, in the ring's frame at it, and turn of the ring.
    moved: Displacement,
    turned: Bearing,
}

impl Steps {
    fn event(&mut self, event: &EventKind) {
        if let EventKind::Odometry {
            moved_mm: [dx_mm, dy_mm],
            turned,
            ..
        } = event
        {
            let moved = Displacement {
                dx_mm: *dx_mm,
                dy_mm: *dy_mm,
            };
            self.moved = self.moved.plus(moved.rotated(self.turned.direction()));
            self.turned = self.turned.plus(Bearing::from_turns(*turned));
        }
    }

    fn decision(&mut self, outputs: &Outputs<16>, known: Mask) {
        if let Some(decision) = &outputs.decision {
            let moved = std::mem::replace(&mut self.moved, Displacement::ZERO);
            let turned = std::mem::replace(&mut self.turned, Bearing::ZERO);
            let perceived = decision.plan.map(|_| (decision.situation, known));
            self.recorder.decided(moved, turned, perceived);
        }
    }
}
