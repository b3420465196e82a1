//! A bridge: the controller drives a Nomad 200 over the robot's own protocol.
//!
//! One thread polls the robot and drives its motors, and never waits for the controller. The other,
//! the worker, runs the controller. The turret never turns. A bumper, a lost controller and an
//! unconfirmed report stop the base; if this program ends, the base's own time-out of one second
//! does.

mod events;
mod motion_control;
mod report;
mod session;
mod worker;

pub use report::{BridgeError, BridgePlan, BridgeReport};
pub use session::{Activity, BridgeSession};
pub use worker::{ResultKind, WorkerResult};

use super::{Host, StateMask, WITH_SONAR};
use amp::controller::{self, Outputs, Progress};
use amp::fixed::Weight;
use amp::scan::Situation;
use remote::log::LoggedController;
use session::check_refusal;
use sim::behavior::is_reached;
use sim::episode::{Seeds, rounded};
use sim::error::EpisodeError;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Interval of polls: a fraction of a firing slot, also at twenty times real time.
pub const POLL_INTERVAL: Duration = Duration::from_millis(2);

/// Flags of the current step.
#[derive(Debug, Clone, Copy, Default)]
struct BridgeStep {
    at_goal: bool,
    shielded: bool,
    touched: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum BridgePhase {
    Explore,
    Learn,
    /// Index of the part of the behavior; steps and goal steps when it began.
    Seek(usize, u32, u32),
    Over,
}

/// Drives the robot of `host` with a controller. `progress` is called with the number of moves and
/// steps. The base always stops at the end; the report covers what was driven before an error.
pub fn drive(
    host: Host,
    controller: LoggedController,
    plan: &BridgePlan,
    interrupted: &AtomicBool,
    progress: impl FnMut(u32),
) -> (BridgeReport, Result<(), BridgeError>) {
    let session = match BridgeSession::open(host, controller, &plan.config, plan.sonars_at_once) {
        Ok(session) => session,
        Err(trouble) => return (BridgeReport::default(), Err(trouble)),
    };
    let mut bridge = Bridge::new(session, plan);
    let result = bridge.run(interrupted, progress);
    bridge
        .session
        .finish(matches!(result, Err(BridgeError::Controller(_))));
    let driven = BridgeReport {
        distance_m: rounded(bridge.driven.distance_m),
        expired: bridge.session.expired(),
        ..bridge.driven
    };
    (driven, result)
}

struct Bridge<'p> {
    session: BridgeSession,
    plan: &'p BridgePlan,
    phase: BridgePhase,
    nest: Option<Situation<16>>,
    open: Option<BridgeStep>,
    driven: BridgeReport,
}

impl<'p> Bridge<'p> {
    fn new(session: BridgeSession, plan: &'p BridgePlan) -> Self {
        Self {
            session,
            plan,
            phase: BridgePhase::Explore,
            nest: None,
            open: None,
            driven: BridgeReport::default(),
        }
    }

    fn run(
        &mut self,
        interrupted: &AtomicBool,
        mut progress: impl FnMut(u32),
    ) -> Result<(), BridgeError> {
        self.session.command(controller::Command::Explore {
            moves: self.plan.explore_moves,
            seed: Seeds::of(self.plan.seed).exploration,
        });
        while self.phase != BridgePhase::Over {
            if interrupted.load(Ordering::Relaxed) {
                return Err(BridgeError::Interrupted);
            }
            self.update()?;
            progress(self.driven.explore_moves + self.driven.steps);
            std::thread::sleep(POLL_INTERVAL);
        }
        Ok(())
    }

    fn update(&mut self) -> Result<(), BridgeError> {
        let update = self.session.update()?;
        self.driven.distance_m += update.distance_m;
        self.driven.time_s = self.session.time_s();
        if let (true, Some(open)) = (update.touched, &mut self.open) {
            open.touched = true;
        }
        if let Some(result) = update.result {
            check_refusal(&result.outputs)?;
            self.apply(&result)?;
        }
        match self.phase {
            BridgePhase::Over => Ok(()),
            BridgePhase::Learn => self.session.deliver_events(Activity::Learning),
            BridgePhase::Explore | BridgePhase::Seek(..) => {
                self.session.deliver_events(Activity::Moving)
            }
        }
    }

    /// Counts steps and changes the phase.
    fn apply(&mut self, result: &WorkerResult) -> Result<(), BridgeError> {
        let outputs = &result.outputs;
        if let Some(reason) = outputs
            .stopped
            .filter(|_| result.kind != ResultKind::Command)
        {
            return Err(BridgeError::Controller(EpisodeError::Stopped(reason)));
        }
        if outputs.decision.is_some() || outputs.mode_changed {
            self.close();
        } else if outputs.motion.is_some()
            && let Some(open) = &mut self.open
        {
            open.shielded = true;
        }
        let mode_changed = outputs.mode_changed && result.kind != ResultKind::Command;
        match self.phase {
            BridgePhase::Explore if mode_changed => {
                self.phase = BridgePhase::Learn;
                self.session.learn();
            }
            BridgePhase::Learn if mode_changed => {
                self.session.discard_events();
                self.seek(0);
            }
            BridgePhase::Seek(part, ..) => {
                if self.driven.steps >= self.plan.steps {
                    self.phase = BridgePhase::Over;
                } else if self.plan.behavior.parts().len() > 1 && self.part_is_reached() {
                    self.seek(part + 1);
                }
            }
            _ => {}
        }
        self.open_step(outputs);
        Ok(())
    }

    fn part_is_reached(&self) -> bool {
        let BridgePhase::Seek(part, steps, goal_steps) = self.phase else {
            return false;
        };
        let Some(part) = self.plan.behavior.parts().get(part) else {
            return false;
        };
        let (steps, goal_steps) = (
            self.driven.steps - steps,
            self.driven.goal_steps - goal_steps,
        );
        is_reached(part, steps, goal_steps)
    }

    /// Pursues a part of the behavior; after the last one the drive is over.
    fn seek(&mut self, part: usize) {
        let Some(behavior) = self.plan.behavior.parts().get(part) else {
            self.phase = BridgePhase::Over;
            return;
        };
        self.phase = BridgePhase::Seek(part, self.driven.steps, self.driven.goal_steps);
        let nest = self.nest.unwrap_or([Weight::ZERO; 16]);
        let goal = behavior.goal(&self.plan.config, &nest);
        self.session.command(controller::Command::Seek(goal));
    }

    fn open_step(&mut self, outputs: &Outputs<16>) {
        let Some(decision) = &outputs.decision else {
            return;
        };
        if self.phase == BridgePhase::Over {
            return;
        }
        self.nest.get_or_insert(decision.situation);
        self.open = Some(BridgeStep {
            at_goal: decision.at_goal,
            shielded: decision.allowed != decision.wanted,
            touched: false,
        });
    }

    fn close(&mut self) {
        let Some(step) = self.open.take() else {
            return;
        };
        let driven = &mut self.driven;
        if self.phase == BridgePhase::Explore {
            driven.explore_moves += 1;
            driven.explore_contacts += u32::from(step.touched);
            return;
        }
        driven.steps += 1;
        driven.contacts += u32::from(step.touched);
        driven.goal_steps += u32::from(step.at_goal);
        driven.shield_stops += u32::from(step.shielded);
    }
}

/// The readings that the bridge requests.
fn mask(sonar: u16) -> StateMask {
    StateMask {
        sonar,
        bumper: true,
        pose: [true; 4],
        velocity: [true; 3],
        attached: WITH_SONAR,
        ..StateMask::NONE
    }
}

/// How a motion ended, if it has.
type Ended = Option<Progress>;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NomadReadings;

    /// docs/nomad.md: 622 bytes over TCP; 178 over a serial line, 46 ms at 38 400 baud.
    #[test]
    fn answers_are_as_long_as_the_docs_say() {
        let bytes = |sonars: u16| {
            let payload = NomadReadings::default().to_payload(&mask(sonars));
            payload.len() + "01 LEN LEN TYPE CK 5C".split(' ').count()
        };
        assert_eq!((bytes(u16::MAX), bytes(0xf)), (622, 178));
        assert_eq!(178 * 10 * 1_000 / 38_400, 46);
    }
}
