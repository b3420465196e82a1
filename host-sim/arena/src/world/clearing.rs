//! What a disc on its way may touch or come nearest to: found once for a whole neighborhood, used as long as the disc stays.
//!
//! Distance changes by no more than the way gone (it is 1-Lipschitz; what J. C. Hart, *Sphere tracing*, The Visual Computer
//! 12, 1996, steps along rays by): a disc that is farther from everything than it can have come since needs no look.

use std::sync::Arc;

use super::World;
use super::faces::{FaceBlock, Faces, LANES, max, min};
use super::geometry::Point;
use super::surfaces::{Circle, Surfaces};
use super::sweep::{Path, Sweep, touch_circle, touch_face};
use super::tree::SLACK_M;

/// Paths that stay within this distance of where the clearing was looked at need no new look, m.
const ROOM_M: f64 = 0.2;

/// The same of the spot within the clearing: a few strides of 10 ms.
const SPOT_M: f64 = 0.05;

/// So few faces are faster looked at one by one than as a block.
const FEW: usize = 3;

/// The surfaces that can be the nearest to, or touched by, a disc near one place. Reusable; whatever it held before, its
/// answers are those of [`World::sweep`] and [`World::clearance`], to the bit.
#[derive(Debug, Clone, Default)]
pub struct Clearing {
    of: Option<Arc<Surfaces>>,
    wide: Near,
    /// What matters nearer by, taken from the wide one.
    spot: Near,
    /// Where the disc stood last, and its distance from what does not move.
    stood: Option<(Point, f64)>,
    /// Gaps from here on need not be told, m.
    told_below: Option<f64>,
    /// A place and a distance, m, within which nothing stands.
    free: Option<(Point, f64)>,
}

/// What matters within some room.
#[derive(Debug, Clone, Default)]
struct Near {
    middle: Point,
    /// Nothing is known while this is 0.
    room: f64,
    radius: f64,
    faces: Faces,
    circles: Vec<Circle>,
}

/// Two clearings differ only in what they have looked at already.
impl PartialEq for Clearing {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Clearing {
    /// From now on gaps between disc and surfaces of so much or more need not be told: they may be told as infinite.
    pub fn tell_below(&mut self, gap: f64) {
        self.told_below = Some(gap);
    }

    /// Whether it is known, without a look, that the disc touches nothing on its way and that no gap on it is to be told.
    /// What a disc has traveled brings it nearer to things by no more than that.
    #[inline]
    pub fn is_far(&self, world: &World, from: Point, to: Point, radius: f64) -> bool {
        let (Some(told), Some((place, free))) = (self.told_below, self.free) else {
            return false;
        };
        let left = free - radius - max(told, 0.0) - SLACK_M;
        let inside = |at: Point| (at - place).dot(at - place) <= left * left;
        left > 0.0
            && inside(from)
            && inside(to)
            && self.knows(&world.surfaces)
            && world.posts.is_empty()
    }

    /// The same, after a look if that may help.
    #[inline]
    pub fn is_far_on_look(&mut self, world: &World, from: Point, to: Point, radius: f64) -> bool {
        if self.is_far(world, from, to, radius) {
            return true;
        }
        if self.told_below.is_none() || !world.posts.is_empty() {
            return false;
        }
        self.look_around(world, from, radius);
        self.is_far(world, from, to, radius)
    }

    /// Finds how far the nearest thing is: not at all from within a circle, unlike [`Clearing::clearance`].
    fn look_around(&mut self, world: &World, place: Point, radius: f64) {
        self.know(&world.surfaces);
        if !self.wide.holds(place, place, radius) {
            self.wide.begin(place, place, radius, ROOM_M);
            self.wide.find(&world.surfaces);
        }
        let here = Path::between(place, place);
        self.free = Some((place, self.wide.distance_to_path(&here, &[])));
    }

    fn knows(&self, surfaces: &Arc<Surfaces>) -> bool {
        self.of.as_ref().is_some_and(|of| Arc::ptr_eq(of, surfaces))
    }

    /// As [`World::sweep`], but for gaps that [need not be told](Clearing::tell_below).
    pub fn sweep(&mut self, world: &World, from: Point, to: Point, radius: f64) -> Sweep {
        if self.is_far(world, from, to, radius) {
            return Sweep {
                traveled_m: from.distance(to),
                contact: None,
                min_clearance_m: f64::INFINITY,
            };
        }
        self.look(world, from, to, radius);
        let path = Path::between(from, to);
        let nearest = self.spot.distance_to_path(&path, &world.posts);
        self.free = Some((to, nearest));
        let free = Sweep {
            traveled_m: path.length,
            contact: None,
            min_clearance_m: (nearest - radius).max(0.0),
        };
        if !path.is_touched_at(nearest, radius) {
            return free;
        }
        match self.spot.first_touch(&path, radius, &world.posts) {
            None => free,
            Some((way, contact)) => Sweep {
                traveled_m: min(way, path.length),
                contact: Some(contact),
                min_clearance_m: 0.0,
            },
        }
    }

    /// As [`World::clearance`].
    pub fn clearance(&mut self, world: &World, point: Point) -> f64 {
        self.look(world, point, point, 0.0);
        let known = self.stood.filter(|(place, _)| *place == point);
        let still = known.map_or_else(|| self.spot.distance(point), |(_, distance)| distance);
        self.stood = Some((point, still));
        self.free = self.stood;
        let posts = world.posts.iter();
        posts.fold(still, |nearest, post| min(nearest, post.distance(point)))
    }

    /// Forgets what it knows of other surfaces.
    fn know(&mut self, surfaces: &Arc<Surfaces>) {
        if !self.knows(surfaces) {
            *self = Self {
                of: Some(Arc::clone(surfaces)),
                told_below: self.told_below,
                ..Self::default()
            };
        }
    }

    /// Holds all that matters to a path afterwards.
    fn look(&mut self, world: &World, from: Point, to: Point, radius: f64) {
        self.know(&world.surfaces);
        if self.spot.holds(from, to, radius) {
            return;
        }
        self.spot.begin(from, to, radius, SPOT_M);
        if !self.wide.covers(&self.spot) {
            self.wide.begin(from, to, radius, ROOM_M);
            self.wide.find(&world.surfaces);
        }
        self.spot.choose(&self.wide);
    }
}

impl Near {
    /// Whether all that matters to a path is here.
    fn holds(&self, from: Point, to: Point, radius: f64) -> bool {
        let inside = |place: Point| {
            let offset = place - self.middle;
            offset.dot(offset) <= self.room * self.room
        };
        self.room > 0.0 && radius <= self.radius && inside(from) && inside(to)
    }

    /// Whether all that matters in another's room is here.
    fn covers(&self, other: &Self) -> bool {
        let apart = self.middle.distance(other.middle);
        other.radius <= self.radius && apart + other.room <= self.room
    }

    /// Begins anew around a path, with room for more as long as it is short: a long one is looked at from its middle, for
    /// itself; the next ones will be elsewhere.
    fn begin(&mut self, from: Point, to: Point, radius: f64, room: f64) {
        let half = from.distance(to) / 2.0;
        (self.middle, self.room) = if half > room / 4.0 {
            // A little more than the rounding of the middle.
            ((from + to) * 0.5, half + SLACK_M)
        } else {
            (from, room)
        };
        self.radius = radius;
        self.faces.clear();
        self.circles.clear();
    }

    /// How far from the middle lies what matters, m, where the nearest thing lies so far: whatever is nearest to a place in
    /// the room is no farther from it than this is, and so no farther from the middle than twice the room more.
    fn reach(&self, nearest: f64) -> f64 {
        max(nearest + 2.0 * self.room, self.radius + self.room) + SLACK_M
    }

    fn find(&mut self, surfaces: &Surfaces) {
        let reach = self.reach(surfaces.distance(self.middle));
        surfaces.faces_near(self.middle, reach, |block| {
            self.faces.keep(block, self.middle, reach)
        });
        surfaces.circles_near(self.middle, reach, |circle| {
            // What it lies in counts too, however deep.
            if self.middle.distance(circle.center) - circle.radius <= reach {
                self.circles.push(*circle);
            }
        });
    }

    /// Takes from a wider one, which covers it, what matters here.
    fn choose(&mut self, wide: &Self) {
        let reach = self.reach(wide.distance(self.middle));
        for block in &wide.faces.blocks {
            self.faces.keep(block, self.middle, reach);
        }
        let near = |circle: &&Circle| self.middle.distance(circle.center) - circle.radius <= reach;
        self.circles.extend(wide.circles.iter().filter(near));
    }

    /// Distance of the nearest thing, m.
    fn distance(&self, place: Point) -> f64 {
        let faces = self.nearest_face(|block| block.distances_squared(place));
        self.circles.iter().fold(faces, |nearest, circle| {
            min(nearest, circle.distance(place))
        })
    }

    fn distance_to_path(&self, path: &Path, posts: &[Circle]) -> f64 {
        let faces = if self.faces.count() <= FEW {
            let gaps = self.faces.iter().map(|face| path.gap_squared(&face));
            gaps.fold(f64::INFINITY, min).sqrt()
        } else {
            self.nearest_face(|block| path.gaps_squared(block))
        };
        let circles = self.circles.iter().chain(posts);
        circles.fold(faces, |nearest, circle| min(nearest, path.gap(circle)))
    }

    /// The square root of the least of what is said of the faces.
    #[inline(always)]
    fn nearest_face(&self, squared: impl Fn(&FaceBlock) -> [f64; LANES]) -> f64 {
        let mut best = [f64::INFINITY; LANES];
        for block in &self.faces.blocks {
            for (best, squared) in best.iter_mut().zip(squared(block)) {
                *best = min(*best, squared);
            }
        }
        best.into_iter().fold(f64::INFINITY, min).sqrt()
    }

    /// Way to the first touch and the point touched; of several at once, that of the surface that comes first in the world.
    fn first_touch(&self, path: &Path, radius: f64, posts: &[Circle]) -> Option<(f64, Point)> {
        let faces = self.faces.iter().filter_map(|face| {
            let (way, contact) = touch_face(path, &face, radius)?;
            Some((way, contact, face.number))
        });
        let circles = self.circles.iter().chain(posts).filter_map(|circle| {
            let (way, contact) = touch_circle(path, circle, radius)?;
            Some((way, contact, circle.number))
        });
        let first = faces.chain(circles).reduce(|a, b| {
            if b.0 < a.0 || (b.0 == a.0 && b.2 < a.2) {
                b
            } else {
                a
            }
        });
        first.map(|(way, contact, _)| (way, contact))
    }
}
