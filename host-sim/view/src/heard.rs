//! Where something was heard: what is shown of surroundings nobody has described.

use super::snapshot::{MAX_PIECES, PIECE, Short, Showable, Xy};
use super::trail::Pieces;
use arena::sonar::RingGeometry;
use arena::world::{Point, Pose};
use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Places nearer to each other than this are one, m.
const CELL_M: f64 = 0.05;
/// Echoes from farther away say little about where: at 2.5 m a lobe of 25° is more than a meter wide.
const FARTHEST_M: f64 = 2.5;

/// The places.
pub(super) struct Heard {
    pieces: Pieces<Xy>,
    cells: BTreeSet<[i32; 2]>,
}

impl Heard {
    /// Nothing yet.
    pub fn new() -> Self {
        Self {
            pieces: Pieces::new("heard", MAX_PIECES),
            cells: BTreeSet::new(),
        }
    }

    /// Nothing, after what was there.
    pub fn afresh(&self) -> Self {
        Self {
            pieces: self.pieces.afresh(),
            cells: BTreeSet::new(),
        }
    }

    /// A sonar heard something in front of its face, with the ring in this pose.
    pub fn hear(&mut self, ring: Pose, sensor: usize, range_m: f64) {
        if range_m > FARTHEST_M {
            return;
        }
        let geometry = RingGeometry::default();
        let way = Point::unit(ring.heading + sensor as f64 * TAU / geometry.count as f64);
        let place = ring.position + way * (geometry.face_radius_m + range_m);
        let cell = [place.x, place.y].map(|m| libm::floor(m / CELL_M) as i32);
        // The oldest are forgotten, and may be heard again.
        if self.cells.len() >= MAX_PIECES * PIECE {
            self.cells.clear();
        }
        if self.cells.insert(cell) {
            self.pieces.push([place.x, place.y].map(Short));
        }
    }

    /// First and last piece.
    pub fn ends(&self) -> [u64; 2] {
        self.pieces.ends()
    }

    /// All pieces.
    pub fn parts(&self) -> impl Iterator<Item = Arc<dyn Showable>> + '_ {
        self.pieces.parts()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_echo_lies_in_front_of_its_sonar_and_is_kept_once() {
        let mut heard = Heard::new();
        let ring = Pose::new(Point::new(1.0, 2.0), 0.0);
        // To the left, half a meter from the face.
        for _ in 0..2 {
            heard.hear(ring, 4, 0.5);
        }
        heard.hear(ring, 4, 3.0);
        let text = heard.parts().next().unwrap().text();
        assert!(text.ends_with("\"value\":[[1.0,2.7305]]}"), "{text}");
        assert!(heard.afresh().ends()[0] > heard.ends()[1]);
    }
}
