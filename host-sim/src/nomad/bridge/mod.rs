//! A mind drives a Nomad: its sonars and its odometry become the mind's events, the mind's motions its commands.
//!
//! Two threads. One asks the robot for its state, again and again, and drives its motors (`course`); it is never kept
//! waiting. The other has the mind (`thinking`), which may be in this process or at the end of a slow line. What has
//! happened meanwhile goes to the mind in the order in which it happened (`feed`): each echo with the pose the robot had
//! when it was heard, by the clock of the robot's own sensor board.
//!
//! The turret is never told to turn, and so keeps its bearing in the world.
//!
//! What stops the base: a bumper; a mind that has not confirmed for [`MOTION_TTL_MS`] what was reported to it while the
//! base moves (the motion is cut off and counts as ended); a mind that fails; an interruption. If this program itself is
//! gone, the base's own time-out of one second does (`conf_tm`), and no motion is longer than a step of the mind.

mod course;
mod driven;
mod feed;
mod thinking;

pub use driven::{Driven, Plan, Trouble};

use super::{Command, Host, Mask, RobotError, State, WITH_SONAR};
use crate::episode::{Failure, Seeds, rounded};
use crate::pilot::Pilot;
use crate::scenes::is_reached;
use crate::sonar::{FIRING_ORDER, FIRING_SLOT_S};
use amp::controller::{self, Decision, Outputs, Progress};
use amp::fixed::Weight;
use amp::node::MOTION_TTL_MS;
use amp::scan::Situation;
use course::Course;
use feed::Feed;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use thinking::{Mind, Task};

/// The base's own time-out, s: the shortest there is.
const TIMEOUT_S: u8 = 1;

/// Time between two questions to the robot: a fraction of a firing slot, also at twenty times real time.
const PAUSE: Duration = Duration::from_millis(2);

/// Longest time without a decision before the mind counts as silent, rings.
const PATIENCE_RINGS: u32 = 100;

/// How often a question is repeated that may well be answered twice.
const ATTEMPTS: u32 = 3;

/// Accelerations: those of the drivers.
const ACCELERATIONS: [u16; 3] = [300; 3];

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
    /// Part of the behaviour, and steps and goal steps when it began.
    Seek(usize, u32, u32),
    Over,
}

/// Lets the mind of `pilot` drive the robot of `host`. `progress` hears how many moves and steps are done. Whatever
/// happens, the base is told to stop in the end; what was driven is returned beside the trouble.
pub fn drive(
    host: Host,
    pilot: &mut (impl Pilot + Send),
    plan: &Plan,
    interrupted: &AtomicBool,
    progress: impl FnMut(u32),
) -> (Driven, Result<(), Trouble>) {
    std::thread::scope(|scope| {
        let mind = Mind::start(scope, pilot);
        let mut bridge = Bridge::new(host, mind, plan);
        let mut result = bridge.prepare();
        if result.is_ok() {
            result = bridge.run(interrupted, progress);
        }
        bridge.finish(&result);
        let distance_m = rounded(bridge.driven.distance_m);
        let driven = Driven {
            distance_m,
            ..bridge.driven
        };
        (driven, result)
    })
}

struct Bridge<'p> {
    host: Host,
    mind: Mind,
    plan: &'p Plan,
    feed: Feed,
    course: Course,
    phase: Phase,
    nest: Option<Situation<16>>,
    open: Option<Stride>,
    pressed: bool,
    began_ms: u32,
    decided_ms: u32,
    driven: Driven,
}

impl<'p> Bridge<'p> {
    fn new(host: Host, mind: Mind, plan: &'p Plan) -> Self {
        Self {
            host,
            mind,
            plan,
            feed: Feed::default(),
            course: Course::default(),
            phase: Phase::Explore,
            nest: None,
            open: None,
            pressed: false,
            began_ms: 0,
            decided_ms: 0,
            driven: Driven::default(),
        }
    }

    /// Brings the robot to a known state and tells the mind to begin.
    fn prepare(&mut self) -> Result<(), Trouble> {
        let rate = (FIRING_SLOT_S * 1e3 / 4.0) as u8;
        let order = FIRING_ORDER.map(|sensor| sensor as u8);
        self.host.ask(&Command::Communicate(mask(u16::MAX)))?;
        for command in [
            Command::Stop,
            Command::ConfigureTimeout(TIMEOUT_S),
            Command::Accelerations(ACCELERATIONS),
            Command::ConfigureSonar { rate, order },
        ] {
            self.host.ask(&command)?;
        }
        let state = self.poll()?;
        self.feed.begin(&state);
        (self.began_ms, self.decided_ms) = (state.time_ms, state.time_ms);
        self.command(controller::Command::Explore {
            moves: self.plan.explore_moves,
            seed: Seeds::of(self.plan.seed).exploration,
        });
        Ok(())
    }

    fn run(
        &mut self,
        interrupted: &AtomicBool,
        mut progress: impl FnMut(u32),
    ) -> Result<(), Trouble> {
        let mut before = self.host.state().clone();
        while self.phase != Phase::Over {
            if interrupted.load(Ordering::Relaxed) {
                return Err(Trouble::Interrupted);
            }
            let state = self.poll()?;
            self.count_way(&before, &state);
            self.feel(&state)?;
            let ended = self.course.follow(&mut self.host, &state)?;
            self.feed.take(&state, self.course.id(), ended);
            self.think(&state)?;
            progress(self.driven.explore_moves + self.driven.steps);
            before = state;
            std::thread::sleep(PAUSE);
        }
        Ok(())
    }

    /// The robot's state, asked for again if the answer was lost.
    fn poll(&mut self) -> Result<State, Trouble> {
        let mut result = Err(RobotError::Silent {
            waited: Duration::ZERO,
        });
        let all = self.plan.sonars_at_once >= 16;
        for _ in 0..ATTEMPTS {
            // A `ct` is answered under its own mask: one question for a choice of sonars.
            let question = if all && *self.host.mask() == mask(u16::MAX) {
                Command::GetState
            } else {
                let sonars = self.feed.longest_unheard(self.plan.sonars_at_once);
                Command::Communicate(mask(sonars))
            };
            result = self.host.ask(&question).cloned();
            if !matches!(result, Err(RobotError::Silent { .. })) {
                break;
            }
        }
        Ok(result?)
    }

    fn count_way(&mut self, before: &State, state: &State) {
        let way = feed::position(&state.pose).distance(feed::position(&before.pose));
        self.driven.distance_m += way;
        self.driven.time_s = f64::from(state.time_ms.wrapping_sub(self.began_ms)) / 1e3;
    }

    /// A bumper ends the motion.
    fn feel(&mut self, state: &State) -> Result<(), Trouble> {
        let pressed = state.bumpers != 0;
        if pressed && !self.pressed {
            if let Some(open) = &mut self.open {
                open.touched = true;
            }
            self.course.touched(&mut self.host)?;
        }
        self.pressed = pressed;
        Ok(())
    }

    /// Exchanges what happened for what the mind makes of it.
    fn think(&mut self, state: &State) -> Result<(), Trouble> {
        if let Some(thought) = self.mind.thought() {
            let thought = thought.map_err(Trouble::Mind)?;
            if let Some((goal, motion)) = thought.motion {
                self.course.begin(&mut self.host, state, goal, &motion)?;
            }
            self.conclude(&thought.outputs, state);
        }
        if self.mind.is_idle() && self.phase != Phase::Over {
            let happenings = self.feed.hand_over();
            if !happenings.is_empty() {
                self.mind.give(Task::Happenings(happenings));
            }
        } else if self.phase != Phase::Learn && self.mind.busy_for() > TTL {
            self.driven.expired += u32::from(self.course.expire(&mut self.host)?);
        }
        let silent_ms = state.time_ms.wrapping_sub(self.decided_ms);
        let patience_ms = u32::from(self.plan.config.robot.ring_period_ms) * PATIENCE_RINGS;
        if self.phase != Phase::Learn && silent_ms > patience_ms && self.mind.is_idle() {
            return Err(Trouble::Mind(Failure::Silent));
        }
        Ok(())
    }

    /// Counts, and goes on to the next phase when one is done.
    fn conclude(&mut self, outputs: &Outputs<16>, state: &State) {
        if outputs.decision.is_some() || outputs.mode_changed {
            self.close();
            self.decided_ms = state.time_ms;
        } else if outputs.motion.is_some()
            && let Some(open) = &mut self.open
        {
            open.shielded = true;
        }
        match self.phase {
            Phase::Explore if outputs.mode_changed && self.mind.has_begun() => {
                self.phase = Phase::Learn;
                self.mind.give(Task::Learn(self.feed.now()));
            }
            Phase::Learn if outputs.mode_changed => {
                // What was heard meanwhile is old, and the base stood.
                drop(self.feed.hand_over());
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
        if self.phase != Phase::Over
            && let Some(decision) = &outputs.decision
        {
            self.open_step(decision);
        }
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

    /// Begins to pursue a part of the behaviour; after the last one it is over.
    fn seek(&mut self, part: usize) {
        let Some(behavior) = self.plan.behavior.parts().get(part) else {
            self.phase = Phase::Over;
            return;
        };
        self.phase = Phase::Seek(part, self.driven.steps, self.driven.goal_steps);
        let nest = self.nest.unwrap_or([Weight::ZERO; 16]);
        let goal = behavior.goal(&self.plan.config, &nest);
        self.command(controller::Command::Seek(goal));
    }

    fn command(&mut self, command: controller::Command<16>) {
        self.mind.give(Task::Command(self.feed.now(), command));
    }

    fn open_step(&mut self, decision: &Decision<16>) {
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

    /// The base stands and the mind too, whatever has happened.
    fn finish(&mut self, result: &Result<(), Trouble>) {
        // Where the line is gone the base's own time-out does it.
        let _ = self.host.ask(&Command::Stop);
        if !matches!(result, Err(Trouble::Mind(_))) {
            self.mind.finish(self.feed.now());
        }
    }
}

const TTL: Duration = Duration::from_millis(MOTION_TTL_MS as u64);

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
