//! The control lock: at most one viewer steers the robot.

use super::guard::Token;
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// Number of a viewer.
pub type ViewerId = u64;

/// Why the lock was not acquired.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ControlLockError {
    /// A wrong token.
    Token,
    /// Another viewer holds the lock.
    Taken,
}

impl std::fmt::Display for ControlLockError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Token => {
                "that is not the token of this run: open the whole address the program printed"
            }
            Self::Taken => "another viewer steers",
        })
    }
}

impl std::error::Error for ControlLockError {}

/// All viewers, and the holder of the lock.
///
/// To steer, a viewer shows the token of the printed address and acquires the lock. Every viewer
/// that has shown the token may stop the robot at any time. A socket that is opened at
/// `/socket?token=TOKEN` has shown it already and does not count as a watcher. The server pings the
/// holder; a real robot stops when the holder is silent for the steering time-out.
#[derive(Debug)]
pub struct ControlLock {
    token: Token,
    viewers: BTreeSet<ViewerId>,
    /// Viewers that have shown the token.
    trusted: BTreeSet<ViewerId>,
    holder: Option<ViewerId>,
    /// Time of the holder's latest message; `None` before the first holder and after
    /// [`becomes_unattended`](Self::becomes_unattended).
    attended: Option<Instant>,
    next: ViewerId,
}

impl ControlLock {
    /// A free lock for viewers that know `token`.
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

    /// Adds a viewer. Returns `None` for one without the token if there are `max_watchers` of them
    /// already.
    pub fn add_viewer(&mut self, max_watchers: usize, token: Option<&str>) -> Option<ViewerId> {
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

    /// Removes a viewer and releases its lock.
    pub fn remove_viewer(&mut self, viewer: ViewerId) {
        self.viewers.remove(&viewer);
        self.trusted.remove(&viewer);
        self.release(viewer);
    }

    /// Acquires the lock; with `over` also from another viewer.
    ///
    /// # Errors
    /// [`ControlLockError`]. With the right token the viewer may stop the robot nevertheless.
    pub fn acquire(
        &mut self,
        viewer: ViewerId,
        token: &str,
        over: bool,
        now: Instant,
    ) -> Result<(), ControlLockError> {
        if !self.viewers.contains(&viewer) || !self.token.is(token) {
            return Err(ControlLockError::Token);
        }
        self.trusted.insert(viewer);
        match self.holder {
            Some(other) if other != viewer && !over => Err(ControlLockError::Taken),
            _ => {
                self.holder = Some(viewer);
                self.attended = Some(now);
                Ok(())
            }
        }
    }

    /// Releases the lock, if this viewer holds it.
    pub fn release(&mut self, viewer: ViewerId) {
        if self.holder == Some(viewer) {
            self.holder = None;
        }
    }

    /// Records a message of a viewer, which keeps the robot attended if the viewer holds the lock.
    pub fn refresh(&mut self, viewer: ViewerId, now: Instant) {
        if self.is_held_by(viewer) {
            self.attended = Some(now);
        }
    }

    /// Whether the holder has been silent or gone for `limit`. True once, until the next holder.
    pub fn becomes_unattended(&mut self, now: Instant, limit: Duration) -> bool {
        let silent = |since| now.saturating_duration_since(since) >= limit;
        let unattended = self.attended.is_some_and(silent);
        if unattended {
            self.attended = None;
        }
        unattended
    }

    /// Whether this viewer holds the lock.
    #[must_use]
    pub fn is_held_by(&self, viewer: ViewerId) -> bool {
        self.holder == Some(viewer)
    }

    /// Whether this viewer may stop the robot.
    #[must_use]
    pub fn may_stop(&self, viewer: ViewerId) -> bool {
        self.trusted.contains(&viewer)
    }

    /// Whether a viewer holds the lock.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.holder.is_some()
    }

    /// Number of viewers.
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
        let mut lock = ControlLock::new(Token::of([7; 16]));
        let mut add_viewer = || lock.add_viewer(2, None);
        let (one, two) = (add_viewer().unwrap(), add_viewer().unwrap());
        assert_eq!(add_viewer(), None);
        assert_eq!(
            lock.acquire(one, "", true, now),
            Err(ControlLockError::Token)
        );
        assert!(!lock.may_stop(one));
        assert_eq!(lock.acquire(one, &token, false, now), Ok(()));
        let refused = lock.acquire(two, &token, false, now);
        assert_eq!(refused, Err(ControlLockError::Taken));
        assert!(lock.is_held_by(one) && !lock.is_held_by(two) && lock.may_stop(two));
        assert_eq!(lock.acquire(two, &token, true, now), Ok(()));
        assert!(lock.is_held_by(two) && !lock.is_held_by(one));
        lock.release(one);
        assert!(lock.is_held());
        lock.remove_viewer(two);
        assert!(!lock.is_held() && !lock.may_stop(two));
        assert_eq!(
            lock.acquire(two, &token, true, now),
            Err(ControlLockError::Token)
        );
        assert_eq!(lock.viewers(), 1);
    }

    #[test]
    fn owners_take_no_watchers_places() {
        let token = Token::of([7; 16]);
        let mut lock = ControlLock::new(token.clone());
        let watcher = lock.add_viewer(1, None).unwrap();
        assert_eq!(lock.add_viewer(1, Some("")), None);
        let owner = lock.add_viewer(1, Some(token.as_str())).unwrap();
        assert!(lock.may_stop(owner) && !lock.may_stop(watcher));
        assert!(lock.add_viewer(1, Some(token.as_str())).is_some());
        // A watcher that shows the token becomes an owner.
        let now = Instant::now();
        assert_eq!(lock.acquire(watcher, token.as_str(), true, now), Ok(()));
        assert!(lock.add_viewer(1, None).is_some());
        assert_eq!(lock.add_viewer(1, None), None);
    }

    #[test]
    fn a_robot_is_unattended_when_its_steering_page_is_silent_or_gone() {
        let token = Token::of([7; 16]);
        let mut lock = ControlLock::new(token.clone());
        let began = Instant::now();
        let at = |ms| began + Duration::from_millis(ms);
        let limit = Duration::from_secs(2);
        let mut add_viewer = || lock.add_viewer(9, Some(token.as_str())).unwrap();
        let (one, two) = (add_viewer(), add_viewer());
        // Before the first holder nothing is lost.
        assert!(!lock.becomes_unattended(at(9_000), limit));
        assert_eq!(lock.acquire(one, token.as_str(), false, at(10_000)), Ok(()));
        lock.refresh(one, at(11_000));
        // A viewer without the lock does not count.
        lock.refresh(two, at(12_500));
        assert!(!lock.becomes_unattended(at(12_999), limit));
        assert!(lock.becomes_unattended(at(13_000), limit));
        assert!(!lock.becomes_unattended(at(20_000), limit));
        // The page returns, closes, and is opened again in time.
        lock.refresh(one, at(21_000));
        lock.remove_viewer(one);
        assert!(!lock.becomes_unattended(at(22_999), limit));
        assert_eq!(lock.acquire(two, token.as_str(), false, at(22_999)), Ok(()));
        assert!(!lock.becomes_unattended(at(24_998), limit));
        lock.remove_viewer(two);
        assert!(lock.becomes_unattended(at(24_999), limit));
    }
}
