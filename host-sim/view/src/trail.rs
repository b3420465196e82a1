//! What only grows, in pieces that no longer change once they are full: decisions, places where something was heard.

use super::snapshot::{MAX_PIECES, Mark, PIECE, Part, Short, Showable};
use arena::world::Point;
use serde::Serialize;
use sim::episode::StepFlags;
use std::collections::VecDeque;
use std::sync::Arc;

/// Things of one kind in the order in which they came.
pub(super) struct Pieces<T> {
    name: &'static str,
    full: VecDeque<Arc<dyn Showable>>,
    last: Vec<T>,
    /// Number of the last piece.
    number: u64,
    /// Number of the first piece of this start.
    began: u64,
    /// Most full pieces that are kept.
    most: usize,
    revision: u64,
}

impl<T: Serialize + Clone + Send + Sync + 'static> Pieces<T> {
    /// Nothing yet; older things than `most` full pieces are forgotten.
    pub fn new(name: &'static str, most: usize) -> Self {
        Self {
            name,
            full: VecDeque::new(),
            last: Vec::new(),
            number: 0,
            began: 0,
            most,
            revision: 0,
        }
    }

    /// Nothing, for a new start whose pieces are not taken for those of the one before.
    pub fn afresh(&self) -> Self {
        Self {
            number: self.number + 1,
            began: self.number + 1,
            revision: self.revision + 1,
            ..Self::new(self.name, self.most)
        }
    }

    /// Adds one.
    pub fn push(&mut self, thing: T) {
        self.last.push(thing);
        self.revision += 1;
        if self.last.len() >= PIECE {
            self.fill();
        }
    }

    /// Begins a new start whose pieces are kept beside those of the ones before.
    pub fn begin(&mut self) {
        if !self.last.is_empty() {
            self.revision += 1;
            self.fill();
        }
        self.began = self.number;
    }

    fn fill(&mut self) {
        let things = std::mem::take(&mut self.last);
        let part = Part::new(self.name, self.number, self.revision, things);
        self.full.push_back(Arc::new(part));
        self.number += 1;
        if self.full.len() > self.most {
            self.full.pop_front();
            self.began = self.began.max(self.number - self.full.len() as u64);
        }
    }

    /// First piece of this start that is kept, and last piece.
    pub fn ends(&self) -> [u64; 2] {
        [self.began, self.number]
    }

    /// All pieces.
    pub fn parts(&self) -> impl Iterator<Item = Arc<dyn Showable>> + '_ {
        let last = Part::new(self.name, self.number, self.revision, self.last.clone());
        let last: Arc<dyn Showable> = Arc::new(last);
        self.full.iter().cloned().chain([last])
    }
}

/// The decisions so far.
pub(super) type Trail = Pieces<Mark>;

impl Trail {
    /// However many decisions.
    pub fn whole() -> Self {
        Self::new("trail", usize::MAX)
    }

    /// The latest six thousand decisions.
    pub fn latest() -> Self {
        Self::new("trail", MAX_PIECES)
    }
}

/// A decision that was carried out at `time_s` and ended at `place`.
pub(super) fn mark(
    time_s: f64,
    place: Point,
    seeks: bool,
    stride: StepFlags,
    neuron: Option<usize>,
    nearest_m: Option<f64>,
) -> Mark {
    let bits = [stride.touched, stride.shielded, stride.at_goal];
    let flags = bits
        .iter()
        .rev()
        .fold(0, |flags, bit| flags * 2 + u8::from(*bit));
    let neuron = neuron.and_then(|neuron| i16::try_from(neuron).ok());
    (
        Short(time_s),
        Short(place.x),
        Short(place.y),
        u8::from(seeks),
        flags,
        neuron.unwrap_or(-1),
        Short(nearest_m.unwrap_or(-1.0)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_pieces_stay_and_the_oldest_are_forgotten() {
        let mut trail = Trail::latest();
        let add = |trail: &mut Trail| {
            let stride = StepFlags {
                touched: true,
                at_goal: true,
                ..StepFlags::default()
            };
            trail.push(mark(1.0, Point::new(2.0, 3.0), true, stride, Some(4), None));
        };
        add(&mut trail);
        let text = trail.parts().next().unwrap().text();
        assert!(text.contains("[1.0,2.0,3.0,1,5,4,-1.0]"), "{text}");
        for _ in 1..PIECE * (MAX_PIECES + 2) {
            add(&mut trail);
        }
        let keys: Vec<_> = trail.parts().map(|part| part.key().1).collect();
        assert_eq!(keys.len(), MAX_PIECES + 1);
        assert_eq!([keys[0], keys[MAX_PIECES]], trail.ends());
        let next = trail.afresh();
        assert!(next.ends()[0] > trail.ends()[1]);
        assert_eq!(next.parts().count(), 1);
    }
}
