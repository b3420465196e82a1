//! Shows a log: the controller is replayed, and its maps and plans are visible at any time.
//!
//! Going back replays from the beginning; ten thousand decisions take a fifth of a second. Every
//! answer is compared with the log's, as [`replay`](remote::log::replay()) does.

mod parts;
mod playback;
mod timeline;

use super::command::{CommandOutcome, PageCommand};
use super::configure::knowledge_file;
use super::dto::KnowledgeParts;
use super::echo_trail::EchoTrail;
use super::snapshot::{PlacesDto, SceneDto, Snapshot, SnapshotPart};
use super::source::{Capabilities, CommandRefused, StepOutcome, ViewSource};
use files::error::BadInput;
use playback::Playback;
use remote::link::Knowledge;
use remote::log::LogFile;
use std::sync::Arc;
use timeline::{Timeline, TimelineItem};

/// Longer pauses are shortened to this, s; the robot was carried.
const LONGEST_WAIT_S: f64 = 2.0;

/// A time without a pose is divided into steps of this length, s.
const LONGEST_STEP_S: f64 = 0.2;

/// A log that is watched.
pub struct WatchedLog {
    timeline: Timeline,
    /// Index of the next item.
    at: usize,
    playback: Playback,
    cache: LogCache,
}

/// Parts of the latest snapshot, and the number of snapshots.
#[derive(Default)]
struct LogCache {
    revision: u64,
    scene: Option<(u32, Arc<SnapshotPart<SceneDto>>)>,
    places: Option<Arc<SnapshotPart<PlacesDto>>>,
    knowledge: KnowledgeParts,
}

impl WatchedLog {
    /// Opens a log at its beginning.
    ///
    /// # Errors
    /// When it cannot be read or holds no decision.
    pub fn new(log: &LogFile) -> Result<Self, BadInput> {
        let timeline = Timeline::read(log)?;
        let playback = Playback::new(log.setup(), &timeline, EchoTrail::new());
        let mut recorded = Self {
            timeline,
            at: 0,
            playback,
            cache: LogCache::default(),
        };
        recorded.set_scene();
        Ok(recorded)
    }

    /// Applies the items before the first event; the robot stands at its first pose.
    fn set_scene(&mut self) {
        let mut items = self.timeline.items.iter();
        let first = items.find_map(|(_, item)| match item {
            TimelineItem::Pose(pose) => Some(*pose),
            _ => None,
        });
        while let Some((
            _,
            item @ (TimelineItem::Start(_) | TimelineItem::World(..) | TimelineItem::Leader(_)),
        )) = self.timeline.items.get(self.at)
        {
            self.playback.take(item, &self.timeline);
            self.at += 1;
        }
        let pose = first.unwrap_or_default();
        (self.playback.pose, self.playback.scan_pose) = (pose, pose);
    }

    /// Advances to the next pose, or by the longest step.
    fn advance(&mut self) {
        let Some(&(began, _)) = self.timeline.items.get(self.at) else {
            return;
        };
        let playback = &mut self.playback;
        let mut is_whole = false;
        while let Some((time_ns, item)) = self.timeline.items.get(self.at) {
            let late = *time_ns > began.saturating_add((LONGEST_STEP_S * 1e9) as u64);
            if late && matches!(item, TimelineItem::Event(_) | TimelineItem::Start(_)) {
                break;
            }
            is_whole = matches!(item, TimelineItem::Pose(_));
            playback.time_s = *time_ns as f64 / 1e9;
            playback.take(item, &self.timeline);
            self.at += 1;
            if is_whole || playback.difference.is_some() {
                break;
            }
        }
        let rest = self.timeline.items.get(self.at..).unwrap_or(&[]);
        let now = rest.first().map_or(began, |(time_ns, _)| *time_ns);
        let took_s = now.saturating_sub(began) as f64 / 1e9;
        playback.step_s = took_s.min(LONGEST_WAIT_S);
        // As in a simulation, a step is executed when it is shown.
        if took_s < LONGEST_WAIT_S {
            let mut places = rest
                .iter()
                .take_while(|(_, item)| !matches!(item, TimelineItem::Start(_)));
            let next = places.find_map(|(_, item)| match item {
                TimelineItem::Pose(pose) => Some(*pose),
                _ => None,
            });
            if let Some(pose) = next.filter(|_| is_whole) {
                playback.end_step(pose);
            }
        }
    }

    /// Jumps to a number of decisions.
    fn jump(&mut self, to: usize) {
        let to = to.min(self.timeline.decisions);
        if to < self.playback.decided || self.playback.difference.is_some() {
            self.at = 0;
            let setup = self.playback.setup.clone();
            self.playback =
                Playback::new(&setup, &self.timeline, self.playback.echo_trail.restarted());
            self.set_scene();
        }
        while self.playback.decided < to && !self.is_over() {
            self.advance();
        }
        self.cache.knowledge.invalidate();
        self.cache.scene = None;
    }

    fn is_over(&self) -> bool {
        self.at >= self.timeline.items.len() || self.playback.difference.is_some()
    }
}

impl ViewSource for WatchedLog {
    fn abilities(&self) -> Capabilities {
        Capabilities {
            pace: true,
            save: true,
            jump: true,
            places: self.playback.seen_places().is_some(),
            ..Capabilities::default()
        }
    }

    fn step(&mut self) -> StepOutcome {
        if self.is_over() {
            return StepOutcome::Idle;
        }
        let (decided, starts) = (self.playback.decided, self.playback.starts);
        let learned = self.learns();
        self.advance();
        let whole = self.playback.decided > decided;
        if whole || learned != self.learns() {
            self.cache.knowledge.invalidate_maps();
        }
        if starts != self.playback.starts {
            self.cache.knowledge.invalidate();
        }
        StepOutcome::Took {
            took_s: self.playback.step_s,
            whole,
        }
    }

    fn execute(&mut self, command: &PageCommand) -> Result<CommandOutcome, CommandRefused> {
        let controller = self.playback.replayer.controller();
        match command {
            PageCommand::Jump { to } => self.jump(*to),
            PageCommand::SaveMind => {
                return Ok(knowledge_file(&Knowledge::of_controller(controller)));
            }
            // Stop is allowed for all, so it is no error here.
            PageCommand::Stop => {}
            _ => return Err("this is a recording: it cannot be steered".into()),
        }
        Ok(CommandOutcome::Done)
    }

    fn snapshot(&mut self) -> Snapshot {
        self.parts()
    }
}

#[cfg(test)]
mod tests;
