//! Received frames: opens sessions, and accepts, repeats or refuses what a host sends.

use super::{FrameSink, Node, add};
use crate::body::Body;
use crate::controller::{Command, Event, Mode, StopReason};
use crate::link::FrameVerdict;
use crate::units::Millis;
use crate::wire::frame::{self, FrameError, Header};
use crate::wire::message::{
    DeviceHello, DeviceMessage, Dimensions, HostHello, HostMessage, Refusal, RobotCommand, Source,
};
use crate::wire::{PROTOCOL, SCHEMA};

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize, B: Body<SENSORS>>
    Node<SENSORS, NEURONS, SAMPLES, B>
{
    /// Takes a received frame, without its zero, at `now` by the device's clock.
    pub fn frame(&mut self, now: Millis, frame: &[u8], out: &mut impl FrameSink) {
        let counters = &mut self.counters;
        match frame::unpack::<HostMessage<SENSORS>>(frame) {
            Ok((header, ref message)) => self.message(header, message, now, out),
            Err(FrameError::Shape | FrameError::TooLong) => add(&mut counters.malformed),
            Err(FrameError::Crc) => add(&mut counters.crc_errors),
            Err(FrameError::Content { .. }) => add(&mut counters.unknown),
        }
    }

    fn message(
        &mut self,
        header: Header,
        message: &HostMessage<SENSORS>,
        now: Millis,
        out: &mut impl FrameSink,
    ) {
        if let HostMessage::Hello(hello) = *message {
            return self.open(header, hello, now, out);
        }
        let verdict = self.link.accept(header);
        if verdict == FrameVerdict::Accept {
            add(&mut self.counters.accepted);
            if !matches!(message, HostMessage::Alive { .. }) {
                self.answer_request(now, out);
            }
            self.reply_cache.begin();
        }
        // A stop acts in every session, with every number and time. If it repeats the last frame,
        // that frame's cached answer holds the order to stand already.
        let is_stop = is_stop(message);
        let is_answered = verdict == FrameVerdict::Replayed { last: true }
            && matches!(self.state.mode(), Mode::Stopped(_))
            && self.reply_cache.frames().next().is_some();
        if is_stop && !is_answered {
            self.stop(now, out);
        }
        let seq = header.seq;
        match verdict {
            FrameVerdict::Accept => self.request(seq, message, now, out),
            // Its answer is on its way.
            FrameVerdict::Replayed { last: true } if self.unanswered == Some(seq) => {
                add(&mut self.counters.replayed);
            }
            FrameVerdict::Replayed { last } => {
                add(&mut self.counters.replayed);
                if last && !matches!(message, HostMessage::Alive { .. }) {
                    self.resend(seq, now, out);
                } else if is_stop {
                    self.done(seq, now, out);
                }
            }
            FrameVerdict::NoSession | FrameVerdict::Stranger => {
                add(&mut self.counters.wrong_session);
                if is_stop {
                    self.done(seq, now, out);
                } else if verdict == FrameVerdict::NoSession {
                    self.refuse(seq, Refusal::NoSession, now, out);
                }
            }
        }
    }

    /// Stops the robot, by the time of the session's clock.
    fn stop(&mut self, now: Millis, out: &mut impl FrameSink) {
        let stop = Event::Command(Command::Stop);
        self.dispatch(self.link.time(now), stop, now, out);
    }

    fn open(&mut self, header: Header, hello: HostHello, now: Millis, out: &mut impl FrameSink) {
        let ours = Self::dimensions();
        if hello.dimensions != ours || header.session == 0 {
            return self.refuse(header.seq, Refusal::Incompatible(ours), now, out);
        }
        let is_repeated = header == self.opened_by
            && header.seq == self.link.seq()
            && hello.clock == self.link.clock()
            && hello.open_space == self.state.expects_open_space();
        if is_repeated {
            // The answer to the first one was lost.
            return self.hello(now, out);
        }
        // A motion under way belongs to the session that ends here.
        let gone = Event::Alarm(StopReason::LinkLost);
        self.dispatch(self.link.time(now), gone, now, out);
        add(&mut self.counters.accepted);
        self.link.open(header, hello.clock, now);
        self.opened_by = header;
        self.state.expect_open_space(hello.open_space);
        self.source = Source::Link;
        self.seq = 0;
        self.reply_cache.clear();
        self.unanswered = None;
        self.hello(now, out);
    }

    pub(super) const fn dimensions() -> Dimensions {
        Dimensions {
            protocol: PROTOCOL,
            schema: SCHEMA,
            sensors: SENSORS as u8,
            neurons: NEURONS as u8,
        }
    }

    /// Sends a hello: the second half of [`start`](Self::start).
    pub fn hello(&mut self, now: Millis, out: &mut impl FrameSink) {
        let hello = DeviceHello {
            dimensions: Self::dimensions(),
            samples: SAMPLES as u16,
            build: self.identity.build,
            reset: self.identity.reset,
            oscillator: self.identity.oscillator,
            config_crc: self.config_crc(),
            maps_crc: self.maps_crc(),
            memory_crc: self.memory_crc(),
        };
        self.send(DeviceMessage::Hello(hello), now, out);
    }
}

const fn is_stop<const SENSORS: usize>(message: &HostMessage<SENSORS>) -> bool {
    matches!(
        message,
        HostMessage::Command {
            command: RobotCommand::Stop,
            ..
        }
    )
}
