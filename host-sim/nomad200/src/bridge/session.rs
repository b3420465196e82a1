//! Connects a robot with its controller; the caller decides what they do.

use super::events::{self, EventQueue};
use super::motion_control::MotionControl;
use super::worker::{Worker, WorkerResult, WorkerTask};
use super::{BridgeError, mask};
use crate::{Host, NomadCommand, NomadReadings, RobotError};
use amp::config::Config;
use amp::controller::{self, Outputs, Progress};
use amp::node::MOTION_TTL_MS;
use arena::sonar::{FIRING_ORDER, FIRING_SLOT_S};
use arena::world::{Point, Pose};
use remote::log::{LogOutput, LogWriter, LoggedController, SharedLog};
use sim::error::EpisodeError;
use std::time::Duration;

/// The base's own time-out, s: the shortest possible.
const TIMEOUT_S: u8 = 1;

/// Rings without a decision after which the controller counts as silent.
const MAX_SILENT_RINGS: u32 = 100;

/// Attempts of a request that may be answered twice.
const ATTEMPTS: u32 = 3;

/// Accelerations of the known drivers.
const ACCELERATIONS: [u16; 3] = [300; 3];

const TTL: Duration = Duration::from_millis(MOTION_TTL_MS as u64);

/// Distance between two poses in the log, m.
const LOG_DISTANCE_M: f64 = 0.01;

/// Activity of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Activity {
    /// The robot stands.
    Rest,
    /// The robot explores or pursues a goal.
    Moving,
    /// The controller learns.
    Learning,
}

/// Changes since the last update.
#[derive(Default)]
pub struct SessionUpdate {
    /// A bumper was pressed.
    pub touched: bool,
    /// Distance rolled, m.
    pub distance_m: f64,
    /// Result of the worker.
    pub result: Option<WorkerResult>,
}

/// A robot and its controller.
pub struct BridgeSession {
    host: Host,
    worker: Worker,
    events: EventQueue,
    motion: MotionControl,
    state: NomadReadings,
    sonars_at_once: u32,
    silence_ms: u32,
    pressed: bool,
    began_ms: u32,
    decided_ms: u32,
    expired: u32,
    log: Option<SharedLog<LogOutput>>,
    /// Position of the latest pose in the log.
    logged_position: Option<Point>,
}

impl BridgeSession {
    /// Initializes the robot: it stands. `sonars_at_once` sonars are requested per poll.
    ///
    /// # Errors
    /// When the robot does not answer.
    pub fn open(
        mut host: Host,
        controller: LoggedController,
        config: &Config<16>,
        sonars_at_once: u32,
    ) -> Result<Self, BridgeError> {
        let rate = (FIRING_SLOT_S * 1e3 / 4.0) as u8;
        let order = FIRING_ORDER.map(|sensor| sensor as u8);
        host.request(&NomadCommand::Communicate(mask(u16::MAX)))?;
        for command in [
            NomadCommand::Stop,
            NomadCommand::ConfigureTimeout(TIMEOUT_S),
            NomadCommand::Accelerations(ACCELERATIONS),
            NomadCommand::ConfigureSonar { rate, order },
        ] {
            host.request(&command)?;
        }
        let log = controller.log().cloned();
        let mut session = Self {
            host,
            worker: Worker::start(controller),
            events: EventQueue::default(),
            motion: MotionControl::default(),
            state: NomadReadings::default(),
            sonars_at_once,
            silence_ms: u32::from(config.robot.ring_period_ms) * MAX_SILENT_RINGS,
            pressed: false,
            began_ms: 0,
            decided_ms: 0,
            expired: 0,
            log,
            logged_position: None,
        };
        session.state = session.poll()?;
        session.events.begin(&session.state);
        (session.began_ms, session.decided_ms) = (session.state.time_ms, session.state.time_ms);
        Ok(session)
    }

    /// Polls the robot and the worker.
    ///
    /// # Errors
    /// When robot or controller is lost; the base may still roll.
    pub fn update(&mut self) -> Result<SessionUpdate, BridgeError> {
        let before = std::mem::take(&mut self.state);
        self.state = self.poll()?;
        let distance_m =
            events::position(&self.state.pose).distance(events::position(&before.pose));
        let touched = self.check_bumpers()?;
        // Before the motion changes, because this packet cannot show the change.
        let is_steering = self.motion.is_steering(&self.state);
        let ended = self.motion.follow(&mut self.host, &self.state)?;
        let steering = is_steering.then_some(Progress::Steering);
        self.events
            .add_state(&self.state, self.motion.id(), ended.or(steering));
        let result = self.worker.poll();
        let result = result.transpose().map_err(BridgeError::Controller)?;
        if let Some(result) = &result {
            self.begin_motion(result)?;
        }
        self.write_log(touched, result.as_ref());
        Ok(SessionUpdate {
            touched,
            distance_m,
            result,
        })
    }

    fn begin_motion(&mut self, result: &WorkerResult) -> Result<(), BridgeError> {
        if let Some((goal, motion)) = result.motion {
            self.motion
                .begin(&mut self.host, &self.state, goal, &motion)?;
        }
        if result.outputs.decision.is_some() || result.outputs.mode_changed {
            self.decided_ms = self.state.time_ms;
        }
        Ok(())
    }

    /// Delivers events to the controller unless it is busy. Cuts off a motion if it is busy for too
    /// long.
    ///
    /// # Errors
    /// When the controller has taken no decision for long.
    pub fn deliver_events(&mut self, activity: Activity) -> Result<(), BridgeError> {
        let is_idle = self.worker.is_idle();
        if is_idle {
            let new_events = self.events.take_events();
            if !new_events.is_empty() {
                self.worker.submit(WorkerTask::Events(new_events));
            }
        } else if activity != Activity::Learning && self.worker.busy_for() > TTL {
            self.expired += u32::from(self.motion.expire(&mut self.host)?);
        }
        let silent_ms = self.state.time_ms.wrapping_sub(self.decided_ms);
        if activity == Activity::Moving && silent_ms > self.silence_ms && is_idle {
            return Err(BridgeError::Controller(EpisodeError::Silent));
        }
        Ok(())
    }

    /// Sends a command to the controller; its result is of that kind.
    pub fn command(&mut self, command: controller::Command<16>) {
        self.decided_ms = self.state.time_ms;
        let now = self.events.now_for_command();
        self.worker.submit(WorkerTask::Command(now, command));
    }

    /// Lets the controller learn.
    pub fn learn(&mut self) {
        let now = self.events.now_for_command();
        self.worker.submit(WorkerTask::Learn(now));
    }

    /// Replaces the configuration.
    pub fn configure(&mut self, config: Config<16>) {
        let config = Box::new(config);
        let now = self.events.now_for_command();
        self.worker.submit(WorkerTask::Configure(now, config));
    }

    /// Requests the controller's state.
    pub fn request_state(&mut self) {
        self.worker.submit(WorkerTask::ReadState);
    }

    /// Discards events: the base stood, and they are old.
    pub fn discard_events(&mut self) {
        drop(self.events.take_events());
        self.decided_ms = self.state.time_ms;
    }

    /// Brakes now.
    ///
    /// # Errors
    /// When the robot does not answer.
    pub fn brake(&mut self) -> Result<(), BridgeError> {
        Ok(self.motion.expire(&mut self.host).map(drop)?)
    }

    /// Stops the base, and the controller unless it is lost.
    pub fn finish(&mut self, is_lost: bool) {
        // If the line is broken, the base's own time-out stops it.
        let _ = self.host.request(&NomadCommand::Stop);
        self.worker.finish((!is_lost).then_some(self.events.now()));
    }

    /// Position in the robot's own frame and heading of its ring.
    pub fn pose(&self) -> Pose {
        events::pose(&self.state)
    }

    /// Latest ranges, m.
    pub fn ranges_m(&self) -> [Option<f64>; 16] {
        std::array::from_fn(|sensor| events::range_m(self.state.sonar[sensor]))
    }

    /// Pose and robot's time of a sonar's latest echo, ms.
    pub fn echo_origin(&self, sensor: usize) -> (Pose, u32) {
        let place = &self.state.sonar_at[sensor];
        (events::pose_of(place), place.sensed_ms)
    }

    /// Robot's time since the session began, s.
    pub fn time_s(&self) -> f64 {
        f64::from(self.state.time_ms.wrapping_sub(self.began_ms)) / 1e3
    }

    /// Motions that were cut off because the controller did not confirm a report in time.
    pub fn expired(&self) -> u32 {
        self.expired
    }

    /// Polls the robot's state; repeats the request if the answer is lost.
    fn poll(&mut self) -> Result<NomadReadings, BridgeError> {
        let mut result = Err(RobotError::Silent {
            waited: Duration::ZERO,
        });
        let all = self.sonars_at_once >= 16;
        for _ in 0..ATTEMPTS {
            // A `ct` is answered under its own mask, so one request selects and reads sonars.
            let request = if all && *self.host.mask() == mask(u16::MAX) {
                NomadCommand::GetState
            } else {
                let sonars = self.events.oldest_sonars(self.sonars_at_once);
                NomadCommand::Communicate(mask(sonars))
            };
            result = self.host.request(&request).cloned();
            if !matches!(result, Err(RobotError::Silent { .. })) {
                break;
            }
            // A silent robot's clock does not advance, so the recorded events are written now.
            if let Some(log) = &self.log {
                log.write(LogWriter::flush);
            }
        }
        Ok(result?)
    }

    /// A bumper ends the motion. Returns whether one was just pressed.
    fn check_bumpers(&mut self) -> Result<bool, BridgeError> {
        let pressed = self.state.bumpers != 0;
        let touched = pressed && !self.pressed;
        if touched {
            self.motion.touched(&mut self.host)?;
        }
        self.pressed = pressed;
        Ok(touched)
    }

    /// Logs the pose, and the ring at a decision.
    fn write_log(&mut self, touched: bool, result: Option<&WorkerResult>) {
        let Some(log) = &self.log else { return };
        let (now, pose) = (self.events.now(), events::pose(&self.state));
        let decided = result.is_some_and(|result| result.outputs.decision.is_some());
        let stood = self
            .logged_position
            .is_some_and(|logged| logged.distance(pose.position) < LOG_DISTANCE_M);
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
            self.logged_position = Some(pose.position);
        }
    }
}

/// Turns a refusal into an error.
pub(super) fn check_refusal(outputs: &Outputs<16>) -> Result<(), BridgeError> {
    let refused = outputs.refusal.map(EpisodeError::Refused);
    refused.map_or(Ok(()), |failure| Err(BridgeError::Controller(failure)))
}
