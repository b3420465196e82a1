//! The pursued goal: a behavior by name, or a situation.

use super::command::{CommandOutcome, PageCommand, PageFile};
use super::source::CommandRefused;
use crate::snapshot::{GoalDto, Rounded};
use amp::config::Config;
use amp::fixed::Mask;
use amp::fixed::Weight;
use amp::goal::{Goal, GoalFrame};
use amp::scan::Situation;
use arena::world::Point;
use files::error::BadInput;
use sim::behavior::{Behavior, is_reached};
use sim::goal_file::{self, GoalFile};
use sim::pilot::SimState;

/// The goal and its origin.
#[derive(Debug, Clone)]
pub(super) struct ActiveGoal {
    kind: GoalKind,
    /// Part of a chain; steps and goal steps when it began.
    part: usize,
    begun: [u32; 2],
    /// The last part of a chain is reached.
    is_complete: bool,
}

#[derive(Debug, Clone)]
enum GoalKind {
    Behavior(Behavior),
    /// A situation with its name, neuron and place.
    Situation(Situation<16>, String, Option<usize>, Option<Point>),
    /// A goal of a recording, of unknown origin.
    Goal(Goal<16>),
}

impl ActiveGoal {
    fn new(kind: GoalKind) -> Self {
        Self {
            kind,
            part: 0,
            begun: [0; 2],
            is_complete: false,
        }
    }

    pub fn behavior(behavior: &Behavior) -> Self {
        Self::new(GoalKind::Behavior(behavior.clone()))
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

    /// The goal of a file.
    pub fn file(file: GoalFile) -> Self {
        Self::behavior(&Behavior::Seek(Box::new(file)))
    }

    /// Starts with the first part, at these counts of steps.
    pub fn begin(&mut self, steps: u32, goal_steps: u32) {
        (self.part, self.begun, self.is_complete) = (0, [steps, goal_steps], false);
    }

    /// Advances to the next part of a chain if the current one is reached; `Some(false)` after the
    /// last.
    pub fn advance(&mut self, steps: u32, goal_steps: u32) -> Option<bool> {
        let parts = self.as_behavior()?.parts();
        let chained = parts.len() > 1 && !self.is_complete;
        let part = parts.get(self.part).filter(|_| chained)?;
        let since = |now: u32, then: u32| now.saturating_sub(then);
        let [began, held] = self.begun;
        if !is_reached(part, since(steps, began), since(goal_steps, held)) {
            return None;
        }
        if self.part + 1 == parts.len() {
            self.is_complete = true;
            return Some(false);
        }
        (self.part, self.begun) = (self.part + 1, [steps, goal_steps]);
        Some(true)
    }

    /// Its name.
    pub fn name(&self) -> String {
        match &self.kind {
            GoalKind::Behavior(behavior) => behavior.name(),
            GoalKind::Situation(_, name, ..) => name.clone(),
            GoalKind::Goal(_) => "a situation".to_owned(),
        }
    }

    /// The behavior, if it is one.
    pub fn as_behavior(&self) -> Option<&Behavior> {
        match &self.kind {
            GoalKind::Behavior(behavior) => Some(behavior),
            GoalKind::Situation(..) | GoalKind::Goal(_) => None,
        }
    }

    /// The goal that a command sets. `here` is the current situation and place, `known` has the
    /// maps, if there are any.
    ///
    /// # Errors
    /// Why it cannot be the goal.
    pub fn from_command(
        command: &PageCommand,
        here: (Situation<16>, Point),
        known: Option<&SimState>,
    ) -> Result<Self, CommandRefused> {
        Ok(match command {
            PageCommand::Behavior { name } => Self::behavior(&named(name)?),
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
        })
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
        found.unwrap_or_else(|| Self::new(GoalKind::Goal(*goal)))
    }

    /// The goal as a file.
    ///
    /// # Errors
    /// Why there is none.
    pub fn save(&self, config: &Config<16>) -> Result<CommandOutcome, CommandRefused> {
        let GoalKind::Situation(situation, _, _, place) = &self.kind else {
            return Err("this goal has a name, not a situation: it needs no file".into());
        };
        let Some(place) = place else {
            let why = "a neuron's situation was perceived nowhere: go there and capture it";
            return Err(why.into());
        };
        let encoding = config.encoding;
        let remark = format!(
            "Captured in the bench view on a scale of {} to {} m.",
            f64::from(encoding.near_mm) / 1e3,
            f64::from(encoding.far_mm) / 1e3
        );
        Ok(CommandOutcome::File(PageFile {
            name: "goal.toml",
            text: Some(goal_file::text(situation, Mask::ALL, *place, &remark)),
            hex: None,
        }))
    }

    /// Whether the present part is to come back to where the exploration began.
    pub fn is_nest(&self) -> bool {
        let parts = self.as_behavior().map_or(&[][..], Behavior::parts);
        parts.get(self.part) == Some(&Behavior::Nest)
    }

    /// The goal situation; `nest` is the situation before the first move.
    pub fn goal(&self, config: &Config<16>, nest: &Situation<16>) -> Goal<16> {
        match &self.kind {
            GoalKind::Behavior(behavior) => {
                let part = behavior.parts().get(self.part);
                part.unwrap_or(behavior).goal(config, nest)
            }
            GoalKind::Situation(situation, ..) => Goal::perceived(situation),
            GoalKind::Goal(goal) => *goal,
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
            GoalKind::Goal(_) => (None, None),
        };
        let parts = self
            .as_behavior()
            .map_or(1, |behavior| behavior.parts().len());
        GoalDto {
            name: self.name(),
            part: (parts > 1).then_some(self.part),
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
fn named(name: &str) -> Result<Behavior, CommandRefused> {
    let known = Behavior::NAMES;
    if let Some(unknown) = name.split(',').find(|part| !known.contains(part)) {
        return Err(BadInput::unknown("behavior", unknown, &known).into());
    }
    Ok(name.parse()?)
}
