//! The presets for the Nomad 200: `touzet`, `recommended` and `probing`.

use super::{
    AtGoal, Config, Exploration, Initialization, LearnFrom, Learning, MapTraining, Online,
    PlannerKind, Planning, SampleOrder, Subgoal, Wander,
};
use crate::action_map::{ActionCode, Recall};
use crate::fixed::{Mask, Weight};
use crate::robot::RobotSpec;
use crate::scan::Encoding;
use crate::shield::ShieldConfig;
use crate::som::{Decay, Edges, Neighborhood, Schedule};

/// 1.0 in Q16.
const ONE_Q16: u32 = 1 << 16;

impl Config<16> {
    /// The most literal reading of the paper: an action is (turn, step), the probe is by squared
    /// distance, the neighbor by grid steps among the four direct ones, learning goes on, straight
    /// ahead at the goal. The ring is to turn with the heading.
    #[must_use]
    pub const fn touzet() -> Self {
        let training = MapTraining {
            neighborhood: Neighborhood::Direct,
            rate: Schedule::from_q16(ONE_Q16 / 2, ONE_Q16 / 20, Decay::Linear),
            radius: Schedule::constant(ONE_Q16 / 2),
        };
        Self {
            robot: RobotSpec::nomad200(),
            enabled: Mask::ALL,
            encoding: Encoding {
                near_mm: 150,
                far_mm: 1_000,
            },
            exploration: Exploration {
                shortest_mm: 0,
                draws: 8,
            },
            action_code: ActionCode::TurnStep,
            learning: Learning {
                epochs: 100,
                order: SampleOrder::Random,
                start: Initialization::Samples,
                augment_rotations: false,
                action_weight_q8: 256,
                learn_from: LearnFrom::Executed,
                largest_change_mm: 10_000,
                most_changed: u8::MAX,
                edges: Edges::Open,
                situations: training,
                actions: training,
                slice: 4,
            },
            online: Some(Online {
                situation_rate_q16: ONE_Q16 / 20,
                action_rate_q16: ONE_Q16 / 20,
                share_q16: ONE_Q16 / 2,
                blame_recalled: false,
            }),
            planning: Planning {
                planner: PlannerKind::Recall,
                subgoal: Subgoal::FewestHops,
                recall: Recall::Distance,
                from_measured: true,
                together: false,
                unmet_only: false,
                straight_q8: 0,
                inertia_q8: 0,
                full_steps: false,
                at_goal: AtGoal::StraightAhead,
                tolerance: Weight::ZERO,
                inhibition: 0,
                wander: None,
            },
            clearance_mm: 1_000,
            shield: Some(ShieldConfig::nomad200()),
            fault_detection: true,
            open_space: false,
        }
    }

    /// The best found: see the project's documentation for the measurement behind each choice. The
    /// ring is to keep its bearing in the world.
    #[must_use]
    pub const fn recommended() -> Self {
        let probing = Self::probing();
        Self {
            clearance_mm: 600,
            planning: Planning {
                planner: PlannerKind::BestHeading,
                wander: Some(Wander {
                    patience: 6,
                    moves: 30,
                }),
                ..probing.planning
            },
            ..probing
        }
    }

    /// As [`recommended`](Self::recommended), but where one step no longer leads nearer to a place,
    /// it plans several over the graph of traversed situations.
    #[cfg(feature = "graph")]
    #[must_use]
    pub const fn traversing() -> Self {
        let recommended = Self::recommended();
        Self {
            planning: Planning {
                planner: PlannerKind::Traversed,
                ..recommended.planning
            },
            ..recommended
        }
    }

    /// The best found that keeps the paper's four steps: the action map is probed with the change
    /// of situation wanted. The ring is to keep its bearing in the world.
    #[must_use]
    pub const fn probing() -> Self {
        let literal = Self::touzet();
        Self {
            encoding: Encoding {
                near_mm: 0,
                far_mm: 4_500,
            },
            clearance_mm: 700,
            action_code: ActionCode::Displacement,
            learning: Learning {
                start: Initialization::Plane,
                augment_rotations: true,
                largest_change_mm: 350,
                actions: MapTraining {
                    rate: Schedule::from_q16(ONE_Q16 / 2, ONE_Q16 / 100, Decay::Exponential),
                    radius: Schedule::from_q16(ONE_Q16, ONE_Q16 * 3 / 10, Decay::Linear),
                    ..literal.learning.actions
                },
                ..literal.learning
            },
            online: Some(Online {
                situation_rate_q16: ONE_Q16 / 20,
                action_rate_q16: ONE_Q16 / 50,
                share_q16: 0,
                blame_recalled: false,
            }),
            planning: Planning {
                subgoal: Subgoal::NearestCode,
                recall: Recall::Direction,
                together: true,
                unmet_only: true,
                full_steps: true,
                at_goal: AtGoal::KeepCourse,
                inhibition: 8,
                ..literal.planning
            },
            ..literal
        }
    }
}
