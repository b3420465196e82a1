//! The rows of the table of settings, in the order of the data's way through the controller.

use super::rows::*;
use super::{NumberFormat, Setting, SettingKind, Value};
use crate::action_map::{ActionCode, Recall};
use crate::config::{AtGoal, Initialization, LearnFrom, PlannerKind, SampleOrder, Subgoal};
use crate::fixed::Weight;
use crate::parameters::Parameter;
use crate::som::{Edges, Neighborhood};
use crate::units::Bearing;

impl<const SENSORS: usize> Setting<SENSORS> {
    /// All of them.
    pub const ALL: &'static [Self] = &[
        Self::of(
            Parameter::Near,
            "near",
            "range at which a value is 1, meters",
        ),
        Self::of(
            Parameter::Far,
            "far",
            "range from which on a value is 0, meters",
        )
        .between(10, 10_000),
        Self::of(
            Parameter::Enabled,
            "disabled-sensors",
            "transducers not to believe: none, or numbers joined by +, e.g. 3+7",
        ),
        Self::of(
            Parameter::FaultDetection,
            "fault-detection",
            "whether sonars that misbehave are no longer believed: on | off",
        ),
        Self::new(
            "open-space",
            "whether rings without any echo are expected; otherwise three in a row stop \
             the robot: on | off",
            SettingKind::Switch,
            |config| Value::of(config.open_space),
            |config, value| config.open_space = value.is_on(),
        ),
        Self::of(
            Parameter::Step,
            "step",
            "longest displacement per decision, meters",
        ),
        Self::new(
            "explore.shortest",
            "shortest random move, meters (the longest is step)",
            number(NumberFormat::Millimeters, 0, 1_000),
            |config| Value::of(config.exploration.shortest_mm),
            |config, value| config.exploration.shortest_mm = value.short(),
        ),
        Self::new(
            "explore.draws",
            "draws until the shield leaves half of a random move: 1..255",
            BYTE,
            |config| Value::of(config.exploration.draws),
            |config, value| config.exploration.draws = value.byte(),
        ),
        words!(
            "action",
            "what an action is: displacement | turn-step",
            action_code,
            [
                ("displacement", ActionCode::Displacement),
                ("turn-step", ActionCode::TurnStep)
            ]
        ),
        Self::of(
            Parameter::Epochs,
            "epochs",
            "presentations of the whole memory: 1..65535",
        )
        .between(1, 65_535),
        words!(
            "order",
            "order of the samples: recorded | random",
            learning.order,
            [
                ("recorded", SampleOrder::Recorded),
                ("random", SampleOrder::Random)
            ]
        ),
        words!(
            "initialization",
            "starting code vectors: samples | random | plane",
            learning.start,
            [
                ("samples", Initialization::Samples),
                ("random", Initialization::Random),
                ("plane", Initialization::Plane)
            ]
        ),
        Self::new(
            "augment-rotations",
            "samples also learned turned by ring steps: on | off",
            SettingKind::Switch,
            |config| Value::of(config.learning.augment_rotations),
            |config, value| config.learning.augment_rotations = value.is_on(),
        ),
        Self::new(
            "action-weight",
            "weight of the action beside the change when learning: 0..255",
            FACTOR,
            |config| Value::of(config.learning.action_weight_q8),
            |config, value| config.learning.action_weight_q8 = value.short(),
        ),
        words!(
            "learn-from",
            "displacement a sample teaches: commanded | executed",
            learning.learn_from,
            [
                ("commanded", LearnFrom::Commanded),
                ("executed", LearnFrom::Executed)
            ]
        ),
        Self::new(
            "largest-change",
            "a larger change of a range in a move is another surface, and not learned, meters",
            number(NumberFormat::Millimeters, 0, 10_000),
            |config| Value::of(config.learning.largest_change_mm),
            |config, value| config.learning.largest_change_mm = value.short(),
        ),
        Self::new(
            "most-changed",
            "with more such changes in a move nothing is learned from it while seeking: 0..255",
            number(NumberFormat::Count, 0, 255),
            |config| Value::of(config.learning.most_changed),
            |config, value| config.learning.most_changed = value.byte(),
        ),
        words!(
            "edges",
            "border of the grids: open | wrapped",
            learning.edges,
            [("open", Edges::Open), ("wrapped", Edges::Wrapped)]
        ),
        words!(
            "situation.neighborhood",
            "situation map: direct | gaussian",
            learning.situations.neighborhood,
            [
                ("direct", Neighborhood::Direct),
                ("gaussian", Neighborhood::Gaussian)
            ]
        ),
        schedule!(
            "situation.rate",
            "situation map's learning rate, START:END:linear|exponential|inverse",
            RATE,
            learning.situations.rate
        ),
        schedule!(
            "situation.radius",
            "situation map's radius (direct: neighbors' share), likewise",
            RADIUS,
            learning.situations.radius
        ),
        words!(
            "action.neighborhood",
            "action map: direct | gaussian",
            learning.actions.neighborhood,
            [
                ("direct", Neighborhood::Direct),
                ("gaussian", Neighborhood::Gaussian)
            ]
        ),
        schedule!(
            "action.rate",
            "action map's learning rate, START:END:linear|exponential|inverse",
            RATE,
            learning.actions.rate
        ),
        schedule!(
            "action.radius",
            "action map's radius (direct: neighbors' share), likewise",
            RADIUS,
            learning.actions.radius
        ),
        Self::new(
            "online.situation-rate",
            "situation map's learning rate while seeking, at first: 0..1",
            SHARE,
            |config| of_online(config, |online| online.situation_rate_q16),
            |config, value| put_online(config, |online| online.situation_rate_q16 = value.long()),
        ),
        Self::new(
            "online.action-rate",
            "action map's learning rate while seeking, at first: 0..1",
            SHARE,
            |config| of_online(config, |online| online.action_rate_q16),
            |config, value| put_online(config, |online| online.action_rate_q16 = value.long()),
        ),
        Self::new(
            "online.share",
            "neighbors' share of it: 0..1",
            SHARE,
            |config| of_online(config, |online| online.share_q16),
            |config, value| put_online(config, |online| online.share_q16 = value.long()),
        ),
        Self::new(
            "online.learner",
            "action neuron that learns while seeking: best | recalled",
            SettingKind::Words(&["best", "recalled"]),
            |config| of_online(config, |online| online.blame_recalled.into()),
            |config, value| put_online(config, |online| online.blame_recalled = value.is_on()),
        ),
        #[cfg(not(feature = "graph"))]
        words!(
            "planner",
            "how the action is found: recall (probe by the change) | neurons | headings \
             (look-ahead)",
            planning.planner,
            [
                ("recall", PlannerKind::Recall),
                ("neurons", PlannerKind::BestNeuron),
                ("headings", PlannerKind::BestHeading)
            ]
        ),
        #[cfg(feature = "graph")]
        words!(
            "planner",
            "how the action is found: recall (probe by the change) | neurons | headings \
             (look-ahead) | traversed (several steps over what was traversed)",
            planning.planner,
            [
                ("recall", PlannerKind::Recall),
                ("neurons", PlannerKind::BestNeuron),
                ("headings", PlannerKind::BestHeading),
                ("traversed", PlannerKind::Traversed)
            ]
        ),
        Self::new(
            "wander",
            "off on a new course when a place comes no nearer: PATIENCE:MOVES decisions, \
             or off",
            SettingKind::Wander,
            |config| Value::Wander(config.planning.wander),
            |config, value| {
                if let Value::Wander(wander) = value {
                    config.planning.wander = wander;
                }
            },
        ),
        words!(
            "subgoal",
            "neuron aimed at: hops | code | goal",
            planning.subgoal,
            [
                ("hops", Subgoal::FewestHops),
                ("code", Subgoal::NearestCode),
                ("goal", Subgoal::Goal)
            ]
        ),
        words!(
            "recall",
            "probe of the action map: distance | direction | projection",
            planning.recall,
            [
                ("distance", Recall::Distance),
                ("direction", Recall::Direction),
                ("projection", Recall::Projection)
            ]
        ),
        words!(
            "change-from",
            "the wanted change starts from: measured | code",
            planning.from_measured,
            [("measured", true), ("code", false)]
        ),
        Self::new(
            "full-steps",
            "recalled moves stretched to the longest step: on | off",
            SettingKind::Switch,
            |config| Value::of(config.planning.full_steps),
            |config, value| config.planning.full_steps = value.is_on(),
        ),
        words!(
            "at-goal",
            "what to do while the goal holds: course | ahead",
            planning.at_goal,
            [
                ("course", AtGoal::KeepCourse),
                ("ahead", AtGoal::StraightAhead)
            ]
        ),
        words!(
            "probe-components",
            "components whose change is wanted: all | unmet (only what the goal does not \
             have yet)",
            planning.unmet_only,
            [("all", false), ("unmet", true)]
        ),
        words!(
            "probe-neurons",
            "who answers the probe of the action map: best | together (all, by how well \
             they match)",
            planning.together,
            [("best", false), ("together", true)]
        ),
        Self::new(
            "straight",
            "preference for actions that keep the course, beside 1 for the wanted change: \
             0..255",
            FACTOR,
            |config| Value::of(config.planning.straight_q8),
            |config, value| config.planning.straight_q8 = value.short(),
        ),
        Self::new(
            "inertia",
            "share of the course added to the recalled action: 0..255",
            FACTOR,
            |config| Value::of(config.planning.inertia_q8),
            |config, value| config.planning.inertia_q8 = value.short(),
        ),
        Self::of(
            Parameter::Clearance,
            "clearance",
            "what free of obstacles means: nothing nearer than this, meters",
        )
        .between(10, 10_000),
        Self::new(
            "tolerance",
            "deviation with which the goal still holds: 0..1",
            number(NumberFormat::WeightBits, 0, 1 << 13),
            |config| Value::of(config.planning.tolerance.to_bits()),
            |config, value| {
                config.planning.tolerance = Weight::from_bits(value.short().cast_signed())
            },
        ),
        Self::new(
            "inhibition",
            "decisions an action neuron rests after its move was cut: 0..255",
            number(NumberFormat::Count, 0, 255),
            |config| Value::of(config.planning.inhibition),
            |config, value| config.planning.inhibition = value.byte(),
        ),
        Self::of(
            Parameter::Margin,
            "shield.margin",
            "distance the shield keeps, meters",
        )
        .between(0, 2_000),
        Self::new(
            "shield.half-lobe",
            "half opening of a sonar's lobe as the shield sees it, degrees",
            number(NumberFormat::Turns, 0, 8_192),
            |config| of_shield(config, |shield| shield.half_lobe.as_turns().into()),
            |config, value| {
                put_shield(config, |shield| {
                    shield.half_lobe = Bearing::from_turns(value.short())
                })
            },
        ),
        Self::new(
            "shield.min-range",
            "shortest range the ring can report, meters: such a reading may be anything \
             nearer",
            LENGTH,
            |config| of_shield(config, |shield| shield.least_range_mm.into()),
            |config, value| put_shield(config, |shield| shield.least_range_mm = value.short()),
        ),
        Self::new(
            "shield.fresh",
            "a direction is open while heard within this time, seconds",
            TIME,
            |config| of_shield(config, |shield| shield.fresh_ms),
            |config, value| put_shield(config, |shield| shield.fresh_ms = value.long()),
        ),
        Self::new(
            "shield.forget",
            "when a sonar was silent for longer, seconds, all that was heard before is forgotten",
            TIME,
            |config| of_shield(config, |shield| shield.forget_ms),
            |config, value| put_shield(config, |shield| shield.forget_ms = value.long()),
        ),
    ];
}
