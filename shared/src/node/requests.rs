//! A host's requests: one function for each kind of accepted message.

use super::{FrameSink, Node};
use crate::body::Body;
use crate::controller::{Command, Event, Mode};
use crate::goal::Goal;
use crate::memory;
use crate::parameters::Parameter;
use crate::units::{Bearing, Displacement, Millis, Range};
use crate::wire::message::{
    Clock, DeviceMessage, GoalSpec, HostMessage, ModeReport, Refusal, RobotCommand, Source,
    TimedEcho,
};

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize, B: Body<SENSORS>>
    Node<SENSORS, NEURONS, SAMPLES, B>
{
    /// Does what an accepted frame asks for, and answers it.
    pub(super) fn request(
        &mut self,
        seq: u16,
        message: &HostMessage<SENSORS>,
        now: Millis,
        out: &mut impl FrameSink,
    ) {
        let was_thinking = self.body.is_thinking();
        let result = if let HostMessage::Flash(what) = *message {
            self.link.heard_timeless(now);
            let requested = self.request_flash(seq, what);
            if requested.is_ok() {
                // `flash_done` answers.
                return;
            }
            requested
        } else {
            self.carry_out(message, now, out)
        };
        if let Err(why) = result {
            self.refuse(seq, why, now, out);
        }
        if matches!(message, HostMessage::Alive { .. }) {
            return;
        }
        self.unanswered = Some(seq);
        if was_thinking || !self.body.is_thinking() {
            self.answer_request(now, out);
        }
    }

    /// Ends the answer to a request.
    pub(super) fn answer_request(&mut self, now: Millis, out: &mut impl FrameSink) {
        if let Some(seq) = self.unanswered.take() {
            self.done(seq, now, out);
            self.reply_cache.finish();
        }
    }

    fn carry_out(
        &mut self,
        message: &HostMessage<SENSORS>,
        now: Millis,
        out: &mut impl FrameSink,
    ) -> Result<(), Refusal> {
        match *message {
            HostMessage::Alive { at_ms } => {
                self.hear_of(at_ms, now, out);
            }
            HostMessage::Scan { at_ms, ref echoes } => {
                let at = self.hear_of(at_ms, now, out);
                self.scan(at, echoes, now, out);
            }
            HostMessage::Odometry {
                at_ms,
                motion,
                dx_mm,
                dy_mm,
                turned,
                progress,
            } => {
                let at = self.hear_of(at_ms, now, out);
                let event = Event::Odometry {
                    motion,
                    moved: Displacement { dx_mm, dy_mm },
                    turned: Bearing::from_turns(turned),
                    progress,
                };
                self.dispatch(at, event, now, out);
            }
            HostMessage::Command {
                at_ms,
                ttl_ms,
                ref command,
            } => {
                let at = self.hear_of(at_ms, now, out);
                return self.command(at_ms, at, ttl_ms, command, now, out);
            }
            ref request => {
                self.link.heard_timeless(now);
                return self.answer(request, now, out);
            }
        }
        Ok(())
    }

    /// Answers a request that does not reach the controller.
    // Apart, so that it adds nothing to the controller's stack.
    #[inline(never)]
    fn answer(
        &mut self,
        request: &HostMessage<SENSORS>,
        now: Millis,
        out: &mut impl FrameSink,
    ) -> Result<(), Refusal> {
        match *request {
            HostMessage::Read { part, offset } => self.read_part(part, offset, now, out),
            HostMessage::Write {
                part,
                offset,
                ref bytes,
                last,
            } => return self.write_part(part, offset, bytes, last),
            HostMessage::Counters => {
                self.counters.clock_drift_ms = self.link.drift_ms();
                self.send(DeviceMessage::Counters(self.counters), now, out);
            }
            HostMessage::Parameter { parameter, value } => {
                return self.parameter(parameter, value, now, out);
            }
            HostMessage::Mode => {
                let mode = ModeReport::from(self.state.mode());
                self.send(DeviceMessage::Mode(mode), now, out);
            }
            HostMessage::Source(source) => return self.set_source(source),
            HostMessage::SaveGoal { name } => return self.save_goal(name),
            HostMessage::DeleteGoal { name } => return self.delete_goal(name),
            HostMessage::ListGoals => self.send_goals(now, out),
            // `request` has handled these.
            HostMessage::Hello(_)
            | HostMessage::Alive { .. }
            | HostMessage::Scan { .. }
            | HostMessage::Odometry { .. }
            | HostMessage::Command { .. }
            | HostMessage::Flash(_) => {}
        }
        Ok(())
    }

    /// Takes the host's time of a frame; in a session with the host's clock, time passes with it.
    /// Returns the time by the session's clock.
    fn hear_of(&mut self, at_ms: u32, now: Millis, out: &mut impl FrameSink) -> Millis {
        let at = Millis::from_ms(at_ms);
        if self.link.clock() == Clock::Host {
            self.watch(at, now, out);
        }
        self.link.heard(at, now)
    }

    fn scan(&mut self, at: Millis, echoes: &[TimedEcho], now: Millis, out: &mut impl FrameSink) {
        if self.source != Source::Link {
            return;
        }
        for echo in echoes {
            let heard = Millis::from_ms(at.as_ms().wrapping_sub(u32::from(echo.age_ms)));
            let event = Event::Echo {
                sensor: echo.sensor,
                range: echo.range_mm.map(Range::from_mm),
            };
            self.dispatch(heard, event, now, out);
        }
    }

    fn command(
        &mut self,
        at_ms: u32,
        at: Millis,
        ttl_ms: u16,
        command: &RobotCommand<SENSORS>,
        now: Millis,
        out: &mut impl FrameSink,
    ) -> Result<(), Refusal> {
        let age_ms = self.link.age_ms(Millis::from_ms(at_ms), now);
        if age_ms > u32::from(ttl_ms) && *command != RobotCommand::Stop {
            super::add(&mut self.counters.expired);
            return Err(Refusal::Expired { age_ms });
        }
        let Some(command) = self.command_of(command)? else {
            return Ok(());
        };
        let refused = self.dispatch(at, Event::Command(command), now, out);
        refused.map_or(Ok(()), |why| Err(Refusal::Command(why)))
    }

    /// The controller's command; `None` if the node alone carries it out.
    // Apart, so that it adds nothing to the stack of every request.
    #[inline(never)]
    fn command_of(
        &mut self,
        command: &RobotCommand<SENSORS>,
    ) -> Result<Option<Command<SENSORS>>, Refusal> {
        Ok(Some(match *command {
            RobotCommand::Goal(ref by) => {
                self.goal = self.goal_of(by)?;
                if !matches!(self.state.mode(), Mode::Seek { .. }) {
                    return Ok(None);
                }
                Command::Seek(self.goal)
            }
            RobotCommand::Seek => Command::Seek(self.goal),
            RobotCommand::Explore { moves, seed } => Command::Explore { moves, seed },
            RobotCommand::Learn => Command::Learn,
            // `message` has stopped the robot already.
            RobotCommand::Stop => return Ok(None),
            RobotCommand::Resume => Command::Resume,
            RobotCommand::Calibrate {
                moves,
                seed,
                actuators,
            } => Command::Calibrate {
                moves,
                seed,
                actuators,
            },
            RobotCommand::Forget => return self.forget().map(|()| None),
            RobotCommand::Lead(aim) => {
                return match self.body.lead_to(aim) || aim.is_none() {
                    true => Ok(None),
                    false => Err(Refusal::NoPlaces),
                };
            }
            RobotCommand::SetDown => {
                self.require_standing()?;
                return self
                    .body
                    .set_down()
                    .then_some(None)
                    .ok_or(Refusal::NoPlaces);
            }
        }))
    }

    fn goal_of(&self, by: &GoalSpec<SENSORS>) -> Result<Goal<SENSORS>, Refusal> {
        match *by {
            GoalSpec::Avoid => Ok(Goal::avoiding(&self.config)),
            GoalSpec::Components(goal) => Ok(goal),
            GoalSpec::Saved(name) => self.goals.find(name).copied().ok_or(Refusal::NoSuchGoal),
            GoalSpec::Perceived => {
                let (scan, known) = (self.state.scan(), self.state.enabled(&self.config));
                if !scan.has_heard_all(known) {
                    return Err(Refusal::NoSituation);
                }
                let situation = self.config.encoding.situation(scan);
                Ok(Goal::perceived(&situation).for_known(known))
            }
            GoalSpec::Situation(bytes) => {
                let (situation, believed) = memory::from_bytes(&bytes);
                Ok(Goal::perceived(&situation).for_known(believed))
            }
        }
    }

    fn forget(&mut self) -> Result<(), Refusal> {
        self.require_standing()?;
        self.state.forget();
        self.goal = Goal::avoiding(&self.config);
        self.goals.clear();
        // Without a memory of places there is none to be forgotten.
        let _ = self.body.write_places(0, &[]);
        self.underway = None;
        Ok(())
    }

    /// Refuses if the robot may move.
    pub(super) fn require_standing(&self) -> Result<(), Refusal> {
        match self.state.mode() {
            Mode::Idle | Mode::Stopped(_) => Ok(()),
            Mode::Explore { .. }
            | Mode::Learn { .. }
            | Mode::Seek { .. }
            | Mode::Babble { .. }
            | Mode::Calibrate => Err(Refusal::Moving),
        }
    }

    fn parameter(
        &mut self,
        parameter: Parameter,
        value: Option<i32>,
        now: Millis,
        out: &mut impl FrameSink,
    ) -> Result<(), Refusal> {
        if let Some(value) = value {
            self.require_standing()?;
            self.set_parameter(parameter, value)
                .map_err(Refusal::Parameter)?;
        }
        let answer = DeviceMessage::Parameter {
            parameter,
            value: parameter.get(&self.config),
            spec: parameter.spec(),
        };
        self.send(answer, now, out);
        Ok(())
    }

    fn set_source(&mut self, source: Source) -> Result<(), Refusal> {
        self.require_standing()?;
        // By the host's clock no time passes while the host is silent: motions by the device's ring
        // would be unsupervised.
        if source == Source::Ring && (!self.identity.ring || self.link.clock() == Clock::Host) {
            return Err(Refusal::NoRing);
        }
        self.source = source;
        Ok(())
    }
}
