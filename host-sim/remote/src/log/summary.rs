//! Summarizes a log: messages, commands, decisions and distance.

use super::channel;
use super::read::{Ending, LogFile};
use super::record::{AnswerRecord, EventKind, EventRecord};
use amp::controller::Progress;
use amp::units::Displacement;
use files::error::BadInput;
use std::collections::BTreeMap;

/// Summary of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Number of messages by channel.
    pub messages: BTreeMap<String, u64>,
    /// Time of the last message since the log began, seconds.
    pub last_s: f64,
    /// Commands and their times, seconds.
    pub commands: Vec<(f64, &'static str)>,
    /// Number of decisions with a goal.
    pub decisions: u64,
    /// Number of random moves.
    pub random_moves: u64,
    /// Number of decisions at the goal.
    pub at_goal: u64,
    /// Number of decisions whose motion the shield shortened.
    pub shortened: u64,
    /// Number of motions that ended at a contact.
    pub contacts: u64,
    /// Path length by odometry, meters.
    pub distance_m: f64,
    /// How it ends.
    pub ending: Ending,
}

impl Summary {
    /// Summarizes a log.
    ///
    /// # Errors
    /// When a message does not match its channel.
    pub fn of(log: &LogFile) -> Result<Self, BadInput> {
        let mut summary = Self {
            messages: BTreeMap::new(),
            last_s: 0.0,
            commands: Vec::new(),
            decisions: 0,
            random_moves: 0,
            at_goal: 0,
            shortened: 0,
            contacts: 0,
            distance_m: 0.0,
            ending: log.ending(),
        };
        for message in log.messages() {
            let refuse = |why| BadInput::file(log.path(), why);
            let seconds = message.time_ns as f64 / 1e9;
            summary.last_s = summary.last_s.max(seconds);
            match message.topic.as_str() {
                channel::EVENT => {
                    let record: EventRecord = message.content().map_err(refuse)?;
                    summary.event(seconds, &record.event);
                }
                channel::PLAN => summary.answer(&message.content().map_err(refuse)?),
                _ => {}
            }
            *summary.messages.entry(message.topic).or_default() += 1;
        }
        Ok(summary)
    }

    fn event(&mut self, seconds: f64, event: &EventKind) {
        let command = match event {
            EventKind::Odometry {
                moved_mm: [dx_mm, dy_mm],
                progress,
                ..
            } => {
                let moved = Displacement {
                    dx_mm: *dx_mm,
                    dy_mm: *dy_mm,
                };
                self.distance_m += f64::from(moved.length_mm()) / 1e3;
                self.contacts += u64::from(*progress == Progress::Touched);
                return;
            }
            EventKind::Explore { .. } => "explore",
            EventKind::Learn => "learn",
            EventKind::Seek(_) => "seek",
            EventKind::Stop => "stop",
            EventKind::Resume => "resume",
            EventKind::Calibrate { .. } => "calibrate",
            EventKind::Alarm(_) => "alarm",
            EventKind::Touched => "bumper",
            EventKind::Configure(_) => "other choices",
            EventKind::Know(_) => "knowledge from a file",
            EventKind::SeekSense(Some(_)) => "seek in another modality",
            EventKind::Echoes(_)
            | EventKind::Ticks { .. }
            | EventKind::LeadTo(_)
            | EventKind::Sense(_)
            | EventKind::SeekSense(None) => return,
        };
        self.commands.push((seconds, command));
    }

    fn answer(&mut self, answer: &AnswerRecord) {
        let Some(decision) = &answer.decision else {
            return;
        };
        match decision.plan {
            Some(_) => self.decisions += 1,
            None => self.random_moves += 1,
        }
        self.at_goal += u64::from(decision.at_goal);
        self.shortened += u64::from(decision.allowed_mm != decision.wanted_mm);
    }
}
