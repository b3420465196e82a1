//! What lies around the places where a robot has been: each is looked at once and kept for when it comes again.

use std::sync::Arc;

use super::World;
use super::geometry::Point;
use super::surfaces::Surfaces;
use super::surroundings::Surroundings;

/// So many are kept besides the present one: enough for a hall of 100 m².
const MOST: usize = 128;

/// The surroundings of places in one world.
#[derive(Debug, Clone, Default)]
pub(super) struct Neighborhoods {
    of: Option<Arc<Surfaces>>,
    /// How many worlds there have been.
    worlds: u64,
    pub here: Surroundings,
    elsewhere: Vec<Surroundings>,
    /// Which one gives way next.
    oldest: usize,
}

impl Neighborhoods {
    /// Makes `here` ready for eyes which are at most `offset_m` from `middle` and see `reach_m` far: it holds all circles
    /// afterwards.
    #[inline]
    pub fn look(&mut self, world: &World, middle: Point, offset_m: f64, reach_m: f64) {
        let same = self.is_of(world);
        if !(same && self.here.holds(middle, offset_m, reach_m)) {
            self.go(world, same, middle, offset_m, reach_m);
        }
    }

    fn is_of(&self, world: &World) -> bool {
        let of = self.of.as_ref();
        of.is_some_and(|of| Arc::ptr_eq(of, &world.surfaces))
    }

    #[cold]
    fn go(&mut self, world: &World, same: bool, middle: Point, offset_m: f64, reach_m: f64) {
        if !same {
            self.worlds += 1;
            self.elsewhere.clear();
        } else if let Some(known) = known(&mut self.elsewhere, middle, offset_m, reach_m) {
            std::mem::swap(&mut self.here, known);
            return;
        } else if self.elsewhere.len() < MOST {
            self.elsewhere.push(std::mem::take(&mut self.here));
        } else if let Some(oldest) = self.elsewhere.get_mut(self.oldest) {
            std::mem::swap(&mut self.here, oldest);
            self.oldest = (self.oldest + 1) % MOST;
        }
        let surfaces = Arc::clone(&world.surfaces);
        self.here.begin(&surfaces, middle, offset_m, reach_m);
        self.of = Some(surfaces);
    }

    /// All that stands still in the world.
    pub fn surfaces(&self) -> Option<&Surfaces> {
        self.of.as_deref()
    }

    /// Another number whenever the world is another one.
    pub fn worlds(&self) -> u64 {
        self.worlds
    }

    /// Here the faces are known up to `far_m` from the middle afterwards, and perhaps more.
    #[inline]
    pub fn know_faces(&mut self, far_m: f64) {
        if let Some(surfaces) = &self.of {
            self.here.know_faces(surfaces, far_m);
        }
    }

    /// Here the corners are known as far as the faces afterwards.
    #[inline]
    pub fn know_corners(&mut self) {
        if let Some(surfaces) = &self.of {
            self.here.know_corners(surfaces);
        }
    }
}

/// Of those that will do, the one whose middle is nearest.
fn known(
    kept: &mut [Surroundings],
    middle: Point,
    offset_m: f64,
    reach_m: f64,
) -> Option<&mut Surroundings> {
    let known = kept.iter_mut();
    known
        .filter(|known| known.holds(middle, offset_m, reach_m))
        .min_by(|a, b| a.apart_m(middle).total_cmp(&b.apart_m(middle)))
}
