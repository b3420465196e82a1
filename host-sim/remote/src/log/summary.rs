//! What is in a log, at a glance.

use super::channel;
use super::read::{Ending, LogFile};
use super::record::{Answer, EventRecord, Happening};
use amp::controller::Progress;
use amp::units::Displacement;
use files::error::BadInput;
use std::collections::BTreeMap;

/// What a log holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Messages by channel.
    pub messages: BTreeMap<String, u64>,
    /// Time of the last message, seconds since the episode began.
    pub last_s: f64,
    /// What the mind was told to do, and when, seconds.
    pub commands: Vec<(f64, &'static str)>,
    /// Decisions towards a goal.
    pub decisions: u64,
    /// Random moves.
    pub random_moves: u64,
    /// Decisions in which the goal held.
    pub at_goal: u64,
    /// Decisions whose motion the shield shortened.
    pub shortened: u64,
    /// Motions that ended at a touch.
    pub contacts: u64,
    /// Way traveled by the base's own account, meters.
    pub distance_m: f64,
    /// How it ends.
    pub ending: Ending,
}

impl Summary {
    /// Of a log.
    ///
    /// # Errors
    /// When a message is not what its channel should hold.
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

    fn event(&mut self, seconds: f64, event: &Happening) {
        let command = match event {
            Happening::Odometry {
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
            Happening::Explore { .. } => "explore",
            Happening::Learn => "learn",
            Happening::Seek(_) => "seek",
            Happening::Stop => "stop",
            Happening::Resume => "resume",
            Happening::Alarm(_) => "alarm",
            Happening::Touched => "bumper",
            Happening::Configure(_) => "other choices",
            Happening::Know(_) => "knowledge from a file",
            Happening::Echoes(_) | Happening::Ticks { .. } => return,
        };
        self.commands.push((seconds, command));
    }

    fn answer(&mut self, answer: &Answer) {
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
