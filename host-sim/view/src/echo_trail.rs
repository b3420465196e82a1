//! Places of echoes, shown where the surroundings are not known.

use super::history::Chunks;
use super::snapshot::{CHUNK_LENGTH, MAX_CHUNKS, PartMessage, Rounded, Xy};
use arena::sonar::RingGeometry;
use arena::world::{Point, Pose};
use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Places nearer than this count as one, m.
const CELL_M: f64 = 0.05;
/// Farther echoes are imprecise: at 2.5 m a lobe of 25° is more than a meter wide.
const MAX_RANGE_M: f64 = 2.5;

/// Places of echoes.
pub(super) struct EchoTrail {
    chunks: Chunks<Xy>,
    cells: BTreeSet<[i32; 2]>,
}

impl EchoTrail {
    /// No places.
    pub fn new() -> Self {
        Self {
            chunks: Chunks::new("heard", MAX_CHUNKS),
            cells: BTreeSet::new(),
        }
    }

    /// No places, after a restart.
    pub fn restarted(&self) -> Self {
        Self {
            chunks: self.chunks.restarted(),
            cells: BTreeSet::new(),
        }
    }

    /// Adds an echo in front of a transducer, with the ring in this pose.
    pub fn add(&mut self, ring: Pose, sensor: usize, range_m: f64) {
        if range_m > MAX_RANGE_M {
            return;
        }
        let geometry = RingGeometry::default();
        let way = Point::unit(ring.heading + sensor as f64 * TAU / geometry.count as f64);
        let place = ring.position + way * (geometry.face_radius_m + range_m);
        let cell = [place.x, place.y].map(|m| libm::floor(m / CELL_M) as i32);
        // The oldest places are discarded and may be added again.
        if self.cells.len() >= MAX_CHUNKS * CHUNK_LENGTH {
            self.cells.clear();
        }
        if self.cells.insert(cell) {
            self.chunks.push([place.x, place.y].map(Rounded));
        }
    }

    /// First and last chunk.
    pub fn ends(&self) -> [u64; 2] {
        self.chunks.ends()
    }

    /// All chunks.
    pub fn parts(&self) -> impl Iterator<Item = Arc<dyn PartMessage>> + '_ {
        self.chunks.parts()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_echo_lies_in_front_of_its_sonar_and_is_kept_once() {
        let mut trail = EchoTrail::new();
        let ring = Pose::new(Point::new(1.0, 2.0), 0.0);
        // Half a meter from the face, to the left.
        for _ in 0..2 {
            trail.add(ring, 4, 0.5);
        }
        trail.add(ring, 4, 3.0);
        let text = trail.parts().next().unwrap().text();
        assert!(text.ends_with("\"value\":[[1.0,2.7305]]}"), "{text}");
        assert!(trail.restarted().ends()[0] > trail.ends()[1]);
    }
}
