//! The one seat from which the robot is steered.

use super::guard::Token;
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// Number of a viewer.
pub type ViewerId = u64;

/// Why the seat was not given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeatError {
    /// That is not the token of this run.
    Token,
    /// Somebody else steers.
    Taken,
}

impl std::fmt::Display for SeatError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Token => {
                "that is not the token of this run: open the whole address the program printed"
            }
            Self::Taken => "somebody else steers",
        })
    }
}

impl std::error::Error for SeatError {}

/// Who watches and who steers.
#[derive(Debug)]
pub struct Seat {
    token: Token,
    viewers: BTreeSet<ViewerId>,
    /// Viewers that have shown the token.
    trusted: BTreeSet<ViewerId>,
    holder: Option<ViewerId>,
    /// When the holder was heard last; `None` before the first one, and after [`becomes_unattended`](Self::becomes_unattended).
    attended: Option<Instant>,
    next: ViewerId,
}

impl Seat {
    /// A free seat for those who know `token`.
    #[must_use]
    pub fn new(token: Token) -> Self {
        Self {
            token,
            viewers: BTreeSet::new(),
            trusted: BTreeSet::new(),
            holder: None,
            attended: None,
            next: 1,
        }
    }

    /// A viewer comes. Without the right token it is refused (`None`) when `max_watchers` others are there without it.
    pub fn enter(&mut self, max_watchers: usize, token: Option<&str>) -> Option<ViewerId> {
        let trusted = token.is_some_and(|token| self.token.is(token));
        let watchers = self.viewers.len().saturating_sub(self.trusted.len());
        if !trusted && watchers >= max_watchers {
            return None;
        }
        let id = self.next;
        self.next += 1;
        self.viewers.insert(id);
        if trusted {
            self.trusted.insert(id);
        }
        Some(id)
    }

    /// A viewer goes; if it steered the seat is free.
    pub fn leave(&mut self, viewer: ViewerId) {
        self.viewers.remove(&viewer);
        self.trusted.remove(&viewer);
        self.rise(viewer);
    }

    /// Takes the seat, with `over` also from somebody else.
    ///
    /// # Errors
    /// [`SeatError`]. With the right token the viewer may stop the robot all the same.
    pub fn take(
        &mut self,
        viewer: ViewerId,
        token: &str,
        over: bool,
        now: Instant,
    ) -> Result<(), SeatError> {
        if !self.viewers.contains(&viewer) || !self.token.is(token) {
            return Err(SeatError::Token);
        }
        self.trusted.insert(viewer);
        match self.holder {
            Some(other) if other != viewer && !over => Err(SeatError::Taken),
            _ => {
                self.holder = Some(viewer);
                self.attended = Some(now);
                Ok(())
            }
        }
    }

    /// Gives the seat up.
    pub fn rise(&mut self, viewer: ViewerId) {
        if self.holder == Some(viewer) {
            self.holder = None;
        }
    }

    /// A viewer has sent something: if it steers, the robot is attended.
    pub fn heard(&mut self, viewer: ViewerId, now: Instant) {
        if self.steers(viewer) {
            self.attended = Some(now);
        }
    }

    /// Whether the viewer that steered has been silent, or gone, for `limit`. True once, until somebody steers again.
    pub fn becomes_unattended(&mut self, now: Instant, limit: Duration) -> bool {
        let silent = |since| now.saturating_duration_since(since) >= limit;
        let unattended = self.attended.is_some_and(silent);
        if unattended {
            self.attended = None;
        }
        unattended
    }

    /// Whether this viewer steers.
    #[must_use]
    pub fn steers(&self, viewer: ViewerId) -> bool {
        self.holder == Some(viewer)
    }

    /// Whether this viewer may stop the robot.
    #[must_use]
    pub fn may_stop(&self, viewer: ViewerId) -> bool {
        self.trusted.contains(&viewer)
    }

    /// Whether anybody steers.
    #[must_use]
    pub fn is_taken(&self) -> bool {
        self.holder.is_some()
    }

    /// How many watch.
    #[must_use]
    pub fn viewers(&self) -> usize {
        self.viewers.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_steers_at_a_time_and_the_seat_comes_free() {
        let (token, now) = (Token::of([7; 16]), Instant::now());
        let token = token.as_str().to_owned();
        let mut seat = Seat::new(Token::of([7; 16]));
        let mut enter = || seat.enter(2, None);
        let (one, two) = (enter().unwrap(), enter().unwrap());
        assert_eq!(enter(), None);
        assert_eq!(seat.take(one, "", true, now), Err(SeatError::Token));
        assert!(!seat.may_stop(one));
        assert_eq!(seat.take(one, &token, false, now), Ok(()));
        let refused = seat.take(two, &token, false, now);
        assert_eq!(refused, Err(SeatError::Taken));
        assert!(seat.steers(one) && !seat.steers(two) && seat.may_stop(two));
        assert_eq!(seat.take(two, &token, true, now), Ok(()));
        assert!(seat.steers(two) && !seat.steers(one));
        seat.rise(one);
        assert!(seat.is_taken());
        seat.leave(two);
        assert!(!seat.is_taken() && !seat.may_stop(two));
        assert_eq!(seat.take(two, &token, true, now), Err(SeatError::Token));
        assert_eq!(seat.viewers(), 1);
    }

    #[test]
    fn owners_take_no_watchers_places() {
        let token = Token::of([7; 16]);
        let mut seat = Seat::new(token.clone());
        let watcher = seat.enter(1, None).unwrap();
        assert_eq!(seat.enter(1, Some("")), None);
        let owner = seat.enter(1, Some(token.as_str())).unwrap();
        assert!(seat.may_stop(owner) && !seat.may_stop(watcher));
        assert!(seat.enter(1, Some(token.as_str())).is_some());
        // A watcher that shows the token later is an owner from then on.
        let now = Instant::now();
        assert_eq!(seat.take(watcher, token.as_str(), true, now), Ok(()));
        assert!(seat.enter(1, None).is_some());
        assert_eq!(seat.enter(1, None), None);
    }

    #[test]
    fn a_robot_is_unattended_when_its_steering_page_is_silent_or_gone() {
        let token = Token::of([7; 16]);
        let mut seat = Seat::new(token.clone());
        let began = Instant::now();
        let at = |ms| began + Duration::from_millis(ms);
        let limit = Duration::from_secs(2);
        let mut enter = || seat.enter(9, Some(token.as_str())).unwrap();
        let (one, two) = (enter(), enter());
        // Before the first page has steered, none is lost.
        assert!(!seat.becomes_unattended(at(9_000), limit));
        assert_eq!(seat.take(one, token.as_str(), false, at(10_000)), Ok(()));
        seat.heard(one, at(11_000));
        // A viewer that does not steer does not count.
        seat.heard(two, at(12_500));
        assert!(!seat.becomes_unattended(at(12_999), limit));
        assert!(seat.becomes_unattended(at(13_000), limit));
        assert!(!seat.becomes_unattended(at(20_000), limit));
        // The page is back, closes, and is opened again in time.
        seat.heard(one, at(21_000));
        seat.leave(one);
        assert!(!seat.becomes_unattended(at(22_999), limit));
        assert_eq!(seat.take(two, token.as_str(), false, at(22_999)), Ok(()));
        assert!(!seat.becomes_unattended(at(24_998), limit));
        seat.leave(two);
        assert!(seat.becomes_unattended(at(24_999), limit));
    }
}
