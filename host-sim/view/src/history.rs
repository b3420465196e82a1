//! Growing lists in chunks: a full chunk never changes, so it is sent once.

use super::snapshot::{CHUNK_LENGTH, HistoryEntry, MAX_CHUNKS, PartMessage, Rounded, SnapshotPart};
use arena::world::Point;
use serde::Serialize;
use sim::episode::StepFlags;
use std::collections::VecDeque;
use std::sync::Arc;

/// Items of one kind in order of arrival.
pub(super) struct Chunks<T> {
    name: &'static str,
    full: VecDeque<Arc<dyn PartMessage>>,
    last: Vec<T>,
    /// Number of the last chunk.
    number: u64,
    /// Number of the first chunk since the start.
    began: u64,
    /// Maximum number of full chunks; older ones are discarded.
    max_full: usize,
    revision: u64,
}

impl<T: Serialize + Clone + Send + Sync + 'static> Chunks<T> {
    /// An empty list of at most `max_full` full chunks.
    pub fn new(name: &'static str, max_full: usize) -> Self {
        Self {
            name,
            full: VecDeque::new(),
            last: Vec::new(),
            number: 0,
            began: 0,
            max_full,
            revision: 0,
        }
    }

    /// An empty list after a restart; its chunk numbers continue, so they are not confused.
    pub fn restarted(&self) -> Self {
        Self {
            number: self.number + 1,
            began: self.number + 1,
            revision: self.revision + 1,
            ..Self::new(self.name, self.max_full)
        }
    }

    /// Adds an item.
    pub fn push(&mut self, item: T) {
        self.last.push(item);
        self.revision += 1;
        if self.last.len() >= CHUNK_LENGTH {
            self.fill();
        }
    }

    /// Begins a new start; the chunks of earlier ones stay.
    pub fn begin(&mut self) {
        if !self.last.is_empty() {
            self.revision += 1;
            self.fill();
        }
        self.began = self.number;
    }

    fn fill(&mut self) {
        let items = std::mem::take(&mut self.last);
        let part = SnapshotPart::new(self.name, self.number, self.revision, items);
        self.full.push_back(Arc::new(part));
        self.number += 1;
        if self.full.len() > self.max_full {
            self.full.pop_front();
            self.began = self.began.max(self.number - self.full.len() as u64);
        }
    }

    /// First chunk since the start, and last chunk.
    pub fn ends(&self) -> [u64; 2] {
        [self.began, self.number]
    }

    /// All chunks.
    pub fn parts(&self) -> impl Iterator<Item = Arc<dyn PartMessage>> + '_ {
        let last = SnapshotPart::new(self.name, self.number, self.revision, self.last.clone());
        let last: Arc<dyn PartMessage> = Arc::new(last);
        self.full.iter().cloned().chain([last])
    }
}

/// The decisions so far.
pub(super) type History = Chunks<HistoryEntry>;

impl History {
    /// Keeps all decisions.
    pub fn whole() -> Self {
        Self::new("trail", usize::MAX)
    }

    /// Keeps the latest 6400 decisions.
    pub fn latest() -> Self {
        Self::new("trail", MAX_CHUNKS)
    }
}

/// The entry of a decision that ended at `time_s` at `place`.
pub(super) fn history_entry(
    time_s: f64,
    place: Point,
    seeking: bool,
    flags: StepFlags,
    neuron: Option<usize>,
    nearest_m: Option<f64>,
) -> HistoryEntry {
    let bits = [flags.touched, flags.shielded, flags.at_goal];
    let flags = bits
        .iter()
        .rev()
        .fold(0, |flags, bit| flags * 2 + u8::from(*bit));
    let neuron = neuron.and_then(|neuron| i16::try_from(neuron).ok());
    (
        Rounded(time_s),
        Rounded(place.x),
        Rounded(place.y),
        u8::from(seeking),
        flags,
        neuron.unwrap_or(-1),
        Rounded(nearest_m.unwrap_or(-1.0)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_chunks_stay_and_the_oldest_are_discarded() {
        let mut trail = History::latest();
        let add = |trail: &mut History| {
            let flags = StepFlags {
                touched: true,
                at_goal: true,
                ..StepFlags::default()
            };
            trail.push(history_entry(
                1.0,
                Point::new(2.0, 3.0),
                true,
                flags,
                Some(4),
                None,
            ));
        };
        add(&mut trail);
        let text = trail.parts().next().unwrap().text();
        assert!(text.contains("[1.0,2.0,3.0,1,5,4,-1.0]"), "{text}");
        for _ in 1..CHUNK_LENGTH * (MAX_CHUNKS + 2) {
            add(&mut trail);
        }
        let keys: Vec<_> = trail.parts().map(|part| part.key().1).collect();
        assert_eq!(keys.len(), MAX_CHUNKS + 1);
        assert_eq!([keys[0], keys[MAX_CHUNKS]], trail.ends());
        let next = trail.restarted();
        assert!(next.ends()[0] > trail.ends()[1]);
        assert_eq!(next.parts().count(), 1);
    }
}
