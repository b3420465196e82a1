//! Running the mind again from a log: every answer must be the same, bit for bit.

use super::channel;
use super::read::{Ending, LogFile, Message};
use super::record::{Answer, EventRecord, Happening};
use crate::error::BadInput;
use crate::pilot::{Mind, Pilot};
use amp::controller::{Event, Outputs};
use amp::units::Millis;
use std::collections::VecDeque;

/// Ticks after which a mind counts as one that never stops learning.
const MOST_TICKS: u32 = 10_000_000;

/// What came of a replay.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Replayed {
    /// Events handed to the mind.
    pub events: u64,
    /// Answers compared.
    pub answers: u64,
    /// Decisions among them.
    pub decisions: u64,
    /// Time of the last event, milliseconds by the mind's clock.
    pub last_ms: u32,
    /// How the log ends.
    pub ending: Ending,
    /// The first answer that differs, in words.
    pub difference: Option<String>,
}

/// Runs the mind of a log again; `progress` hears the time of each event, milliseconds.
///
/// # Errors
/// When a message is not what its channel should hold.
pub fn replay(log: &LogFile, mut progress: impl FnMut(u32)) -> Result<Replayed, BadInput> {
    let mut replay = Replay {
        mind: Mind::new(log.setup().config.clone()),
        answers: VecDeque::new(),
        done: Replayed {
            events: 0,
            answers: 0,
            decisions: 0,
            last_ms: 0,
            ending: Ending::Complete,
            difference: None,
        },
    };
    let mut messages = log.messages();
    for message in messages.by_ref() {
        replay
            .take(&message)
            .map_err(|why| BadInput::file(log.path(), why))?;
        progress(replay.done.last_ms);
        if replay.done.difference.is_some() {
            break;
        }
    }
    replay.done.ending = messages.ending();
    replay.end();
    Ok(replay.done)
}

struct Replay {
    mind: Mind,
    /// What the mind answered and the log has not yet said.
    answers: VecDeque<Answer>,
    done: Replayed,
}

impl Replay {
    fn take(&mut self, message: &Message) -> Result<(), String> {
        match message.topic.as_str() {
            channel::EVENT => self.event(&message.content()?),
            channel::PLAN => self.compare(&message.content()?),
            _ => {}
        }
        Ok(())
    }

    fn event(&mut self, record: &EventRecord) {
        // What the mind said to the events before, the log says before this one.
        self.nothing_left();
        self.done.events += 1;
        self.done.last_ms = record.at_ms;
        let at = Millis::from_ms(record.at_ms);
        match &record.event {
            Happening::Echoes(echoes) => {
                let echoes: Vec<_> = echoes.iter().map(|echo| echo.echo()).collect();
                let mut left = &echoes[..];
                while !left.is_empty() {
                    let (taken, outputs) = self.mind.echoes(at, left);
                    self.answered(at, &outputs);
                    left = left.get(taken.max(1)..).unwrap_or(&[]);
                }
            }
            Happening::Ticks { count, done } => self.ticks(at, *count, *done),
            other => {
                if let Some(event) = other.event() {
                    let outputs = self.mind.handle(at, event);
                    self.answered(at, &outputs);
                }
            }
        }
    }

    /// Ticks that ended learning do so here as well, however many it takes.
    fn ticks(&mut self, at: Millis, count: u32, done: bool) {
        let most = if done { MOST_TICKS } else { count };
        for _ in 0..most {
            let outputs = self.mind.handle(at, Event::Tick);
            self.answered(at, &outputs);
            if done && outputs.mode_changed {
                break;
            }
        }
    }

    fn answered(&mut self, at: Millis, outputs: &Outputs<16>) {
        self.answers.extend(Answer::of(at.as_ms(), outputs));
    }

    fn compare(&mut self, logged: &Answer) {
        self.done.answers += 1;
        self.done.decisions += u64::from(logged.decision.is_some());
        let found = self.answers.pop_front();
        if found.as_ref() != Some(logged) {
            self.differs(Some(logged), found.as_ref());
        }
    }

    fn nothing_left(&mut self) {
        if let Some(found) = self.answers.pop_front() {
            self.differs(None, Some(&found));
        }
    }

    /// A log that is cut off may lack the answers to its last event.
    fn end(&mut self) {
        if self.done.ending == Ending::Complete && self.done.difference.is_none() {
            self.nothing_left();
        }
    }

    fn differs(&mut self, logged: Option<&Answer>, found: Option<&Answer>) {
        let decisions = self.done.decisions;
        let at = logged.or(found).map_or(0, |answer| answer.at_ms);
        let difference = format!(
            "after {decisions} decisions, at {:.3} s: the log says {}, the mind {}",
            f64::from(at) / 1e3,
            said(logged),
            said(found)
        );
        self.done.difference.get_or_insert(difference);
    }
}

fn said(answer: Option<&Answer>) -> String {
    answer.map_or("nothing".to_owned(), |answer| {
        serde_json::to_string(answer).unwrap_or_else(|error| error.to_string())
    })
}
