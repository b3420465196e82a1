//! A mind drives a Nomad: its sonars and its odometry become the mind's events, the mind's motions its commands.
//!
//! Two threads. One asks the robot for its state, again and again, and drives its motors (`course`); it is never kept
//! waiting. The other has the mind (`thinking`), which may be in this process or at the end of a slow line. What has
//! happened meanwhile goes to the mind in the order in which it happened (`feed`): each echo with the pose the robot had
//! when it was heard, by the clock of the robot's own sensor board.
//!
//! The turret is never told to turn, and so keeps its bearing in the world.
//!
//! What stops the base: a bumper; a mind that has not confirmed for [`MOTION_TTL_MS`](amp::node::MOTION_TTL_MS) what was reported to it while the
//! base moves (the motion is cut off and counts as ended); a mind that fails; an interruption. If this program itself is
//! gone, the base's own time-out of one second does (`conf_tm`), and no motion is longer than a step of the mind.

mod course;
mod driven;
mod feed;
mod reins;
mod thinking;

pub use driven::{Driven, Plan, Trouble};
pub use reins::{At, Reins};
pub use thinking::{About, Thought};

use super::{Host, Mask, WITH_SONAR};
use amp::controller::{self, Outputs, Progress};
use amp::fixed::Weight;
use amp::scan::Situation;
use reins::refused;
use remote::log::LoggedController;
use sim::behavior::is_reached;
use sim::episode::{Seeds, rounded};
use sim::error::EpisodeError;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Time between two questions to the robot: a fraction of a firing slot, also at twenty times real time.
pub const PAUSE: Duration = Duration::from_millis(2);

/// The step under way.
#[derive(Debug, Clone, Copy, Default)]
struct Stride {
    at_goal: bool,
    shielded: bool,
    touched: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Explore,
    Learn,
    /// Part of the behavior, and steps and goal steps when it began.
    Seek(usize, u32, u32),
    Over,
}

/// Lets a mind drive the robot of `host`. `progress` hears how many moves and steps are done. Whatever happens, the base
/// is told to stop in the end; what was driven is returned beside the trouble.
pub fn drive(
    host: Host,
    mind: LoggedController,
    plan: &Plan,
    interrupted: &AtomicBool,
    progress: impl FnMut(u32),
) -> (Driven, Result<(), Trouble>) {
    let reins = match Reins::take(host, mind, &plan.config, plan.sonars_at_once) {
        Ok(reins) => reins,
        Err(trouble) => return (Driven::default(), Err(trouble)),
    };
    let mut bridge = Bridge::new(reins, plan);
    let result = bridge.run(interrupted, progress);
    bridge.reins.finish(matches!(result, Err(Trouble::Mind(_))));
    let driven = Driven {
        distance_m: rounded(bridge.driven.distance_m),
        expired: bridge.reins.expired(),
        ..bridge.driven
    };
    (driven, result)
}

struct Bridge<'p> {
    reins: Reins,
    plan: &'p Plan,
    phase: Phase,
    nest: Option<Situation<16>>,
    open: Option<Stride>,
    driven: Driven,
}

impl<'p> Bridge<'p> {
    fn new(reins: Reins, plan: &'p Plan) -> Self {
        Self {
            reins,
            plan,
            phase: Phase::Explore,
            nest: None,
            open: None,
            driven: Driven::default(),
        }
    }

    fn run(
        &mut self,
        interrupted: &AtomicBool,
        mut progress: impl FnMut(u32),
    ) -> Result<(), Trouble> {
        self.reins.command(controller::Command::Explore {
            moves: self.plan.explore_moves,
            seed: Seeds::of(self.plan.seed).exploration,
        });
        while self.phase != Phase::Over {
            if interrupted.load(Ordering::Relaxed) {
                return Err(Trouble::Interrupted);
            }
            self.turn()?;
            progress(self.driven.explore_moves + self.driven.steps);
            std::thread::sleep(PAUSE);
        }
        Ok(())
    }

    fn turn(&mut self) -> Result<(), Trouble> {
        let turn = self.reins.look()?;
        self.driven.distance_m += turn.way_m;
        self.driven.time_s = self.reins.time_s();
        if let (true, Some(open)) = (turn.touched, &mut self.open) {
            open.touched = true;
        }
        if let Some(thought) = turn.thought {
            refused(&thought.outputs)?;
            self.conclude(&thought)?;
        }
        match self.phase {
            Phase::Over => Ok(()),
            Phase::Learn => self.reins.pass_on(At::School),
            Phase::Explore | Phase::Seek(..) => self.reins.pass_on(At::Work),
        }
    }

    /// Counts, and goes on to the next phase when one is done.
    fn conclude(&mut self, thought: &Thought) -> Result<(), Trouble> {
        let outputs = &thought.outputs;
        if let Some(reason) = outputs.stopped.filter(|_| thought.about != About::Command) {
            return Err(Trouble::Mind(EpisodeError::Stopped(reason)));
        }
        if outputs.decision.is_some() || outputs.mode_changed {
            self.close();
        } else if outputs.motion.is_some()
            && let Some(open) = &mut self.open
        {
            open.shielded = true;
        }
        let came_about = outputs.mode_changed && thought.about != About::Command;
        match self.phase {
            Phase::Explore if came_about => {
                self.phase = Phase::Learn;
                self.reins.learn();
            }
            Phase::Learn if came_about => {
                self.reins.forget_heard();
                self.seek(0);
            }
            Phase::Seek(part, ..) => {
                if self.driven.steps >= self.plan.steps {
                    self.phase = Phase::Over;
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
        let Phase::Seek(part, steps, goal_steps) = self.phase else {
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

    /// Begins to pursue a part of the behavior; after the last one it is over.
    fn seek(&mut self, part: usize) {
        let Some(behavior) = self.plan.behavior.parts().get(part) else {
            self.phase = Phase::Over;
            return;
        };
        self.phase = Phase::Seek(part, self.driven.steps, self.driven.goal_steps);
        let nest = self.nest.unwrap_or([Weight::ZERO; 16]);
        let goal = behavior.goal(&self.plan.config, &nest);
        self.reins.command(controller::Command::Seek(goal));
    }

    fn open_step(&mut self, outputs: &Outputs<16>) {
        let Some(decision) = &outputs.decision else {
            return;
        };
        if self.phase == Phase::Over {
            return;
        }
        self.nest.get_or_insert(decision.situation);
        self.open = Some(Stride {
            at_goal: decision.at_goal,
            shielded: decision.allowed != decision.wanted,
            touched: false,
        });
    }

    fn close(&mut self) {
        let Some(stride) = self.open.take() else {
            return;
        };
        let driven = &mut self.driven;
        if self.phase == Phase::Explore {
            driven.explore_moves += 1;
            driven.explore_contacts += u32::from(stride.touched);
            return;
        }
        driven.steps += 1;
        driven.contacts += u32::from(stride.touched);
        driven.goal_steps += u32::from(stride.at_goal);
        driven.shield_stops += u32::from(stride.shielded);
    }
}

/// What the bridge wants of a state packet.
fn mask(sonar: u16) -> Mask {
    Mask {
        sonar,
        bumper: true,
        pose: [true; 4],
        velocity: [true; 3],
        attached: WITH_SONAR,
        ..Mask::NONE
    }
}

/// How a motion ended, if it did.
type Ended = Option<Progress>;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::State;

    /// docs/nomad.md: 622 bytes over TCP; 178 over a serial line, 46 ms at 38 400 baud.
    #[test]
    fn answers_are_as_long_as_the_docs_say() {
        let bytes = |sonars: u16| {
            let payload = State::default().to_payload(&mask(sonars));
            payload.len() + "01 LEN LEN TYPE CK 5C".split(' ').count()
        };
        assert_eq!((bytes(u16::MAX), bytes(0xf)), (622, 178));
        assert_eq!(178 * 10 * 1_000 / 38_400, 46);
    }
}
