//! A mind that is told again what a log says it was told.

use super::record::{Answer, EventRecord, Happening, Setup};
use crate::link::Knowledge;
use amp::controller::{Event, Mode, Outputs};
use amp::units::Millis;
use files::hex::unhex;
use sim::pilot::{LocalController, Pilot as _};
use std::collections::VecDeque;

/// Ticks after which a mind counts as one that never stops learning.
const MAX_TICKS: u32 = 10_000_000;

/// A mind of a log, and what it has answered that the log has not yet said.
pub struct Replayer {
    mind: LocalController,
    answers: VecDeque<Answer>,
}

impl Replayer {
    /// A mind that starts under these conditions.
    #[must_use]
    pub fn new(setup: &Setup) -> Self {
        Self {
            mind: LocalController::new(setup.config.clone()),
            answers: VecDeque::new(),
        }
    }

    /// The mind as it is now.
    #[must_use]
    pub fn mind(&self) -> &LocalController {
        &self.mind
    }

    /// Tells it something; `heard` hears what it makes of it.
    ///
    /// # Errors
    /// What cannot be told, in words.
    pub fn tell(
        &mut self,
        record: &EventRecord,
        mut heard: impl FnMut(&Outputs<16>),
    ) -> Result<(), String> {
        let at = Millis::from_ms(record.at_ms);
        match &record.event {
            Happening::Echoes(echoes) => {
                let echoes: Vec<_> = echoes.iter().map(|echo| echo.echo()).collect();
                let mut left = &echoes[..];
                while !left.is_empty() {
                    let (taken, outputs) = self.mind.echoes(at, left);
                    self.answered(at, &outputs, &mut heard);
                    left = left.get(taken.max(1)..).unwrap_or(&[]);
                }
            }
            Happening::Ticks { count, done } => self.tick(at, *count, *done, &mut heard),
            Happening::Configure(config) => self.mind.configure((**config).clone()),
            Happening::Know(hex) => self.mind = known(hex)?,
            other => {
                if let Some(event) = other.event() {
                    let outputs = self.mind.handle(at, event);
                    self.answered(at, &outputs, &mut heard);
                }
            }
        }
        Ok(())
    }

    /// Ticks that ended learning do so here as well, however many it takes. At most one answer comes of them, the last
    /// one's, and outside learning the second tick of a moment does what the first did: nothing.
    fn tick(&mut self, at: Millis, count: u32, done: bool, heard: &mut impl FnMut(&Outputs<16>)) {
        let most = if done { MAX_TICKS } else { count };
        for _ in 0..most.min(MAX_TICKS) {
            let outputs = self.mind.handle(at, Event::Tick);
            self.answered(at, &outputs, heard);
            let learns = matches!(self.mind.state().mode(), Mode::Learn { .. });
            if outputs != Outputs::NONE || !learns {
                break;
            }
        }
    }

    fn answered(
        &mut self,
        at: Millis,
        outputs: &Outputs<16>,
        heard: &mut impl FnMut(&Outputs<16>),
    ) {
        self.answers.extend(Answer::of(at.as_ms(), outputs));
        heard(outputs);
    }

    /// Compares its next answer with that of the log; what differs, in words.
    pub fn compare(&mut self, logged: &Answer) -> Option<String> {
        let found = self.answers.pop_front();
        (found.as_ref() != Some(logged)).then(|| differs(Some(logged), found.as_ref()))
    }

    /// What it has said and the log has not, in words.
    pub fn unsaid(&mut self) -> Option<String> {
        let found = self.answers.pop_front()?;
        Some(differs(None, Some(&found)))
    }
}

fn known(hex: &str) -> Result<LocalController, String> {
    let bytes = unhex(hex).ok_or("knowledge: not in hexadecimal")?;
    let knowledge = Knowledge::from_bytes(&bytes).map_err(|why| format!("knowledge: {why}"))?;
    let (config, state) = (knowledge.config(), knowledge.state());
    Ok(LocalController::with_state(config.clone(), state.clone()))
}

fn differs(logged: Option<&Answer>, found: Option<&Answer>) -> String {
    let at = logged.or(found).map_or(0, |answer| answer.at_ms);
    format!(
        "at {:.3} s of the mind's clock: the log says {}, the mind {}",
        f64::from(at) / 1e3,
        said(logged),
        said(found)
    )
}

fn said(answer: Option<&Answer>) -> String {
    answer.map_or("nothing".to_owned(), |answer| {
        serde_json::to_string(answer).unwrap_or_else(|error| error.to_string())
    })
}
