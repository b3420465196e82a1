//! The all-zero configuration of a node that has not been started.

use super::{
    AtGoal, Config, Exploration, Initialization, LearnFrom, Learning, MapTraining, Online,
    PlannerKind, Planning, SampleOrder, Subgoal,
};
use crate::action_map::{ActionCode, Recall};
use crate::fixed::{Mask, Weight};
use crate::robot::RobotSpec;
use crate::scan::Encoding;
use crate::som::{Edges, Neighborhood, Schedule};
use crate::units::{Bearing, Direction};

impl<const SENSORS: usize> Config<SENSORS> {
    /// All zeros: no transducer enabled, a step of no length, no epochs. A static node with it lies
    /// in zeroed memory.
    #[must_use]
    pub(crate) const fn zeroed() -> Self {
        let training = MapTraining {
            neighborhood: Neighborhood::Direct,
            rate: Schedule::constant(0),
            radius: Schedule::constant(0),
        };
        Self {
            robot: RobotSpec {
                directions: [Direction { x_q14: 0, y_q14: 0 }; SENSORS],
                symmetric: false,
                face_radius_mm: 0,
                body_radius_mm: 0,
                step_mm: 0,
                speed_mm_s: 0,
                braking_mm_s2: 0,
                ring_period_ms: 0,
                steer_ms: 0,
                half_cone: Bearing::ZERO,
            },
            enabled: Mask::NONE,
            encoding: Encoding {
                near_mm: 0,
                far_mm: 0,
            },
            exploration: Exploration {
                shortest_mm: 0,
                draws: 0,
            },
            action_code: ActionCode::Displacement,
            learning: Learning {
                epochs: 0,
                order: SampleOrder::Recorded,
                start: Initialization::Samples,
                augment_rotations: false,
                action_weight_q8: 0,
                learn_from: LearnFrom::Commanded,
                largest_change_mm: 0,
                most_changed: 0,
                edges: Edges::Open,
                situations: training,
                actions: training,
                slice: 0,
            },
            // Of rate 0: the bits of `None` would not be zeros.
            online: Some(Online {
                situation_rate_q16: 0,
                action_rate_q16: 0,
                share_q16: 0,
                blame_recalled: false,
            }),
            planning: Planning {
                planner: PlannerKind::Recall,
                wander: None,
                subgoal: Subgoal::FewestHops,
                recall: Recall::Distance,
                from_measured: false,
                together: false,
                unmet_only: false,
                straight_q8: 0,
                inertia_q8: 0,
                full_steps: false,
                at_goal: AtGoal::KeepCourse,
                tolerance: Weight::ZERO,
                inhibition: 0,
            },
            clearance_mm: 0,
            shield: None,
            fault_detection: false,
            open_space: false,
        }
    }
}
