//! Bad lines, for tests.

use super::Transport;
use std::collections::VecDeque;
use std::io;
use std::time::{Duration, Instant};

/// After this time a [`Flood`] breaks.
const FLOOD_DURATION: Duration = Duration::from_secs(5);

/// A way on which whole frames get lost, at regular intervals.
pub struct Lossy<T> {
    inner: T,
    outgoing: Sieve,
    incoming: Sieve,
    ready: VecDeque<u8>,
}

/// Drops every so-manieth frame.
struct Sieve {
    every: u32,
    seen: u32,
    frame: Vec<u8>,
}

impl Sieve {
    fn new(every: u32) -> Self {
        Self {
            every,
            seen: 0,
            frame: Vec::new(),
        }
    }

    /// Takes bytes and returns the frames they complete, as far as they get through.
    fn pass(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut passed = Vec::new();
        for &byte in bytes {
            self.frame.push(byte);
            if byte != 0 {
                continue;
            }
            // A zero alone is no frame.
            let counts = self.frame.len() > 1;
            self.seen += u32::from(counts);
            if !(counts && self.every > 0 && self.seen.is_multiple_of(self.every)) {
                passed.append(&mut self.frame);
            }
            self.frame.clear();
        }
        passed
    }
}

impl<T: Transport> Lossy<T> {
    /// Loses every `outgoing`th frame on the way there and every `incoming`th on the way back; 0 = none.
    #[must_use]
    pub fn new(inner: T, outgoing: u32, incoming: u32) -> Self {
        Self {
            inner,
            outgoing: Sieve::new(outgoing),
            incoming: Sieve::new(incoming),
            ready: VecDeque::new(),
        }
    }
}

impl<T: Transport> Transport for Lossy<T> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.inner.send(&self.outgoing.pass(bytes))
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        while self.ready.is_empty() {
            let mut raw = [0; 256];
            let count = self.inner.receive(&mut raw, patience)?;
            if count == 0 {
                return Ok(0);
            }
            self.ready
                .extend(self.incoming.pass(raw.get(..count).unwrap_or(&raw)));
        }
        io::Read::read(&mut self.ready, buffer)
    }
}

/// A line at whose end nobody is. Waits take no time.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Transport for Silent {
    fn send(&mut self, _: &[u8]) -> io::Result<()> {
        Ok(())
    }

    fn receive(&mut self, _: &mut [u8], _: Duration) -> io::Result<usize> {
        Ok(0)
    }
}

/// A line whose other end never pauses: each wait brings what `say` gives, at once. It breaks after 5 s, so that even a wait
/// for its silence ends.
pub struct Flood<F> {
    say: F,
    began: Option<Instant>,
}

impl<F: FnMut() -> Vec<u8> + Send> Flood<F> {
    /// A line that brings this.
    #[must_use]
    pub fn of(say: F) -> Self {
        Self { say, began: None }
    }
}

impl<F: FnMut() -> Vec<u8> + Send> Transport for Flood<F> {
    fn send(&mut self, _: &[u8]) -> io::Result<()> {
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], _: Duration) -> io::Result<usize> {
        if self.began.get_or_insert_with(Instant::now).elapsed() > FLOOD_DURATION {
            return Err(io::Error::other("the flood is over"));
        }
        io::Read::read(&mut &*(self.say)(), buffer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_third_frame_is_lost_whole_wherever_the_bytes_are_cut() {
        let mut sieve = Sieve::new(3);
        let passed: Vec<u8> = [&[1, 1][..], &[0, 0, 2, 0, 3], &[3, 0, 4, 0]]
            .iter()
            .flat_map(|bytes| sieve.pass(bytes))
            .collect();
        assert_eq!(passed, [1, 1, 0, 0, 2, 0, 4, 0]);
        assert_eq!(Sieve::new(0).pass(&[1, 0, 2, 0]), [1, 0, 2, 0]);
    }
}
