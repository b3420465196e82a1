//! A robot and the mind that drives it: everything but what it is to do.

use super::course::Course;
use super::feed::{self, Feed};
use super::thinking::{Mind, Task, Thought};
use super::{Trouble, mask};
use crate::{Command, Host, RobotError, State};
use amp::config::Config;
use amp::controller::{self, Outputs, Progress};
use amp::node::MOTION_TTL_MS;
use arena::sonar::{FIRING_ORDER, FIRING_SLOT_S};
use arena::world::{Point, Pose};
use remote::log::{LogOutput, LogWriter, LoggedController, SharedLog};
use sim::error::EpisodeError;
use std::time::Duration;

/// The base's own time-out, s: the shortest there is.
const TIMEOUT_S: u8 = 1;

/// Longest time without a decision before the mind counts as silent, rings.
const PATIENCE_RINGS: u32 = 100;

/// How often a question is repeated that may well be answered twice.
const ATTEMPTS: u32 = 3;

/// Accelerations: those of the drivers.
const ACCELERATIONS: [u16; 3] = [300; 3];

const TTL: Duration = Duration::from_millis(MOTION_TTL_MS as u64);

/// The base is in the log where it was when it has moved so far since, m.
const LOGGED_EVERY_M: f64 = 0.01;

/// What the mind is at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum At {
    /// The robot stands and waits.
    Rest,
    /// It moves.
    Work,
    /// The maps are made.
    School,
}

/// What has happened since the last look.
#[derive(Default)]
pub struct Turn {
    /// A bumper was pressed.
    pub touched: bool,
    /// Way rolled, m.
    pub way_m: f64,
    /// What the mind made of what it was given.
    pub thought: Option<Thought>,
}

/// A robot and its mind.
pub struct Reins {
    host: Host,
    mind: Mind,
    feed: Feed,
    course: Course,
    state: State,
    sonars_at_once: u32,
    silence_ms: u32,
    pressed: bool,
    began_ms: u32,
    decided_ms: u32,
    expired: u32,
    log: Option<SharedLog<LogOutput>>,
    /// Where the base was by the log.
    logged: Option<Point>,
}

impl Reins {
    /// Brings the robot to a known state: it stands. So many sonars are asked for at once.
    ///
    /// # Errors
    /// When the robot does not answer.
    pub fn take(
        mut host: Host,
        mind: LoggedController,
        config: &Config<16>,
        sonars_at_once: u32,
    ) -> Result<Self, Trouble> {
        let rate = (FIRING_SLOT_S * 1e3 / 4.0) as u8;
        let order = FIRING_ORDER.map(|sensor| sensor as u8);
        host.ask(&Command::Communicate(mask(u16::MAX)))?;
        for command in [
            Command::Stop,
            Command::ConfigureTimeout(TIMEOUT_S),
            Command::Accelerations(ACCELERATIONS),
            Command::ConfigureSonar { rate, order },
        ] {
            host.ask(&command)?;
        }
        let log = mind.log().cloned();
        let mut reins = Self {
            host,
            mind: Mind::start(mind),
            feed: Feed::default(),
            course: Course::default(),
            state: State::default(),
            sonars_at_once,
            silence_ms: u32::from(config.robot.ring_period_ms) * PATIENCE_RINGS,
            pressed: false,
            began_ms: 0,
            decided_ms: 0,
            expired: 0,
            log,
            logged: None,
        };
        reins.state = reins.poll()?;
        reins.feed.begin(&reins.state);
        (reins.began_ms, reins.decided_ms) = (reins.state.time_ms, reins.state.time_ms);
        Ok(reins)
    }

    /// Looks at the robot and at what the mind has thought of meanwhile.
    ///
    /// # Errors
    /// A robot or a mind that is lost; the base may still roll.
    pub fn look(&mut self) -> Result<Turn, Trouble> {
        let before = std::mem::take(&mut self.state);
        self.state = self.poll()?;
        let way_m = feed::position(&self.state.pose).distance(feed::position(&before.pose));
        let touched = self.feel()?;
        // As it was until now: what is begun in this moment has not been seen yet.
        let is_steering = self.course.is_steering(&self.state);
        let ended = self.course.follow(&mut self.host, &self.state)?;
        let steering = is_steering.then_some(Progress::Steering);
        self.feed
            .take(&self.state, self.course.id(), ended.or(steering));
        let thought = self.mind.thought();
        let thought = thought.transpose().map_err(Trouble::Mind)?;
        if let Some(thought) = &thought {
            self.obey(thought)?;
        }
        self.write(touched, thought.as_ref());
        Ok(Turn {
            touched,
            way_m,
            thought,
        })
    }

    fn obey(&mut self, thought: &Thought) -> Result<(), Trouble> {
        if let Some((goal, motion)) = thought.motion {
            self.course
                .begin(&mut self.host, &self.state, goal, &motion)?;
        }
        if thought.outputs.decision.is_some() || thought.outputs.mode_changed {
            self.decided_ms = self.state.time_ms;
        }
        Ok(())
    }

    /// Hands what has happened to the mind, unless it still thinks; whoever moves is not kept waiting for long.
    ///
    /// # Errors
    /// A mind that has decided nothing for long.
    pub fn pass_on(&mut self, at: At) -> Result<(), Trouble> {
        let is_idle = self.mind.is_idle();
        if is_idle {
            let happenings = self.feed.hand_over();
            if !happenings.is_empty() {
                self.mind.give(Task::Happenings(happenings));
            }
        } else if at != At::School && self.mind.busy_for() > TTL {
            self.expired += u32::from(self.course.expire(&mut self.host)?);
        }
        let silent_ms = self.state.time_ms.wrapping_sub(self.decided_ms);
        if at == At::Work && silent_ms > self.silence_ms && is_idle {
            return Err(Trouble::Mind(EpisodeError::Silent));
        }
        Ok(())
    }

    /// Gives the mind a command; what comes of it is a thought of that kind.
    pub fn command(&mut self, command: controller::Command<16>) {
        self.decided_ms = self.state.time_ms;
        let now = self.feed.now_for_command();
        self.mind.give(Task::Command(now, command));
    }

    /// Has the maps made.
    pub fn learn(&mut self) {
        let now = self.feed.now_for_command();
        self.mind.give(Task::Learn(now));
    }

    /// Gives the mind other open choices.
    pub fn configure(&mut self, config: Config<16>) {
        let config = Box::new(config);
        let now = self.feed.now_for_command();
        self.mind.give(Task::Configure(now, config));
    }

    /// Asks what the mind knows.
    pub fn ask_knowledge(&mut self) {
        self.mind.give(Task::Tell);
    }

    /// What was heard lies behind: the base stood, and it is old.
    pub fn forget_heard(&mut self) {
        drop(self.feed.hand_over());
        self.decided_ms = self.state.time_ms;
    }

    /// Brakes now, whatever the mind thinks.
    ///
    /// # Errors
    /// When the robot does not answer.
    pub fn brake(&mut self) -> Result<(), Trouble> {
        Ok(self.course.expire(&mut self.host).map(drop)?)
    }

    /// The base stands and the mind too, whatever has happened; a mind that is lost is not told.
    pub fn finish(&mut self, mind_is_lost: bool) {
        // Where the line is gone the base's own time-out does it.
        let _ = self.host.ask(&Command::Stop);
        self.mind.finish((!mind_is_lost).then_some(self.feed.now()));
    }

    /// Where the robot is in its own frame, and where its ring looks.
    pub fn pose(&self) -> Pose {
        feed::pose(&self.state)
    }

    /// Latest ranges, m.
    pub fn ranges_m(&self) -> [Option<f64>; 16] {
        std::array::from_fn(|sensor| feed::range_m(self.state.sonar[sensor]))
    }

    /// Where the robot was when a sonar was heard last, and when by its own clock, ms.
    pub fn heard_at(&self, sensor: usize) -> (Pose, u32) {
        let place = &self.state.sonar_at[sensor];
        (feed::pose_of(place), place.sensed_ms)
    }

    /// Robot's time since it was taken, s.
    pub fn time_s(&self) -> f64 {
        f64::from(self.state.time_ms.wrapping_sub(self.began_ms)) / 1e3
    }

    /// Motions cut off because the mind had not confirmed in time.
    pub fn expired(&self) -> u32 {
        self.expired
    }

    /// The robot's state, asked for again if the answer was lost.
    fn poll(&mut self) -> Result<State, Trouble> {
        let mut result = Err(RobotError::Silent {
            waited: Duration::ZERO,
        });
        let all = self.sonars_at_once >= 16;
        for _ in 0..ATTEMPTS {
            // A `ct` is answered under its own mask: one question for a choice of sonars.
            let question = if all && *self.host.mask() == mask(u16::MAX) {
                Command::GetState
            } else {
                let sonars = self.feed.longest_unheard(self.sonars_at_once);
                Command::Communicate(mask(sonars))
            };
            result = self.host.ask(&question).cloned();
            if !matches!(result, Err(RobotError::Silent { .. })) {
                break;
            }
            // The robot's clock does not advance while it is silent, so the recorded events are written now.
            if let Some(log) = &self.log {
                log.write(LogWriter::flush);
            }
        }
        Ok(result?)
    }

    /// A bumper ends the motion. Returns whether one has just been pressed.
    fn feel(&mut self) -> Result<bool, Trouble> {
        let pressed = self.state.bumpers != 0;
        let touched = pressed && !self.pressed;
        if touched {
            self.course.touched(&mut self.host)?;
        }
        self.pressed = pressed;
        Ok(touched)
    }

    /// Writes down where the robot is, and what its ring heard when it decided.
    fn write(&mut self, touched: bool, thought: Option<&Thought>) {
        let Some(log) = &self.log else { return };
        let (now, pose) = (self.feed.now(), feed::pose(&self.state));
        let decided = thought.is_some_and(|thought| thought.outputs.decision.is_some());
        let stood = self
            .logged
            .is_some_and(|logged| logged.distance(pose.position) < LOGGED_EVERY_M);
        let ranges_m = self.ranges_m();
        log.write(|log| {
            if !stood || decided || touched {
                log.pose(now, pose, None);
            }
            if decided {
                log.sonar(now, &ranges_m);
            }
            if touched {
                log.contact(now, pose.position);
            }
            log.pass_time(now);
        });
        if !stood || decided || touched {
            self.logged = Some(pose.position);
        }
    }
}

/// A command was refused, if it was.
pub(super) fn refused(outputs: &Outputs<16>) -> Result<(), Trouble> {
    let refused = outputs.refusal.map(EpisodeError::Refused);
    refused.map_or(Ok(()), |failure| Err(Trouble::Mind(failure)))
}
