//! A host's requests: one function for each kind of accepted message.

use super::{FrameSink, Node};
use crate::controller::{Command, Event, Mode};
use crate::goal::{Component, Goal};
use crate::memory;
use crate::parameters::Parameter;
use crate::units::{Bearing, Displacement, Millis, Range};
use crate::wire::message::{
    Clock, FromMind, GoalBy, Heard, ModeReport, Order, Refusal, Source, ToMind,
};

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    Node<SENSORS, NEURONS, SAMPLES>
{
    /// Does what an accepted frame asks for, and answers it.
    pub(super) fn request(
        &mut self,
        seq: u16,
        message: &ToMind<SENSORS>,
        now: Millis,
        out: &mut impl FrameSink,
    ) {
        let result = if let ToMind::Flash(what) = *message {
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
        if !matches!(message, ToMind::Alive { .. }) {
            self.done(seq, now, out);
            self.reply_cache.finish();
        }
    }

    fn carry_out(
        &mut self,
        message: &ToMind<SENSORS>,
        now: Millis,
        out: &mut impl FrameSink,
    ) -> Result<(), Refusal> {
        match *message {
            ToMind::Alive { at_ms } => {
                self.hear_of(at_ms, now, out);
            }
            ToMind::Scan { at_ms, ref echoes } => {
                let at = self.hear_of(at_ms, now, out);
                self.scan(at, echoes, now, out);
            }
            ToMind::Odometry {
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
            ToMind::Command {
                at_ms,
                ttl_ms,
                ref order,
            } => {
                let at = self.hear_of(at_ms, now, out);
                return self.command(at_ms, at, ttl_ms, order, now, out);
            }
            ref question => {
                self.link.heard_timeless(now);
                return self.answer(question, now, out);
            }
        }
        Ok(())
    }

    /// Answers a request that does not reach the controller.
    // Apart, so that it adds nothing to the controller's stack.
    #[inline(never)]
    fn answer(
        &mut self,
        question: &ToMind<SENSORS>,
        now: Millis,
        out: &mut impl FrameSink,
    ) -> Result<(), Refusal> {
        match *question {
            ToMind::Read { part, offset } => self.read_part(part, offset, now, out),
            ToMind::Write {
                part,
                offset,
                ref bytes,
                last,
            } => return self.write_part(part, offset, bytes, last),
            ToMind::Counters => {
                self.counters.clock_drift_ms = self.link.drift_ms();
                self.send(FromMind::Counters(self.counters), now, out);
            }
            ToMind::Parameter { parameter, value } => {
                return self.parameter(parameter, value, now, out);
            }
            ToMind::Mode => {
                let mode = ModeReport::from(self.state.mode());
                self.send(FromMind::Mode(mode), now, out);
            }
            ToMind::Source(source) => return self.set_source(source),
            ToMind::Keep { name } => return self.save_goal(name),
            ToMind::Drop { name } => return self.delete_goal(name),
            ToMind::Goals => self.send_goals(now, out),
            // `request` has handled these.
            ToMind::Hello(_)
            | ToMind::Alive { .. }
            | ToMind::Scan { .. }
            | ToMind::Odometry { .. }
            | ToMind::Command { .. }
            | ToMind::Flash(_) => {}
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

    fn scan(&mut self, at: Millis, echoes: &[Heard], now: Millis, out: &mut impl FrameSink) {
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
        order: &Order<SENSORS>,
        now: Millis,
        out: &mut impl FrameSink,
    ) -> Result<(), Refusal> {
        let age_ms = self.link.age_ms(Millis::from_ms(at_ms), now);
        if age_ms > u32::from(ttl_ms) && *order != Order::Stop {
            super::add(&mut self.counters.expired);
            return Err(Refusal::Expired { age_ms });
        }
        let Some(command) = self.command_of(order)? else {
            return Ok(());
        };
        let refused = self.dispatch(at, Event::Command(command), now, out);
        refused.map_or(Ok(()), |why| Err(Refusal::Command(why)))
    }

    /// The controller's command for an order; `None` for an order to the node alone.
    // Apart, so that it adds nothing to the stack of every request.
    #[inline(never)]
    fn command_of(&mut self, order: &Order<SENSORS>) -> Result<Option<Command<SENSORS>>, Refusal> {
        Ok(Some(match *order {
            Order::Goal(ref by) => {
                self.goal = self.goal_of(by)?;
                if !matches!(self.state.mode(), Mode::Seek { .. }) {
                    return Ok(None);
                }
                Command::Seek(self.goal)
            }
            Order::Seek => Command::Seek(self.goal),
            Order::Explore { moves, seed } => Command::Explore { moves, seed },
            Order::Learn => Command::Learn,
            // `message` has stopped the robot already.
            Order::Stop => return Ok(None),
            Order::Resume => Command::Resume,
            Order::Forget => return self.forget().map(|()| None),
        }))
    }

    fn goal_of(&self, by: &GoalBy<SENSORS>) -> Result<Goal<SENSORS>, Refusal> {
        match *by {
            GoalBy::Avoid => Ok(Goal::avoiding(&self.config)),
            GoalBy::Components(goal) => Ok(goal),
            GoalBy::Kept(name) => self.goals.find(name).copied().ok_or(Refusal::NoSuchGoal),
            GoalBy::Perceived => {
                let scan = self.state.scan();
                if !scan.has_heard_all(self.state.enabled(&self.config)) {
                    return Err(Refusal::NothingPerceived);
                }
                Ok(Goal::perceived(&self.config.encoding.situation(scan)))
            }
            GoalBy::Situation(bytes) => {
                let (situation, believed) = memory::from_bytes(&bytes);
                let mut goal = Goal::perceived(&situation);
                for (sensor, component) in goal.components.iter_mut().enumerate() {
                    if !believed.contains(sensor) {
                        *component = Component::ANY;
                    }
                }
                Ok(goal)
            }
        }
    }

    fn forget(&mut self) -> Result<(), Refusal> {
        self.require_standing()?;
        self.state.forget();
        self.goal = Goal::avoiding(&self.config);
        self.goals.clear();
        self.underway = None;
        Ok(())
    }

    /// Refuses if the robot may move.
    pub(super) fn require_standing(&self) -> Result<(), Refusal> {
        match self.state.mode() {
            Mode::Idle | Mode::Stopped(_) => Ok(()),
            Mode::Explore { .. } | Mode::Learn { .. } | Mode::Seek { .. } => Err(Refusal::Moving),
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
        let answer = FromMind::Parameter {
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
