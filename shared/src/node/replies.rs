//! Frames on their way out: decisions, motions, notices and answers.

use super::{FrameSink, MOTION_TTL_MS, Node, RENEWAL_MS, Underway, add};
use crate::body::Body;
use crate::controller::{Motion, Outputs};
use crate::units::Millis;
use crate::wire::frame::{Frame, Header};
use crate::wire::message::{
    Counters, DeviceMessage, LogEvent, ModeReport, MotionCommand, Refusal, Report,
};

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize, B: Body<SENSORS>>
    Node<SENSORS, NEURONS, SAMPLES, B>
{
    /// Sends what an event brought about.
    // Apart, so that it adds nothing to the controller's stack.
    #[inline(never)]
    pub(super) fn publish(
        &mut self,
        outputs: &Outputs<SENSORS>,
        at: Millis,
        now: Millis,
        out: &mut impl FrameSink,
    ) {
        if outputs.motion.is_some() || outputs.mode_changed {
            self.reply_cache.invalidate();
        }
        if let Some(verdict) = outputs.verdict {
            self.log(verdict.into(), now, out);
        }
        if let Some(age_ms) = outputs.stale_ms {
            self.count_stale(age_ms, now, out);
        }
        if let Some(decision) = outputs.decision {
            self.stale_reported = false;
            self.send(DeviceMessage::Decision(decision), now, out);
        }
        if let Some(motion) = outputs.motion {
            let command = self.motion_command(motion);
            self.underway = Some(Underway { command, sent: at });
            self.send_motion(command, now, out);
        }
        if outputs.mode_changed {
            let mode = ModeReport::from(self.state.mode());
            self.send(DeviceMessage::Mode(mode), now, out);
        }
    }

    /// The command for a motion: a shortened motion keeps its number and gets the next revision.
    fn motion_command(&self, motion: Motion) -> MotionCommand {
        let revision = match self.underway {
            Some(underway) if underway.command.id == motion.id => {
                underway.command.revision.wrapping_add(1)
            }
            _ => 0,
        };
        MotionCommand {
            id: motion.id,
            revision,
            dx_mm: motion.displacement.dx_mm,
            dy_mm: motion.displacement.dy_mm,
            speed_mm_s: motion.speed_mm_s,
            ttl_ms: MOTION_TTL_MS,
        }
    }

    /// Counts a stale echo; reports the first one since the last decision.
    fn count_stale(&mut self, age_ms: u32, now: Millis, out: &mut impl FrameSink) {
        add(&mut self.counters.stale_echoes);
        if !core::mem::replace(&mut self.stale_reported, true) {
            self.log(LogEvent::StaleEcho { age_ms }, now, out);
        }
    }

    // The next four are apart, so that their messages add nothing to the controller's stack.
    #[inline(never)]
    fn send_motion(&mut self, command: MotionCommand, now: Millis, out: &mut impl FrameSink) {
        self.send(DeviceMessage::Motion(command), now, out);
    }

    #[inline(never)]
    pub(super) fn refuse(
        &mut self,
        seq: u16,
        reason: Refusal,
        now: Millis,
        out: &mut impl FrameSink,
    ) {
        add(&mut self.counters.refused);
        self.send(DeviceMessage::Refusal { seq, reason }, now, out);
    }

    #[inline(never)]
    pub(super) fn done(&mut self, seq: u16, now: Millis, out: &mut impl FrameSink) {
        self.send(DeviceMessage::Done { seq }, now, out);
    }

    #[inline(never)]
    pub(super) fn log(&mut self, event: LogEvent, now: Millis, out: &mut impl FrameSink) {
        self.send(DeviceMessage::Log(event), now, out);
    }

    /// Sends one message in a frame of its own and adds it to the cached answer.
    // One copy in the program.
    #[inline(never)]
    pub(super) fn send(
        &mut self,
        message: DeviceMessage<SENSORS>,
        now: Millis,
        out: &mut impl FrameSink,
    ) {
        self.seq = self.seq.wrapping_add(1);
        let header = Header {
            session: self.link.session(),
            seq: self.seq,
        };
        let report = Report {
            device_ms: self.link.time(now).as_ms(),
            message,
        };
        let mut frame = Frame::EMPTY;
        let sent = frame.fill(header, &report).is_ok() && {
            self.reply_cache.push(frame.as_bytes());
            out.send(frame.as_bytes())
        };
        self.counters.count_sent(sent);
    }

    /// Sends the cached answer again, or only its *Done* if the answer was too long for the cache.
    pub(super) fn resend(&mut self, seq: u16, now: Millis, out: &mut impl FrameSink) {
        let mut frames = 0_u32;
        for frame in self.reply_cache.frames() {
            self.counters.count_sent(out.send(frame));
            add(&mut frames);
        }
        if frames == 0 {
            self.done(seq, now, out);
        }
    }

    /// Sends a motion under way again before it expires.
    pub(super) fn renew_motion(&mut self, time: Millis, now: Millis, out: &mut impl FrameSink) {
        let moving = self.state.is_moving();
        if let Some(underway) = self.underway.filter(|_| moving)
            && time.since(underway.sent) >= RENEWAL_MS
        {
            self.underway = Some(Underway {
                sent: time,
                ..underway
            });
            self.send_motion(underway.command, now, out);
        }
    }
}

impl Counters {
    /// Counts a frame as sent or dropped.
    const fn count_sent(&mut self, taken: bool) {
        let counter = if taken {
            &mut self.sent
        } else {
            &mut self.dropped
        };
        add(counter);
    }
}
