//! Drives the simulated robot with a controller at the other end of a link.
//!
//! The controller's clock follows the time of the messages (`Clock::Host`), so neither a slow
//! link nor a slow chip changes the result of an episode.

mod heartbeats;
mod pilot;

use super::twin::Twin;
use super::{Fingerprint, Knowledge, LinkError, Response, Session, next_number};
use amp::config::Config;
use amp::controller::{Command, Event, Motion, Outputs, StopReason};
use amp::fixed::Mask;
use amp::som::Grid;
use amp::turret::BodySpec;
use amp::units::{Millis, Range};
use amp::wire::message::{
    DeviceMessage, GoalSpec, LogEvent, ModeReport, MotionCommand, Refusal, Report, RobotCommand,
    TimedEcho, TransferPart,
};
use amp::wire::{HostMessage, message};
use sim::error::EpisodeError;
use sim::pilot::{AgedEcho, InspectableController, SimState};
use sim::robot::ToldRobot;
use sim::turret_pilot::TurretController;
use std::borrow::BorrowMut;
use std::time::{Duration, Instant};

/// Interval of the queries whether the controller still learns.
const LEARN_POLL: Duration = Duration::from_millis(500);

/// Limit for learning and for finding the sensors; the F405 takes a second or two.
const LEARN_TIMEOUT: Duration = Duration::from_secs(60);

/// A controller at the other end of a link, for one episode. It owns its session (`Session`) or
/// borrows it (`&mut Session`).
pub struct RemoteController<S> {
    session: S,
    config: Config<16>,
    /// The robot, as it was told.
    robot: Option<ToldRobot>,
    /// Of a robot with a memory of places.
    twin: Option<Twin>,
    /// Transducers that the controller's fault detector has disabled.
    disabled: Mask,
    found: Fingerprint,
    fresh: Fingerprint,
    /// Time of the latest message.
    last_sent: Millis,
    /// Number and revision of the latest motion.
    motion: Option<(u16, u8)>,
    /// A stop command was sent and is not yet confirmed.
    stopping: bool,
    /// The controller learns, or finds where the sensors look.
    thinking: bool,
    knowledge: Box<SimState>,
    error: Option<LinkError>,
}

impl<S: BorrowMut<Session>> RemoteController<S> {
    /// Opens session `number` and the next one: writes the configuration and the robot (`None` = a
    /// ring on a held turret), clears the knowledge and checks it and the configuration.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn start(
        mut session: S,
        number: u16,
        config: &Config<16>,
        robot: Option<&ToldRobot>,
    ) -> Result<Self, LinkError> {
        let (found, fresh) = session.borrow_mut().open_fresh(number, config, robot)?;
        let twin = twin(session.borrow_mut(), config, robot)?;
        Ok(Self {
            twin,
            session,
            config: config.clone(),
            robot: robot.cloned(),
            disabled: Mask::NONE,
            found,
            fresh,
            last_sent: Millis::from_ms(0),
            motion: None,
            stopping: false,
            thinking: false,
            knowledge: Box::new(SimState::new(Grid::rectangle(4, 4))),
            error: None,
        })
    }

    /// Does the same as [`start`](Self::start) with another configuration, also after an error; the
    /// simulated time restarts at 0.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn restart(&mut self, config: &Config<16>) -> Result<(), LinkError> {
        let session = self.session.borrow_mut();
        let number = next_number(session.number());
        (self.found, self.fresh) = session.open_fresh(number, config, self.robot.as_ref())?;
        self.twin = twin(session, config, self.robot.as_ref())?;
        (self.config, self.disabled) = (config.clone(), Mask::NONE);
        (self.last_sent, self.motion, self.error) = (Millis::from_ms(0), None, None);
        self.thinking = false;
        Ok(())
    }

    /// Replaces the configuration and keeps the knowledge.
    ///
    /// # Errors
    /// [`LinkError`]; a refusal while the robot explores, learns or seeks.
    pub fn configure(&mut self, config: &Config<16>) -> Result<(), LinkError> {
        let bytes = Knowledge::encode_config(config)?;
        let session = self.session.borrow_mut();
        session.write_part(TransferPart::Config, &bytes)?;
        if let Some(twin) = &mut self.twin {
            twin.configure(config);
        }
        (self.config, self.disabled) = (config.clone(), Mask::NONE);
        Ok(())
    }

    /// The configuration.
    #[must_use]
    pub fn config(&self) -> &Config<16> {
        &self.config
    }

    /// The controller in this process that decides the same, of a robot with a memory of places:
    /// what it knows, this one does.
    #[must_use]
    pub fn twin(&self) -> Option<&TurretController> {
        self.twin.as_ref().map(Twin::controller)
    }

    /// Transducers it uses.
    #[must_use]
    pub fn enabled(&self) -> Mask {
        Mask::from_bits(self.config.enabled.to_bits() & !self.disabled.to_bits())
    }

    /// The parts that differed from this configuration and empty knowledge before the start, in
    /// words.
    #[must_use]
    pub fn replaced(&self) -> Vec<&'static str> {
        self.found.differences(&self.fresh)
    }

    /// Adds body and places to what is known of it.
    ///
    /// # Errors
    /// When it cannot be reached.
    pub fn read_body(&mut self, knowledge: &mut Knowledge) -> Result<(), EpisodeError> {
        let read = knowledge.read_body(self.session.borrow_mut());
        read.map_err(EpisodeError::from)
    }

    fn dispatch(&mut self, at: Millis, event: Event<16>) -> Result<Outputs<16>, LinkError> {
        let at_ms = at.as_ms();
        match event {
            Event::Echo { sensor, range } => self.send_echoes(at, &[AgedEcho::now(sensor, range)]),
            Event::Odometry {
                motion,
                moved,
                turned,
                progress,
            } => self.send(
                at,
                &HostMessage::Odometry {
                    at_ms,
                    motion,
                    dx_mm: moved.dx_mm,
                    dy_mm: moved.dy_mm,
                    turned: turned.as_turns(),
                    progress,
                },
            ),
            Event::Command(command) => self.command(at, command),
            Event::Tick if self.thinking => self.wait_until_idle(LEARN_TIMEOUT),
            Event::Tick => self.tick(at),
            // Alarms come from the controller's side of the link.
            Event::Alarm(_) | Event::Touched => Ok(Outputs::NONE),
        }
    }

    fn send_echoes(&mut self, at: Millis, echoes: &[AgedEcho]) -> Result<Outputs<16>, LinkError> {
        let received = |echo: &AgedEcho| TimedEcho {
            sensor: echo.sensor,
            range_mm: echo.range.map(Range::as_mm),
            // Any controller ignores an echo older than a minute.
            age_ms: echo.age_ms.try_into().unwrap_or(u16::MAX),
        };
        let echoes = echoes.iter().take(message::MAX_ECHOES).map(received);
        let message = HostMessage::Scan {
            at_ms: at.as_ms(),
            echoes: echoes.collect(),
        };
        self.send(at, &message)
    }

    fn command(&mut self, at: Millis, command: Command<16>) -> Result<Outputs<16>, LinkError> {
        self.stopping = command == Command::Stop;
        let wire_command = match command {
            Command::Explore { moves, seed } => RobotCommand::Explore { moves, seed },
            Command::Learn => RobotCommand::Learn,
            Command::Seek(goal) => {
                self.send_command(at, RobotCommand::Goal(GoalSpec::Components(goal)))?;
                RobotCommand::Seek
            }
            Command::Stop => RobotCommand::Stop,
            Command::Resume => RobotCommand::Resume,
            Command::Calibrate {
                moves,
                seed,
                actuators,
            } => RobotCommand::Calibrate {
                moves,
                seed,
                actuators,
            },
        };
        let done = self.send_command(at, wire_command);
        self.stopping = false;
        let is_done = matches!(&done, Ok(outputs) if outputs.refusal.is_none());
        self.thinking = is_done && command == Command::Learn;
        done
    }

    fn send_command(
        &mut self,
        at: Millis,
        command: RobotCommand<16>,
    ) -> Result<Outputs<16>, LinkError> {
        let message = HostMessage::Command {
            at_ms: at.as_ms(),
            ttl_ms: super::session::COMMAND_TTL_MS,
            command,
        };
        self.send(at, &message)
    }

    /// Sends an event of the time `at` and returns its outputs.
    fn send(&mut self, at: Millis, message: &HostMessage<16>) -> Result<Outputs<16>, LinkError> {
        self.queue_heartbeats(at)?;
        let answer = self.session.borrow_mut().request(message)?;
        self.outputs(&answer)
    }

    fn outputs(&mut self, answer: &Response) -> Result<Outputs<16>, LinkError> {
        if answer.missing > 0 {
            let reports = answer.missing;
            return Err(LinkError::ReportsLost { reports });
        }
        let mut outputs = Outputs::NONE;
        for report in &answer.reports {
            self.take(report, &mut outputs)?;
        }
        match answer.refusal {
            Some(Refusal::Command(why)) => outputs.refusal = Some(why),
            Some(why) => return Err(LinkError::Refused(why)),
            None => {}
        }
        Ok(outputs)
    }

    fn take(&mut self, report: &Report<16>, outputs: &mut Outputs<16>) -> Result<(), LinkError> {
        match &report.message {
            DeviceMessage::Decision(decision) => outputs.decision = Some(*decision),
            DeviceMessage::Motion(command) => {
                outputs.motion = self.new_motion(*command).or(outputs.motion)
            }
            DeviceMessage::Mode(ModeReport::Stopped(StopReason::Commanded)) if self.stopping => {
                outputs.mode_changed = true;
            }
            DeviceMessage::Mode(ModeReport::Stopped(reason)) => {
                return Err(LinkError::Stopped(*reason));
            }
            DeviceMessage::Mode(mode) => {
                outputs.mode_changed = true;
                self.thinking |= *mode == ModeReport::Calibrate;
            }
            DeviceMessage::Log(LogEvent::SensorDisabled { sensor, .. }) => {
                self.disabled = self.disabled.with((*sensor).into());
            }
            DeviceMessage::Log(LogEvent::SensorEnabled { sensor }) => {
                self.disabled = self.disabled.without((*sensor).into());
            }
            _ => {}
        }
        Ok(())
    }

    /// The motion, unless it only renews the time to live of the current one.
    fn new_motion(&mut self, command: MotionCommand) -> Option<Motion> {
        let mark = Some((command.id, command.revision));
        (std::mem::replace(&mut self.motion, mark) != mark).then(|| command.motion())
    }

    /// Waits until the controller has learned, for `limit` at most.
    fn wait_until_idle(&mut self, limit: Duration) -> Result<Outputs<16>, LinkError> {
        self.thinking = false;
        let end = Instant::now() + limit;
        let mut outputs = Outputs::NONE;
        while !outputs.mode_changed {
            let until = end.min(Instant::now() + LEARN_POLL);
            match self.session.borrow_mut().next_report(until)? {
                Some(report) => self.take(&report, &mut outputs)?,
                // A query would have a time limit of its own.
                None if Instant::now() >= end => return Err(LinkError::Learning { waited: limit }),
                // The report may have been lost.
                None => outputs.mode_changed = !self.is_thinking()?,
            }
        }
        Ok(outputs)
    }

    fn is_thinking(&mut self) -> Result<bool, LinkError> {
        let mode = self.session.borrow_mut().mode()?;
        Ok(matches!(mode, ModeReport::Learn | ModeReport::Calibrate))
    }

    fn record_error(&mut self, result: Result<Outputs<16>, LinkError>) -> Outputs<16> {
        result.unwrap_or_else(|error| {
            self.error = Some(error);
            Outputs::NONE
        })
    }
}

impl<S: BorrowMut<Session>> InspectableController for RemoteController<S> {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        // The state does not change between messages, in any mode.
        let read = Knowledge::read(self.session.borrow_mut()).map(Knowledge::into_state);
        self.knowledge = read.map_err(EpisodeError::from)?;
        Ok(&self.knowledge)
    }

    fn body(&mut self) -> Result<Option<BodySpec<16>>, EpisodeError> {
        let bytes = self.session.borrow_mut().read_part(TransferPart::Body);
        Ok(BodySpec::from_bytes(&bytes.map_err(EpisodeError::from)?))
    }
}

/// The twin of the controller of this robot, if it has a memory of places.
fn twin(
    session: &mut Session,
    config: &Config<16>,
    robot: Option<&ToldRobot>,
) -> Result<Option<Twin>, LinkError> {
    Ok(match robot {
        Some(robot) if session.has_places()? => Some(Twin::new(config, robot)),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::InProcessNode;
    use crate::link::tests::floods::frames;
    use crate::link::{Flood, Transport};
    use amp::wire::{Frame, frame};
    use std::io;

    /// Reports endlessly that it learns. Fails after 30 s, so that every wait ends.
    struct EndlessLearner {
        controller: InProcessNode,
        began: Instant,
    }

    impl Transport for EndlessLearner {
        fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
            self.controller.send(bytes)
        }

        fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
            if self.began.elapsed() > Duration::from_secs(30) {
                return Err(io::Error::other("it has learned for long enough"));
            }
            let mut one = [0];
            let mut bytes = Vec::new();
            while self.controller.receive(&mut one, timeout)? > 0 && one != [0] {
                bytes.push(one[0]);
            }
            let Ok((header, mut report)) = frame::unpack::<Report<16>>(&bytes) else {
                return Ok(0);
            };
            if let DeviceMessage::Mode(mode) = &mut report.message {
                *mode = ModeReport::Learn;
            }
            let frame = Frame::pack(header, &report).unwrap();
            io::Read::read(&mut frame.as_bytes(), buffer)
        }
    }

    #[test]
    fn a_controller_that_learns_without_end_times_out() {
        let config = Config::recommended();
        let learner = EndlessLearner {
            controller: InProcessNode::new(config.clone()),
            began: Instant::now(),
        };
        let mut controller =
            RemoteController::start(Session::new(learner), 1, &config, None).unwrap();
        // Long enough for one query.
        let limit = Duration::from_millis(600);
        let ended = controller.wait_until_idle(limit);
        let timed_out = Err(LinkError::Learning { waited: limit });
        assert_eq!(ended, timed_out, "it reports that it learns");
        let limit = Duration::from_millis(200);
        controller.session.transport = Box::new(Flood::of(frames(controller.session.number(), 1)));
        let ended = controller.wait_until_idle(limit);
        let timed_out = Err(LinkError::Learning { waited: limit });
        assert_eq!(ended, timed_out, "it sends other reports");
        let error = LinkError::Learning {
            waited: LEARN_TIMEOUT,
        };
        assert_eq!(
            error.to_string(),
            "the controller has not learned within 60 s"
        );
    }
}
