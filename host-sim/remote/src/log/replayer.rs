//! Feeds the events of a log to a controller and compares its answers.

use super::record::{AnswerRecord, EventKind, EventRecord};
use super::setup_record::SetupRecord;
use crate::link::Knowledge;
use amp::controller::{Event, Mode, Outputs};
use amp::units::Millis;
use files::hex::unhex;
use sim::error::EpisodeError;
use sim::pilot::Pilot as _;
use sim::senses::SenseGoal;
use sim::sim_controller::SimController;
use std::collections::VecDeque;

/// Limit for the ticks of learning.
const MAX_TICKS: u32 = 10_000_000;

/// A controller and its answers that are not compared yet.
pub struct Replayer {
    controller: SimController,
    answers: VecDeque<AnswerRecord>,
}

impl Replayer {
    /// A controller that starts with these conditions.
    #[must_use]
    pub fn new(setup: &SetupRecord) -> Self {
        Self {
            controller: SimController::told(
                &setup.config,
                setup.robot.as_ref().map(|robot| &robot.told),
            ),
            answers: VecDeque::new(),
        }
    }

    /// The controller in its current state.
    #[must_use]
    pub fn controller(&self) -> &SimController {
        &self.controller
    }

    /// Applies an event; calls `on_outputs` with each result.
    ///
    /// # Errors
    /// What is wrong with the event, in words.
    pub fn apply(
        &mut self,
        record: &EventRecord,
        mut on_outputs: impl FnMut(&Outputs<16>),
    ) -> Result<(), String> {
        let at = Millis::from_ms(record.at_ms);
        match &record.event {
            EventKind::Echoes(echoes) => {
                let echoes: Vec<_> = echoes.iter().map(|echo| echo.echo()).collect();
                let mut rest = &echoes[..];
                while !rest.is_empty() {
                    let (taken, outputs) = self.controller.echoes(at, rest);
                    self.collect(at, &outputs, &mut on_outputs);
                    rest = rest.get(taken.max(1)..).unwrap_or(&[]);
                }
            }
            EventKind::Ticks { count, done } => self.tick(at, *count, *done, &mut on_outputs),
            EventKind::Configure(config) => self.controller.configure((**config).clone()),
            EventKind::Know(hex) => self.know(hex, at)?,
            EventKind::LeadTo(aim) => told(self.controller.lead_to(*aim))?,
            EventKind::Sense(readings) => self.controller.sense(at, readings),
            EventKind::SeekSense(goal) => {
                let goal = goal.as_deref().map(str::parse::<SenseGoal>).transpose();
                let goal = goal.map_err(|why| why.to_string())?;
                told(self.controller.seek_sense(goal))?;
            }
            other => {
                if let Some(event) = other.event() {
                    let outputs = self.controller.handle(at, event);
                    self.collect(at, &outputs, &mut on_outputs);
                }
            }
        }
        Ok(())
    }

    /// Ticks that ended learning do so here too, whatever their number. At most the last tick has
    /// an answer; a second tick of the same time does nothing where it is no step of thinking.
    fn tick(
        &mut self,
        at: Millis,
        count: u32,
        done: bool,
        on_outputs: &mut impl FnMut(&Outputs<16>),
    ) {
        let max_ticks = if done { MAX_TICKS } else { count };
        for _ in 0..max_ticks.min(MAX_TICKS) {
            let outputs = self.controller.handle(at, Event::Tick);
            self.collect(at, &outputs, on_outputs);
            if outputs != Outputs::NONE || !self.thinks() {
                break;
            }
        }
    }

    /// Whether each tick is a step of learning or of finding sensors.
    fn thinks(&self) -> bool {
        match self.controller.as_turret() {
            Some(turret) => turret.thinks(),
            None => matches!(self.controller.state().mode(), Mode::Learn { .. }),
        }
    }

    fn know(&mut self, hex: &str, at: Millis) -> Result<(), String> {
        let bytes = unhex(hex).ok_or("knowledge: not in hexadecimal")?;
        let knowledge = Knowledge::from_bytes(&bytes).map_err(|why| format!("knowledge: {why}"))?;
        knowledge.give_to(&mut self.controller, at);
        Ok(())
    }

    fn collect(
        &mut self,
        at: Millis,
        outputs: &Outputs<16>,
        on_outputs: &mut impl FnMut(&Outputs<16>),
    ) {
        self.answers.extend(AnswerRecord::of(at.as_ms(), outputs));
        on_outputs(outputs);
    }

    /// Compares the next answer with that of the log; returns the difference in words.
    pub fn compare(&mut self, logged: &AnswerRecord) -> Option<String> {
        let found = self.answers.pop_front();
        (found.as_ref() != Some(logged)).then(|| difference_text(Some(logged), found.as_ref()))
    }

    /// An answer that the log lacks, in words.
    pub fn unlogged_answer(&mut self) -> Option<String> {
        let found = self.answers.pop_front()?;
        Some(difference_text(None, Some(&found)))
    }
}

/// What the controller was told, it took.
fn told(taken: Result<(), EpisodeError>) -> Result<(), String> {
    taken.map_err(|why| why.to_string())
}

fn difference_text(logged: Option<&AnswerRecord>, found: Option<&AnswerRecord>) -> String {
    let at = logged.or(found).map_or(0, |answer| answer.at_ms);
    format!(
        "at {:.3} s of the controller's clock: the log says {}, the controller {}",
        f64::from(at) / 1e3,
        answer_text(logged),
        answer_text(found)
    )
}

fn answer_text(answer: Option<&AnswerRecord>) -> String {
    answer.map_or("nothing".to_owned(), |answer| {
        serde_json::to_string(answer).unwrap_or_else(|error| error.to_string())
    })
}
