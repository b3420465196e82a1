//! The one seat from which the robot is steered.

use super::guard::Token;
use std::collections::BTreeSet;

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
            next: 1,
        }
    }

    /// Somebody comes to watch; `None` when `most` are there already.
    pub fn enter(&mut self, most: usize) -> Option<ViewerId> {
        if self.viewers.len() >= most {
            return None;
        }
        let id = self.next;
        self.next += 1;
        self.viewers.insert(id);
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
    pub fn take(&mut self, viewer: ViewerId, token: &str, over: bool) -> Result<(), SeatError> {
        if !self.viewers.contains(&viewer) || !self.token.is(token) {
            return Err(SeatError::Token);
        }
        self.trusted.insert(viewer);
        match self.holder {
            Some(other) if other != viewer && !over => Err(SeatError::Taken),
            _ => {
                self.holder = Some(viewer);
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
        let token = Token::of([7; 16]);
        let mut seat = Seat::new(token.clone());
        let (one, two) = (seat.enter(2).unwrap(), seat.enter(2).unwrap());
        assert_eq!(seat.enter(2), None);
        assert_eq!(seat.take(one, "", true), Err(SeatError::Token));
        assert!(!seat.may_stop(one));
        assert_eq!(seat.take(one, token.as_str(), false), Ok(()));
        assert_eq!(seat.take(two, token.as_str(), false), Err(SeatError::Taken));
        assert!(seat.steers(one) && !seat.steers(two) && seat.may_stop(two));
        assert_eq!(seat.take(two, token.as_str(), true), Ok(()));
        assert!(seat.steers(two) && !seat.steers(one));
        seat.rise(one);
        assert!(seat.is_taken());
        seat.leave(two);
        assert!(!seat.is_taken() && !seat.may_stop(two));
        assert_eq!(seat.take(two, token.as_str(), true), Err(SeatError::Token));
        assert_eq!(seat.viewers(), 1);
    }
}
