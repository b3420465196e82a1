//! The TOML world file.
//!
//! ```toml
//! name = "corridor"
//! [start]
//! position_m = [0.0, 0.0]
//! heading_deg = 0.0
//! [[wall]]
//! points_m = [[-3.0, -2.0], [5.0, -2.0], [5.0, 2.0]]
//! [[box]]
//! center_m = [1.0, 0.5]
//! size_m = [0.4, 0.4]
//! angle_deg = 0.0
//! [[circle]]
//! center_m = [2.0, -1.0]
//! radius_m = 0.3
//! ```
//!
//! Meters and degrees. At least one `wall`, `box` or `circle`; everything else has a default: the file's
//! name, the origin, angle 0. A key that is not listed here is an error, with its line.

use core::ops::Range;
use std::path::Path;

use toml::de::DeValue;

use super::geometry::{Point, Pose};
use super::shapes::Shape;
use super::{MAX_COORDINATE_M, World};
use files::error::BadInput;
use files::toml_reader::{Reader, Table, Value};
use files::{MAX_INPUT_BYTES, read_text};
use std::ops::Deref;

/// Longest range of a sonar, 255 in, m.
const SONAR_RANGE_M: f64 = 6.477;

/// Loads the world file at `path`; without a `name` of its own the world is called after the file.
pub(super) fn load(path: &Path) -> Result<World, BadInput> {
    let text = read_text(path, MAX_INPUT_BYTES)?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    parse(&text, &path.display().to_string(), &stem)
}

/// Reads a world from `text`; `source` names it in errors.
pub(super) fn parse(text: &str, source: &str, default_name: &str) -> Result<World, BadInput> {
    let reader = WorldReader(Reader { text, source });
    let document = reader.document()?;
    let top = document.get_ref();
    reader.only_keys(
        "a world file",
        top,
        &["name", "start", "wall", "box", "circle"],
    )?;
    let name = match top.get("name") {
        Some(value) => reader.text(value, "name")?,
        None => default_name,
    };
    let start = reader.start(top)?;
    let mut shapes = reader.each(top, "wall", WorldReader::wall)?;
    shapes.extend(reader.each(top, "box", WorldReader::rectangle)?);
    shapes.extend(reader.each(top, "circle", WorldReader::circle)?);
    let world = World::new(name, start, shapes)
        .map_err(|error| BadInput::new(format!("{source}: {error}")))?;
    reader.check_start_is_within(&world, top)?;
    Ok(world)
}

/// Reads shapes of a world.
struct WorldReader<'a>(Reader<'a>);

impl<'a> Deref for WorldReader<'a> {
    type Target = Reader<'a>;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl WorldReader<'_> {
    fn start(&self, top: &Table<'_>) -> Result<Pose, BadInput> {
        let Some(value) = top.get("start") else {
            return Ok(Pose::default());
        };
        let DeValue::Table(table) = value.get_ref() else {
            return Err(self.error(value.span(), "start must be a table: [start]"));
        };
        self.only_keys("[start]", table, &["position_m", "heading_deg"])?;
        let position = match table.get("position_m") {
            Some(value) => self.point(value, "position_m")?,
            None => Point::default(),
        };
        Ok(Pose::new(position, self.angle(table, "heading_deg")?))
    }

    /// Refuses a start outside the walls: the robot would drive around the world, not in it. Where walls close, one of them
    /// must go around the start, or the start lie in the bounding box of those that stay open. Where all stay open, it must
    /// lie at most a sonar's range outside the bounding box of all shapes. Without any wall there is no outside.
    fn check_start_is_within(&self, world: &World, top: &Table<'_>) -> Result<(), BadInput> {
        let walls = world.shapes().iter().filter_map(|shape| match shape {
            Shape::Wall { points } => Some(points.as_slice()),
            _ => None,
        });
        let (closed, open): (Vec<_>, Vec<_>) =
            walls.partition(|points| points.first() == points.last());
        let start = world.start().position;
        let bounds = world.bounds();
        let is_within = match (closed.as_slice(), open.as_slice()) {
            ([], []) => true,
            ([], _) => lies_in(start, bounds, SONAR_RANGE_M),
            _ => {
                closed.iter().any(|wall| encloses(wall, start))
                    || lies_in(start, box_around(&open.concat()), 0.0)
            }
        };
        if is_within {
            return Ok(());
        }
        let (Point { x, y }, (low, high)) = (start, bounds);
        let what = if closed.is_empty() {
            format!(
                "position_m: the start ({x}, {y}) lies outside the world, which spans ({}, {}) to ({}, {})",
                low.x, low.y, high.x, high.y
            )
        } else {
            format!("position_m: the start ({x}, {y}) lies outside the walls that close")
        };
        let start = top.get("start").map(|start| match start.get_ref() {
            DeValue::Table(table) => table.get("position_m").unwrap_or(start).span(),
            _ => start.span(),
        });
        Err(self.error(start.unwrap_or_default(), what))
    }

    /// The shapes of the array `[[key]]`, each read from its table; none if the key is not there.
    fn each(
        &self,
        top: &Table<'_>,
        key: &str,
        read: impl Fn(&Self, &Table<'_>, Range<usize>) -> Result<Shape, BadInput>,
    ) -> Result<Vec<Shape>, BadInput> {
        let Some(value) = top.get(key) else {
            return Ok(Vec::new());
        };
        let wrong = |span| {
            self.error(
                span,
                format!("each {key} must be a table of its own: [[{key}]]"),
            )
        };
        let DeValue::Array(entries) = value.get_ref() else {
            return Err(wrong(value.span()));
        };
        let shape = |entry: &Value<'_>| match entry.get_ref() {
            DeValue::Table(table) => read(self, table, entry.span()),
            _ => Err(wrong(entry.span())),
        };
        entries.iter().map(shape).collect()
    }

    fn wall(&self, table: &Table<'_>, span: Range<usize>) -> Result<Shape, BadInput> {
        self.only_keys("a wall", table, &["points_m"])?;
        let value = self.required(table, "points_m", "a wall", &span)?;
        let DeValue::Array(entries) = value.get_ref() else {
            let what = "points_m must be a list of points: [[x, y], [x, y], …]";
            return Err(self.error(value.span(), what));
        };
        let points = entries
            .iter()
            .map(|entry| self.point(entry, "each of points_m"));
        let points = points.collect::<Result<Vec<_>, _>>()?;
        self.sound(Shape::Wall { points }, value.span())
    }

    fn rectangle(&self, table: &Table<'_>, span: Range<usize>) -> Result<Shape, BadInput> {
        self.only_keys("a box", table, &["center_m", "size_m", "angle_deg"])?;
        let center = self.point(
            self.required(table, "center_m", "a box", &span)?,
            "center_m",
        )?;
        let size = self.required(table, "size_m", "a box", &span)?;
        let shape = Shape::Box {
            center,
            size: self.point(size, "size_m")?,
            angle: self.angle(table, "angle_deg")?,
        };
        self.sound(shape, size.span())
    }

    fn circle(&self, table: &Table<'_>, span: Range<usize>) -> Result<Shape, BadInput> {
        self.only_keys("a circle", table, &["center_m", "radius_m"])?;
        let center = self.required(table, "center_m", "a circle", &span)?;
        let radius = self.required(table, "radius_m", "a circle", &span)?;
        let shape = Shape::Circle {
            center: self.point(center, "center_m")?,
            radius: self.number(radius, "radius_m")?,
        };
        self.sound(shape, radius.span())
    }

    fn sound(&self, shape: Shape, span: Range<usize>) -> Result<Shape, BadInput> {
        match shape.defect(MAX_COORDINATE_M) {
            Some(defect) => Err(self.error(span, defect)),
            None => Ok(shape),
        }
    }

    /// An optional angle in degrees, as rad; 0 when left out.
    fn angle(&self, table: &Table<'_>, key: &str) -> Result<f64, BadInput> {
        let degrees = table
            .get(key)
            .map_or(Ok(0.0), |value| self.number(value, key))?;
        Ok(degrees * (core::f64::consts::PI / 180.0))
    }

    fn point(&self, value: &Value<'_>, key: &str) -> Result<Point, BadInput> {
        let DeValue::Array(entries) = value.get_ref() else {
            return Err(self.error(value.span(), format!("{key} must be two numbers: [x, y]")));
        };
        if entries.len() != 2 {
            let what = format!("{key} must be two numbers: [x, y], not {}", entries.len());
            return Err(self.error(value.span(), what));
        }
        Ok(Point::new(
            self.number(&entries[0], key)?,
            self.number(&entries[1], key)?,
        ))
    }
}

/// Whether a closed wall goes around a place: a ray from there crosses it an odd number of times.
fn encloses(wall: &[Point], place: Point) -> bool {
    let is_crossed = |pair: &&[Point]| match pair {
        [from, to] if (from.y > place.y) != (to.y > place.y) => {
            let share = (place.y - from.y) / (to.y - from.y);
            place.x < from.x + share * (to.x - from.x)
        }
        _ => false,
    };
    wall.windows(2).filter(is_crossed).count() % 2 == 1
}

/// The lowest and the highest coordinates of points; without any, a box that nothing lies in.
fn box_around(points: &[Point]) -> (Point, Point) {
    let nothing = f64::INFINITY;
    let (mut low, mut high) = (Point::new(nothing, nothing), Point::new(-nothing, -nothing));
    for point in points {
        low = Point::new(low.x.min(point.x), low.y.min(point.y));
        high = Point::new(high.x.max(point.x), high.y.max(point.y));
    }
    (low, high)
}

/// Whether a place lies in a box, or at most `margin` outside it.
fn lies_in(place: Point, (low, high): (Point, Point), margin: f64) -> bool {
    let within = |at: f64, low: f64, high: f64| (low - margin..=high + margin).contains(&at);
    within(place.x, low.x, high.x) && within(place.y, low.y, high.y)
}

#[cfg(test)]
mod tests;
