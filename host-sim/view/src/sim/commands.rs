//! Executes the page's commands for the simulator.

use super::{Simulator, SimulatorActivity, SimulatorStart};
use crate::command::{CommandOutcome, PageCommand, Reset};
use crate::configure::switched;
use crate::goal::ActiveGoal;
use crate::source::CommandRefused;
use amp::config::Config;
use amp::controller::Command;
use amp::fixed::Weight;
use amp::scan::Situation;
use amp::units::Range;
use arena::loaders::{WorldSource, parse_worlds};
use arena::world::{Point, Shape, World};
use files::error::BadInput;
use remote::link::AnyController;
use remote::log::LoggedController;
use sim::behavior::Behavior;
use sim::episode::{CARRY_TIME_S, Seeds};
use sim::pilot::nest_known;

impl Simulator {
    pub(super) fn execute_command(
        &mut self,
        command: &PageCommand,
    ) -> Result<CommandOutcome, CommandRefused> {
        if let (Some(why), false) = (&self.failure, matches!(command, PageCommand::Reset(_))) {
            return Err(format!("{why}; restart").into());
        }
        match command {
            PageCommand::Stop => self.stop()?,
            PageCommand::Explore => self.explore()?,
            PageCommand::Learn => self.begin_learning()?,
            PageCommand::Seek => self.seek()?,
            PageCommand::Resume => self.resume()?,
            PageCommand::Reset(reset) => self.reset(reset)?,
            PageCommand::Record { on } => self.record(*on)?,
            PageCommand::GoalShown => self.use_recorded()?,
            PageCommand::SaveGoal => return self.goal.save(&self.config),
            PageCommand::SaveMind => return self.save_mind(),
            PageCommand::LoadMind { hex } => self.load_mind(hex)?,
            PageCommand::Shield { .. } | PageCommand::Online { .. } | PageCommand::Sonar { .. } => {
                self.configure(command)?;
            }
            PageCommand::MoveShape { shape, x, y } => {
                self.move_shape(*shape, Point::new(*x, *y))?
            }
            PageCommand::MoveSource { source, x, y } => {
                self.move_source(*source, Point::new(*x, *y))?;
            }
            PageCommand::MoveRobot { x, y } => self.move_robot(Point::new(*x, *y))?,
            PageCommand::Behavior { .. }
            | PageCommand::GoalNeuron { .. }
            | PageCommand::GoalHere
            | PageCommand::GoalPosition { .. }
            | PageCommand::GoalFile { .. } => self.choose_goal(command)?,
            // Commands of the control lock and the clock are handled elsewhere.
            _ => return Err("this is not a command for the robot".into()),
        }
        Ok(CommandOutcome::Done)
    }

    pub(super) fn stop(&mut self) -> Result<(), CommandRefused> {
        if matches!(
            self.activity,
            SimulatorActivity::Explore | SimulatorActivity::Seek
        ) {
            self.interrupted = self.activity;
        } else if self.activity != SimulatorActivity::Stopped {
            self.interrupted = SimulatorActivity::Idle;
        }
        self.command(Command::Stop)?;
        self.activity = SimulatorActivity::Stopped;
        // The last step ends only after the controller has accepted the stop.
        self.open = None;
        if self.body.is_moving() {
            self.body.halt();
        }
        self.log_place();
        Ok(())
    }

    /// Logs the pose, also between two rings.
    fn log_place(&self) {
        if let Some(log) = self.controller.log() {
            log.write(|log| log.pose(self.body.now(), self.body.pose(), self.body.leader()));
        }
    }

    fn begin(&mut self, activity: SimulatorActivity) {
        self.activity = activity;
        self.interrupted = SimulatorActivity::Idle;
        self.last_decision_s = self.body.time_s();
        self.before = None;
        self.note = None;
    }

    /// Makes random moves, first those that find the sensors of a body that nobody has told of.
    pub(super) fn explore(&mut self) -> Result<(), CommandRefused> {
        let setup = &self.start.setup;
        // Each further exploration has its own moves.
        let seed = Seeds::of(setup.seed.wrapping_add(self.explorations)).exploration;
        let robot = setup.robot.as_ref().filter(|_| !self.is_calibrated);
        if let Some(calibration) =
            robot.and_then(|robot| robot.calibration(setup.explore_moves, seed.wrapping_add(1)))
        {
            self.command(calibration)?;
            self.explored = sim::episode::Metrics::new(self.body.world(), self.body.radius_m());
            self.learning = 0;
            self.begin(SimulatorActivity::Babble);
            return Ok(());
        }
        let moves = setup.explore_moves - setup.calibration_moves();
        self.command(Command::Explore { moves, seed })?;
        self.begin_places();
        self.explorations += 1;
        self.explored = sim::episode::Metrics::new(self.body.world(), self.body.radius_m());
        self.begin(SimulatorActivity::Explore);
        Ok(())
    }

    fn begin_learning(&mut self) -> Result<(), CommandRefused> {
        self.command(Command::Learn)?;
        self.learning = 0;
        self.begin(SimulatorActivity::Learn);
        Ok(())
    }

    /// Situation before the first move; the current one if there was none.
    pub(super) fn nest(&self) -> Situation<16> {
        self.nest.map_or_else(|| self.perceived(), |(nest, _)| nest)
    }

    fn seek(&mut self) -> Result<(), CommandRefused> {
        if self.activity == SimulatorActivity::Learn {
            return Err("it still learns".into());
        }
        self.prepare_goal()?;
        self.goal.begin(self.seeking.steps, self.seeking.goal_steps);
        self.pursue()?;
        if self.activity != SimulatorActivity::Seek {
            self.begin(SimulatorActivity::Seek);
        }
        Ok(())
    }

    /// Sends the goal to the controller; of a chain the current part.
    pub(super) fn pursue(&mut self) -> Result<(), CommandRefused> {
        let mut goal = self.goal.goal(&self.config, &self.nest());
        if self.goal.is_nest() {
            goal = goal.for_known(nest_known(self.controller.pilot().cached_state()?));
        }
        self.lead()?;
        self.command(Command::Seek(goal))?;
        // The step under way was decided for what was pursued before.
        if let Some(open) = &mut self.open {
            open.at_goal = false;
        }
        Ok(())
    }

    /// Starts the next part of a chain when the current one is reached; stops after the last.
    pub(super) fn advance_goal(&mut self) {
        if self.activity != SimulatorActivity::Seek || self.failure.is_some() {
            return;
        }
        let (steps, held) = (self.seeking.steps, self.seeking.goal_steps);
        let done = match self.goal.advance(steps, held) {
            None => return,
            Some(true) => self.pursue(),
            Some(false) => {
                let note = self.goal.reached();
                self.stop().map(|()| self.note = Some(note))
            }
        };
        if let Err(refused) = done {
            self.fail(refused.0);
        }
    }

    /// Adds a leader if the goal needs one, and what it seeks.
    fn prepare_goal(&mut self) -> Result<(), CommandRefused> {
        let behavior = self.goal.as_behavior();
        let needs_leader = behavior.is_some_and(Behavior::has_leader);
        if needs_leader && self.body.leader().is_none() {
            self.body.add_leader();
        }
        self.add_missing_sources()
    }

    fn resume(&mut self) -> Result<(), CommandRefused> {
        self.command(Command::Resume)?;
        self.begin(self.interrupted);
        Ok(())
    }

    pub(super) fn choose(&mut self, goal: ActiveGoal) -> Result<(), CommandRefused> {
        let before = std::mem::replace(&mut self.goal, goal);
        let outcome = match self.activity {
            SimulatorActivity::Seek => self.seek(),
            // So that the robot may come upon it before.
            _ => self.add_missing_sources(),
        };
        if outcome.is_err() {
            self.goal = before;
        }
        outcome
    }

    fn choose_goal(&mut self, command: &PageCommand) -> Result<(), CommandRefused> {
        let here = (self.perceived(), self.body.pose().position);
        let has_places = self.has_places();
        let known = match self.learned {
            true => Some(self.controller.pilot().cached_state()?),
            false => None,
        };
        let goal = ActiveGoal::from_command(command, here, known, has_places)?;
        if let Some(place) = goal.position() {
            self.check_room(place)?;
        }
        self.choose(goal)
    }

    /// The ranges in this pose as a situation.
    pub(super) fn perceived(&self) -> Situation<16> {
        if self.start.setup.robot.is_some() {
            // Only a decision reads a ring off what the sensors have heard.
            return self
                .decision
                .map_or([Weight::ZERO; 16], |decision| decision.situation);
        }
        let millimeters = |m: f64| Range::from_mm((m * 1e3) as u16);
        let value = |range: Option<f64>| self.config.encoding.value(range.map(millimeters));
        self.body.look().map(value)
    }

    fn configure(&mut self, command: &PageCommand) -> Result<(), CommandRefused> {
        let config = switched(command, &self.config, &self.start.whole)?;
        self.controller.configure(self.body.now(), &config)?;
        self.config = config;
        Ok(())
    }

    fn move_shape(&mut self, index: usize, to: Point) -> Result<(), CommandRefused> {
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
        let radius_m = self.body.radius_m();
        let free = |place: Point| !world.is_inside(place) && world.clearance(place) >= radius_m;
        let robot = self.body.pose().position;
        if !free(robot) || !self.body.leader().is_none_or(free) {
            return Err("the robot stands there".into());
        }
        self.replace_world(world);
        Ok(())
    }

    /// Puts the robot where it is into another world.
    pub(super) fn replace_world(&mut self, world: World) {
        if let Some(log) = self.controller.log() {
            log.write(|log| log.world(self.body.now(), &world));
        }
        self.body.set_world(world);
        self.cache.scene = None;
    }

    /// Whether the robot may stand there.
    fn check_room(&self, place: Point) -> Result<(), CommandRefused> {
        let world = self.body.world();
        let (low, high) = world.bounds();
        let inside = (low.x..=high.x).contains(&place.x) && (low.y..=high.y).contains(&place.y);
        if !inside || world.is_inside(place) || world.clearance(place) < self.body.radius_m() {
            return Err("there is no room for the robot".into());
        }
        Ok(())
    }

    /// Moves the robot: its activity is interrupted, and its shield forgets earlier echoes.
    fn move_robot(&mut self, to: Point) -> Result<(), CommandRefused> {
        self.check_room(to)?;
        let goes_on = matches!(
            self.activity,
            SimulatorActivity::Explore | SimulatorActivity::Seek
        );
        if goes_on {
            self.stop()?;
        }
        self.body.wait(CARRY_TIME_S);
        self.body.set_down_at(to);
        self.recorder.carried();
        self.log_place();
        self.before = None;
        self.carry_places();
        self.lead()?;
        if goes_on {
            self.resume()?;
        }
        Ok(())
    }

    fn reset(&mut self, reset: &Reset) -> Result<(), CommandRefused> {
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
        // Switches keep their state.
        let (config, whole) = (&mut start.setup.config, &start.whole);
        config.shield = self.config.shield.and(whole.shield);
        config.online = self.config.online.and(whole.online);
        let config = config.clone();
        self.renew(start, &config)
    }

    /// Restarts everything; a named goal stays.
    pub(super) fn renew(
        &mut self,
        start: SimulatorStart,
        config: &Config<16>,
    ) -> Result<(), CommandRefused> {
        let mut record = start.record();
        record.config = config.clone();
        if let Err(error) = self.controller.reset(&record, Some(&start.world)) {
            self.fail(error.to_string());
            return Err(error.into());
        }
        let placeholder = LoggedController::new(AnyController::local(config, None), None);
        let controller = std::mem::replace(&mut self.controller, placeholder);
        let mut next = Self::with_controller(start, controller);
        next.config = config.clone();
        next.trail = self.trail.restarted();
        next.cache.revision = self.cache.revision;
        if self.goal.as_behavior().is_some() {
            next.goal = self.goal.clone();
        }
        *self = next;
        Ok(())
    }
}

/// A world of the menu or a random room. Files are not allowed: they belong to this machine's user.
fn menu_world(name: &str) -> Result<World, CommandRefused> {
    if !name.starts_with("random:") && !World::builtin_names().contains(&name) {
        let known = World::builtin_names();
        return Err(BadInput::unknown("world", name, &known).into());
    }
    match parse_worlds(name)?.as_slice() {
        [source @ (WorldSource::Random(_) | WorldSource::Builtin(_))] => Ok(source.load()?),
        _ => Err(format!("world \"{name}\": one room at a time").into()),
    }
}

fn choose_preset(start: &mut SimulatorStart, name: &str) -> Result<(), CommandRefused> {
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
