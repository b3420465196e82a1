//! The JSON records of the channels `/event` and `/plan`.

use amp::config::Config;
use amp::controller::{
    Command, CommandRefusal, Decision, Event, Motion, Outputs, Progress, StopReason,
};
use amp::fixed::Weight;
use amp::goal::Goal;
use amp::places::Aim;
use amp::planner::Plan;
use amp::units::{Bearing, Displacement, Range};
use serde::{Deserialize, Serialize};
use sim::pilot::AgedEcho;
use sim::senses::Readings;

/// An input of the controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EventRecord {
    /// Time, milliseconds by the controller's clock.
    pub at_ms: u32,
    /// The input.
    #[serde(flatten)]
    pub event: EventKind,
}

/// Inputs of the controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// Echoes that were delivered together, in this order.
    Echoes(Vec<EchoRecord>),
    /// Odometry of the base.
    Odometry {
        /// The current or last motion.
        motion: u16,
        /// Displacement since the last report, millimeters in the ring's frame at that report.
        moved_mm: [i16; 2],
        /// Turn of the ring since then, in 1/65536 of a turn.
        turned: u16,
        /// State of the motion.
        progress: Progress,
    },
    /// Make random moves and remember samples.
    Explore {
        /// Number of moves.
        moves: u16,
        /// Seed of the controller's own generator.
        seed: u64,
    },
    /// Learn the maps.
    Learn,
    /// Pursue a goal.
    Seek(Goal<16>),
    /// Stop.
    Stop,
    /// Resume what a stop interrupted.
    Resume,
    /// Find where the body's sensors look.
    Calibrate {
        /// Number of random moves for that.
        moves: u16,
        /// Their seed.
        seed: u64,
        /// Whether to find as well what the base makes of its commands.
        actuators: bool,
    },
    /// Several ticks in a row. A remote controller may need another number of them.
    Ticks {
        /// Number of ticks.
        count: u32,
        /// The last one changed the mode: learning is done.
        done: bool,
    },
    /// An external alarm.
    Alarm(StopReason),
    /// A bumper touched something.
    Touched,
    /// A new configuration; the knowledge stays.
    Configure(Box<Config<16>>),
    /// Uploaded knowledge: the bytes of a controller's file, in hexadecimal.
    Know(String),
    /// Its places lead the robot there from now on; `None`: nowhere.
    LeadTo(Option<Aim>),
    /// What else its sensors read, where it is.
    Sense(Readings),
    /// It is led to this in another modality from now on, by its name on the command line; `None`:
    /// to nothing.
    SeekSense(Option<String>),
}

/// An echo.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct EchoRecord {
    /// Transducer.
    pub sensor: u8,
    /// Range, millimeters; `None` = no echo.
    pub range_mm: Option<u16>,
    /// Age when it was delivered, milliseconds.
    #[serde(default, skip_serializing_if = "is_none")]
    pub age_ms: u32,
}

/// An age of 0 is not written.
fn is_none(age_ms: &u32) -> bool {
    *age_ms == 0
}

impl EchoRecord {
    /// Converts an echo of the pilot.
    #[must_use]
    pub fn of(echo: &AgedEcho) -> Self {
        Self {
            sensor: echo.sensor,
            range_mm: echo.range.map(Range::as_mm),
            age_ms: echo.age_ms,
        }
    }

    /// Converts to an echo of the pilot.
    #[must_use]
    pub fn echo(self) -> AgedEcho {
        AgedEcho {
            sensor: self.sensor,
            range: self.range_mm.map(Range::from_mm),
            age_ms: self.age_ms,
        }
    }
}

impl EventKind {
    /// Converts an event; a tick counts as one without a result.
    #[must_use]
    pub fn of(event: &Event<16>) -> Self {
        match *event {
            Event::Echo { sensor, range } => {
                Self::Echoes(vec![EchoRecord::of(&AgedEcho::now(sensor, range))])
            }
            Event::Odometry {
                motion,
                moved,
                turned,
                progress,
            } => Self::Odometry {
                motion,
                moved_mm: [moved.dx_mm, moved.dy_mm],
                turned: turned.as_turns(),
                progress,
            },
            Event::Command(Command::Explore { moves, seed }) => Self::Explore { moves, seed },
            Event::Command(Command::Learn) => Self::Learn,
            Event::Command(Command::Seek(goal)) => Self::Seek(goal),
            Event::Command(Command::Stop) => Self::Stop,
            Event::Command(Command::Resume) => Self::Resume,
            Event::Command(Command::Calibrate {
                moves,
                seed,
                actuators,
            }) => Self::Calibrate {
                moves,
                seed,
                actuators,
            },
            Event::Tick => Self::Ticks {
                count: 1,
                done: false,
            },
            Event::Alarm(reason) => Self::Alarm(reason),
            Event::Touched => Self::Touched,
        }
    }

    /// Converts back; `None` for echoes and ticks, which stand for several events, and for changes
    /// that are no events.
    #[must_use]
    pub fn event(&self) -> Option<Event<16>> {
        Some(match *self {
            Self::Echoes(_)
            | Self::Ticks { .. }
            | Self::Configure(_)
            | Self::Know(_)
            | Self::LeadTo(_)
            | Self::Sense(_)
            | Self::SeekSense(_) => return None,
            Self::Odometry {
                motion,
                moved_mm: [dx_mm, dy_mm],
                turned,
                progress,
            } => Event::Odometry {
                motion,
                moved: Displacement { dx_mm, dy_mm },
                turned: Bearing::from_turns(turned),
                progress,
            },
            Self::Explore { moves, seed } => Event::Command(Command::Explore { moves, seed }),
            Self::Learn => Event::Command(Command::Learn),
            Self::Seek(goal) => Event::Command(Command::Seek(goal)),
            Self::Stop => Event::Command(Command::Stop),
            Self::Resume => Event::Command(Command::Resume),
            Self::Calibrate {
                moves,
                seed,
                actuators,
            } => Event::Command(Command::Calibrate {
                moves,
                seed,
                actuators,
            }),
            Self::Alarm(reason) => Event::Alarm(reason),
            Self::Touched => Event::Touched,
        })
    }
}

/// Outputs of the controller for an event.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AnswerRecord {
    /// Time, milliseconds by the controller's clock.
    pub at_ms: u32,
    /// The motion for the base.
    pub motion: Option<MotionRecord>,
    /// A decision.
    pub decision: Option<DecisionRecord>,
    /// The mode changed.
    pub mode_changed: bool,
    /// A command was refused.
    pub refusal: Option<CommandRefusal>,
}

impl AnswerRecord {
    /// The outputs of an event; `None` if there are none.
    #[must_use]
    pub fn of(at_ms: u32, outputs: &Outputs<16>) -> Option<Self> {
        let is_answer = outputs.motion.is_some()
            || outputs.decision.is_some()
            || outputs.mode_changed
            || outputs.refusal.is_some();
        is_answer.then(|| Self {
            at_ms,
            motion: outputs.motion.map(MotionRecord::from),
            decision: outputs.decision.as_ref().map(DecisionRecord::from),
            mode_changed: outputs.mode_changed,
            refusal: outputs.refusal,
        })
    }
}

/// A motion of the base: a displacement in the ring's frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct MotionRecord {
    /// Number of the motion.
    pub id: u16,
    /// Displacement, millimeters.
    pub displacement_mm: [i16; 2],
    /// Maximum speed.
    pub speed_mm_s: u16,
}

impl From<Motion> for MotionRecord {
    fn from(motion: Motion) -> Self {
        Self {
            id: motion.id,
            displacement_mm: pair(motion.displacement),
            speed_mm_s: motion.speed_mm_s,
        }
    }
}

/// A decision.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DecisionRecord {
    /// Situation at the decision, one value in [0, 1] per transducer.
    pub situation: Vec<f64>,
    /// Intermediate values of the planner; `None` for a random move.
    pub plan: Option<PlanRecord>,
    /// Wanted displacement, millimeters in the ring's frame.
    pub wanted_mm: [i16; 2],
    /// Displacement after the shield.
    pub allowed_mm: [i16; 2],
    /// The goal holds.
    pub at_goal: bool,
}

impl From<&Decision<16>> for DecisionRecord {
    fn from(decision: &Decision<16>) -> Self {
        Self {
            situation: numbers(&decision.situation),
            plan: decision.plan.as_ref().map(PlanRecord::from),
            wanted_mm: pair(decision.wanted),
            allowed_mm: pair(decision.allowed),
            at_goal: decision.at_goal,
        }
    }
}

/// Intermediate values of the paper's four steps (section 2.5, Fig. 3).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanRecord {
    /// Goal neuron.
    pub goal_neuron: u8,
    /// Best-matching unit of the current situation.
    pub current_neuron: u8,
    /// Subgoal.
    pub subgoal_neuron: u8,
    /// Wanted change of situation, one value in [−1, 1] per transducer.
    pub wanted_change: Vec<f64>,
    /// Best neuron of the action map.
    pub action_neuron: u8,
    /// The goal holds.
    pub at_goal: bool,
    /// The action map recalled this action.
    pub recalled: bool,
    /// Wanted displacement, millimeters in the ring's frame.
    pub action_mm: [i16; 2],
    /// Reason, in words.
    pub why: String,
}

impl From<&Plan<16>> for PlanRecord {
    fn from(plan: &Plan<16>) -> Self {
        Self {
            goal_neuron: plan.goal_neuron,
            current_neuron: plan.current_neuron,
            subgoal_neuron: plan.subgoal_neuron,
            wanted_change: numbers(&plan.wanted),
            action_neuron: plan.action_neuron,
            at_goal: plan.at_goal,
            recalled: plan.recalled,
            action_mm: pair(plan.action),
            why: plan.why.to_string(),
        }
    }
}

/// Multiples of 2⁻¹³ are exact in decimal.
fn numbers(weights: &[Weight]) -> Vec<f64> {
    weights.iter().map(|weight| weight.to_num()).collect()
}

fn pair(displacement: Displacement) -> [i16; 2] {
    [displacement.dx_mm, displacement.dy_mm]
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::goal::Side;
    use arena::sources::Sensed;

    #[test]
    fn every_event_comes_back_from_json() {
        let config = Config::<16>::recommended();
        let goal = Goal::wall(Side::Right, Range::from_mm(600), &config);
        let events = [
            Event::Odometry {
                motion: 7,
                moved: Displacement {
                    dx_mm: -3,
                    dy_mm: 250,
                },
                turned: Bearing::from_turns(65_000),
                progress: Progress::Touched,
            },
            Event::Command(Command::Explore {
                moves: 100,
                seed: u64::MAX - 1,
            }),
            Event::Command(Command::Learn),
            Event::Command(Command::Seek(goal)),
            Event::Command(Command::Stop),
            Event::Command(Command::Resume),
            Event::Alarm(StopReason::LinkLost),
            Event::Touched,
        ];
        for event in events {
            let record = EventRecord {
                at_ms: 7,
                event: EventKind::of(&event),
            };
            let json = serde_json::to_string(&record).unwrap();
            let back: EventRecord = serde_json::from_str(&json).unwrap();
            assert_eq!(back, record, "{json}");
            assert_eq!(back.event.event(), Some(event), "{json}");
        }
        let echo = Event::Echo {
            sensor: 3,
            range: Some(Range::from_mm(1_234)),
        };
        let json = serde_json::to_string(&EventKind::of(&echo)).unwrap();
        assert_eq!(json, "{\"echoes\":[{\"sensor\":3,\"range_mm\":1234}]}");
        for age_ms in [0, 70_000] {
            let echo = AgedEcho {
                sensor: 3,
                range: None,
                age_ms,
            };
            let json = serde_json::to_string(&EchoRecord::of(&echo)).unwrap();
            let back: EchoRecord = serde_json::from_str(&json).unwrap();
            assert_eq!(back.echo(), echo, "{json}");
        }
    }

    #[test]
    fn what_a_body_is_told_comes_back_from_json() {
        let position = Displacement {
            dx_mm: -7,
            dy_mm: 1_250,
        };
        let aims = [
            Aim::Frontier,
            Aim::Everywhere,
            Aim::Situation,
            Aim::Position(position),
        ];
        let aims = aims.map(Some).into_iter().chain([None]);
        let goals = [Some("floor:red".to_owned()), None];
        let sensed = Sensed {
            scent: 0.5,
            light: 1.0,
            floor: [0.25; 3],
        };
        let readings = Readings::of(&sensed, || 1.0);
        let events = aims
            .map(EventKind::LeadTo)
            .chain(goals.map(EventKind::SeekSense))
            .chain([EventKind::Sense(readings)]);
        for event in events {
            let record = EventRecord { at_ms: 7, event };
            let json = serde_json::to_string(&record).unwrap();
            let back: EventRecord = serde_json::from_str(&json).unwrap();
            assert_eq!(back, record, "{json}");
            assert_eq!(back.event.event(), None, "{json}");
        }
    }

    /// Logs of format 3 have former names.
    #[test]
    fn former_names_are_read() {
        let former = [
            ("\"enabled\"", "\"believed\""),
            ("\"augment_rotations\"", "\"turned\""),
            ("\"learn_from\"", "\"taught\""),
            ("\"planner\"", "\"choice\""),
            ("\"subgoal\"", "\"intermediate\""),
            ("\"BestHeading\"", "\"Headings\""),
        ];
        let config = Config::<16>::recommended();
        let mut json = serde_json::to_string(&config).unwrap();
        for (name, before) in former {
            assert!(json.contains(name), "{name}");
            json = json.replace(name, before);
        }
        assert_eq!(serde_json::from_str::<Config<16>>(&json).unwrap(), config);
        let stop: StopReason = serde_json::from_str("\"NoEchoes\"").unwrap();
        assert_eq!(stop, StopReason::NoEchoes);
    }

    #[test]
    fn a_configuration_comes_back_from_json() {
        for config in [Config::<16>::recommended(), Config::touzet()] {
            let json = serde_json::to_string(&config).unwrap();
            assert_eq!(serde_json::from_str::<Config<16>>(&json).unwrap(), config);
        }
    }
}
