//! The frames of the latest answer, sent again when the host repeats its request. It never holds
//! part of an answer.

use heapless::Vec;

/// Most bytes of a cached answer: a decision with everything that comes with it takes half of them.
pub(super) const MAX_BYTES: usize = 512;

/// The frames of the latest answer, from the first to its *Done*.
#[derive(Debug, Clone)]
pub(super) struct ReplyCache {
    frames: Vec<u8, MAX_BYTES>,
    /// The answer has begun and its *Done* has not been sent.
    open: bool,
    /// The answer did not fit.
    overflowed: bool,
}

impl ReplyCache {
    /// An empty cache.
    pub(super) const fn new() -> Self {
        Self {
            frames: Vec::new(),
            open: false,
            overflowed: false,
        }
    }

    /// Forgets the answer.
    pub(super) fn clear(&mut self) {
        self.frames.clear();
        (self.open, self.overflowed) = (false, false);
    }

    /// A frame was accepted: its answer begins now. After a sign of life, which has no *Done*, it
    /// has begun already.
    pub(super) fn begin(&mut self) {
        if !self.open {
            self.clear();
            self.open = true;
        }
    }

    /// Adds a frame of the answer.
    pub(super) fn push(&mut self, frame: &[u8]) {
        if self.open {
            self.overflowed |= self.frames.extend_from_slice(frame).is_err();
        }
    }

    /// Forgets a finished answer: the robot has moved on by itself, and the cached frames would
    /// order a motion that is over.
    pub(super) fn invalidate(&mut self) {
        if !self.open {
            self.clear();
        }
    }

    /// The answer is complete.
    pub(super) const fn finish(&mut self) {
        self.open = false;
    }

    /// The frames of the answer, zeros included; none if the answer is not complete.
    pub(super) fn frames(&self) -> impl Iterator<Item = &[u8]> {
        let frames = if self.overflowed || self.open {
            &[][..]
        } else {
            &self.frames
        };
        frames.split_inclusive(|byte| *byte == 0)
    }
}
