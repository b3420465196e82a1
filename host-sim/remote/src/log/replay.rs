//! Runs the controller of a log again; every answer must be the same, bit for bit.

use super::channel;
use super::read::{Ending, LogFile, LogMessage};
use super::record::{AnswerRecord, EventRecord};
use super::replayer::Replayer;
use files::error::BadInput;

/// Result of a replay.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReplayResult {
    /// Number of events.
    pub events: u64,
    /// Number of answers that were compared.
    pub answers: u64,
    /// Number of decisions among them.
    pub decisions: u64,
    /// Time of the last event since the log began, milliseconds.
    pub last_ms: u64,
    /// How the log ends.
    pub ending: Ending,
    /// The first difference, in words.
    pub difference: Option<String>,
}

/// Replays a log. `progress` is called with the time of each event since the log began,
/// milliseconds.
///
/// # Errors
/// When a message does not match its channel.
pub fn replay(log: &LogFile, mut progress: impl FnMut(u64)) -> Result<ReplayResult, BadInput> {
    let mut replay = Replay {
        replayer: Replayer::new(log.setup()),
        done: ReplayResult {
            events: 0,
            answers: 0,
            decisions: 0,
            last_ms: 0,
            ending: log.ending(),
            difference: None,
        },
    };
    for message in log.messages() {
        replay
            .process(&message)
            .map_err(|why| BadInput::file(log.path(), why))?;
        progress(replay.done.last_ms);
        if replay.done.difference.is_some() {
            break;
        }
    }
    replay.end();
    Ok(replay.done)
}

struct Replay {
    replayer: Replayer,
    done: ReplayResult,
}

impl Replay {
    fn process(&mut self, message: &LogMessage) -> Result<(), String> {
        match message.topic.as_str() {
            channel::SETUP => {
                self.check_unlogged();
                self.replayer = Replayer::new(&message.content()?);
            }
            channel::EVENT => {
                // The log holds all answers to earlier events before this event.
                self.check_unlogged();
                self.done.events += 1;
                self.done.last_ms = message.time_ns / 1_000_000;
                let record: EventRecord = message.content()?;
                self.replayer.apply(&record, |_| {})?;
            }
            channel::PLAN => self.compare(&message.content()?),
            _ => {}
        }
        Ok(())
    }

    fn compare(&mut self, logged: &AnswerRecord) {
        self.done.answers += 1;
        self.done.decisions += u64::from(logged.decision.is_some());
        if let Some(difference) = self.replayer.compare(logged) {
            self.record_difference(&difference);
        }
    }

    fn check_unlogged(&mut self) {
        if let Some(difference) = self.replayer.unlogged_answer() {
            self.record_difference(&difference);
        }
    }

    /// A log that was cut off may lack the answers to its last event.
    fn end(&mut self) {
        if self.done.ending == Ending::Complete && self.done.difference.is_none() {
            self.check_unlogged();
        }
    }

    fn record_difference(&mut self, difference: &str) {
        let decisions = self.done.decisions;
        let difference = format!("after {decisions} decisions, {difference}");
        self.done.difference.get_or_insert(difference);
    }
}
