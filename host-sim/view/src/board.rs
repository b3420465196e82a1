//! Shows a board: a controller with its own ring and base at the end of a link.
//!
//! The link carries the mode, the decisions and, on request, the maps; it carries neither pose nor
//! ranges, so there is no arena. The session uses the board's clock: a silent link stops the robot.

mod parts;

use super::command::{CommandOutcome, PageCommand};
use super::configure::knowledge_file;
use super::dto::KnowledgeParts;
use super::goal::ActiveGoal;
use super::history::{History, history_entry};
use super::snapshot::{DriveCounts, PartMessage, SceneDto, Snapshot, SnapshotPart};
use super::source::{Capabilities, CommandRefused, StepOutcome, ViewSource};
use amp::config::Config;
use amp::controller::Decision;
use amp::fixed::Weight;
use amp::scan::Situation;
use amp::wire::DeviceMessage;
use amp::wire::message::{self, GoalSpec, ModeReport};
use arena::world::Point;
use files::hex::unhex;
use remote::link::{Knowledge, LinkError, Session};
use sim::behavior::Behavior;
use sim::episode::{Seeds, StepFlags};
use sim::pilot::SimState;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Interval of heartbeats: a third of the silence that a controller accepts.
const HEARTBEAT: Duration = Duration::from_millis(100);

/// Heartbeats between two queries of the mode. A heartbeat is not answered; a query is.
const MODE_POLL: u32 = 10;

/// Unanswered queries in a row after which the board counts as lost.
const MAX_SILENT: u32 = 3;

/// A board that is watched and steered.
pub struct WatchedBoard {
    session: Session,
    name: String,
    config: Config<16>,
    known: Box<SimState>,
    explore_moves: u16,
    seed: u64,
    mode: ModeReport,
    goal: ActiveGoal,
    nest: Option<Situation<16>>,
    decision: Option<Decision<16>>,
    before: Option<Situation<16>>,
    counts: DriveCounts,
    trail: History,
    note: Option<String>,
    failure: Option<String>,
    checked: u32,
    /// Unanswered queries in a row.
    silent: u32,
    time_s: f64,
    revision: u64,
    scene: Option<Arc<SnapshotPart<SceneDto>>>,
    knowledge: KnowledgeParts,
}

impl WatchedBoard {
    /// Watches the controller at the end of an open session; `name` is its name in messages. Uses
    /// the controller's own sonars; without any, a note on the page says so.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn new(
        mut session: Session,
        name: String,
        explore_moves: u16,
        seed: u64,
        behavior: &Behavior,
    ) -> Result<Self, LinkError> {
        let note = match session.use_own_ring()? {
            true => None,
            false => Some("It has no sonars of its own: it will not move".to_owned()),
        };
        let mode = session.mode()?;
        let knowledge = Knowledge::read(&mut session)?;
        Ok(Self {
            session,
            name,
            config: knowledge.config().clone(),
            known: Box::new(knowledge.state().clone()),
            explore_moves,
            seed,
            mode,
            goal: ActiveGoal::behavior(behavior),
            nest: None,
            decision: None,
            before: None,
            counts: DriveCounts::default(),
            trail: History::latest(),
            note,
            failure: None,
            checked: 0,
            silent: 0,
            time_s: 0.0,
            revision: 0,
            scene: None,
            knowledge: KnowledgeParts::default(),
        })
    }

    /// Sends a heartbeat and receives reports for one interval. Returns whether a decision was
    /// taken or the mode changed.
    fn listen(&mut self) -> Result<bool, LinkError> {
        let until = Instant::now() + HEARTBEAT;
        let at_ms = self.session.elapsed_ms();
        self.session.send_heartbeat(at_ms)?;
        let mut whole = false;
        while let Some(report) = self.session.next_report(until)? {
            whole |= self.take(&report.message);
        }
        self.checked += 1;
        if self.checked.is_multiple_of(MODE_POLL) {
            let mode = self.session.mode()?;
            whole |= self.change(mode);
        }
        if whole {
            self.advance_goal()?;
        }
        if whole && !self.moves() {
            self.fetch()?;
        }
        Ok(whole)
    }

    fn take(&mut self, said: &DeviceMessage<16>) -> bool {
        match said {
            DeviceMessage::Decision(decision) => self.decide(decision),
            DeviceMessage::Mode(mode) => return self.change(*mode),
            _ => return false,
        }
        true
    }

    fn change(&mut self, mode: ModeReport) -> bool {
        let before = std::mem::replace(&mut self.mode, mode);
        // A repeated mode keeps its note.
        if before != mode {
            self.note = match mode {
                ModeReport::Stopped(reason) => {
                    Some(format!("It stands: {}", sim::error::stop_reason(reason)))
                }
                _ => None,
            };
        }
        std::mem::discriminant(&before) != std::mem::discriminant(&mode)
    }

    fn decide(&mut self, decision: &Decision<16>) {
        self.nest.get_or_insert(decision.situation);
        self.before = self.decision.map(|before| before.situation);
        self.decision = Some(*decision);
        let flags = StepFlags {
            at_goal: decision.at_goal,
            shielded: decision.allowed != decision.wanted,
            touched: false,
            touched_by: false,
        };
        let neuron = decision.plan.map(|plan| usize::from(plan.current_neuron));
        let seeking = neuron.is_some();
        match seeking {
            true => self.counts.steps += 1,
            false => self.counts.explored[0] += 1,
        }
        self.counts.at_goal += u32::from(seeking && flags.at_goal);
        self.counts.shielded += u32::from(seeking && flags.shielded);
        let place = Point::default();
        self.trail.push(history_entry(
            self.time_s,
            place,
            seeking,
            flags,
            neuron,
            None,
        ));
    }

    /// Starts the next part of a chain when the current one is reached; stops after the last.
    fn advance_goal(&mut self) -> Result<(), LinkError> {
        if self.mode != ModeReport::Seek {
            return Ok(());
        }
        match self.goal.advance(self.counts.steps, self.counts.at_goal) {
            None => Ok(()),
            Some(true) => self.pursue(),
            Some(false) => self.send_command(message::RobotCommand::Stop),
        }
    }

    /// Reads maps, memory and configuration.
    fn fetch(&mut self) -> Result<(), LinkError> {
        let knowledge = Knowledge::read(&mut self.session)?;
        *self.known = knowledge.state().clone();
        self.config = knowledge.config().clone();
        self.knowledge.invalidate();
        Ok(())
    }

    fn moves(&self) -> bool {
        !matches!(self.mode, ModeReport::Idle | ModeReport::Stopped(_))
    }

    fn send_command(&mut self, command: message::RobotCommand<16>) -> Result<(), LinkError> {
        let at_ms = self.session.elapsed_ms();
        let reports = self.session.command(at_ms, command)?;
        let mut changed = false;
        for report in &reports {
            changed |= self.take(&report.message);
        }
        if changed && !self.moves() {
            self.fetch()?;
        }
        Ok(())
    }

    fn pursue(&mut self) -> Result<(), LinkError> {
        let goal = self.goal.goal(&self.config, &self.nest());
        self.send_command(message::RobotCommand::Goal(GoalSpec::Components(goal)))?;
        self.send_command(message::RobotCommand::Seek)
    }

    fn nest(&self) -> Situation<16> {
        self.nest.unwrap_or([Weight::ZERO; 16])
    }

    fn execute_command(&mut self, command: &PageCommand) -> Result<CommandOutcome, CommandRefused> {
        if self.mode == ModeReport::Learn && *command != PageCommand::Stop {
            return Err("it still learns".into());
        }
        match command {
            PageCommand::Stop => self.send_command(message::RobotCommand::Stop)?,
            PageCommand::Explore => self.send_command(message::RobotCommand::Explore {
                moves: self.explore_moves,
                seed: Seeds::of(self.seed).exploration,
            })?,
            PageCommand::Learn => self.send_command(message::RobotCommand::Learn)?,
            PageCommand::Seek => {
                self.goal.begin(self.counts.steps, self.counts.at_goal);
                self.pursue()?;
            }
            PageCommand::Resume => self.send_command(message::RobotCommand::Resume)?,
            PageCommand::Behavior { .. }
            | PageCommand::GoalNeuron { .. }
            | PageCommand::GoalFile { .. } => {
                let known = Some(&*self.known).filter(|known| known.has_learned());
                self.goal = ActiveGoal::from_command(
                    command,
                    (self.nest(), Point::default()),
                    known,
                    false,
                )?;
                if self.mode == ModeReport::Seek {
                    self.execute_command(&PageCommand::Seek)?;
                }
            }
            PageCommand::SaveMind => {
                let mut knowledge = Knowledge::of(&self.config, &self.known);
                knowledge.read_body(&mut self.session)?;
                return Ok(knowledge_file(&knowledge));
            }
            PageCommand::LoadMind { hex } => {
                let bytes = unhex(hex).ok_or("the file is incomplete")?;
                Knowledge::from_bytes(&bytes)?.upload(&mut self.session)?;
                self.fetch()?;
                self.scene = None;
            }
            _ => return Err("a board cannot do that".into()),
        }
        Ok(CommandOutcome::Done)
    }
}

impl ViewSource for WatchedBoard {
    fn abilities(&self) -> Capabilities {
        Capabilities {
            drive: true,
            save: true,
            load: true,
            unplaced: true,
            ..Capabilities::default()
        }
    }

    fn step(&mut self) -> StepOutcome {
        if self.failure.is_some() {
            return StepOutcome::Idle;
        }
        let whole = match self.listen() {
            Ok(whole) => {
                self.silent = 0;
                whole
            }
            // The link may only be slow.
            Err(LinkError::Silent { .. }) if self.silent < MAX_SILENT => {
                self.silent += 1;
                false
            }
            Err(error) => {
                self.failure = Some(format!("{}: {error}", self.name));
                return StepOutcome::Idle;
            }
        };
        let now_s = f64::from(self.session.elapsed_ms()) / 1e3;
        let took_s = now_s - std::mem::replace(&mut self.time_s, now_s);
        StepOutcome::Took { took_s, whole }
    }

    fn execute(&mut self, command: &PageCommand) -> Result<CommandOutcome, CommandRefused> {
        if let Some(why) = &self.failure {
            return Err(why.clone().into());
        }
        self.execute_command(command)
    }

    fn snapshot(&mut self) -> Snapshot {
        self.revision += 1;
        let learned = self.known.has_learned();
        let mut parts: Vec<Arc<dyn PartMessage>> = vec![self.scene()];
        let (revision, known) = (self.revision, &self.known);
        parts.extend(self.knowledge.parts(revision, known, &self.config, learned));
        Snapshot {
            parts,
            now: Box::new(self.now()),
            trail: self.trail.parts().collect(),
            revision,
        }
    }

    fn steering_lost(&mut self, silence: Duration) {
        let drives = matches!(self.mode, ModeReport::Explore { .. } | ModeReport::Seek);
        if self.failure.is_some() || !drives {
            return;
        }
        match self.send_command(message::RobotCommand::Stop) {
            Ok(()) => {
                let seconds = silence.as_secs_f64();
                self.note = Some(format!(
                    "It stopped: no page has steered it for {seconds} s"
                ));
            }
            Err(error) => self.failure = Some(format!("{}: {error}", self.name)),
        }
    }

    /// Stops the robot.
    fn end(&mut self) -> Result<(), String> {
        if self.failure.is_some() || !self.moves() {
            return Ok(());
        }
        let stopped = self.send_command(message::RobotCommand::Stop);
        stopped.map_err(|error| format!("{}: {error}", self.name))
    }
}
