//! What the simulator does when somebody asks.

use super::{Doing, Simulator, Start};
use crate::choices::{mind_file, switched};
use crate::goal::Pursued;
use crate::order::{Done, Order, Reset};
use crate::source::Refused;
use amp::config::Config;
use amp::controller::Command;
use amp::scan::Situation;
use amp::units::Range;
use arena::robot::COLLISION_RADIUS_M;
use arena::world::{Point, Shape, World, WorldSource, parse_worlds};
use files::error::BadInput;
use files::hex::unhex;
use remote::link::{AnyController, Knowledge};
use remote::log::LoggedController;
use sim::episode::{CARRY_TIME_S, Seeds};

impl Simulator {
    pub(super) fn obey(&mut self, order: &Order) -> Result<Done, Refused> {
        if let (Some(why), false) = (&self.failure, matches!(order, Order::Reset(_))) {
            return Err(format!("{why}; start anew").into());
        }
        match order {
            Order::Stop => self.stop()?,
            Order::Explore => self.explore()?,
            Order::Learn => self.begin_learning()?,
            Order::Seek => self.seek()?,
            Order::Resume => self.resume()?,
            Order::Reset(reset) => self.reset(reset)?,
            Order::SaveGoal => return self.goal.save(&self.config),
            Order::SaveMind => return self.save_mind(),
            Order::LoadMind { hex } => self.load_mind(hex)?,
            Order::Shield { .. } | Order::Online { .. } | Order::Sonar { .. } => {
                self.configure(order)?;
            }
            Order::MoveShape { shape, x, y } => self.move_shape(*shape, Point::new(*x, *y))?,
            Order::MoveRobot { x, y } => self.move_robot(Point::new(*x, *y))?,
            Order::Behavior { .. }
            | Order::GoalNeuron { .. }
            | Order::GoalHere
            | Order::GoalFile { .. } => self.choose_goal(order)?,
            // Those of seat and pace do not come here.
            _ => return Err("that is nothing for the robot".into()),
        }
        Ok(Done::Well)
    }

    pub(super) fn stop(&mut self) -> Result<(), Refused> {
        if matches!(self.doing, Doing::Explore | Doing::Seek) {
            self.interrupted = self.doing;
        } else if self.doing != Doing::Stopped {
            self.interrupted = Doing::Idle;
        }
        self.command(Command::Stop)?;
        self.doing = Doing::Stopped;
        // Not before it was known what the mind made of it: its last step ends here.
        self.open = None;
        if self.body.is_moving() {
            self.body.halt();
        }
        self.log_place();
        Ok(())
    }

    /// A log says where the robot is, also between two rings.
    fn log_place(&self) {
        if let Some(log) = self.mind.log() {
            log.write(|log| log.pose(self.body.now(), self.body.pose(), self.body.leader()));
        }
    }

    fn begin(&mut self, doing: Doing) {
        self.doing = doing;
        self.interrupted = Doing::Idle;
        self.last_decision_s = self.body.time_s();
        self.before = None;
        self.note = None;
    }

    fn explore(&mut self) -> Result<(), Refused> {
        let setup = &self.start.setup;
        // Another exploration of the same start has moves of its own.
        let seed = Seeds::of(setup.seed.wrapping_add(self.explorations)).exploration;
        let moves = setup.explore_moves;
        self.command(Command::Explore { moves, seed })?;
        self.explorations += 1;
        self.explored = sim::episode::Metrics::new(self.body.world());
        self.begin(Doing::Explore);
        Ok(())
    }

    fn begin_learning(&mut self) -> Result<(), Refused> {
        self.command(Command::Learn)?;
        self.learning = 0;
        self.begin(Doing::Learn);
        Ok(())
    }

    /// What was perceived before the first move, or now if there was none.
    pub(super) fn nest(&self) -> Situation<16> {
        self.nest.map_or_else(|| self.perceived(), |(nest, _)| nest)
    }

    fn seek(&mut self) -> Result<(), Refused> {
        if self.doing == Doing::Learn {
            return Err("it still learns".into());
        }
        self.prepare_goal();
        self.goal.begin(self.seeking.steps, self.seeking.goal_steps);
        self.pursue()?;
        if self.doing != Doing::Seek {
            self.begin(Doing::Seek);
        }
        Ok(())
    }

    /// Tells the mind the goal, of a chain that of its present part.
    pub(super) fn pursue(&mut self) -> Result<(), Refused> {
        let goal = self.goal.goal(&self.config, &self.nest());
        self.command(Command::Seek(goal))
    }

    /// A leader where one is to be followed.
    fn prepare_goal(&mut self) {
        let Some(behavior) = self.goal.as_behavior() else {
            return;
        };
        if behavior.has_leader() && self.body.leader().is_none() {
            self.body.add_leader();
        }
    }

    fn resume(&mut self) -> Result<(), Refused> {
        self.command(Command::Resume)?;
        self.begin(self.interrupted);
        Ok(())
    }

    fn choose(&mut self, goal: Pursued) -> Result<(), Refused> {
        let before = std::mem::replace(&mut self.goal, goal);
        let outcome = match self.doing {
            Doing::Seek => self.seek(),
            _ => Ok(()),
        };
        if outcome.is_err() {
            self.goal = before;
        }
        outcome
    }

    fn choose_goal(&mut self, order: &Order) -> Result<(), Refused> {
        let here = (self.perceived(), self.body.pose().position);
        let known = match self.learned {
            true => Some(self.mind.pilot().cached_state()?),
            false => None,
        };
        let goal = Pursued::asked(order, here, known)?;
        self.choose(goal)
    }

    /// What the ring hears from here, as a situation.
    pub(super) fn perceived(&self) -> Situation<16> {
        let millimeters = |m: f64| Range::from_mm((m * 1e3) as u16);
        let value = |range: Option<f64>| self.config.encoding.value(range.map(millimeters));
        self.body.look().map(value)
    }

    fn save_mind(&mut self) -> Result<Done, Refused> {
        Ok(mind_file(&self.config, self.mind.pilot().cached_state()?))
    }

    fn load_mind(&mut self, hex: &str) -> Result<(), Refused> {
        if !self.mind.inner().is_local() {
            return Err("a mind elsewhere takes its file from `host-sim link … push`".into());
        }
        let bytes = unhex(hex).ok_or("the file did not arrive whole")?;
        let knowledge = Knowledge::from_bytes(&bytes)?;
        self.renew(self.start.clone(), knowledge.config())?;
        self.mind.load(self.body.now(), &knowledge);
        self.learned = knowledge.state().has_learned();
        Ok(())
    }

    fn configure(&mut self, order: &Order) -> Result<(), Refused> {
        let config = switched(order, &self.config, &self.start.whole)?;
        self.mind.configure(self.body.now(), &config)?;
        self.config = config;
        Ok(())
    }

    fn move_shape(&mut self, index: usize, to: Point) -> Result<(), Refused> {
        let world = self.body.world();
        let shape = match world.shapes().get(index) {
            Some(Shape::Box { size, angle, .. }) => Shape::Box {
                center: to,
                size: *size,
                angle: *angle,
            },
            Some(Shape::Circle { radius, .. }) => Shape::Circle {
                center: to,
                radius: *radius,
            },
            Some(_) => return Err("walls stay where they are".into()),
            None => return Err(format!("there is no shape {index}").into()),
        };
        let world = world.with_shape(index, shape)?;
        let free =
            |place: Point| !world.is_inside(place) && world.clearance(place) >= COLLISION_RADIUS_M;
        let robot = self.body.pose().position;
        if !free(robot) || !self.body.leader().is_none_or(free) {
            return Err("the robot stands there".into());
        }
        if let Some(log) = self.mind.log() {
            log.write(|log| log.world(self.body.now(), &world));
        }
        self.body.set_world(world);
        self.shown.scene = None;
        Ok(())
    }

    /// Carries the robot: what it did is interrupted, and its shield forgets what it heard before.
    fn move_robot(&mut self, to: Point) -> Result<(), Refused> {
        let world = self.body.world();
        let (low, high) = world.bounds();
        let inside = (low.x..=high.x).contains(&to.x) && (low.y..=high.y).contains(&to.y);
        if !inside || world.is_inside(to) || world.clearance(to) < COLLISION_RADIUS_M {
            return Err("there is no room for the robot".into());
        }
        let goes_on = matches!(self.doing, Doing::Explore | Doing::Seek);
        if goes_on {
            self.stop()?;
        }
        self.body.wait(CARRY_TIME_S);
        self.body.set_down_at(to);
        self.log_place();
        self.before = None;
        if goes_on {
            self.resume()?;
        }
        Ok(())
    }

    fn reset(&mut self, reset: &Reset) -> Result<(), Refused> {
        let mut start = self.start.clone();
        if let Some(seed) = reset.seed {
            start.setup.seed = seed;
        }
        if let Some(name) = reset.world.as_ref().filter(|name| **name != start.named) {
            start.world = menu_world(name)?;
            start.named.clone_from(name);
        }
        if let Some(name) = reset
            .preset
            .as_ref()
            .filter(|name| **name != start.setup.preset)
        {
            choose_preset(&mut start, name)?;
        }
        // What was switched stays switched.
        let (config, whole) = (&mut start.setup.config, &start.whole);
        config.shield = self.config.shield.and(whole.shield);
        config.online = self.config.online.and(whole.online);
        let config = config.clone();
        self.renew(start, &config)
    }

    /// Everything from the beginning, but for what the goal is called.
    fn renew(&mut self, start: Start, config: &Config<16>) -> Result<(), Refused> {
        let mut record = start.record();
        record.config = config.clone();
        if let Err(error) = self.mind.reset(&record, Some(&start.world)) {
            self.fail(error.to_string());
            return Err(error.into());
        }
        let placeholder = LoggedController::new(AnyController::local(config), None);
        let mind = std::mem::replace(&mut self.mind, placeholder);
        let mut next = Self::with_mind(start, mind);
        next.config = config.clone();
        next.trail = self.trail.afresh();
        next.shown.revision = self.shown.revision;
        if self.goal.as_behavior().is_some() {
            next.goal = self.goal.clone();
        }
        *self = next;
        Ok(())
    }
}

/// A world of the menu, or a random room: no files, which are for whoever sits at this machine.
fn menu_world(name: &str) -> Result<World, Refused> {
    if !name.starts_with("random:") && !World::builtin_names().contains(&name) {
        let known = World::builtin_names();
        return Err(BadInput::unknown("world", name, &known).into());
    }
    match parse_worlds(name)?.as_slice() {
        [source @ (WorldSource::Random(_) | WorldSource::Builtin(_))] => Ok(source.load()?),
        _ => Err(format!("world \"{name}\": one room at a time").into()),
    }
}

fn choose_preset(start: &mut Start, name: &str) -> Result<(), Refused> {
    let Some(preset) = start.presets.iter().find(|preset| preset.name == name) else {
        let names: Vec<_> = start.presets.iter().map(|preset| preset.name).collect();
        return Err(BadInput::unknown("preset", name, &names).into());
    };
    start.setup.preset = preset.name.to_owned();
    start.setup.turret = preset.turret;
    start.setup.config = preset.config.clone();
    start.whole = preset.config.clone();
    Ok(())
}
