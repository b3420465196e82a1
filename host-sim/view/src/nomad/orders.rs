//! What a watched Nomad does when somebody asks.

use super::{Doing, WatchedNomad};
use crate::choices::{mind_file, switched};
use crate::goal::Pursued;
use crate::order::{Done, Order};
use crate::source::Refused;
use amp::controller::Command;
use amp::scan::Situation;
use amp::units::Range;
use nomad200::bridge::BridgeError;
use sim::episode::Seeds;

impl WatchedNomad {
    pub(super) fn obey(&mut self, order: &Order) -> Result<Done, Refused> {
        match order {
            Order::Stop => self.stop()?,
            Order::Explore => self.explore()?,
            Order::Learn => self.learn()?,
            Order::Seek => self.seek()?,
            Order::Resume => self.resume()?,
            Order::Behavior { .. }
            | Order::GoalNeuron { .. }
            | Order::GoalHere
            | Order::GoalFile { .. } => self.choose(order)?,
            Order::SaveGoal => return self.goal.save(&self.config),
            Order::SaveMind => {
                let known = self.mind.known.as_deref();
                let known = known.ok_or("the mind has not answered yet")?;
                return Ok(mind_file(&self.config, known));
            }
            Order::Shield { .. } | Order::Online { .. } | Order::Sonar { .. } => {
                self.configure(order)?;
            }
            _ => return Err("a real robot cannot do that".into()),
        }
        Ok(Done::Well)
    }

    /// The base brakes at once, whatever the mind is at.
    pub(super) fn stop(&mut self) -> Result<(), BridgeError> {
        self.session.brake()?;
        if self.doing == Doing::Learn {
            return Ok(());
        }
        if matches!(self.doing, Doing::Explore | Doing::Seek) {
            self.interrupted = self.doing;
        } else if self.doing != Doing::Stopped {
            self.interrupted = Doing::Idle;
        }
        self.session.command(Command::Stop);
        self.open = None;
        self.rest(Doing::Stopped);
        Ok(())
    }

    fn begin(&mut self, doing: Doing) {
        self.doing = doing;
        self.interrupted = Doing::Idle;
        (self.before, self.note) = (None, None);
    }

    fn refuse_while_learning(&self) -> Result<(), Refused> {
        match self.doing {
            Doing::Learn => Err("it still learns".into()),
            _ => Ok(()),
        }
    }

    fn explore(&mut self) -> Result<(), Refused> {
        self.refuse_while_learning()?;
        let seed = self.start.seed.wrapping_add(self.explorations);
        self.session.command(Command::Explore {
            moves: self.start.explore_moves,
            seed: Seeds::of(seed).exploration,
        });
        self.explorations += 1;
        self.explored = [0; 2];
        self.begin(Doing::Explore);
        Ok(())
    }

    fn learn(&mut self) -> Result<(), Refused> {
        self.refuse_while_learning()?;
        let known = self.mind.known.as_deref();
        if known.is_none_or(|known| known.memory().samples().is_empty()) {
            return Err("there is nothing to learn from: explore first".into());
        }
        if matches!(self.doing, Doing::Explore | Doing::Seek) {
            return Err("it moves: stop it first".into());
        }
        self.session.learn();
        self.begin(Doing::Learn);
        Ok(())
    }

    fn seek(&mut self) -> Result<(), Refused> {
        self.refuse_while_learning()?;
        if !self.knows_maps() {
            return Err("there are no maps yet: explore and learn first".into());
        }
        let [steps, _, _, held] = self.steps;
        self.goal.begin(steps, held);
        self.pursue();
        if self.doing != Doing::Seek {
            self.begin(Doing::Seek);
        }
        Ok(())
    }

    /// Tells the mind the goal, of a chain that of its present part.
    pub(super) fn pursue(&mut self) {
        let goal = self.goal.goal(&self.config, &self.nest());
        self.session.command(Command::Seek(goal));
    }

    fn resume(&mut self) -> Result<(), Refused> {
        if self.interrupted == Doing::Idle {
            return Err("nothing was interrupted".into());
        }
        self.session.command(Command::Resume);
        self.begin(self.interrupted);
        Ok(())
    }

    fn choose(&mut self, order: &Order) -> Result<(), Refused> {
        let here = (self.perceived(), self.session.pose().position);
        let known = self.mind.known.as_deref().filter(|_| self.knows_maps());
        let goal = Pursued::asked(order, here, known)?;
        if goal
            .as_behavior()
            .is_some_and(|behavior| behavior.has_leader())
        {
            return Err("whom it would follow is not known here".into());
        }
        self.goal = goal;
        match self.doing {
            Doing::Seek => self.seek(),
            _ => Ok(()),
        }
    }

    fn configure(&mut self, order: &Order) -> Result<(), Refused> {
        let moves = matches!(self.doing, Doing::Explore | Doing::Learn | Doing::Seek);
        if moves {
            return Err("it moves: stop it first".into());
        }
        let config = switched(order, &self.config, &self.start.whole)?;
        self.session.configure(config.clone());
        self.config = config;
        Ok(())
    }

    /// What was perceived before the first move, or now if there was none.
    pub(super) fn nest(&self) -> Situation<16> {
        self.nest.map_or_else(|| self.perceived(), |(nest, _)| nest)
    }

    /// What the ring has heard last, as a situation.
    pub(super) fn perceived(&self) -> Situation<16> {
        let millimeters = |m: f64| Range::from_mm((m * 1e3) as u16);
        let encoding = self.config.encoding;
        let ranges_m = self.session.ranges_m();
        ranges_m.map(|range| encoding.value(range.map(millimeters)))
    }
}
