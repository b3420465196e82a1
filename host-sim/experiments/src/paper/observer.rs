//! Observes a controller's decisions: every plan with its situation, and copies of its state.

use amp::config::Config;
use amp::controller::{Command, Event, Outputs};
use amp::fixed::{Mask, Weight};
use amp::goal::Goal;
use amp::planner::Plan;
use amp::scan::Situation;
use amp::units::Millis;
use sim::error::EpisodeError;
use sim::pilot::{InspectableController, LocalController, Pilot, SimState};

/// One decision toward the goal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObservedDecision {
    /// The situation (D in Fig. 3).
    pub situation: Situation<16>,
    /// The plan.
    pub plan: Plan<16>,
    /// Code vector of the subgoal's neuron at that moment (F in Fig. 3).
    pub aim: Situation<16>,
    /// That code vector is nearer to the goal than the present neuron's.
    pub aim_is_nearer: bool,
    /// The present neuron's code vector meets the goal.
    pub neuron_meets_goal: bool,
}

/// A controller with its observation.
pub struct ObservedController {
    mind: LocalController,
    /// Number of decisions after which [`ObservedController::later`] is copied.
    keep_after: usize,
    goal: Option<Goal<16>>,
    /// All decisions toward the goal.
    pub observed: Vec<ObservedDecision>,
    /// State when the goal arrived.
    pub learned: Option<Box<SimState>>,
    /// State `keep_after` decisions later.
    pub later: Option<Box<SimState>>,
}

impl ObservedController {
    /// An untrained controller; its state is copied again after `keep_after` decisions.
    #[must_use]
    pub fn new(config: Config<16>, keep_after: usize) -> Self {
        Self {
            mind: LocalController::new(config),
            keep_after,
            goal: None,
            observed: Vec::new(),
            learned: None,
            later: None,
        }
    }
}

impl Pilot for ObservedController {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        if let Event::Command(Command::Seek(goal)) = event {
            self.goal = Some(goal);
            self.learned
                .get_or_insert_with(|| Box::new(self.mind.state().clone()));
        }
        let outputs = self.mind.handle(at, event);
        let plan = outputs.decision.and_then(|decision| decision.plan);
        if let (Some(decision), Some(plan)) = (outputs.decision, plan) {
            let code = |neuron| {
                let map = self.mind.state().situations();
                map.code_vector(usize::from(neuron))
            };
            let away = |neuron| {
                let goal = self.goal.as_ref();
                goal.map_or(0, |goal| goal.distance(&code(neuron), Mask::ALL))
            };
            let now = away(plan.current_neuron);
            self.observed.push(ObservedDecision {
                situation: decision.situation,
                plan,
                aim: code(plan.subgoal_neuron),
                aim_is_nearer: away(plan.subgoal_neuron) < now,
                neuron_meets_goal: now == 0,
            });
            if self.observed.len() == self.keep_after {
                self.later = Some(Box::new(self.mind.state().clone()));
            }
        }
        outputs
    }
}

impl InspectableController for ObservedController {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        self.mind.knowledge()
    }
}

/// `to − from`, by component.
#[must_use]
pub fn change(to: &[Weight], from: &[Weight]) -> Vec<f64> {
    let values = to.iter().zip(from);
    values
        .map(|(to, from)| to.to_num::<f64>() - from.to_num::<f64>())
        .collect()
}

/// Euclidean length.
#[must_use]
pub fn length(vector: &[f64]) -> f64 {
    vector.iter().map(|value| value * value).sum::<f64>().sqrt()
}

/// Cosine of the angle between two vectors; `None` if one has length 0.
#[must_use]
pub fn cosine(a: &[f64], b: &[f64]) -> Option<f64> {
    let lengths = length(a) * length(b);
    let product: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    (lengths > 0.0).then(|| product / lengths)
}
