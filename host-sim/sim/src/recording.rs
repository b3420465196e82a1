//! The recorded data of an episode, for pictures and tests: plain values in meters, radians and map
//! units.
//!
//! Every picture of an episode is drawn from a [`Recording`], so it can be drawn again later.

use amp::fixed::Weight;
use amp::som::Som;
use arena::world::{Point, Pose, World};

/// One decision and its execution.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Step {
    /// Pose at the decision; the heading is the bearing of transducer 0.
    pub pose: Pose,
    /// Simulated time of the decision, seconds since the episode began.
    pub time_s: f64,
    /// Ranges by transducer, meters from its face; `None` = no echo.
    pub ranges_m: Vec<Option<f64>>,
    /// Situation, one value in [0, 1] per transducer: 1 = obstacle at the near limit, 0 = none.
    pub situation: Vec<f64>,
    /// Intermediate values of the planner; `None` while exploring.
    pub plan: Option<PlanTrace>,
    /// Displacement asked for, meters in the ring's frame: x along transducer 0, y to its left.
    pub commanded_m: [f64; 2],
    /// Displacement the base carried out, meters in the same frame.
    pub executed_m: [f64; 2],
    /// The robot touched something during the motion.
    pub touched: bool,
    /// The shield shortened or stopped the motion.
    pub shielded: bool,
    /// Position of the leader, if there is one.
    pub leader: Option<Point>,
    /// Index of the goal in a chain.
    pub part: usize,
}

/// The planner's intermediate values for one decision (steps 1 to 4 of the paper, Fig. 3).
#[derive(Debug, Clone, PartialEq)]
pub struct PlanTrace {
    /// Neuron of the situation map that stands for the goal.
    pub goal_neuron: usize,
    /// Best-matching unit of the current situation.
    pub current_neuron: usize,
    /// Neighbor of the current neuron that is nearer to the goal.
    pub subgoal_neuron: usize,
    /// Wanted change of situation, one value in [-1, 1] per transducer: the probe of the action
    /// map.
    pub wanted_change: Vec<f64>,
    /// Neuron of the action map with the best match.
    pub action_neuron: usize,
    /// Why this action, in a few words.
    pub reason: String,
    /// The goal held when the decision was taken.
    pub at_goal: bool,
}

/// A self-organizing map as it is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct MapRecord {
    /// Neurons along x and along y of the grid.
    pub grid: [usize; 2],
    /// Code vectors, one per neuron, row by row from the top.
    pub code: Vec<Vec<f64>>,
    /// Hits per neuron. The situation map is probed with every situation of the episode, the change
    /// map with every remembered change.
    pub hits: Vec<usize>,
    /// Mean distance of each neuron to its direct neighbors (U-matrix).
    pub u_matrix: Vec<f64>,
}

impl MapRecord {
    /// The map, with the hits of these samples.
    #[must_use]
    pub fn new<const NEURONS: usize, const DIMS: usize>(
        map: &Som<NEURONS, DIMS>,
        samples: &[[Weight; DIMS]],
    ) -> Self {
        let (_, hits) = map.quality(samples);
        let code = map.code().iter();
        let distances = map.u_matrix();
        Self {
            grid: [map.grid().columns(), map.grid().rows()],
            code: code
                .map(|row| row.iter().map(|value| value.to_num()).collect())
                .collect(),
            hits: hits.iter().map(|&hit| hit as usize).collect(),
            u_matrix: distances.iter().map(|&u| f64::from(u) / 8_192.0).collect(),
        }
    }
}

/// A whole episode: one world, one exploration, one behavior.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// The world it happened in.
    pub world: World,
    /// Name of the behavior, e.g. `avoid`, and of the file with its goal, if it has one.
    pub behavior: String,
    /// Names of the behaviors of a chain; one for all others.
    pub parts: Vec<String>,
    /// Name of the preset, e.g. `default`.
    pub preset: String,
    /// Seed of all randomness.
    pub seed: u64,
    /// Bearings of the transducers in the ring's frame, radians counter-clockwise from its x axis.
    pub bearings_rad: Vec<f64>,
    /// Range at which a situation value is 1, meters.
    pub near_m: f64,
    /// Range at which a situation value becomes 0, meters.
    pub far_m: f64,
    /// Place of the nest or of a captured situation; `None` where there is none or it is unknown.
    pub goal_place: Option<Point>,
    /// Radius of the collision disc, meters.
    pub robot_radius_m: f64,
    /// The random moves; those of the tour if there was one.
    pub exploration: Vec<Step>,
    /// The robot drove around before the behavior.
    pub has_toured: bool,
    /// The decisions taken while seeking the goal.
    pub seeking: Vec<Step>,
    /// The situation map at the end.
    pub situation_map: MapRecord,
    /// The action map's changes of situation at the end.
    pub change_map: MapRecord,
    /// The action map's actions at the end: displacements in meters in the ring's frame, one per
    /// neuron.
    pub actions_m: Vec<[f64; 2]>,
}
