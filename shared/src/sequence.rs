//! Sequences of patterns, recalled one after the other by a pair of associative memories.
//!
//! The paper's section 4 names M. Lawrence, T. Trappenberg and A. Fine, "Rapid learning and robust
//! recall of long sequences in modular associator networks", *Neurocomputing* 69, 2006, 634–641,
//! after J. Lisman, *Neuron* 22, 1999, 233–242. Two recurrent auto-associative networks hold the
//! elements. The synapses on the way from the first to the second are trained
//! hetero-associatively, from an element to its successor; the way back is one to one. The first
//! network converges to the present element, its output makes the second one converge to the next.
//!
//! # What was changed
//!
//! Both networks store the same elements, so they have the same weights, which are stored once.
//! Bits are ±1 and change in a fixed order, each by the sign of its field (J. J. Hopfield, *PNAS*
//! 79, 1982); a field of 0 leaves the bit. No bit feeds itself in the auto-associative network: the
//! diagonal is zero. There is no other threshold than 0.
//!
//! | rule | weights | needs |
//! | --- | --- | --- |
//! | Hebb ([`SequenceMemory::learn`]) | `w[i][j] += to[i]·from[j]` | each element once, alone |
//! | corrected ([`SequenceMemory::correct`]) | the same where `to[i]·field[i] < N` | all elements, several times |
//!
//! The second is the local rule of S. Diederich and M. Opper, *Physical Review Letters* 58, 1987:
//! a perceptron with a margin. It tells elements apart that have most of their bits in common, as
//! situations of a robot have; Hebb's rule takes them all for their mean.
//!
//! # Cost
//!
//! 2·N² bytes: 8 KiB for 64 bits, 32 KiB for 128. To learn an element takes 2·N² additions, a round
//! of completion and a step to the successor N² multiplications and additions each. The firmware
//! does not call this module.
//!
//! # Limits
//!
//! An element has one successor: after one that occurs in two sequences, the recall cannot know
//! which it is in. Weights saturate at ±127, so Hebb's rule holds at most 127 elements exactly.

mod associations;
mod pattern;

pub use pattern::Pattern;

use associations::Associations;

/// Rounds of completion, at most. Hebb's weights are symmetric, so they converge; corrected ones
/// need not.
pub const MAX_ROUNDS: u8 = 16;

/// What follows the last element of a sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// Itself: the recall ends there.
    Stays,
    /// The first one: a patrol.
    Returns,
}

/// A cue that was completed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Completion<const N: usize> {
    /// The element, or a mixture of elements.
    pub pattern: Pattern<N>,
    /// Rounds in which bits changed, at most [`MAX_ROUNDS`].
    pub rounds: u8,
    /// No bit would change any more.
    pub has_converged: bool,
}

/// A pair of associative memories over `N` bits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SequenceMemory<const N: usize> {
    /// Of both networks.
    elements: Associations<N>,
    /// On the way from the first network to the second.
    successors: Associations<N>,
}

impl<const N: usize> Default for SequenceMemory<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> SequenceMemory<N> {
    /// Nothing is stored.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            elements: Associations::new(),
            successors: Associations::new(),
        }
    }

    /// Stores one element by Hebb's rule.
    pub fn store(&mut self, element: &Pattern<N>) {
        self.elements.associate(element, element);
        self.elements.clear_diagonal();
    }

    /// Stores by Hebb's rule that `to` follows `from`; both are to be stored as elements.
    pub fn link(&mut self, from: &Pattern<N>, to: &Pattern<N>) {
        self.successors.associate(from, to);
    }

    /// Stores a sequence by Hebb's rule, one element after the other.
    pub fn learn(&mut self, sequence: &[Pattern<N>], end: End) {
        for element in sequence {
            self.store(element);
        }
        for (from, to) in links(sequence, end) {
            self.link(from, to);
        }
    }

    /// Presents a learned sequence once more and corrects what is not recalled with the margin
    /// `N`. Returns the number of bits that it corrected: 0 when nothing is left to learn. Several
    /// sequences are to be presented in turn.
    pub fn correct(&mut self, sequence: &[Pattern<N>], end: End) -> u32 {
        let mut corrected = 0_u32;
        for element in sequence {
            let bits = self.elements.correct(element, element);
            corrected = corrected.saturating_add(bits);
            self.elements.clear_diagonal();
        }
        for (from, to) in links(sequence, end) {
            let bits = self.successors.correct(from, to);
            corrected = corrected.saturating_add(bits);
        }
        corrected
    }

    /// The first network: the element that a cue belongs to.
    #[must_use]
    pub fn complete(&self, cue: &Pattern<N>) -> Completion<N> {
        let mut pattern = *cue;
        for rounds in 0..MAX_ROUNDS {
            if !self.elements.settle(&mut pattern) {
                return Completion {
                    pattern,
                    rounds,
                    has_converged: true,
                };
            }
        }
        Completion {
            pattern,
            rounds: MAX_ROUNDS,
            has_converged: false,
        }
    }

    /// What the synapses on the way to the second network make of an element: its successor, not
    /// completed.
    #[must_use]
    pub fn successor(&self, element: &Pattern<N>) -> Pattern<N> {
        self.successors.output(element)
    }

    /// A whole step: the cue is completed, its successor follows and is completed by the second
    /// network.
    #[must_use]
    pub fn step(&self, cue: &Pattern<N>) -> Pattern<N> {
        let element = self.complete(cue).pattern;
        self.complete(&self.successor(&element)).pattern
    }

    /// The element that a cue belongs to, and the rest of its sequence. It ends at an element that
    /// follows itself. A patrol has no end: take as many as are needed.
    #[must_use]
    pub fn recall(&self, cue: &Pattern<N>) -> Recall<'_, N> {
        Recall {
            memory: self,
            next: Some(self.complete(cue).pattern),
        }
    }
}

/// A sequence that is recalled; each step takes at most 2·[`MAX_ROUNDS`] rounds.
#[derive(Debug, Clone)]
pub struct Recall<'m, const N: usize> {
    memory: &'m SequenceMemory<N>,
    next: Option<Pattern<N>>,
}

impl<const N: usize> Iterator for Recall<'_, N> {
    type Item = Pattern<N>;

    fn next(&mut self) -> Option<Pattern<N>> {
        let element = self.next?;
        let following = self.memory.step(&element);
        self.next = (following != element).then_some(following);
        Some(element)
    }
}

/// All pairs of an element and what follows it.
fn links<const N: usize>(
    sequence: &[Pattern<N>],
    end: End,
) -> impl Iterator<Item = (&Pattern<N>, &Pattern<N>)> {
    let after_last = match end {
        End::Stays => sequence.last(),
        End::Returns => sequence.first(),
    };
    sequence
        .iter()
        .zip(sequence.iter().skip(1).chain(after_last))
}

#[cfg(test)]
mod tests;
