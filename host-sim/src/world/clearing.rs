//! What a disc on its way may touch or come nearest to: found once for a whole neighbourhood, used as long as the disc stays.

use std::sync::Arc;

use super::World;
use super::faces::{Faces, LANES, max, min};
use super::geometry::Point;
use super::surfaces::{Circle, Surfaces};
use super::sweep::{Path, Sweep, touch_circle, touch_face};
use super::tree::SLACK_M;

/// Paths that stay within this distance of where the clearing was looked at need no new look, m.
const ROOM_M: f64 = 0.2;

/// The surfaces that can be the nearest to, or touched by, a disc near one place. Reusable; whatever it held before, its
/// answers are those of [`World::sweep`] and [`World::clearance`], to the bit.
#[derive(Debug, Clone, Default)]
pub struct Clearing {
    of: Option<Arc<Surfaces>>,
    middle: Point,
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
    /// As [`World::sweep`].
    pub fn sweep(&mut self, world: &World, from: Point, to: Point, radius: f64) -> Sweep {
        self.look(world, from, to, radius);
        let path = Path::between(from, to);
        let nearest = self.distance_to_path(&path, &world.posts);
        let free = Sweep {
            travelled_m: path.length,
            contact: None,
            min_clearance_m: (nearest - radius).max(0.0),
        };
        if !path.is_touched_at(nearest, radius) {
            return free;
        }
        match self.first_touch(&path, radius, &world.posts) {
            None => free,
            Some((way, contact)) => Sweep {
                travelled_m: min(way, path.length),
                contact: Some(contact),
                min_clearance_m: 0.0,
            },
        }
    }

    /// As [`World::clearance`].
    pub fn clearance(&mut self, world: &World, point: Point) -> f64 {
        self.look(world, point, point, 0.0);
        let mut best = [f64::INFINITY; LANES];
        for block in &self.faces.blocks {
            let squared = block.distances_squared(point);
            for (best, squared) in best.iter_mut().zip(squared) {
                *best = min(*best, squared);
            }
        }
        let faces = best.into_iter().fold(f64::INFINITY, min).sqrt();
        let circles = self.circles.iter().chain(&world.posts);
        circles.fold(faces, |nearest, circle| {
            min(nearest, circle.distance(point))
        })
    }

    /// Holds all that matters to a path afterwards.
    fn look(&mut self, world: &World, from: Point, to: Point, radius: f64) {
        let same = self
            .of
            .as_ref()
            .is_some_and(|of| Arc::ptr_eq(of, &world.surfaces));
        let inside = |place: Point| {
            let offset = place - self.middle;
            offset.dot(offset) <= self.room * self.room
        };
        if same && radius <= self.radius && inside(from) && inside(to) {
            return;
        }
        let surfaces = &world.surfaces;
        // A long path is looked at from its middle, for itself; the next ones will be elsewhere.
        let half = from.distance(to) / 2.0;
        let (middle, room) = if half > ROOM_M / 2.0 {
            ((from + to) * 0.5, half)
        } else {
            (from, ROOM_M)
        };
        let nearest = surfaces.distance(middle);
        // Whatever is nearest to a place in the room is no farther from it than this is, and so no farther from the
        // middle than twice the room more.
        let reach = max(nearest + 2.0 * room, radius + room) + SLACK_M;
        self.faces.clear();
        self.circles.clear();
        surfaces.faces_near(middle, reach, |block| {
            let squared = block.distances_squared(middle);
            for (lane, squared) in squared.into_iter().enumerate() {
                if squared <= reach * reach {
                    self.faces.push(block.face(lane));
                }
            }
        });
        surfaces.circles_near(middle, reach, |circle| {
            // What it lies in counts too, however deep.
            if middle.distance(circle.center) - circle.radius <= reach {
                self.circles.push(*circle);
            }
        });
        (self.middle, self.room, self.radius) = (middle, room, radius);
        if !same {
            self.of = Some(Arc::clone(surfaces));
        }
    }

    fn distance_to_path(&self, path: &Path, posts: &[Circle]) -> f64 {
        let mut best = [f64::INFINITY; LANES];
        for block in &self.faces.blocks {
            let squared = path.gaps_squared(block);
            for (best, squared) in best.iter_mut().zip(squared) {
                *best = min(*best, squared);
            }
        }
        let faces = best.into_iter().fold(f64::INFINITY, min).sqrt();
        let circles = self.circles.iter().chain(posts);
        circles.fold(faces, |nearest, circle| min(nearest, path.gap(circle)))
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
