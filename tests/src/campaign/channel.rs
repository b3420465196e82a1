//! A simulated channel that loses, duplicates, reorders and delays frames.

use super::{below, generator, happens};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::collections::BinaryHeap;

/// Fault rates of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FaultRates {
    /// Lost frames, percent.
    pub(super) lost: usize,
    /// Duplicated frames, percent of those delivered.
    pub(super) twice: usize,
    /// Shortest and longest delay, ms.
    pub(super) delay_ms: [u64; 2],
    /// Frames in a thousand that start a stall.
    pub(super) stalls: usize,
    /// Longest stall, ms: frames sent during a stall arrive at its end.
    pub(super) stall_ms: u64,
}

/// A delivered frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Arrival {
    /// Time of arrival.
    pub(super) at_ms: u64,
    /// Time of sending.
    pub(super) sent_ms: u64,
    /// Its number among the frames sent, from 0.
    pub(super) number: u64,
    /// The frame.
    pub(super) bytes: Vec<u8>,
}

impl Ord for Arrival {
    /// Reversed for a max-heap: the first to arrive is the greatest.
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        (other.at_ms, other.number).cmp(&(self.at_ms, self.number))
    }
}

impl PartialOrd for Arrival {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// A channel with its statistics.
#[derive(Debug)]
pub(super) struct LossyChannel {
    badness: FaultRates,
    /// End of the current stall.
    stalled_until_ms: u64,
    random: Xoshiro256PlusPlus,
    under_way: BinaryHeap<Arrival>,
    sent: u64,
    lost: u64,
    repeated: u64,
}

impl LossyChannel {
    pub(super) fn new(badness: FaultRates, seed: u64, part: u64) -> Self {
        Self {
            badness,
            stalled_until_ms: 0,
            random: generator(seed, part),
            under_way: BinaryHeap::new(),
            sent: 0,
            lost: 0,
            repeated: 0,
        }
    }

    /// Sends a frame; returns its number.
    pub(super) fn send(&mut self, now_ms: u64, bytes: &[u8]) -> u64 {
        let number = self.sent;
        self.sent += 1;
        if happens(&mut self.random, self.badness.lost) {
            self.lost += 1;
            return number;
        }
        if below(&mut self.random, 1_000) < self.badness.stalls {
            let stall_ms = 1 + below(&mut self.random, self.badness.stall_ms as usize) as u64;
            self.stalled_until_ms = self.stalled_until_ms.max(now_ms + stall_ms);
        }
        let again = happens(&mut self.random, self.badness.twice);
        self.repeated += u64::from(again);
        for _ in 0..1 + u32::from(again) {
            let [least, most] = self.badness.delay_ms;
            let delay_ms = least + below(&mut self.random, (most - least + 1) as usize) as u64;
            self.under_way.push(Arrival {
                at_ms: (now_ms + delay_ms).max(self.stalled_until_ms),
                sent_ms: now_ms,
                number,
                bytes: bytes.to_vec(),
            });
        }
        number
    }

    /// The next frame that has arrived by now.
    pub(super) fn next_arrival(&mut self, now_ms: u64) -> Option<Arrival> {
        let due = self
            .under_way
            .peek()
            .is_some_and(|come| come.at_ms <= now_ms);
        due.then(|| self.under_way.pop()).flatten()
    }

    /// Whether no frame is in transit.
    pub(super) fn is_empty(&self) -> bool {
        self.under_way.is_empty()
    }

    /// Frames sent.
    pub(super) const fn sent(&self) -> u64 {
        self.sent
    }

    /// Frames lost.
    pub(super) const fn lost(&self) -> u64 {
        self.lost
    }

    /// Frames duplicated.
    pub(super) const fn repeated(&self) -> u64 {
        self.repeated
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_come_in_the_order_of_their_times_and_the_book_is_right() {
        let badness = FaultRates {
            lost: 30,
            twice: 10,
            delay_ms: [2, 60],
            stalls: 0,
            stall_ms: 0,
        };
        let mut channel = LossyChannel::new(badness, 1, 0);
        for now_ms in 0..10_000 {
            assert_eq!(channel.send(now_ms, &[1]), now_ms);
        }
        let all: Vec<_> = std::iter::from_fn(|| channel.next_arrival(20_000)).collect();
        assert!(channel.is_empty() && all.is_sorted_by_key(|come| come.at_ms));
        assert!(
            !all.is_sorted_by_key(|come| come.number),
            "none was overtaken"
        );
        let late = |come: &Arrival| come.at_ms - come.sent_ms;
        assert_eq!(all.iter().map(late).min(), Some(2));
        assert_eq!(all.iter().map(late).max(), Some(60));
        let came = channel.sent() - channel.lost() + channel.repeated();
        assert_eq!(all.len() as u64, came);
        assert!((2_800..3_200).contains(&channel.lost()));
        assert!((600..800).contains(&channel.repeated()));
        assert_eq!(channel.next_arrival(20_000), None);
    }

    #[test]
    fn a_stall_holds_frames_back() {
        let badness = FaultRates {
            lost: 0,
            twice: 0,
            delay_ms: [2, 60],
            stalls: 5,
            stall_ms: 2_000,
        };
        let mut channel = LossyChannel::new(badness, 1, 0);
        for number in 0..10_000 {
            channel.send(20 * number, &[1]);
        }
        let all: Vec<_> = std::iter::from_fn(|| channel.next_arrival(u64::MAX)).collect();
        let late = all.iter().filter(|come| come.at_ms - come.sent_ms > 520);
        assert!((500..3_000).contains(&late.count()));
        assert!(all.iter().all(|come| come.at_ms - come.sent_ms <= 2_060));
    }
}
