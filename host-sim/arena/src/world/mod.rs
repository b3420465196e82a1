//! The world: what stands around the robot, and the three questions the simulator asks about it.
//!
//! * [`World::sweep`]: a disc moves straight; how far does it get, and how near does it come to anything?
//! * [`View::nearest_in_cone`]: how far is the nearest surface inside a cone?
//! * [`LobeView`] and [`World::cast`]: what do single rays of sound meet, and under what angle?
//!
//! Each looks only at what is near, by a tree of boxes, from near to far and no farther than something could change the
//! answer, and what it found is used again while the robot stays near; no answer depends on any of that.
//!
//! Worlds come from files ([`World::load`]), from a seed ([`World::random`]) or are built in
//! ([`World::builtin`]). All are flat: straight pieces and circles, meters and radians.

use std::path::Path;
use std::sync::Arc;

use crate::robot::COLLISION_RADIUS_M;
use files::error::BadInput;

mod answer;
pub mod barn;
mod builtin;
mod clearing;
mod eye;
mod faces;
mod feet;
mod geometry;
mod graymap;
mod lobe;
mod nearby;
mod neighborhoods;
mod occupancy;
mod outline;
mod pgm;
mod random;
mod ray;
mod rays;
mod ros_map;
mod sdf;
mod shapes;
mod spec;
mod steady;
mod surfaces;
mod surroundings;
mod sweep;
mod toml_file;
mod tree;
mod view;

pub use answer::Fan;
pub use clearing::Clearing;
pub(crate) use faces::{max, min};
pub use geometry::{Point, Pose, wrap_angle};
pub use lobe::{Lobe, LobeView};
pub use ray::{Hit, Surface};
pub use rays::Rays;
pub use shapes::Shape;
pub use spec::{WorldSource, parse_worlds};
pub use sweep::{Sweep, TOUCH_SLACK_M};
pub use view::{ConeShape, View};

use surfaces::{Circle, FIRST_CIRCLE, Surfaces};

/// Largest coordinate a world may use, m.
pub const MAX_COORDINATE_M: f64 = 1e5;

/// Most shapes a world may have.
pub const MAX_SHAPES: usize = 1_000_000;

/// Everything that stands around the robot, and where the robot starts. Clones share what stands still.
#[derive(Debug, Clone, PartialEq)]
pub struct World {
    name: String,
    start: Pose,
    goal: Option<Point>,
    shapes: Vec<Shape>,
    surfaces: Arc<Surfaces>,
    /// Posts that come and go, after the circles that stand still.
    posts: Vec<Circle>,
    bounds: (Point, Point),
}

impl World {
    /// A world of `shapes` in which the robot starts at `start`.
    ///
    /// # Errors
    /// When there is no shape or more than [`MAX_SHAPES`]; a coordinate is not finite or beyond
    /// [`MAX_COORDINATE_M`]; a size is not positive; or the robot would start inside something.
    pub fn new(name: impl Into<String>, start: Pose, shapes: Vec<Shape>) -> Result<Self, BadInput> {
        Self::for_body(name, start, shapes, COLLISION_RADIUS_M)
    }

    /// As [`World::new`], for a robot whose body has another radius, m.
    ///
    /// # Errors
    /// Like [`World::new`].
    pub fn for_body(
        name: impl Into<String>,
        start: Pose,
        shapes: Vec<Shape>,
        radius_m: f64,
    ) -> Result<Self, BadInput> {
        if shapes.is_empty() {
            return Err(BadInput::new(
                "a world needs at least one wall, box or circle",
            ));
        }
        if shapes.len() > MAX_SHAPES {
            return Err(BadInput::new(format!(
                "a world may have at most {MAX_SHAPES} shapes, not {}",
                shapes.len()
            )));
        }
        if let Some(defect) = shapes.iter().find_map(|s| s.defect(MAX_COORDINATE_M)) {
            return Err(BadInput::new(defect));
        }
        let world = Self::prepared(name.into(), start, shapes);
        world.check_start(radius_m)?;
        Ok(world)
    }

    fn prepared(name: String, start: Pose, shapes: Vec<Shape>) -> Self {
        Self {
            surfaces: Arc::new(Surfaces::of(&shapes)),
            posts: Vec::new(),
            bounds: bounds_of(&shapes),
            name,
            start,
            goal: None,
            shapes,
        }
    }

    /// This world with one more post.
    #[must_use]
    pub fn with_post(&self, center: Point, radius: f64) -> Self {
        let mut world = self.clone();
        let circles = self.surfaces.circles.len() + self.posts.len();
        world.shapes.push(Shape::Circle { center, radius });
        world.posts.push(Circle {
            center,
            radius,
            number: FIRST_CIRCLE + circles as f64,
        });
        world
    }

    /// Puts the post added last elsewhere, if there is one.
    pub fn move_post(&mut self, to: Point) {
        if let (Some(post), Some(Shape::Circle { center, .. })) =
            (self.posts.last_mut(), self.shapes.last_mut())
        {
            post.center = to;
            *center = to;
        }
    }

    /// This world with a place to go to.
    #[must_use]
    pub fn with_goal(mut self, goal: Point) -> Self {
        self.goal = Some(goal);
        self
    }

    /// This world with another shape in the place of shape `index`; the start is not looked at again.
    ///
    /// # Errors
    /// When there is no such shape, or the new one is impossible.
    pub fn with_shape(&self, index: usize, shape: Shape) -> Result<Self, BadInput> {
        if let Some(defect) = shape.defect(MAX_COORDINATE_M) {
            return Err(BadInput::new(defect));
        }
        let mut shapes = self.shapes.clone();
        match shapes.get_mut(index) {
            Some(place) => *place = shape,
            None => return Err(BadInput::new(format!("there is no shape {index}"))),
        }
        Ok(Self {
            goal: self.goal,
            ..Self::prepared(self.name.clone(), self.start, shapes)
        })
    }

    fn check_start(&self, radius_m: f64) -> Result<(), BadInput> {
        let at = self.start.position;
        if let Some(defect) = shapes::point_defect(at, MAX_COORDINATE_M) {
            return Err(BadInput::new(format!("the start: {defect}")));
        }
        if !self.start.heading.is_finite() {
            return Err(BadInput::new("the start: the heading must be finite"));
        }
        let clearance = self.clearance(at);
        if !self.is_inside(at) && clearance >= radius_m {
            return Ok(());
        }
        Err(BadInput::new(format!(
            "the robot would start inside something: at ({}, {}) the nearest surface is {clearance:.3} m \
             from its center, its radius is {radius_m} m",
            at.x, at.y
        )))
    }

    /// Reads a world from a `.toml` world file or a ROS map_server `.yaml` or `.yml` file.
    ///
    /// # Errors
    /// When the file is missing, is not what its extension says, or describes an impossible world.
    pub fn load(path: &Path) -> Result<Self, BadInput> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        match extension.to_ascii_lowercase().as_str() {
            "toml" => toml_file::load(path),
            "yaml" | "yml" => ros_map::load(path),
            _ => Err(BadInput::file(
                path,
                "a world is a .toml world file or a .yaml map of the ROS map_server",
            )),
        }
    }

    /// Reads the text of a TOML world file; `source` names it in errors, and names the world if it has
    /// no `name` of its own.
    ///
    /// # Errors
    /// Like [`World::load`].
    pub fn from_toml(text: &str, source: &str) -> Result<Self, BadInput> {
        toml_file::parse(text, source, source)
    }

    /// What the world is called.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where the robot starts.
    #[must_use]
    pub fn start(&self) -> Pose {
        self.start
    }

    /// Where it is to go, if the world says it.
    #[must_use]
    pub fn goal(&self) -> Option<Point> {
        self.goal
    }

    /// The shapes, as given.
    #[must_use]
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// Every straight piece once, with its ends.
    pub fn segments(&self) -> impl Iterator<Item = (Point, Point)> + '_ {
        self.shapes.iter().flat_map(|shape| {
            let mut pieces = Vec::new();
            shape.for_each_segment(|from, to| pieces.push((from, to)));
            pieces
        })
    }

    /// The lower left and the upper right corner of everything in the world, m.
    #[must_use]
    pub fn bounds(&self) -> (Point, Point) {
        self.bounds
    }

    /// Distance from `point` to the nearest surface, m, never negative. See [`World::is_inside`].
    #[must_use]
    pub fn clearance(&self, point: Point) -> f64 {
        let still = self.surfaces.distance(point);
        self.posts
            .iter()
            .fold(still, |nearest, post| nearest.min(post.distance(point)))
    }

    /// Whether `point` lies in the body of a box, a circle or an occupied part of a map.
    #[must_use]
    pub fn is_inside(&self, point: Point) -> bool {
        if self.shapes.iter().any(|shape| shape.contains(point)) {
            return true;
        }
        // Even–odd rule over the outlines: an odd number of them to one side.
        let crossings = self.shapes.iter().filter(|shape| match shape {
            Shape::Outline { from, to } => {
                (from.y > point.y) != (to.y > point.y) && {
                    let share = (point.y - from.y) / (to.y - from.y);
                    from.x + share * (to.x - from.x) > point.x
                }
            }
            _ => false,
        });
        crossings.count() % 2 == 1
    }
}

/// What stands still in a world, kept to know it again.
#[derive(Debug, Clone, Default)]
pub(crate) struct Standing(Option<Arc<Surfaces>>);

impl Standing {
    /// Whether a world is the one kept and nothing in it moves; from now on it is the one.
    pub(crate) fn remains(&mut self, world: &World) -> bool {
        let surfaces = &world.surfaces;
        let same = self
            .0
            .as_ref()
            .is_some_and(|kept| Arc::ptr_eq(kept, surfaces));
        if !same {
            self.0 = Some(Arc::clone(surfaces));
        }
        same && world.posts.is_empty()
    }
}

fn bounds_of(shapes: &[Shape]) -> (Point, Point) {
    let mut low = Point::new(f64::INFINITY, f64::INFINITY);
    let mut high = -low;
    let mut include = |point: Point, margin: f64| {
        low = Point::new(low.x.min(point.x - margin), low.y.min(point.y - margin));
        high = Point::new(high.x.max(point.x + margin), high.y.max(point.y + margin));
    };
    for shape in shapes {
        if let Shape::Circle { center, radius } = shape {
            include(*center, *radius);
        }
        shape.for_each_segment(|from, to| {
            include(from, 0.0);
            include(to, 0.0);
        });
    }
    (low, high)
}

#[cfg(test)]
pub(crate) mod naive;
#[cfg(test)]
mod tests;
