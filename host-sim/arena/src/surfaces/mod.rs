//! All fixed surfaces of a world, each kind in blocks with a bounding-box tree.
//!
//! It finds the surfaces near a position, and the distance to the nearest. It is independent of
//! rays and cones.

use crate::geometry::{Point, min};
use crate::shapes::Shape;

mod circle;
mod faces;
mod tree;

pub(crate) use circle::{Circle, FIRST_CIRCLE, list_circles};
pub(crate) use faces::{Face, FaceBlock, list_faces};

use tree::{Bounds, NearSearch, NearestSearch, Tree};
pub(crate) use tree::{Boxes, LANES, SLACK_M, TreeSearch};

/// The fixed faces, circles and corners of a world.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Surfaces {
    faces: Vec<FaceBlock>,
    circles: Vec<Circle>,
    corners: Vec<Point>,
    face_tree: Tree,
    circle_tree: Tree,
    corner_tree: Tree,
}

/// Distances of surfaces from a query object.
pub(crate) trait Distance {
    /// Squared distance of each face of a block, m².
    fn to_faces(&self, block: &FaceBlock) -> [f64; LANES];

    /// Distance of a circle, m.
    fn to_circle(&self, circle: &Circle) -> f64;
}

impl Surfaces {
    /// The surfaces of `shapes`, numbered in their order.
    pub fn of(shapes: &[Shape]) -> Self {
        let mut faces = list_faces(shapes);
        tree::sort(&mut faces, Face::bounds);
        let mut circles = list_circles(shapes);
        tree::sort(&mut circles, Circle::bounds);
        let mut corners = Vec::new();
        for shape in shapes {
            shape.for_each_corner(|corner| corners.push(corner));
        }
        let corner_bounds = |corner: &Point| Bounds::of(*corner, *corner);
        tree::sort(&mut corners, corner_bounds);
        Self {
            face_tree: Tree::over(&faces, Face::bounds),
            circle_tree: Tree::over(&circles, Circle::bounds),
            corner_tree: Tree::over(&corners, corner_bounds),
            faces: faces.chunks(LANES).map(FaceBlock::of).collect(),
            circles,
            corners,
        }
    }

    /// Calls `look` with every block of faces that may be within `reach` m of `place`.
    pub fn faces_near(&self, place: Point, reach: f64, mut look: impl FnMut(&FaceBlock)) {
        let look = |block: usize| look(self.face_block(block));
        self.face_tree
            .search(&mut NearSearch { place, reach, look });
    }

    /// Calls `look` with at least every circle within `reach` m of `place`.
    pub fn circles_near(&self, place: Point, reach: f64, mut look: impl FnMut(&Circle)) {
        let look = |block: usize| self.circle_block(block).iter().for_each(&mut look);
        self.circle_tree
            .search(&mut NearSearch { place, reach, look });
    }

    /// Calls `look` with at least every corner within `reach` m of `place`.
    pub fn corners_near(&self, place: Point, reach: f64, mut look: impl FnMut(Point)) {
        let look = |block: usize| {
            let corners = block_of(&self.corners, block);
            corners.iter().for_each(|corner| look(*corner));
        };
        self.corner_tree
            .search(&mut NearSearch { place, reach, look });
    }

    /// Smallest distance of any surface from a query object that is within `extent_m` of `place`,
    /// m; infinite if there is no surface.
    pub fn nearest(&self, place: Point, extent_m: f64, distance: &impl Distance) -> f64 {
        let of_faces = NearestSearch {
            place,
            extent_m,
            best: f64::INFINITY,
            measure: |block: usize, reach: f64| {
                let block = self.face_block(block);
                if least(block.distances_squared(place)) > reach * reach {
                    return f64::INFINITY;
                }
                least(distance.to_faces(block)).sqrt()
            },
        };
        let of_circles = NearestSearch {
            place,
            extent_m,
            best: of_faces.search(&self.face_tree),
            measure: |block: usize, _| {
                let circles = self.circle_block(block).iter();
                let distances = circles.map(|circle| distance.to_circle(circle));
                distances.fold(f64::INFINITY, min)
            },
        };
        of_circles.search(&self.circle_tree)
    }

    /// Runs a search over the faces; it receives indices of [blocks](Surfaces::face_block).
    pub fn search_faces(&self, search: &mut impl TreeSearch) {
        self.face_tree.search(search);
    }

    /// Runs a search over the circles; it receives indices of [blocks](Surfaces::circle_block).
    pub fn search_circles(&self, search: &mut impl TreeSearch) {
        self.circle_tree.search(search);
    }

    /// A block of faces; a block of unreachable faces if the index is invalid.
    pub fn face_block(&self, block: usize) -> &FaceBlock {
        self.faces.get(block).unwrap_or(&FaceBlock::EMPTY)
    }

    /// A block of circles.
    pub fn circle_block(&self, block: usize) -> &[Circle] {
        block_of(&self.circles, block)
    }

    /// All circles.
    pub fn circles(&self) -> &[Circle] {
        &self.circles
    }
}

fn least(all: [f64; LANES]) -> f64 {
    all.into_iter().fold(f64::INFINITY, min)
}

fn block_of<T>(things: &[T], block: usize) -> &[T] {
    let end = things.len().min(LANES * (block + 1));
    things.get(LANES * block..end).unwrap_or(&[])
}
