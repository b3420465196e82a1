//! What was said last, to be said again when it was lost on the way.

use heapless::Vec;

/// Most bytes of frames kept: a decision with everything that may come with it takes half of them.
pub(super) const MOST: usize = 512;

/// The frames of the latest answer, from the first to its *Done*.
#[derive(Debug, Clone)]
pub(super) struct Kept {
    frames: Vec<u8, MOST>,
    /// The answer has begun and is not done.
    open: bool,
    /// It did not fit.
    cut: bool,
}

impl Kept {
    /// Nothing.
    pub(super) const fn new() -> Self {
        Self {
            frames: Vec::new(),
            open: false,
            cut: false,
        }
    }

    /// Forgets the answer.
    pub(super) fn clear(&mut self) {
        self.frames.clear();
        (self.open, self.cut) = (false, false);
    }

    /// A frame was accepted: unless the answer has begun already, with signs of life before it, it begins now.
    pub(super) fn begin(&mut self) {
        if !self.open {
            self.clear();
            self.open = true;
        }
    }

    /// Keeps a frame that belongs to the answer.
    pub(super) fn keep(&mut self, frame: &[u8]) {
        if self.open {
            self.cut |= self.frames.extend_from_slice(frame).is_err();
        }
    }

    /// Something has happened that no frame asked for: an answer from before it would order a motion that is over.
    pub(super) fn overtake(&mut self) {
        if !self.open {
            self.clear();
        }
    }

    /// The answer is whole.
    pub(super) const fn end(&mut self) {
        self.open = false;
    }

    /// The frames of the answer, zeros included; none if they are not all here.
    pub(super) fn frames(&self) -> impl Iterator<Item = &[u8]> {
        let kept = if self.cut || self.open {
            &[][..]
        } else {
            &self.frames
        };
        kept.split_inclusive(|byte| *byte == 0)
    }
}
