//! What is pursued: a behavior by name, or a situation that was shown.

use super::order::{Done, File, Order};
use super::source::Refused;
use crate::snapshot::{GoalSeen, Short};
use amp::config::Config;
use amp::fixed::Weight;
use amp::goal::{Frame, Goal};
use amp::scan::Situation;
use arena::world::Point;
use files::error::BadInput;
use sim::behavior::{Behavior, is_reached};
use sim::goal_file::{self, GoalFile};
use sim::pilot::SimState;

/// A goal and where it came from.
#[derive(Debug, Clone)]
pub(super) struct Pursued {
    what: What,
    /// Part of a chain, and steps and goal steps when it was begun.
    part: usize,
    begun: [u32; 2],
    /// The last part of a chain has been reached.
    over: bool,
}

#[derive(Debug, Clone)]
enum What {
    Behavior(Behavior),
    /// A situation, what it is called, its neuron, and its place.
    Situation(Situation<16>, String, Option<usize>, Option<Point>),
    /// Of a recording, nobody knows from where.
    Goal(Goal<16>),
}

impl Pursued {
    fn new(what: What) -> Self {
        Self {
            what,
            part: 0,
            begun: [0; 2],
            over: false,
        }
    }

    pub fn behavior(behavior: &Behavior) -> Self {
        Self::new(What::Behavior(behavior.clone()))
    }

    /// What a neuron of the situation map stands for.
    pub fn neuron(neuron: usize, code: Situation<16>) -> Self {
        let name = format!("neuron N{}", neuron + 1);
        Self::new(What::Situation(code, name, Some(neuron), None))
    }

    /// What is perceived at a place.
    pub fn captured(situation: Situation<16>, place: Point) -> Self {
        let name = "captured here".to_owned();
        Self::new(What::Situation(situation, name, None, Some(place)))
    }

    /// From a file.
    pub fn file(file: GoalFile) -> Self {
        Self::behavior(&Behavior::Seek(Box::new(file)))
    }

    /// Begins with the first part, after so many steps of which a goal held in some.
    pub fn begin(&mut self, steps: u32, goal_steps: u32) {
        (self.part, self.begun, self.over) = (0, [steps, goal_steps], false);
    }

    /// Goes on to the next part of a chain if the present one is reached; `Some(false)` when it was the last.
    pub fn go_on(&mut self, steps: u32, goal_steps: u32) -> Option<bool> {
        let parts = self.as_behavior()?.parts();
        let chained = parts.len() > 1 && !self.over;
        let part = parts.get(self.part).filter(|_| chained)?;
        let since = |now: u32, then: u32| now.saturating_sub(then);
        let [began, held] = self.begun;
        if !is_reached(part, since(steps, began), since(goal_steps, held)) {
            return None;
        }
        if self.part + 1 == parts.len() {
            self.over = true;
            return Some(false);
        }
        (self.part, self.begun) = (self.part + 1, [steps, goal_steps]);
        Some(true)
    }

    /// What it is called.
    pub fn name(&self) -> String {
        match &self.what {
            What::Behavior(behavior) => behavior.name(),
            What::Situation(_, name, ..) => name.clone(),
            What::Goal(_) => "a situation".to_owned(),
        }
    }

    /// The behavior, if it is one.
    pub fn as_behavior(&self) -> Option<&Behavior> {
        match &self.what {
            What::Behavior(behavior) => Some(behavior),
            What::Situation(..) | What::Goal(_) => None,
        }
    }

    /// What an order makes the goal; `here` = what is perceived and where, `known` = the maps, if there are any.
    ///
    /// # Errors
    /// Why it cannot be the goal.
    pub fn asked(
        order: &Order,
        here: (Situation<16>, Point),
        known: Option<&SimState>,
    ) -> Result<Self, Refused> {
        Ok(match order {
            Order::Behavior { name } => Self::behavior(&named(name)?),
            Order::GoalNeuron { neuron } => {
                let known = known.ok_or("there are no maps yet: explore and learn first")?;
                if *neuron >= known.situations().code().len() {
                    return Err(format!("there is no neuron {neuron}").into());
                }
                Self::neuron(*neuron, meant(known, *neuron))
            }
            Order::GoalHere => Self::captured(here.0, here.1),
            Order::GoalFile { text } => Self::file(GoalFile::read(text, "goal.toml")?),
            _ => return Err("that is no goal".into()),
        })
    }

    /// Finds out what a goal of the mind is called.
    pub fn recognized(
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
        let mut neurons = neurons.map(|neuron| Self::neuron(neuron, meant(known, neuron)));
        let found = neurons.find(|neuron| neuron.goal(config, nest) == *goal);
        found.unwrap_or_else(|| Self::new(What::Goal(*goal)))
    }

    /// The goal as a file.
    ///
    /// # Errors
    /// Why it makes none.
    pub fn save(&self, config: &Config<16>) -> Result<Done, Refused> {
        let What::Situation(situation, _, _, place) = &self.what else {
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
        Ok(Done::File(File {
            name: "goal.toml",
            text: Some(goal_file::text(situation, *place, &remark)),
            hex: None,
        }))
    }

    /// The goal itself; `nest` is what was perceived before the first move.
    pub fn goal(&self, config: &Config<16>, nest: &Situation<16>) -> Goal<16> {
        match &self.what {
            What::Behavior(behavior) => {
                let part = behavior.parts().get(self.part);
                part.unwrap_or(behavior).goal(config, nest)
            }
            What::Situation(situation, ..) => Goal::perceived(situation),
            What::Goal(goal) => *goal,
        }
    }

    pub fn seen(&self, config: &Config<16>, nest: &Situation<16>, start: Point) -> GoalSeen {
        let goal = self.goal(config, nest);
        let asked = goal.components.iter().map(|component| {
            let ends = [component.low, component.high].map(|end| Short(end.to_num()));
            (component.weight > 0).then_some(ends)
        });
        let (neuron, place) = match &self.what {
            What::Behavior(behavior) => (None, behavior.place(start)),
            What::Situation(_, _, neuron, place) => (*neuron, *place),
            What::Goal(_) => (None, None),
        };
        let parts = self
            .as_behavior()
            .map_or(1, |behavior| behavior.parts().len());
        GoalSeen {
            name: self.name(),
            part: (parts > 1).then_some(self.part),
            asked: asked.collect(),
            travels: goal.frame == Frame::Travel,
            neuron,
            place: place.map(|place| [place.x, place.y].map(Short)),
        }
    }
}

/// The situation a neuron stands for.
fn meant(known: &SimState, neuron: usize) -> Situation<16> {
    let code = known.situations().code_vector(neuron);
    code.map(|value| value.clamp(Weight::ZERO, Weight::ONE))
}

/// A behavior of the menu, or a chain of them: no files, which are for whoever sits at this machine.
fn named(name: &str) -> Result<Behavior, Refused> {
    let known = Behavior::NAMES;
    if let Some(unknown) = name.split(',').find(|part| !known.contains(part)) {
        return Err(BadInput::unknown("behavior", unknown, &known).into());
    }
    Ok(name.parse()?)
}
