//! Every open choice of the method as a named value, and the two presets.
//!
//! The paper fixes the idea (100 random moves, two maps of 16 neurons, a neighbor nearer to the
//! goal, recall by the difference) and leaves much open: what an action is, how near is near, how a
//! map is trained, how it is probed, what to do at the goal. [`Config::touzet`] is the most literal
//! reading of each point, [`Config::recommended`] the best found; the project's documentation holds
//! the ablation of each choice.

use crate::action_map::{ActionCode, Recall};
use crate::fixed::{Mask, Weight};
use crate::robot::RobotSpec;
use crate::scan::Encoding;
use crate::shield::ShieldConfig;
use crate::som::{Edges, Neighborhood, Schedule};
use serde::{Deserialize, Serialize};

/// Most bytes of a configuration in postcard's form.
pub const MAX_CONFIG: usize = 384;

mod presets;
#[cfg(feature = "link")]
mod zeroed;

/// The configuration of a robot with `SENSORS` transducers. Nothing changes it while the robot
/// runs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Config<const SENSORS: usize> {
    /// The body.
    pub robot: RobotSpec<SENSORS>,
    /// Transducers that are used.
    #[serde(alias = "believed")]
    pub enabled: Mask,
    /// From ranges to situations.
    pub encoding: Encoding,
    /// The random moves.
    pub exploration: Exploration,
    /// How an action stands in the map.
    pub action_code: ActionCode,
    /// Learning from the memory.
    pub learning: Learning,
    /// Learning from each move while seeking; `None` = the maps stay as they are.
    pub online: Option<Online>,
    /// From a goal to an action.
    pub planning: Planning,
    /// Obstacle avoidance asks for nothing nearer than this, millimeters; at or beyond the far
    /// limit, for nothing perceived at all.
    pub clearance_mm: u16,
    /// How echoes limit motions; `None` = not at all.
    pub shield: Option<ShieldConfig>,
    /// Whether transducers that misbehave are disabled: see [`faults`](crate::faults).
    pub fault_detection: bool,
    /// A session with this configuration expects rings without any echo: see
    /// [`State::expect_open_space`](crate::controller::State::expect_open_space). The controller
    /// itself does not read it.
    pub open_space: bool,
}

impl<const SENSORS: usize> Config<SENSORS> {
    /// In postcard's form, as it goes over the link and is saved. Empty if it does not fit, which a
    /// ring of more than 32 transducers would not.
    // One copy of it in a program.
    #[cfg(feature = "store")]
    #[inline(never)]
    #[must_use]
    pub fn to_bytes<'a>(&self, buffer: &'a mut [u8; MAX_CONFIG]) -> &'a [u8] {
        postcard::to_slice(self, buffer).map_or(&[], |bytes| bytes)
    }

    /// Undoes [`to_bytes`](Self::to_bytes); `None` for bytes that are no configuration, or for one
    /// without deadlines that can be supervised.
    #[cfg(feature = "store")]
    #[inline(never)]
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let config: Self = postcard::from_bytes(bytes).ok()?;
        config.robot.is_supervisable().then_some(config)
    }
}

/// The random moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Exploration {
    /// Shortest move, millimeters; the longest is the robot's step. Lengths are uniform in between,
    /// bearings uniform.
    pub shortest_mm: u16,
    /// Draws of a random move, at least 1; the last one is taken even if the shield shortens it
    /// below half.
    pub draws: u8,
}

/// The order in which samples are presented.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum SampleOrder {
    /// One after another, epoch by epoch.
    Recorded,
    /// A random one each time.
    Random,
}

/// Where the code vectors start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Initialization {
    /// Random samples.
    Samples,
    /// Random values in the range of what is to be learned.
    Random,
    /// Actions spread over the grid as over the plane, changes zero; situations from samples.
    Plane,
}

/// Which displacement of a sample is learned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum LearnFrom {
    /// The commanded one.
    Commanded,
    /// The executed one, by odometry.
    Executed,
}

/// How one map learns from the memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct MapTraining {
    /// Shape of the neighborhood.
    pub neighborhood: Neighborhood,
    /// Learning rate, Q16.
    pub rate: Schedule,
    /// Radius of the neighborhood, Q16 grid steps (or the direct neighbors' share).
    pub radius: Schedule,
}

/// Learning from the memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Learning {
    /// Presentations of the whole memory.
    pub epochs: u16,
    /// SampleOrder of the presentations.
    pub order: SampleOrder,
    /// Where the code vectors start.
    pub start: Initialization,
    /// Whether each presentation is rotated by a random number of ring steps (symmetric rings
    /// only): a hundred moves yield as many samples as the ring has places, times a hundred.
    #[serde(alias = "turned")]
    pub augment_rotations: bool,
    /// λ, the weight of the action beside the change when the action map's winner is sought, in
    /// 1/256.
    pub action_weight_q8: u16,
    /// Which displacement of a sample is learned.
    #[serde(alias = "taught")]
    pub learn_from: LearnFrom,
    /// A transducer whose range changes by more than this in a move has met another surface, and
    /// nothing is learned from that change, millimeters. At or beyond the far limit all are learned
    /// from.
    pub largest_change_mm: u16,
    /// Where more transducers than this met another surface in a move made while seeking, the
    /// action map learns nothing from that move.
    pub most_changed: u8,
    /// Border of both grids.
    pub edges: Edges,
    /// The situation map's training.
    pub situations: MapTraining,
    /// The action map's training.
    pub actions: MapTraining,
    /// Presentations per [`Event::Tick`](crate::controller::Event::Tick), 1 … 16 (half as many at
    /// first, when many ties are to be settled): bounds the work between two events and changes
    /// nothing else.
    pub slice: u16,
}

/// Learning from each move while seeking. Both rates are halved after 2048 moves since the maps
/// were made or read back, and each time the number of moves has doubled, down to 1/32.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Online {
    /// Learning rate of the situation map, Q16.
    pub situation_rate_q16: u32,
    /// Learning rate of the action map, Q16.
    pub action_rate_q16: u32,
    /// The direct neighbors' share of the rate, Q16.
    pub share_q16: u32,
    /// The action map updates the neuron that chose the move, not the best-matching one: a move
    /// without effect weakens its own cause.
    pub blame_recalled: bool,
}

/// The neuron aimed at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Subgoal {
    /// The direct neighbor fewest grid steps from the goal neuron (the paper's step 3), the one
    /// nearer in code on ties.
    FewestHops,
    /// The direct neighbor whose code vector is nearest to the goal, if nearer than the present
    /// neuron's.
    NearestCode,
    /// The goal itself: no intermediate neuron.
    Goal,
}

/// What to do while the goal holds and asks for no change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum AtGoal {
    /// Keep the last displacement.
    KeepCourse,
    /// Straight ahead along transducer 0.
    StraightAhead,
}

/// How the action is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum PlannerKind {
    /// The action map is probed with the change of situation wanted (the paper's step 4).
    Recall,
    /// One step ahead: the neuron whose action, stretched to the whole step, leads nearest to the
    /// goal.
    #[serde(alias = "Neurons")]
    BestNeuron,
    /// One step ahead: the direction of a transducer whose change, as all neurons together predict
    /// it, leads nearest to the goal.
    #[serde(alias = "Headings")]
    BestHeading,
    /// As [`PlannerKind::BestHeading`], but a robot that comes no nearer to a place does not
    /// wander: it goes several steps over the graph of traversed situations, if that knows a way.
    /// A device without the feature `graph` refuses such a configuration.
    #[cfg(feature = "graph")]
    Traversed,
}

/// What to do when no action leads nearer to a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Wander {
    /// Decisions without coming nearer before the robot wanders off.
    pub patience: u8,
    /// Decisions for which it then avoids obstacles on a new course.
    pub moves: u8,
}

/// From a goal to an action.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Planning {
    /// How the action is found; the fields up to `at_goal` are for [`PlannerKind::Recall`].
    #[serde(alias = "choice")]
    pub planner: PlannerKind,
    /// The neuron aimed at.
    #[serde(alias = "intermediate")]
    pub subgoal: Subgoal,
    /// How the action map is probed.
    pub recall: Recall,
    /// The wanted change starts from the situation as measured, not from the present neuron's code
    /// vector.
    pub from_measured: bool,
    /// All neurons of the action map answer the probe, weighted by how well their changes match;
    /// otherwise the best one alone.
    pub together: bool,
    /// Only unmet components of the goal are wanted: the others may change freely.
    pub unmet_only: bool,
    /// Weight of an action that keeps the course, beside 1 for the match of its change, in 1/256
    /// (recall by direction only).
    pub straight_q8: u16,
    /// Share of the course added to the recalled action, in 1/256.
    pub inertia_q8: u16,
    /// Recalled displacements are stretched to the robot's step.
    pub full_steps: bool,
    /// What to do at the goal.
    pub at_goal: AtGoal,
    /// A component may deviate this much and the goal still holds.
    pub tolerance: Weight,
    /// Decisions for which an action neuron is not recalled again after its move was cut below
    /// half; 0 = never.
    pub inhibition: u8,
    /// What to do when no action leads nearer to a place; `None` = keep trying.
    pub wander: Option<Wander>,
}

impl<const SENSORS: usize> Config<SENSORS> {
    /// The same choices for another robot, with all its transducers enabled.
    #[must_use]
    pub fn for_robot<const OTHERS: usize>(&self, robot: RobotSpec<OTHERS>) -> Config<OTHERS> {
        Config {
            robot,
            enabled: Mask::ALL,
            encoding: self.encoding,
            exploration: self.exploration,
            action_code: self.action_code,
            learning: self.learning,
            online: self.online,
            planning: self.planning,
            clearance_mm: self.clearance_mm,
            shield: self.shield,
            fault_detection: self.fault_detection,
            open_space: self.open_space,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::som::Decay;

    /// The values quoted in the documentation, and a checksum of all: a preset changes on purpose
    /// only.
    #[test]
    fn the_presets_are_what_they_are_said_to_be() {
        let literal = Config::touzet();
        let halves = |training: &MapTraining| (training.rate.start_q16(), training.rate.end_q16());
        assert_eq!(halves(&literal.learning.situations), (32_768, 3_276));
        assert_eq!(literal.learning.actions, literal.learning.situations);
        assert_eq!(
            literal.learning.situations.radius,
            Schedule::constant(32_768)
        );
        let best = Config::recommended();
        assert_eq!(halves(&best.learning.actions), (32_768, 655));
        let radius = Schedule::from_q16(65_536, 19_660, Decay::Linear);
        assert_eq!(best.learning.actions.radius, radius);
        assert!(literal.learning.largest_change_mm >= literal.encoding.far_mm);
        assert_eq!(best.learning.largest_change_mm, 350);
        assert!(best.learning.most_changed >= 32);
        let online = best.online.expect("it learns");
        assert_eq!(
            (online.situation_rate_q16, online.action_rate_q16),
            (3_276, 1_310)
        );
        let sum =
            |config: &Config<16>| crate::checksum::checksum(config.to_bytes(&mut [0; MAX_CONFIG]));
        let sums = [literal, Config::probing(), best].map(|config| sum(&config));
        assert_eq!(sums, [0x6adf_eb12, 0xb4e3_b8ae, 0x910c_ca6d]);
    }

    #[test]
    fn a_configuration_comes_back_from_its_bytes_and_nothing_from_others() {
        let config = Config::probing();
        let mut buffer = [0; MAX_CONFIG];
        let bytes = config.to_bytes(&mut buffer);
        assert_eq!(Config::from_bytes(bytes), Some(config));
        assert_eq!(Config::<16>::from_bytes(&bytes[..bytes.len() - 1]), None);
        assert_eq!(Config::<16>::from_bytes(&[]), None);
        // All zeros but for what learns at rate 0.
        let zeroed = Config::<16>::zeroed();
        let bytes = zeroed.to_bytes(&mut buffer);
        assert!(bytes.iter().filter(|byte| **byte != 0).count() <= 1);
    }
}
