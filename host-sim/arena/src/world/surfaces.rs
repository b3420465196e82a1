//! Everything that stands still in a world, sorted and with its trees.

use core::f64::consts::PI;

use super::faces::{FaceBlock, Faces, LANES, max, min};
use super::feet::Feet;
use super::geometry::Point;
use super::shapes::Shape;
use super::tree::{self, Bounds, Near, Nearest, Search, Tree};

/// Number of the first circle: beyond every face's.
pub(super) const FIRST_CIRCLE: f64 = 1e9;

/// So many faces are looked at before it is asked whether more are needed.
const CROWD: f64 = 200.0;

/// A solid disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Circle {
    pub center: Point,
    pub radius: f64,
    /// Its place in the world's list, [`FIRST_CIRCLE`] added.
    pub number: f64,
}

impl Circle {
    /// Distance from its side to a place within or without, m.
    pub fn distance(&self, place: Point) -> f64 {
        (place.distance(self.center) - self.radius).abs()
    }
}

/// The faces, circles and corners of a world that do not move.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Surfaces {
    pub faces: Faces,
    pub circles: Vec<Circle>,
    pub corners: Vec<Point>,
    /// Radius of a circle in which about [`CROWD`] faces lie, were they spread evenly over the world, m.
    pub crowd_m: f64,
    pub feet: Feet,
    face_tree: Tree,
    circle_tree: Tree,
    corner_tree: Tree,
}

impl Surfaces {
    /// Those of `shapes`, numbered in their order.
    pub fn of(shapes: &[Shape]) -> Self {
        let (faces, face_bounds) = Faces::of(shapes);
        let size = Bounds::all(face_bounds.iter().copied()).size();
        let area_m2 = max(size.x, 0.0) * max(size.y, 0.0);
        let (mut circles, mut corners) = (Vec::new(), Vec::new());
        for shape in shapes {
            shape.for_each_corner(|corner| corners.push(corner));
            if let Shape::Circle { center, radius } = *shape {
                circles.push(Circle {
                    center,
                    radius,
                    number: FIRST_CIRCLE + circles.len() as f64,
                });
            }
        }
        let around = |circle: &Circle| Bounds::around(circle.center, circle.radius);
        tree::sort(&mut circles, around);
        tree::sort(&mut corners, |&corner| Bounds::of(corner, corner));
        let circle_blocks = circles
            .chunks(LANES)
            .map(|block| Bounds::all(block.iter().map(around)));
        let corner_blocks = corners
            .chunks(LANES)
            .map(|block| Bounds::all(block.iter().map(|&corner| Bounds::of(corner, corner))));
        Self {
            feet: Feet::of(&faces),
            crowd_m: (CROWD / PI * area_m2 / max(faces.count() as f64, 1.0)).sqrt(),
            face_tree: Tree::of(&face_bounds),
            circle_tree: Tree::of(&circle_blocks.collect::<Vec<_>>()),
            corner_tree: Tree::of(&corner_blocks.collect::<Vec<_>>()),
            faces,
            circles,
            corners,
        }
    }

    /// Shows every block of faces that may come within `reach` m of `place`.
    pub fn faces_near(&self, place: Point, reach: f64, mut look: impl FnMut(&FaceBlock)) {
        let look = |block: usize| {
            if let Some(block) = self.faces.blocks.get(block) {
                look(block);
            }
        };
        self.face_tree.search(&mut Near { place, reach, look });
    }

    /// Shows every circle that may come within `reach` m of `place`, and others.
    pub fn circles_near(&self, place: Point, reach: f64, mut look: impl FnMut(&Circle)) {
        let look = |block: usize| block_of(&self.circles, block).iter().for_each(&mut look);
        self.circle_tree.search(&mut Near { place, reach, look });
    }

    /// Shows every corner that may come within `reach` m of `place`, and others.
    pub fn corners_near(&self, place: Point, reach: f64, mut look: impl FnMut(&Point)) {
        let look = |block: usize| block_of(&self.corners, block).iter().for_each(&mut look);
        self.corner_tree.search(&mut Near { place, reach, look });
    }

    /// Distance from `place` to the nearest surface, m; infinite in an empty world.
    pub fn distance(&self, place: Point) -> f64 {
        let of_faces = Nearest {
            place,
            best: f64::INFINITY,
            measure: |block: usize| {
                let block = self.faces.blocks.get(block);
                let squared = block.map_or([f64::INFINITY; LANES], |b| b.distances_squared(place));
                squared.into_iter().fold(f64::INFINITY, min).sqrt()
            },
        };
        let of_circles = Nearest {
            place,
            best: of_faces.search(&self.face_tree),
            measure: |block: usize| {
                let distances = self.circle_block(block).iter().map(|c| c.distance(place));
                distances.fold(f64::INFINITY, min)
            },
        };
        of_circles.search(&self.circle_tree)
    }

    /// Puts the blocks of faces and of circles that a search wants before it.
    pub fn search_faces(&self, search: &mut impl Search) {
        self.face_tree.search(search);
    }

    /// As [`Surfaces::search_faces`], for circles.
    pub fn search_circles(&self, search: &mut impl Search) {
        self.circle_tree.search(search);
    }

    /// A block of circles.
    pub fn circle_block(&self, block: usize) -> &[Circle] {
        block_of(&self.circles, block)
    }
}

fn block_of<T>(things: &[T], block: usize) -> &[T] {
    things.chunks(LANES).nth(block).unwrap_or(&[])
}
