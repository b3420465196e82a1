//! Session, order and age of frames, and whether the other end is still there: pure, with time as an argument; the chip
//! and the host use the same.
//!
//! A host opens a *session* with a number of its own choice; frames of other sessions are strangers. Within a session
//! frames are numbered; a frame whose number is not newer than the last one accepted came again or too late. A command
//! carries the host's time and a time to live. How old it is, seen from here, is how much later it came than the promptest
//! frame of the session did: the two clocks need not agree, only run alike.

use crate::units::Millis;
use crate::wire::Header;
use crate::wire::message::Clock;

/// A silence longer than this means that the other end is gone, milliseconds.
pub const SILENCE_MS: u32 = 300;

/// What to do with a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
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
    /// When the last frame of the session was heard, by the session's clock; by the host's, none before it has told its
    /// time.
    heard: Option<Millis>,
    /// The latest time of the host.
    host: Millis,
    /// Least difference so far between the time here and the host's.
    offset: Option<u32>,
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
            host: Millis::from_ms(0),
            offset: None,
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
            host: Millis::from_ms(0),
            offset: None,
            alive: true,
        };
    }

    /// Number of the session; 0 = none.
    #[must_use]
    pub const fn session(&self) -> u16 {
        self.session
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
    pub const fn is_alive(&self) -> bool {
        self.alive
    }

    /// Takes the header of a sound frame.
    pub const fn accept(&mut self, header: Header) -> Verdict {
        if self.session == 0 {
            return Verdict::NoSession;
        }
        if header.session != self.session {
            return Verdict::Stranger;
        }
        let ahead = header.seq.wrapping_sub(self.seq) as i16;
        if ahead <= 0 {
            return Verdict::Replayed { last: ahead == 0 };
        }
        self.seq = header.seq;
        Verdict::Accept
    }

    /// Takes the time of an accepted frame, `at` by the host's clock and `now` by the one here; returns the moment it speaks
    /// of by the session's clock.
    pub fn heard(&mut self, at: Millis, now: Millis) -> Millis {
        self.alive = true;
        let late = now.since(at);
        let offset = match self.offset {
            // The difference is a number modulo 2³²; the lesser one is the prompter one.
            Some(offset) if (late.wrapping_sub(offset) as i32) >= 0 => offset,
            _ => late,
        };
        self.offset = Some(offset);
        if self.host.since(at) as i32 <= 0 {
            self.host = at;
        }
        match self.clock() {
            Clock::Host => {
                self.heard = Some(self.host);
                at
            }
            Clock::Device => {
                self.heard = Some(now);
                Millis::from_ms(at.as_ms().wrapping_add(offset))
            }
        }
    }

    /// Takes an accepted frame without a time.
    pub const fn heard_timeless(&mut self, now: Millis) {
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

    /// Age of a frame of the host's time `at`, milliseconds: how much later than the promptest one it came.
    #[must_use]
    pub fn age_ms(&self, at: Millis, now: Millis) -> u32 {
        match self.clock() {
            Clock::Host => self.host.since(at),
            Clock::Device => now.since(at).wrapping_sub(self.offset.unwrap_or(0)),
        }
    }

    /// Whether the host has just fallen silent, at `time` by the session's clock; true once for each silence.
    pub const fn falls_silent(&mut self, time: Millis) -> bool {
        let Some(heard) = self.heard else {
            return false;
        };
        let gone = self.alive && time.since(heard) > SILENCE_MS;
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
        assert_eq!(link.accept(header(7, 1)), Verdict::NoSession);
        link = opened(Clock::Device);
        assert_eq!(link.accept(header(6, 65_531)), Verdict::Stranger);
        assert_eq!(
            link.accept(header(7, 65_530)),
            Verdict::Replayed { last: true }
        );
        assert_eq!(link.accept(header(7, 65_535)), Verdict::Accept);
        // Over the end of the numbers, with two lost.
        assert_eq!(link.accept(header(7, 2)), Verdict::Accept);
        assert_eq!(link.accept(header(7, 1)), Verdict::Replayed { last: false });
    }

    #[test]
    fn a_delayed_command_is_old_whatever_the_clocks_say() {
        let mut link = opened(Clock::Device);
        assert_eq!(link.heard(ms(50_020), ms(1_025)), ms(1_025));
        assert_eq!(link.heard(ms(50_040), ms(1_040)), ms(1_040));
        // The promptest one had no delay: this one was sent at 1 060 and came at 1 500.
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
        assert_eq!(
            (
                link.age_ms(ms(200), ms(9_000)),
                link.age_ms(ms(150), ms(9_000))
            ),
            (0, 50)
        );
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
        // A pause that was announced is no silence; it brings nobody back.
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
}
