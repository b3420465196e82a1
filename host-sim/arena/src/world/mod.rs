//! The world: obstacles, start and goal of the robot.
//!
//! All worlds are flat: straight segments and circles, meters and radians. Queries go to the
//! caster. [`loaders`](crate::loaders) create worlds.

mod symmetry;

use crate::caster::{Caster, LobeView, SonarLobe};
use crate::nomad::COLLISION_RADIUS_M;
use crate::shapes::point_defect;
use crate::sources::{BARE_FLOOR, Cloud, Sensed, Sources};
use files::error::BadInput;
use std::sync::Arc;

pub use crate::caster::{ConeShape, ConeView, Hit, Surface, Sweep, TOUCH_SLACK_M};
pub use crate::geometry::{Point, Pose, wrap_angle};
pub use crate::shapes::Shape;

/// Largest coordinate a world may use, m.
pub const MAX_COORDINATE_M: f64 = 1e5;

/// Maximum number of shapes.
pub const MAX_SHAPES: usize = 1_000_000;

/// Obstacles, start and goal of the robot. Clones share the surfaces that do not move.
#[derive(Debug, Clone, PartialEq)]
pub struct World {
    name: String,
    start: Pose,
    goal: Option<Point>,
    shapes: Vec<Shape>,
    caster: Caster,
    bounds: (Point, Point),
    sources: Sources,
    /// Of each scent.
    clouds: Vec<Arc<Cloud>>,
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
        let world = Self::unchecked(name.into(), start, shapes);
        world.check_start(radius_m)?;
        Ok(world)
    }

    /// As [`World::new`], without checks.
    pub(crate) fn unchecked(name: String, start: Pose, shapes: Vec<Shape>) -> Self {
        Self {
            caster: Caster::new(&shapes),
            bounds: bounds_of(&shapes),
            name,
            start,
            goal: None,
            shapes,
            sources: Sources::default(),
            clouds: Vec::new(),
        }
    }

    /// This world with these sources instead of its own.
    ///
    /// # Errors
    /// When a position lies beyond [`MAX_COORDINATE_M`], or a brightness, a reach or a size is not
    /// positive or too great.
    pub fn with_sources(mut self, sources: Sources) -> Result<Self, BadInput> {
        if let Some(defect) = sources.defect() {
            return Err(BadInput::new(defect));
        }
        let clouds = sources
            .scents
            .iter()
            .map(|scent| Arc::new(Cloud::of(scent, &self)));
        self.clouds = clouds.collect();
        self.sources = sources;
        Ok(self)
    }

    /// This world with one more post.
    #[must_use]
    pub fn with_post(&self, center: Point, radius: f64) -> Self {
        let mut world = self.clone();
        world.shapes.push(Shape::Circle { center, radius });
        world.caster.add_post(center, radius);
        world
    }

    /// Moves the post added last, if there is one.
    pub fn move_post(&mut self, to: Point) {
        if let (true, Some(Shape::Circle { center, .. })) =
            (self.caster.move_post(to), self.shapes.last_mut())
        {
            *center = to;
        }
    }

    /// This world with a goal.
    #[must_use]
    pub fn with_goal(mut self, goal: Point) -> Self {
        self.goal = Some(goal);
        self
    }

    /// This world with shape `index` replaced; does not check the start again.
    ///
    /// # Errors
    /// If there is no such shape, or the new one is invalid.
    pub fn with_shape(&self, index: usize, shape: Shape) -> Result<Self, BadInput> {
        if let Some(defect) = shape.defect(MAX_COORDINATE_M) {
            return Err(BadInput::new(defect));
        }
        let mut shapes = self.shapes.clone();
        match shapes.get_mut(index) {
            Some(old) => *old = shape,
            None => return Err(BadInput::new(format!("there is no shape {index}"))),
        }
        let world = Self {
            goal: self.goal,
            ..Self::unchecked(self.name.clone(), self.start, shapes)
        };
        world.with_sources(self.sources.clone())
    }

    fn check_start(&self, radius_m: f64) -> Result<(), BadInput> {
        let at = self.start.position;
        if let Some(defect) = point_defect(at, MAX_COORDINATE_M) {
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

    /// Name of the world.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Start of the robot.
    #[must_use]
    pub fn start(&self) -> Pose {
        self.start
    }

    /// Goal of the robot, if the world has one.
    #[must_use]
    pub fn goal(&self) -> Option<Point> {
        self.goal
    }

    /// The shapes, as given.
    #[must_use]
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// The ends of every straight segment.
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
        self.caster.clearance(point)
    }

    /// Moves a disc of `radius` m straight `from` one point towards another, up to its first
    /// contact. A disc that already touches a surface may move away from it, but not further into
    /// it.
    #[must_use]
    pub fn sweep(&self, from: Point, to: Point, radius: f64) -> Sweep {
        self.caster.sweep(from, to, radius)
    }

    /// The first hit of a ray from `origin` along the unit vector `direction`. A surface on which
    /// the ray starts is not hit.
    #[must_use]
    pub fn cast(&self, origin: Point, direction: Point) -> Option<Hit> {
        self.caster.cast(origin, direction)
    }

    /// The surfaces for queries with cones around `middle`. Their tips are `offset_m` from it along
    /// their axes, and they reach `reach_m` from there.
    #[must_use]
    pub fn view(&self, middle: Point, offset_m: f64, reach_m: f64) -> ConeView {
        self.caster.view(middle, offset_m, reach_m)
    }

    /// Aims a view at a lobe: collects the surfaces that the sound of one transducer can hit.
    pub(crate) fn aim(&self, view: &mut LobeView, lobe: &SonarLobe) {
        self.caster.aim(view, lobe);
    }

    /// Lamps, scents and colored floor.
    #[must_use]
    pub fn sources(&self) -> &Sources {
        &self.sources
    }

    /// What can be perceived of them at a point, `time_s` after the start.
    #[must_use]
    pub fn sensed(&self, at: Point, time_s: f64) -> Sensed {
        let lights = self.sources.lights.iter();
        let light: f64 = lights.map(|light| light.at(self, at, time_s)).sum();
        let scents = self.clouds.iter().map(|cloud| cloud.at(at));
        let patches = self.sources.floor.iter().rev();
        let patch = { patches }.find(|patch| patch.shape().contains(at));
        Sensed {
            scent: scents.fold(0.0, f64::max),
            light: light.min(1.0),
            floor: patch.map_or(BARE_FLOOR, |patch| patch.color),
        }
    }

    /// Whether a surface stands between two points.
    pub(crate) fn is_hidden(&self, from: Point, to: Point) -> bool {
        let way = to - from;
        let away_m = way.length();
        if away_m == 0.0 {
            return false;
        }
        let hit = self.cast(from, way * (1.0 / away_m));
        hit.is_some_and(|hit| hit.distance_m < away_m)
    }

    /// Whether `point` is inside a box, a circle or an occupied part of a map.
    #[must_use]
    pub fn is_inside(&self, point: Point) -> bool {
        if self.shapes.iter().any(|shape| shape.contains(point)) {
            return true;
        }
        // Even–odd rule: inside if a ray crosses an odd number of outlines.
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

/// The world of the last query, to recognize it.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct LastWorld(Option<Caster>);

impl LastWorld {
    /// Whether `world` is the last one and nothing in it moves. Stores it as the last one.
    pub(crate) fn is_same(&mut self, world: &World) -> bool {
        let same = |last: &Caster| last.is_same_still(&world.caster);
        if self.0.as_ref().is_some_and(same) {
            return true;
        }
        self.0 = Some(world.caster.clone());
        false
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
mod tests;
