//! Bad transports, for tests.

use super::Transport;
use std::collections::VecDeque;
use std::io;
use std::time::{Duration, Instant};

/// A [`Flood`] fails after this time.
const FLOOD_DURATION: Duration = Duration::from_secs(30);

/// Loses whole frames at regular intervals.
pub struct Lossy<T> {
    inner: T,
    outgoing: FrameDropper,
    incoming: FrameDropper,
    ready: VecDeque<u8>,
}

/// Drops every n-th frame.
struct FrameDropper {
    every: u32,
    count: u32,
    frame: Vec<u8>,
}

impl FrameDropper {
    fn new(every: u32) -> Self {
        Self {
            every,
            count: 0,
            frame: Vec::new(),
        }
    }

    /// Takes bytes; returns the complete frames that are not dropped.
    fn pass(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut passed = Vec::new();
        for &byte in bytes {
            self.frame.push(byte);
            if byte != 0 {
                continue;
            }
            // A single zero is no frame.
            let is_frame = self.frame.len() > 1;
            self.count += u32::from(is_frame);
            if !(is_frame && self.every > 0 && self.count.is_multiple_of(self.every)) {
                passed.append(&mut self.frame);
            }
            self.frame.clear();
        }
        passed
    }
}

impl<T: Transport> Lossy<T> {
    /// Loses every `outgoing`th sent and every `incoming`th received frame; 0 = none.
    #[must_use]
    pub fn new(inner: T, outgoing: u32, incoming: u32) -> Self {
        Self {
            inner,
            outgoing: FrameDropper::new(outgoing),
            incoming: FrameDropper::new(incoming),
            ready: VecDeque::new(),
        }
    }
}

impl<T: Transport> Transport for Lossy<T> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.inner.send(&self.outgoing.pass(bytes))
    }

    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        while self.ready.is_empty() {
            let mut raw = [0; 256];
            let count = self.inner.receive(&mut raw, timeout)?;
            if count == 0 {
                return Ok(0);
            }
            self.ready
                .extend(self.incoming.pass(raw.get(..count).unwrap_or(&raw)));
        }
        io::Read::read(&mut self.ready, buffer)
    }
}

/// Never answers. Waits take no time.
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

/// Never stops sending: each wait returns the bytes of `source` at once. It fails after 30 s, so a
/// test that waits for silence ends, with another error.
pub struct Flood<F> {
    source: F,
    began: Option<Instant>,
}

impl<F: FnMut() -> Vec<u8> + Send> Flood<F> {
    /// Sends the bytes of `source`.
    #[must_use]
    pub fn of(source: F) -> Self {
        Self {
            source,
            began: None,
        }
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
        io::Read::read(&mut &*(self.source)(), buffer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_third_frame_is_lost_whole_wherever_the_bytes_are_cut() {
        let mut dropper = FrameDropper::new(3);
        let passed: Vec<u8> = [&[1, 1][..], &[0, 0, 2, 0, 3], &[3, 0, 4, 0]]
            .iter()
            .flat_map(|bytes| dropper.pass(bytes))
            .collect();
        assert_eq!(passed, [1, 1, 0, 0, 2, 0, 4, 0]);
        assert_eq!(FrameDropper::new(0).pass(&[1, 0, 2, 0]), [1, 0, 2, 0]);
    }
}
