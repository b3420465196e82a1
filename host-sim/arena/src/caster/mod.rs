//! The caster: intersections of rays, cones and moving discs with the surfaces of a world.
//!
//! [`Caster`] is its interface. Bounding-box trees limit each query to near surfaces. Queries share
//! no state, except that a [`LobeView`] caches the surroundings of its transducer.

use std::sync::Arc;

use crate::geometry::{Point, min};
use crate::shapes::Shape;
use crate::surfaces::{Circle, Distance, FaceBlock, LANES, Surfaces};

mod answer;
mod candidates;
mod cone;
mod lobe;
mod ray;
mod seen;
mod sweep;
#[cfg(test)]
mod tests;

pub(crate) use answer::Fan;
pub use cone::{ConeShape, ConeView};
pub(crate) use lobe::LobeView;
pub use ray::{Hit, Surface};
pub(crate) use seen::{LobeHit, SonarLobe};
pub use sweep::{Sweep, TOUCH_SLACK_M};
#[cfg(test)]
pub(crate) use {
    cone::circle_in_cone,
    sweep::{Path, touch_circle, touch_face},
};

/// The surfaces of a world, prepared for queries. Clones share the surfaces that do not move.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Caster {
    still: Arc<Surfaces>,
    /// Movable posts, numbered after the fixed circles.
    posts: Vec<Circle>,
}

impl Caster {
    /// A caster for `shapes`.
    pub fn new(shapes: &[Shape]) -> Self {
        Self {
            still: Arc::new(Surfaces::of(shapes)),
            posts: Vec::new(),
        }
    }

    /// Adds a post that [can be moved](Caster::move_post).
    pub fn add_post(&mut self, center: Point, radius: f64) {
        let index = self.still.circles().len() + self.posts.len();
        self.posts.push(Circle::new(center, radius, index));
    }

    /// Moves the post added last. Returns whether there is one.
    pub fn move_post(&mut self, to: Point) -> bool {
        let last = self.posts.last_mut();
        last.map(|post| post.center = to).is_some()
    }

    /// Distance from `point` to the nearest surface, m, never negative.
    pub fn clearance(&self, point: Point) -> f64 {
        let still = self.still.nearest(point, 0.0, &FromPoint(point));
        self.posts
            .iter()
            .fold(still, |nearest, post| min(nearest, post.distance(point)))
    }

    /// Moves a disc of `radius` m straight `from` one point towards another, up to its first
    /// contact.
    pub fn sweep(&self, from: Point, to: Point, radius: f64) -> Sweep {
        sweep::sweep(&self.still, &self.posts, [from, to], radius)
    }

    /// The first hit of a ray from `origin` along the unit vector `direction`.
    pub fn cast(&self, origin: Point, direction: Point) -> Option<Hit> {
        ray::cast(&self.still, &self.posts, origin, direction)
    }

    /// The surfaces for queries with cones around `middle`. Their tips are `offset_m` from it along
    /// their axes, and they reach `reach_m` from there.
    pub fn view(&self, middle: Point, offset_m: f64, reach_m: f64) -> ConeView {
        ConeView::new(&self.still, &self.posts, middle, offset_m, reach_m)
    }

    /// Aims a view at a lobe: collects the surfaces that the sound of one transducer can hit.
    pub fn aim(&self, view: &mut LobeView, lobe: &SonarLobe) {
        view.aim(&self.still, &self.posts, lobe);
    }

    /// Whether both have the same surfaces and none of them can move.
    pub fn is_same_still(&self, other: &Self) -> bool {
        let posts = self.posts.len() + other.posts.len();
        posts == 0 && Arc::ptr_eq(&self.still, &other.still)
    }
}

/// Distances from a point.
struct FromPoint(Point);

impl Distance for FromPoint {
    fn to_faces(&self, block: &FaceBlock) -> [f64; LANES] {
        block.distances_squared(self.0)
    }

    fn to_circle(&self, circle: &Circle) -> f64 {
        circle.distance(self.0)
    }
}
