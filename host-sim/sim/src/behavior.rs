//! Behaviors by name, their goal situations and start conditions.
//!
//! Success is [measured](crate::episode) in the true world, which the controller never sees.

use crate::goal_file::GoalFile;
use crate::senses::SenseGoal;
use amp::config::Config;
use amp::fixed::Weight;
use amp::goal::{Goal, Side};
use amp::places::Aim;
use amp::scan::Situation;
use amp::units::Range;
use arena::world::Point;
use files::error::BadInput;
use std::str::FromStr;

/// Range to the followed wall, meters from the ring.
pub const WALL_RANGE_M: f64 = 0.6;
/// Room to keep on the side on which obstacles are passed, meters.
pub const PASSING_ROOM_M: f64 = 1.5;
/// Range to the leader, meters from the ring.
pub const LEADER_RANGE_M: f64 = 0.34;
/// In a chain, a behavior without an end is done when its goal has held for this many decisions.
pub const CHAIN_HOLDS: u32 = 20;

/// Steps of driving around before the way home.
pub const TOUR_STEPS: u32 = 500;

/// Driving around before a goal is pursued.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tour {
    /// Decisions; 0: there is none.
    pub steps: u32,
    /// What leads the robot.
    pub by: TourBy,
}

/// What leads a robot that drives around.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TourBy {
    /// Its places, to where it has not been.
    Frontier,
    /// Nothing: it avoids obstacles.
    Avoid,
}

impl Tour {
    /// None.
    pub const NONE: Self = Self::of(0);

    /// So many decisions, to where the robot has not been.
    #[must_use]
    pub const fn of(steps: u32) -> Self {
        Self {
            steps,
            by: TourBy::Frontier,
        }
    }
}

/// A behavior by name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Behavior {
    /// Obstacle avoidance, the paper's experiment: nothing nearer than the clearance.
    Avoid,
    /// As `Avoid`, but obstacles are passed on the robot's left.
    AvoidRight,
    /// Follow a wall on the left.
    WallLeft,
    /// Follow a wall on the right.
    WallRight,
    /// Return to the position before the first move, set down elsewhere.
    Nest {
        /// Before it is set down elsewhere.
        tour: Tour,
        /// It is turned by a random angle as well.
        is_turned: bool,
    },
    /// Drive around, and return to the position before the first move.
    Home {
        /// Before it goes back.
        tour: Tour,
    },
    /// Drive around, and go to what is sought in another modality.
    Sense {
        /// What is sought.
        goal: SenseGoal,
        /// Before it goes there.
        tour: Tour,
    },
    /// Follow another robot.
    Follow,
    /// Go to where the situation of a file was captured.
    Seek(Box<GoalFile>),
    /// Several in a row: the next one begins when the goal is reached.
    Chain(Vec<Self>),
}

impl Behavior {
    /// Return to the position before the first move, set down elsewhere at once, not turned.
    pub const NEST: Self = Self::Nest {
        tour: Tour::NONE,
        is_turned: false,
    };

    /// Names of the behaviors that any robot has, without a parameter.
    pub const NAMES: [&str; 6] = [
        "avoid",
        "avoid-right",
        "wall-left",
        "wall-right",
        "nest",
        "follow",
    ];

    /// A short description; empty for an unknown name.
    #[must_use]
    pub fn about(name: &str) -> &'static str {
        match name {
            "avoid" => "keeps away from everything",
            "avoid-right" => "passes obstacles so that they stay on its left",
            "wall-left" => "follows a wall on its left, 0.6 m away",
            "wall-right" => "follows a wall on its right, 0.6 m away",
            "nest" => "comes back to where it began to explore",
            "home" => "drives around and comes back to where it began to explore",
            "follow" => "keeps behind another robot",
            "seek" => "goes to where a situation was captured (seek:FILE)",
            "scent" => "drives around and goes to where it smelled strongest (scent:strongest)",
            "light" => "drives around and goes to where it was brightest (light:strongest)",
            "floor" => "drives around and goes to where the floor has this color (floor:red)",
            _ if name.contains(',') => "one after the other: the next when the goal is reached",
            _ => "",
        }
    }

    /// The name on the command line.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Avoid => "avoid".to_owned(),
            Self::AvoidRight => "avoid-right".to_owned(),
            Self::WallLeft => "wall-left".to_owned(),
            Self::WallRight => "wall-right".to_owned(),
            Self::Nest { .. } => "nest".to_owned(),
            Self::Home { .. } => "home".to_owned(),
            Self::Sense { goal, .. } => goal.name(),
            Self::Follow => "follow".to_owned(),
            Self::Seek(file) => format!("seek:{}", file.path),
            Self::Chain(parts) => {
                let names: Vec<_> = parts.iter().map(Self::name).collect();
                names.join(",")
            }
        }
    }

    /// The goal situation; `nest` is the situation before the first move. A chain has that of its
    /// first part.
    #[must_use]
    pub fn goal(&self, config: &Config<16>, nest: &Situation<16>) -> Goal<16> {
        let range = |meters: f64| Range::from_mm((meters * 1e3) as u16);
        match self {
            Self::Avoid => Goal::avoiding(config),
            Self::AvoidRight => Goal::passing(Side::Right, range(PASSING_ROOM_M), config),
            Self::WallLeft => Goal::wall(Side::Left, range(WALL_RANGE_M), config),
            Self::WallRight => Goal::wall(Side::Right, range(WALL_RANGE_M), config),
            Self::Nest { .. } | Self::Home { .. } => Goal::perceived(nest),
            // Its places lead it.
            Self::Sense { .. } => Goal::avoiding(config),
            Self::Follow => Goal::following(range(LEADER_RANGE_M), config),
            Self::Seek(file) => file.goal,
            Self::Chain(parts) => parts
                .first()
                .map_or_else(|| Goal::avoiding(config), |part| part.goal(config, nest)),
        }
    }

    /// The goal of one that asks for the same wherever it begins; `None` for those that are of a
    /// place or of several goals.
    #[must_use]
    pub fn fixed_goal(&self, config: &Config<16>) -> Option<Goal<16>> {
        match self {
            Self::Nest { .. } | Self::Home { .. } | Self::Sense { .. } | Self::Chain(_) => None,
            fixed => Some(fixed.goal(config, &[Weight::ZERO; 16])),
        }
    }

    /// The parts of a chain; one part for all others.
    #[must_use]
    pub fn parts(&self) -> &[Self] {
        match self {
            Self::Chain(parts) => parts,
            single => std::slice::from_ref(single),
        }
    }

    /// The robot is placed elsewhere after exploring.
    #[must_use]
    pub fn is_set_down_elsewhere(&self) -> bool {
        match self {
            Self::Nest { .. } | Self::Seek(_) => true,
            // In a chain the parts before it move the robot away.
            _ => false,
        }
    }

    /// The robot that is placed elsewhere is turned as well.
    #[must_use]
    pub const fn is_turned(&self) -> bool {
        matches!(
            self,
            Self::Nest {
                is_turned: true,
                ..
            }
        )
    }

    /// The place to reach, if there is one and it is known.
    #[must_use]
    pub fn place(&self, nest: Point) -> Option<Point> {
        match self {
            Self::Seek(file) => file.place(),
            Self::Chain(parts) => parts.iter().rev().find_map(|part| part.place(nest)),
            Self::Nest { .. } | Self::Home { .. } => Some(nest),
            _ => None,
        }
    }

    /// A memory of places leads the robot in some part.
    #[must_use]
    pub fn needs_places(&self) -> bool {
        let mut parts = self.parts().iter();
        parts.any(|part| match part {
            Self::Home { .. } | Self::Sense { .. } => true,
            Self::Nest { tour, .. } => tour.steps > 0,
            _ => false,
        })
    }

    /// Driving around before the behavior, of one that may begin so.
    #[must_use]
    pub fn tour(&self) -> Option<Tour> {
        match self {
            Self::Nest { tour, .. } | Self::Home { tour } | Self::Sense { tour, .. } => Some(*tour),
            _ => None,
        }
    }

    /// As [`tour`](Self::tour), to be changed.
    pub fn tour_mut(&mut self) -> Option<&mut Tour> {
        match self {
            Self::Nest { tour, .. } | Self::Home { tour } | Self::Sense { tour, .. } => Some(tour),
            _ => None,
        }
    }

    /// Where its places lead the robot on that tour.
    #[must_use]
    pub fn tour_aim(&self) -> Option<Aim> {
        match (self, self.tour()?.by) {
            (_, TourBy::Avoid) => None,
            // What is sought may be anywhere; home is by the ways that it knows.
            (Self::Sense { .. }, TourBy::Frontier) => Some(Aim::Everywhere),
            (_, TourBy::Frontier) => Some(Aim::Frontier),
        }
    }

    /// It ends where the robot thinks that it is there, also if it is alone.
    #[must_use]
    pub fn has_end(&self) -> bool {
        matches!(self, Self::Home { .. } | Self::Sense { .. })
    }

    /// What is sought in other modalities.
    pub fn sense_goals(&self) -> impl Iterator<Item = SenseGoal> {
        self.parts().iter().filter_map(|part| match part {
            Self::Sense { goal, .. } => Some(*goal),
            _ => None,
        })
    }

    /// The world contains a second robot.
    #[must_use]
    pub fn has_leader(&self) -> bool {
        self.parts().contains(&Self::Follow)
    }
}

impl FromStr for Behavior {
    type Err = BadInput;

    fn from_str(name: &str) -> Result<Self, BadInput> {
        if let Some((first, rest)) = name.split_once(',') {
            let mut parts = vec![first.parse()?];
            for part in rest.split(',') {
                parts.push(part.parse()?);
            }
            return Ok(Self::Chain(parts));
        }
        if let Some(path) = name.strip_prefix("seek:") {
            if path.is_empty() {
                return Err(BadInput::new("seek: takes a goal file: seek:FILE"));
            }
            return Ok(Self::Seek(Box::new(GoalFile::load(path.as_ref())?)));
        }
        if SenseGoal::is_meant_by(name) {
            return Ok(Self::Sense {
                goal: name.parse()?,
                tour: Tour::of(TOUR_STEPS),
            });
        }
        match name {
            "avoid" => Ok(Self::Avoid),
            "avoid-right" => Ok(Self::AvoidRight),
            "wall-left" => Ok(Self::WallLeft),
            "wall-right" => Ok(Self::WallRight),
            "nest" => Ok(Self::NEST),
            "home" => Ok(Self::Home {
                tour: Tour::of(TOUR_STEPS),
            }),
            "follow" => Ok(Self::Follow),
            _ => {
                let known: Vec<_> = Self::NAMES
                    .into_iter()
                    .chain(["home", "seek:FILE"])
                    .chain(SenseGoal::FORMS)
                    .collect();
                Err(BadInput::unknown("behavior", name, &known))
            }
        }
    }
}

/// Whether a part of a chain is done. A place is reached as soon as the goal holds; other behaviors
/// end after a number of decisions.
#[must_use]
pub fn is_reached(part: &Behavior, steps: u32, goal_steps: u32) -> bool {
    match part {
        Behavior::Nest { .. }
        | Behavior::Home { .. }
        | Behavior::Seek(_)
        | Behavior::Sense { .. } => goal_steps > 0,
        Behavior::WallLeft | Behavior::WallRight => steps >= CHAIN_HOLDS * 5,
        _ => goal_steps >= CHAIN_HOLDS,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_back() {
        for name in Behavior::NAMES {
            assert_eq!(name.parse::<Behavior>().expect(name).name(), name);
        }
        assert_eq!("home".parse::<Behavior>().expect("home").name(), "home");
        let chain: Behavior = "avoid-right,wall-right,nest".parse().expect("a chain");
        assert_eq!(chain.name(), "avoid-right,wall-right,nest");
        assert_eq!(chain.parts().len(), 3);
    }

    #[test]
    fn bad_names_and_files_are_refused_by_name() {
        let say = |name: &str| name.parse::<Behavior>().expect_err(name).to_string();
        assert!(say("wall-rigth").contains("did you mean \"wall-right\""));
        assert!(say("avoid,").contains("behavior"));
        assert!(say("seek:/nowhere.toml").contains("/nowhere.toml"));
    }
}
