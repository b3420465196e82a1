//! The decisions so far, in pieces that no longer change once they are full.

use crate::episode::Stride;
use crate::view::snapshot::{MOST_PIECES, Mark, PIECE, Part, Short, Showable};
use crate::world::Point;
use std::collections::VecDeque;
use std::sync::Arc;

/// The trail of one start; older decisions than the last six thousand are forgotten.
#[derive(Default)]
pub(super) struct Trail {
    full: VecDeque<Arc<dyn Showable>>,
    last: Vec<Mark>,
    /// Number of the last piece.
    number: u64,
    /// Number of the first piece of this start.
    began: u64,
    revision: u64,
}

impl Trail {
    /// A trail for a new start, whose pieces are not taken for those of the one before.
    pub fn afresh(&self) -> Self {
        Self {
            number: self.number + 1,
            began: self.number + 1,
            revision: self.revision + 1,
            ..Self::default()
        }
    }

    /// Adds a decision that was carried out at `time_s` and ended at `place`.
    pub fn mark(
        &mut self,
        time_s: f64,
        place: Point,
        seeks: bool,
        stride: Stride,
        neuron: Option<usize>,
        nearest_m: Option<f64>,
    ) {
        let bits = [stride.touched, stride.shielded, stride.at_goal];
        let flags = bits
            .iter()
            .rev()
            .fold(0, |flags, bit| flags * 2 + u8::from(*bit));
        let neuron = neuron.and_then(|neuron| i16::try_from(neuron).ok());
        self.last.push((
            Short(time_s),
            Short(place.x),
            Short(place.y),
            u8::from(seeks),
            flags,
            neuron.unwrap_or(-1),
            Short(nearest_m.unwrap_or(-1.0)),
        ));
        self.revision += 1;
        if self.last.len() >= PIECE {
            let part = Part::new(
                "trail",
                self.number,
                self.revision,
                std::mem::take(&mut self.last),
            );
            self.full.push_back(Arc::new(part));
            self.number += 1;
            if self.full.len() > MOST_PIECES {
                self.full.pop_front();
                self.began = self.began.max(self.number - self.full.len() as u64);
            }
        }
    }

    /// First and last piece that are kept.
    pub fn ends(&self) -> [u64; 2] {
        [self.began, self.number]
    }

    /// All pieces.
    pub fn parts(&self) -> impl Iterator<Item = Arc<dyn Showable>> + '_ {
        let last = Part::new("trail", self.number, self.revision, self.last.clone());
        let last: Arc<dyn Showable> = Arc::new(last);
        self.full.iter().cloned().chain([last])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_pieces_stay_and_the_oldest_are_forgotten() {
        let mut trail = Trail::default();
        let mark = |trail: &mut Trail| {
            let stride = Stride {
                touched: true,
                at_goal: true,
                ..Stride::default()
            };
            trail.mark(1.0, Point::new(2.0, 3.0), true, stride, Some(4), None);
        };
        mark(&mut trail);
        let text = trail.parts().next().unwrap().text();
        assert!(text.contains("[1.0,2.0,3.0,1,5,4,-1.0]"), "{text}");
        for _ in 1..PIECE * (MOST_PIECES + 2) {
            mark(&mut trail);
        }
        let keys: Vec<_> = trail.parts().map(|part| part.key().1).collect();
        assert_eq!(keys.len(), MOST_PIECES + 1);
        assert_eq!([keys[0], keys[MOST_PIECES]], trail.ends());
        let next = trail.afresh();
        assert!(next.ends()[0] > trail.ends()[1]);
        assert_eq!(next.parts().count(), 1);
    }
}
