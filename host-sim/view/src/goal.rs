//! The pursued goal: a behavior by name, or a situation.

use super::command::{CommandOutcome, PageCommand, PageFile};
use super::source::CommandRefused;
use crate::snapshot::{GoalDto, Rounded};
use amp::config::Config;
use amp::fixed::Mask;
use amp::fixed::Weight;
use amp::goal::{Goal, GoalFrame};
use amp::places::Aim;
use amp::scan::Situation;
use arena::world::Point;
use files::error::BadInput;
use sim::behavior::{Behavior, is_reached};
use sim::goal_file::{self, GoalFile};
use sim::pilot::SimState;
use sim::senses::SenseGoal;

/// Why a robot cannot be sent home or to a position.
pub(super) const NO_PLACES: &str =
    "only a simulated robot with a memory of places finds its way there: view --places on";

/// The goal and its origin.
#[derive(Debug, Clone)]
pub(super) struct ActiveGoal {
    kind: GoalKind,
    /// Part of a chain; steps and goal steps when it began.
    part: usize,
    begun: [u32; 2],
    /// It drives around before the way home.
    is_touring: bool,
    /// The last part of a chain is reached.
    is_complete: bool,
}

#[derive(Debug, Clone)]
enum GoalKind {
    Behavior(Behavior),
    /// A situation with its name, neuron and place.
    Situation(Situation<16>, String, Option<usize>, Option<Point>),
    /// A position, to which places lead the robot.
    Position(Point),
    /// A goal of a recording, of unknown origin, or of a demonstration, with its name.
    Goal(Goal<16>, String),
}

impl ActiveGoal {
    fn new(kind: GoalKind) -> Self {
        let mut goal = Self {
            kind,
            part: 0,
            begun: [0; 2],
            is_touring: false,
            is_complete: false,
        };
        // No step counts before it begins.
        goal.begin(u32::MAX, u32::MAX);
        goal
    }

    pub fn behavior(behavior: &Behavior) -> Self {
        Self::new(GoalKind::Behavior(behavior.clone()))
    }

    /// A position in the world.
    pub fn position_of(place: Point) -> Self {
        Self::new(GoalKind::Position(place))
    }

    /// The situation of a neuron.
    pub fn neuron(neuron: usize, code: Situation<16>) -> Self {
        let name = format!("neuron N{}", neuron + 1);
        Self::new(GoalKind::Situation(code, name, Some(neuron), None))
    }

    /// A situation captured at a place.
    pub fn captured(situation: Situation<16>, place: Point) -> Self {
        let name = "captured here".to_owned();
        Self::new(GoalKind::Situation(situation, name, None, Some(place)))
    }

    /// The goal of a demonstration.
    pub fn shown(goal: Goal<16>, name: String) -> Self {
        Self::new(GoalKind::Goal(goal, name))
    }

    /// The goal of a file.
    pub fn file(file: GoalFile) -> Self {
        Self::behavior(&Behavior::Seek(Box::new(file)))
    }

    /// Starts with the first part, at these counts of steps.
    pub fn begin(&mut self, steps: u32, goal_steps: u32) {
        (self.part, self.begun, self.is_complete) = (0, [steps, goal_steps], false);
        self.is_touring = self.tour_steps().is_some_and(|all| all > 0);
    }

    /// Advances to the way home after a tour, and to the next part of a chain if the current one is
    /// reached; `Some(false)` after the last.
    pub fn advance(&mut self, steps: u32, goal_steps: u32) -> Option<bool> {
        let [began, held] = self.begun;
        let done = [steps.saturating_sub(began), goal_steps.saturating_sub(held)];
        if self.is_complete || !self.is_part_over(done) {
            return None;
        }
        let parts = self
            .as_behavior()
            .map_or(1, |behavior| behavior.parts().len());
        if self.is_touring {
            self.is_touring = false;
        } else if self.part + 1 < parts {
            self.part += 1;
        } else {
            self.is_complete = true;
            return Some(false);
        }
        self.begun = [steps, goal_steps];
        Some(true)
    }

    /// What is sought in another modality.
    pub fn sought(&self) -> Option<SenseGoal> {
        self.present_part()?.sense_goals().next()
    }

    /// Whether the present part is over after so many steps, with so many at its goal. A behavior
    /// that is no place to go to is never over by itself.
    fn is_part_over(&self, [steps, goal_steps]: [u32; 2]) -> bool {
        match &self.kind {
            _ if self.is_touring => self.tour_steps().is_none_or(|all| steps >= all),
            GoalKind::Position(_) => goal_steps > 0,
            GoalKind::Behavior(behavior) => {
                let ends = behavior.parts().len() > 1 || behavior.has_end();
                let part = behavior.parts().get(self.part);
                ends && part.is_some_and(|part| is_reached(part, steps, goal_steps))
            }
            GoalKind::Situation(..) | GoalKind::Goal(..) => false,
        }
    }

    /// Steps of driving around before the way home. In a chain home has none.
    fn tour_steps(&self) -> Option<u32> {
        let behavior = self.as_behavior().filter(|behavior| behavior.has_end());
        Some(behavior?.tour()?.steps)
    }

    /// Steps of driving around before the way home, at this count of steps: driven, and in all.
    pub fn tour(&self, steps: u32) -> Option<[u32; 2]> {
        let all = self.tour_steps()?;
        let driven = match self.is_touring {
            true => steps.saturating_sub(self.begun[0]).min(all),
            false => all,
        };
        Some([driven, all])
    }

    /// Where its places lead the robot while it drives around.
    pub fn tour_aim(&self) -> Option<Aim> {
        self.as_behavior()?.tour_aim()
    }

    /// Whether it drives around before the way home.
    pub fn is_touring(&self) -> bool {
        self.is_touring
    }

    /// Whether the present part is the way home.
    pub fn is_home(&self) -> bool {
        matches!(self.present_part(), Some(Behavior::Home { .. }))
    }

    /// The position to go to, if it is one.
    pub fn position(&self) -> Option<Point> {
        match &self.kind {
            GoalKind::Position(place) => Some(*place),
            _ => None,
        }
    }

    fn present_part(&self) -> Option<&Behavior> {
        self.as_behavior()?.parts().get(self.part)
    }

    /// Its name.
    pub fn name(&self) -> String {
        match &self.kind {
            GoalKind::Behavior(behavior) => behavior.name(),
            GoalKind::Situation(_, name, ..) => name.clone(),
            GoalKind::Position(_) => "a place".to_owned(),
            GoalKind::Goal(_, name) => name.clone(),
        }
    }

    /// What is to be told when its last part is reached.
    pub fn reached(&self) -> String {
        let is_chain = self
            .as_behavior()
            .is_some_and(|behavior| behavior.parts().len() > 1);
        let what = if is_chain { ": the last goal" } else { "" };
        format!("{}{what} is reached", self.name())
    }

    /// The behavior, if it is one.
    pub fn as_behavior(&self) -> Option<&Behavior> {
        match &self.kind {
            GoalKind::Behavior(behavior) => Some(behavior),
            GoalKind::Situation(..) | GoalKind::Position(_) | GoalKind::Goal(..) => None,
        }
    }

    /// The goal that a command sets. `here` is the current situation and place, `known` has the
    /// maps, if there are any; `has_places` tells whether a memory of places leads the robot.
    ///
    /// # Errors
    /// Why it cannot be the goal.
    pub fn from_command(
        command: &PageCommand,
        here: (Situation<16>, Point),
        known: Option<&SimState>,
        has_places: bool,
    ) -> Result<Self, CommandRefused> {
        let goal = match command {
            PageCommand::Behavior { name, tour } => Self::behavior(&named(name, *tour)?),
            PageCommand::GoalPosition { x, y } => Self::position_of(Point::new(*x, *y)),
            PageCommand::GoalNeuron { neuron } => {
                let known = known.ok_or("there are no maps yet: explore and learn first")?;
                if *neuron >= known.situations().code().len() {
                    return Err(format!("there is no neuron {neuron}").into());
                }
                Self::neuron(*neuron, neuron_situation(known, *neuron))
            }
            PageCommand::GoalHere => Self::captured(here.0, here.1),
            PageCommand::GoalFile { text } => Self::file(GoalFile::read(text, "goal.toml")?),
            _ => return Err("that is no goal".into()),
        };
        let behavior = goal.as_behavior();
        let needs_places = behavior.is_some_and(Behavior::needs_places);
        if (needs_places || goal.position().is_some()) && !has_places {
            return Err(NO_PLACES.into());
        }
        Ok(goal)
    }

    /// Finds the name of a controller's goal.
    pub fn recognize(
        goal: &Goal<16>,
        config: &Config<16>,
        nest: &Situation<16>,
        known: &SimState,
    ) -> Self {
        let named = Behavior::NAMES.iter().filter_map(|name| name.parse().ok());
        let mut named = named.map(|behavior: Behavior| Self::behavior(&behavior));
        if let Some(found) = named.find(|named| named.goal(config, nest) == *goal) {
            return found;
        }
        let neurons = 0..known.situations().code().len();
        let mut neurons =
            neurons.map(|neuron| Self::neuron(neuron, neuron_situation(known, neuron)));
        let found = neurons.find(|neuron| neuron.goal(config, nest) == *goal);
        found.unwrap_or_else(|| Self::shown(*goal, "a situation".to_owned()))
    }

    /// The goal as a file.
    ///
    /// # Errors
    /// Why there is none.
    pub fn save(&self, config: &Config<16>) -> Result<CommandOutcome, CommandRefused> {
        let encoding = config.encoding;
        let whole = |goal| goal_file::whole_text(&goal, &self.name(), &goal_file::scale(encoding));
        let text = match &self.kind {
            GoalKind::Situation(situation, _, _, Some(place)) => {
                let scale = goal_file::scale(encoding);
                let remark = format!("Captured in the bench view {scale}.");
                goal_file::text(situation, Mask::ALL, *place, &remark)
            }
            GoalKind::Situation(situation, _, _, None) => whole(Goal::perceived(situation)),
            GoalKind::Goal(goal, _) => whole(*goal),
            GoalKind::Position(_) => return Err("this goal is a place, not a situation".into()),
            GoalKind::Behavior(behavior) => {
                let why = "this goal is found where the robot is: go there and capture it";
                whole(behavior.fixed_goal(config).ok_or(why)?)
            }
        };
        Ok(CommandOutcome::File(PageFile {
            name: "goal.toml",
            text: Some(text),
            hex: None,
        }))
    }

    /// Whether the present part is to come back to where the exploration began.
    pub fn is_nest(&self) -> bool {
        self.is_home() && !self.is_touring
            || matches!(self.present_part(), Some(Behavior::Nest { .. }))
    }

    /// The goal situation; `nest` is the situation before the first move.
    pub fn goal(&self, config: &Config<16>, nest: &Situation<16>) -> Goal<16> {
        match &self.kind {
            _ if self.is_touring => Goal::avoiding(config),
            GoalKind::Behavior(behavior) => {
                let part = behavior.parts().get(self.part);
                part.unwrap_or(behavior).goal(config, nest)
            }
            GoalKind::Situation(situation, ..) => Goal::perceived(situation),
            // The way is what leads it.
            GoalKind::Position(_) => Goal::avoiding(config),
            GoalKind::Goal(goal, _) => *goal,
        }
    }

    pub fn to_dto(&self, config: &Config<16>, nest: &Situation<16>, start: Point) -> GoalDto {
        let goal = self.goal(config, nest);
        let bounds = goal.components.iter().map(|component| {
            let ends = [component.low, component.high].map(|end| Rounded(end.to_num()));
            (component.weight > 0).then_some(ends)
        });
        let (neuron, place) = match &self.kind {
            GoalKind::Behavior(behavior) => (None, behavior.place(start)),
            GoalKind::Situation(_, _, neuron, place) => (*neuron, *place),
            GoalKind::Position(place) => (None, Some(*place)),
            GoalKind::Goal(..) => (None, None),
        };
        let parts = self
            .as_behavior()
            .map_or(1, |behavior| behavior.parts().len());
        GoalDto {
            name: self.name(),
            part: (parts > 1).then_some(self.part),
            tour: None,
            bounds: bounds.collect(),
            travels: goal.frame == GoalFrame::Travel,
            neuron,
            place: place.map(|place| [place.x, place.y].map(Rounded)),
        }
    }
}

/// The situation that a neuron stands for.
fn neuron_situation(known: &SimState, neuron: usize) -> Situation<16> {
    let code = known.situations().code_vector(neuron);
    code.map(|value| value.clamp(Weight::ZERO, Weight::ONE))
}

/// A behavior of the menu or a chain of them. Files are not allowed: they belong to this machine's
/// user.
fn named(name: &str, tour: Option<u32>) -> Result<Behavior, CommandRefused> {
    let known: Vec<_> = Behavior::NAMES.into_iter().chain(["home"]).collect();
    let is_known = |part: &&str| known.contains(part) || SenseGoal::is_meant_by(part);
    if let Some(unknown) = name.split(',').find(|part| !is_known(part)) {
        return Err(BadInput::unknown("behavior", unknown, &known).into());
    }
    let mut behavior: Behavior = name.parse()?;
    if let (Some(tour), Some(steps)) = (behavior.tour_mut(), tour) {
        tour.steps = steps;
    }
    Ok(behavior)
}
