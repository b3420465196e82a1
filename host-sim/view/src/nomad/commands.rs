//! Executes the page's commands for a Nomad.

use super::{NomadActivity, WatchedNomad};
use crate::command::{CommandOutcome, PageCommand};
use crate::configure::{knowledge_file, switched};
use crate::goal::ActiveGoal;
use crate::source::CommandRefused;
use amp::controller::Command;
use amp::scan::Situation;
use amp::units::Range;
use nomad200::bridge::BridgeError;
use remote::link::Knowledge;
use sim::episode::Seeds;

impl WatchedNomad {
    pub(super) fn execute_command(
        &mut self,
        command: &PageCommand,
    ) -> Result<CommandOutcome, CommandRefused> {
        match command {
            PageCommand::Stop => self.stop()?,
            PageCommand::Explore => self.explore()?,
            PageCommand::Learn => self.learn()?,
            PageCommand::Seek => self.seek()?,
            PageCommand::Resume => self.resume()?,
            PageCommand::Behavior { .. }
            | PageCommand::GoalNeuron { .. }
            | PageCommand::GoalHere
            | PageCommand::GoalFile { .. } => self.choose(command)?,
            PageCommand::SaveGoal => return self.goal.save(&self.config),
            PageCommand::SaveMind => {
                let known = self.controller.known.as_deref();
                let known = known.ok_or("the controller has not answered yet")?;
                return Ok(knowledge_file(&Knowledge::of(&self.config, known)));
            }
            PageCommand::Shield { .. } | PageCommand::Online { .. } | PageCommand::Sonar { .. } => {
                self.configure(command)?;
            }
            _ => return Err("a real robot cannot do that".into()),
        }
        Ok(CommandOutcome::Done)
    }

    /// Brakes at once, whatever the controller does.
    pub(super) fn stop(&mut self) -> Result<(), BridgeError> {
        self.session.brake()?;
        if self.activity == NomadActivity::Learn {
            return Ok(());
        }
        if matches!(self.activity, NomadActivity::Explore | NomadActivity::Seek) {
            self.interrupted = self.activity;
        } else if self.activity != NomadActivity::Stopped {
            self.interrupted = NomadActivity::Idle;
        }
        self.session.command(Command::Stop);
        self.open = None;
        self.rest(NomadActivity::Stopped);
        Ok(())
    }

    fn begin(&mut self, activity: NomadActivity) {
        self.activity = activity;
        self.interrupted = NomadActivity::Idle;
        (self.before, self.note) = (None, None);
    }

    fn refuse_while_learning(&self) -> Result<(), CommandRefused> {
        match self.activity {
            NomadActivity::Learn => Err("it still learns".into()),
            _ => Ok(()),
        }
    }

    fn explore(&mut self) -> Result<(), CommandRefused> {
        self.refuse_while_learning()?;
        let seed = self.start.seed.wrapping_add(self.explorations);
        self.session.command(Command::Explore {
            moves: self.start.explore_moves,
            seed: Seeds::of(seed).exploration,
        });
        self.explorations += 1;
        self.explored = [0; 2];
        self.begin(NomadActivity::Explore);
        Ok(())
    }

    fn learn(&mut self) -> Result<(), CommandRefused> {
        self.refuse_while_learning()?;
        let known = self.controller.known.as_deref();
        if known.is_none_or(|known| known.memory().samples().is_empty()) {
            return Err("there is nothing to learn from: explore first".into());
        }
        if matches!(self.activity, NomadActivity::Explore | NomadActivity::Seek) {
            return Err("it moves: stop it first".into());
        }
        self.session.learn();
        self.begin(NomadActivity::Learn);
        Ok(())
    }

    fn seek(&mut self) -> Result<(), CommandRefused> {
        self.refuse_while_learning()?;
        if !self.knows_maps() {
            return Err("there are no maps yet: explore and learn first".into());
        }
        let [steps, _, _, held] = self.steps;
        self.goal.begin(steps, held);
        self.pursue();
        if self.activity != NomadActivity::Seek {
            self.begin(NomadActivity::Seek);
        }
        Ok(())
    }

    /// Sends the goal to the controller; of a chain the current part.
    pub(super) fn pursue(&mut self) {
        let goal = self.goal.goal(&self.config, &self.nest());
        self.session.command(Command::Seek(goal));
    }

    fn resume(&mut self) -> Result<(), CommandRefused> {
        if self.interrupted == NomadActivity::Idle {
            return Err("nothing was interrupted".into());
        }
        self.session.command(Command::Resume);
        self.begin(self.interrupted);
        Ok(())
    }

    fn choose(&mut self, command: &PageCommand) -> Result<(), CommandRefused> {
        let here = (self.perceived(), self.session.pose().position);
        let known = self
            .controller
            .known
            .as_deref()
            .filter(|_| self.knows_maps());
        let goal = ActiveGoal::from_command(command, here, known, false)?;
        if goal
            .as_behavior()
            .is_some_and(|behavior| behavior.has_leader())
        {
            return Err("there is no robot to follow".into());
        }
        self.goal = goal;
        match self.activity {
            NomadActivity::Seek => self.seek(),
            _ => Ok(()),
        }
    }

    fn configure(&mut self, command: &PageCommand) -> Result<(), CommandRefused> {
        let moves = matches!(
            self.activity,
            NomadActivity::Explore | NomadActivity::Learn | NomadActivity::Seek
        );
        if moves {
            return Err("it moves: stop it first".into());
        }
        let config = switched(command, &self.config, &self.start.whole)?;
        self.session.configure(config.clone());
        self.config = config;
        Ok(())
    }

    /// Situation before the first move; the current one if there was none.
    pub(super) fn nest(&self) -> Situation<16> {
        self.nest.map_or_else(|| self.perceived(), |(nest, _)| nest)
    }

    /// The latest ranges as a situation.
    pub(super) fn perceived(&self) -> Situation<16> {
        let millimeters = |m: f64| Range::from_mm((m * 1e3) as u16);
        let encoding = self.config.encoding;
        let ranges_m = self.session.ranges_m();
        ranges_m.map(|range| encoding.value(range.map(millimeters)))
    }
}
