//! Session, order and age of frames, and whether the other end is alive. Time is an argument; chip
//! and host use the same code.
//!
//! A host opens a *session* with a number of its own choice; frames of other sessions are
//! strangers. Within a session frames are numbered; a frame whose number is not newer than the last
//! one accepted came again or too late. A command carries the host's time and a time to live. Its
//! *age* is its arrival time minus its send time, less the least such difference of about the last
//! minute. The two clocks need equal rates, not a common epoch.

use crate::units::Millis;
use crate::wire::Header;
use crate::wire::message::Clock;
use offset::OffsetWindow;

pub(crate) mod offset;

/// A silence longer than this means that the other end is gone, milliseconds.
pub const SILENCE_MS: u32 = 300;

/// What to do with a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameVerdict {
    /// It is the next one, or some were lost before it.
    Accept,
    /// No session has been opened yet.
    NoSession,
    /// It belongs to another session.
    Stranger,
    /// It was accepted before, or a later one was.
    Replayed {
        /// It is the very last one accepted: its sender may have missed the answer.
        last: bool,
    },
}

/// The state of a link.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Link {
    /// 0 = no session yet.
    session: u16,
    seq: u16,
    /// The host's time counts, not the one here.
    by_host: bool,
    /// When the last frame of the session was heard, by the session's clock; by the host's, none
    /// before it has sent its time.
    heard: Option<Millis>,
    /// When the last frame of the session came, by the clock here.
    came: Millis,
    /// The latest time of the host.
    host: Millis,
    offset: OffsetWindow,
    alive: bool,
}

impl Default for Link {
    fn default() -> Self {
        Self::new()
    }
}

impl Link {
    /// No session. All zeros, as a [`Node`](crate::node::Node) has to be before it starts.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            session: 0,
            seq: 0,
            by_host: false,
            heard: None,
            came: Millis::from_ms(0),
            host: Millis::from_ms(0),
            offset: OffsetWindow::new(),
            alive: false,
        }
    }

    /// Opens a session with the frame that asked for it.
    pub const fn open(&mut self, header: Header, clock: Clock, now: Millis) {
        *self = Self {
            session: header.session,
            seq: header.seq,
            by_host: matches!(clock, Clock::Host),
            heard: match clock {
                Clock::Host => None,
                Clock::Device => Some(now),
            },
            came: now,
            host: Millis::from_ms(0),
            offset: OffsetWindow::new(),
            alive: true,
        };
    }

    /// Number of the session; 0 = none.
    #[must_use]
    pub const fn session(&self) -> u16 {
        self.session
    }

    /// Number of the last frame accepted.
    #[must_use]
    pub const fn seq(&self) -> u16 {
        self.seq
    }

    /// Whose time counts.
    #[must_use]
    pub const fn clock(&self) -> Clock {
        if self.by_host {
            Clock::Host
        } else {
            Clock::Device
        }
    }

    /// Whether a session is open and its host has not fallen silent.
    #[must_use]
    pub(crate) const fn is_alive(&self) -> bool {
        self.alive
    }

    /// Whether the host was heard lately, by the clock here. In a session by the host's clock
    /// [`is_alive`](Self::is_alive) does not detect silence: no time passes meanwhile.
    #[must_use]
    pub(crate) const fn has_heard(&self, now: Millis) -> bool {
        self.alive && now.since(self.came) <= SILENCE_MS
    }

    /// Takes the header of a sound frame.
    pub const fn accept(&mut self, header: Header) -> FrameVerdict {
        if self.session == 0 {
            return FrameVerdict::NoSession;
        }
        if header.session != self.session {
            return FrameVerdict::Stranger;
        }
        let ahead = header.seq.wrapping_sub(self.seq) as i16;
        if ahead <= 0 {
            return FrameVerdict::Replayed { last: ahead == 0 };
        }
        self.seq = header.seq;
        FrameVerdict::Accept
    }

    /// Takes the time of an accepted frame, `at` by the host's clock and `now` by the one here;
    /// returns the moment it speaks of by the session's clock, never later than now.
    pub fn heard(&mut self, at: Millis, now: Millis) -> Millis {
        self.alive = true;
        self.came = now;
        match self.clock() {
            Clock::Host => {
                // The host's clock was set back: continue from there.
                if self.host.is_before(at) || self.host.since(at) > SILENCE_MS {
                    self.host = at;
                }
                self.heard = Some(self.host);
                at
            }
            Clock::Device => {
                self.offset.add(now.since(at), now);
                self.heard = Some(now);
                now.minus_ms(self.age_ms(at, now))
            }
        }
    }

    /// Takes an accepted frame without a time.
    pub const fn heard_timeless(&mut self, now: Millis) {
        self.came = now;
        if !self.by_host {
            self.heard = Some(now);
            self.alive = true;
        }
    }

    /// Begins to wait for the host anew, after a pause during which nothing could be heard here.
    pub const fn resume(&mut self, now: Millis) {
        if self.alive && !self.by_host {
            self.heard = Some(now);
        }
    }

    /// Time by the session's clock.
    #[must_use]
    pub const fn time(&self, now: Millis) -> Millis {
        match self.clock() {
            Clock::Host => self.host,
            Clock::Device => now,
        }
    }

    /// Age of a frame of the host's time `at`, milliseconds: (arrival − sent) minus the least such
    /// difference of the window. Needs equal clock rates, not a common epoch. By the host's clock
    /// no frame is late.
    #[must_use]
    pub fn age_ms(&self, at: Millis, now: Millis) -> u32 {
        match self.clock() {
            Clock::Host => 0,
            Clock::Device => self.offset.excess_ms(now.since(at)),
        }
    }

    /// How far the host's clock has fallen behind the one here since the session began,
    /// milliseconds; negative: it is ahead. 0 by the host's clock.
    #[must_use]
    pub(crate) fn drift_ms(&self) -> i32 {
        self.offset.drift_ms()
    }

    /// Whether the host has just fallen silent, at `time` by the session's clock; true once for
    /// each silence.
    pub const fn falls_silent(&mut self, time: Millis) -> bool {
        let Some(heard) = self.heard else {
            return false;
        };
        // By the host's clock a frame may be a little older than the one before.
        let is_silent = time.since(heard) > SILENCE_MS && heard.since(time) > SILENCE_MS;
        let gone = self.alive && is_silent;
        self.alive &= !gone;
        gone
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ms(ms: u32) -> Millis {
        Millis::from_ms(ms)
    }

    fn opened(clock: Clock) -> Link {
        let mut link = Link::new();
        link.open(
            Header {
                session: 7,
                seq: 65_530,
            },
            clock,
            ms(1_000),
        );
        link
    }

    #[test]
    fn only_newer_frames_of_the_session_are_accepted() {
        let mut link = Link::new();
        let header = |session, seq| Header { session, seq };
        assert_eq!(link.accept(header(7, 1)), FrameVerdict::NoSession);
        link = opened(Clock::Device);
        assert_eq!(link.accept(header(6, 65_531)), FrameVerdict::Stranger);
        assert_eq!(
            link.accept(header(7, 65_530)),
            FrameVerdict::Replayed { last: true }
        );
        assert_eq!(link.accept(header(7, 65_535)), FrameVerdict::Accept);
        // Over the end of the numbers, with two lost.
        assert_eq!(link.accept(header(7, 2)), FrameVerdict::Accept);
        assert_eq!(
            link.accept(header(7, 1)),
            FrameVerdict::Replayed { last: false }
        );
    }

    #[test]
    fn a_delayed_command_is_old_whatever_the_clocks_say() {
        let mut link = opened(Clock::Device);
        assert_eq!(link.heard(ms(50_020), ms(1_025)), ms(1_025));
        assert_eq!(link.heard(ms(50_040), ms(1_040)), ms(1_040));
        assert_eq!(link.heard(ms(50_050), ms(1_050)), ms(1_050));
        // The promptest ones had no delay: this one was sent at 1 060 and came at 1 500.
        assert_eq!(link.heard(ms(50_060), ms(1_500)), ms(1_060));
        assert_eq!(link.age_ms(ms(50_060), ms(1_500)), 440);
    }

    #[test]
    fn by_the_hosts_clock_a_slow_link_is_not_late() {
        let mut link = opened(Clock::Host);
        // The host's clock may have started after the one here.
        assert!(!link.falls_silent(ms(90)));
        assert_eq!(link.heard(ms(100), ms(1_000)), ms(100));
        assert_eq!(link.heard(ms(200), ms(9_000)), ms(200));
        assert_eq!(link.age_ms(ms(150), ms(9_000)), 0);
        // A frame that is a little older does not turn time back; a clock that was set back does.
        assert_eq!(link.heard(ms(190), ms(9_010)), ms(190));
        assert_eq!(link.time(ms(9_010)), ms(200));
        link.heard(ms(60_000), ms(9_020));
        link.heard(ms(200), ms(9_030));
        assert_eq!(link.time(ms(9_030)), ms(200));
        assert!(!link.falls_silent(link.time(ms(60_000))));
        assert!(link.falls_silent(ms(501)));
    }

    #[test]
    fn a_silence_is_noticed_once_and_ends_with_a_frame() {
        let mut link = opened(Clock::Device);
        assert!(!link.falls_silent(ms(1_300)));
        assert!(link.falls_silent(ms(1_301)) && !link.falls_silent(ms(1_302)));
        assert!(!link.is_alive());
        link.heard_timeless(ms(2_000));
        assert!(link.is_alive() && !link.falls_silent(ms(2_300)) && link.falls_silent(ms(2_301)));
        assert!(!Link::new().falls_silent(ms(u32::MAX)));
        // An announced pause is no silence, and does not make a lost host alive.
        link.resume(ms(6_000));
        assert!(!link.is_alive());
        link.heard_timeless(ms(7_000));
        link.resume(ms(11_000));
        assert!(!link.falls_silent(ms(11_300)) && link.falls_silent(ms(11_301)));
        // By the host's clock there was none.
        let mut link = opened(Clock::Host);
        link.heard(ms(100), ms(1_000));
        link.resume(ms(6_000));
        assert!(!link.falls_silent(ms(400)) && link.falls_silent(ms(401)));
    }

    #[test]
    fn a_silence_is_one_by_the_clock_here_as_well() {
        assert!(!Link::new().has_heard(ms(0)));
        for clock in [Clock::Device, Clock::Host] {
            let mut link = opened(clock);
            assert!(link.has_heard(ms(1_300)) && !link.has_heard(ms(1_301)));
            link.heard(ms(100), ms(2_000));
            assert!(link.has_heard(ms(2_300)) && !link.has_heard(ms(2_301)));
            link.heard_timeless(ms(3_000));
            assert!(link.has_heard(ms(3_300)) && !link.has_heard(ms(3_301)));
        }
    }
}
