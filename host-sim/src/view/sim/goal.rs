//! What is pursued: a behaviour by name, or a situation that was shown.

use crate::goal_file::GoalFile;
use crate::scenes::Behavior;
use crate::view::snapshot::{GoalSeen, Short};
use crate::world::Point;
use amp::config::Config;
use amp::goal::{Frame, Goal};
use amp::scan::Situation;

/// A goal and where it came from.
#[derive(Debug, Clone)]
pub(super) struct Pursued {
    what: What,
}

#[derive(Debug, Clone)]
enum What {
    Behavior(Behavior),
    /// A situation, what it is called, its neuron, and its place.
    Situation(Situation<16>, String, Option<usize>, Option<Point>),
}

impl Pursued {
    pub fn behavior(behavior: &Behavior) -> Self {
        Self {
            what: What::Behavior(behavior.clone()),
        }
    }

    /// What a neuron of the situation map stands for.
    pub fn neuron(neuron: usize, code: Situation<16>) -> Self {
        let name = format!("neuron N{}", neuron + 1);
        Self {
            what: What::Situation(code, name, Some(neuron), None),
        }
    }

    /// What is perceived at a place.
    pub fn captured(situation: Situation<16>, place: Point) -> Self {
        Self {
            what: What::Situation(situation, "captured here".to_owned(), None, Some(place)),
        }
    }

    /// From a file.
    pub fn file(file: GoalFile) -> Self {
        Self::behavior(&Behavior::Seek(Box::new(file)))
    }

    /// The behaviour, if it is one.
    pub fn as_behavior(&self) -> Option<&Behavior> {
        match &self.what {
            What::Behavior(behavior) => Some(behavior),
            What::Situation(..) => None,
        }
    }

    /// The situation and its place, if it is one that was shown.
    pub fn as_situation(&self) -> Option<(&Situation<16>, Option<Point>)> {
        match &self.what {
            What::Situation(situation, _, _, place) => Some((situation, *place)),
            What::Behavior(_) => None,
        }
    }

    /// The goal itself; `nest` is what was perceived before the first move.
    pub fn goal(&self, config: &Config<16>, nest: &Situation<16>) -> Goal<16> {
        match &self.what {
            What::Behavior(behavior) => behavior.goal(config, nest),
            What::Situation(situation, ..) => Goal::perceived(situation),
        }
    }

    pub fn seen(&self, config: &Config<16>, nest: &Situation<16>, start: Point) -> GoalSeen {
        let goal = self.goal(config, nest);
        let asked = goal.components.iter().map(|component| {
            let ends = [component.low, component.high].map(|end| Short(end.to_num()));
            (component.weight > 0).then_some(ends)
        });
        let (name, neuron, place) = match &self.what {
            What::Behavior(behavior) => (behavior.name(), None, behavior.place(start)),
            What::Situation(_, name, neuron, place) => (name.clone(), *neuron, *place),
        };
        GoalSeen {
            name,
            asked: asked.collect(),
            travels: goal.frame == Frame::Travel,
            neuron,
            place: place.map(|place| [place.x, place.y].map(Short)),
        }
    }
}
