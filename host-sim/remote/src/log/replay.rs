//! Running the mind again from a log: every answer must be the same, bit for bit.

use super::channel;
use super::read::{Ending, LogFile, Message};
use super::record::{Answer, EventRecord};
use super::retell::Replayer;
use files::error::BadInput;

/// What came of a replay.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Replayed {
    /// Events handed to the mind.
    pub events: u64,
    /// Answers compared.
    pub answers: u64,
    /// Decisions among them.
    pub decisions: u64,
    /// Time of the last event since the log began, milliseconds.
    pub last_ms: u64,
    /// How the log ends.
    pub ending: Ending,
    /// The first answer that differs, in words.
    pub difference: Option<String>,
}

/// Runs the mind of a log again; `progress` hears the time of each event since the log began, milliseconds.
///
/// # Errors
/// When a message is not what its channel should hold.
pub fn replay(log: &LogFile, mut progress: impl FnMut(u64)) -> Result<Replayed, BadInput> {
    let mut replay = Replay {
        retold: Replayer::new(log.setup()),
        done: Replayed {
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
            .take(&message)
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
    retold: Replayer,
    done: Replayed,
}

impl Replay {
    fn take(&mut self, message: &Message) -> Result<(), String> {
        match message.topic.as_str() {
            channel::SETUP => {
                self.nothing_left();
                self.retold = Replayer::new(&message.content()?);
            }
            channel::EVENT => {
                // What the mind said to the events before, the log says before this one.
                self.nothing_left();
                self.done.events += 1;
                self.done.last_ms = message.time_ns / 1_000_000;
                let record: EventRecord = message.content()?;
                self.retold.tell(&record, |_| {})?;
            }
            channel::PLAN => self.compare(&message.content()?),
            _ => {}
        }
        Ok(())
    }

    fn compare(&mut self, logged: &Answer) {
        self.done.answers += 1;
        self.done.decisions += u64::from(logged.decision.is_some());
        if let Some(difference) = self.retold.compare(logged) {
            self.differs(&difference);
        }
    }

    fn nothing_left(&mut self) {
        if let Some(difference) = self.retold.unsaid() {
            self.differs(&difference);
        }
    }

    /// A log that is cut off may lack the answers to its last event.
    fn end(&mut self) {
        if self.done.ending == Ending::Complete && self.done.difference.is_none() {
            self.nothing_left();
        }
    }

    fn differs(&mut self, difference: &str) {
        let decisions = self.done.decisions;
        let difference = format!("after {decisions} decisions, {difference}");
        self.done.difference.get_or_insert(difference);
    }
}
