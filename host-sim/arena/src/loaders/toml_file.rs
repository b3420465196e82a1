//! The TOML world file: `[[wall]]`, `[[box]]` and `[[circle]]` in meters and degrees, and what else
//! can be perceived: `[[light]]`, `[[scent]]` and `[[floor]]`.
//!
//! At least one obstacle is needed; everything else has a default: the file's name, the origin,
//! angle 0. An unknown key is an error, with its line. Examples stand in `host-sim/worlds`.

use core::ops::Range;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use crate::geometry::{Point, Pose};
use crate::shapes::Shape;
use crate::sources::{FloorPatch, Light, SCENT_REACH_M, Scent, Sources, named_color};
use crate::world::{MAX_COORDINATE_M, World};
use files::error::BadInput;
use files::toml_reader::{Finite, Keyed, TomlText, TwoNumbers};
use files::{MAX_INPUT_BYTES, read_text};

/// Maximum range of a sonar, 255 in, m.
const SONAR_RANGE_M: f64 = 6.477;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WorldFile {
    name: Option<Spanned<String>>,
    start: Option<Spanned<Keyed<StartTable>>>,
    #[serde(default)]
    wall: Vec<Keyed<WallTable>>,
    #[serde(default, rename = "box")]
    boxes: Vec<Keyed<BoxTable>>,
    #[serde(default)]
    circle: Vec<Keyed<CircleTable>>,
    #[serde(default)]
    light: Vec<Keyed<LightTable>>,
    #[serde(default)]
    scent: Vec<Keyed<ScentTable>>,
    #[serde(default)]
    floor: Vec<Keyed<FloorTable>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StartTable {
    position_m: Option<Spanned<TwoNumbers>>,
    #[serde(default)]
    heading_deg: Finite,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WallTable {
    points_m: Spanned<Vec<TwoNumbers>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BoxTable {
    center_m: TwoNumbers,
    size_m: Spanned<TwoNumbers>,
    #[serde(default)]
    angle_deg: Finite,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CircleTable {
    center_m: TwoNumbers,
    radius_m: Spanned<Finite>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LightTable {
    position_m: Spanned<TwoNumbers>,
    brightness: Option<Finite>,
    until_s: Option<Finite>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ScentTable {
    position_m: Spanned<TwoNumbers>,
    reach_m: Option<Finite>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FloorTable {
    center_m: TwoNumbers,
    size_m: Spanned<TwoNumbers>,
    #[serde(default)]
    angle_deg: Finite,
    color: Spanned<String>,
}

/// Loads the world file at `path`. Without a `name`, the world gets the name of the file.
pub(super) fn load(path: &Path) -> Result<World, BadInput> {
    let text = read_text(path, MAX_INPUT_BYTES)?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    parse(&text, &path.display().to_string(), &stem)
}

/// Reads a world from `text`; `source` names it in errors.
pub(super) fn parse(text: &str, source: &str, default_name: &str) -> Result<World, BadInput> {
    let text = TomlText { text, source };
    let file: WorldFile = text.read()?;
    let name = match &file.name {
        Some(name) if name.get_ref().is_empty() => {
            return Err(text.error(name.span(), "name: expected a text that is not empty"));
        }
        Some(name) => name.get_ref(),
        None => default_name,
    };
    let walls = file.wall.iter().map(|Keyed(wall)| wall.shape());
    let boxes = file.boxes.iter().map(|Keyed(boxed)| boxed.shape());
    let circles = file.circle.iter().map(|Keyed(circle)| circle.shape());
    let shapes = walls.chain(boxes).chain(circles);
    let shapes = shapes.map(|(shape, span)| match shape.defect(MAX_COORDINATE_M) {
        Some(defect) => Err(text.error(span, defect)),
        None => Ok(shape),
    });
    let shapes = shapes.collect::<Result<Vec<_>, _>>()?;
    let sources = sources(&file, text)?;
    let start = file.start.as_ref();
    let pose = start
        .map(|start| start.get_ref().0.pose())
        .unwrap_or_default();
    let world = World::new(name, pose, shapes)
        .and_then(|world| world.with_sources(sources))
        .map_err(|error| BadInput::new(format!("{source}: {error}")))?;
    match outside(&world) {
        None => Ok(world),
        Some(what) => {
            let span = start.map(|start| match &start.get_ref().0.position_m {
                Some(position) => position.span(),
                None => start.span(),
            });
            Err(text.error(span.unwrap_or_default(), format!("position_m: {what}")))
        }
    }
}

/// What else can be perceived.
fn sources(file: &WorldFile, text: TomlText<'_>) -> Result<Sources, BadInput> {
    let each = |one: Sources, span: Range<usize>| match one.defect() {
        Some(defect) => Err(text.error(span, defect)),
        None => Ok(one),
    };
    let mut all = Sources::default();
    for Keyed(light) in &file.light {
        let one = Sources {
            lights: vec![light.light()],
            ..Sources::default()
        };
        all.lights
            .extend(each(one, light.position_m.span())?.lights);
    }
    for Keyed(scent) in &file.scent {
        let one = Sources {
            scents: vec![scent.scent()],
            ..Sources::default()
        };
        all.scents
            .extend(each(one, scent.position_m.span())?.scents);
    }
    for Keyed(patch) in &file.floor {
        let color = named_color(patch.color.get_ref())
            .map_err(|error| text.error(patch.color.span(), error))?;
        let one = Sources {
            floor: vec![patch.patch(color)],
            ..Sources::default()
        };
        all.floor.extend(each(one, patch.size_m.span())?.floor);
    }
    Ok(all)
}

impl LightTable {
    fn light(&self) -> Light {
        Light {
            position: point(*self.position_m.get_ref()),
            brightness: self.brightness.map_or(1.0, |Finite(value)| value),
            until_s: self.until_s.map(|Finite(value)| value),
        }
    }
}

impl ScentTable {
    fn scent(&self) -> Scent {
        Scent {
            position: point(*self.position_m.get_ref()),
            reach_m: self.reach_m.map_or(SCENT_REACH_M, |Finite(value)| value),
        }
    }
}

impl FloorTable {
    fn patch(&self, color: [f64; 3]) -> FloorPatch {
        FloorPatch {
            center: point(self.center_m),
            size: point(*self.size_m.get_ref()),
            angle: radians(self.angle_deg),
            color,
        }
    }
}

impl StartTable {
    fn pose(&self) -> Pose {
        let position = self.position_m.as_ref();
        let position = position.map_or(Point::default(), |pair| point(*pair.get_ref()));
        Pose::new(position, radians(self.heading_deg))
    }
}

impl WallTable {
    /// The shape, and the span of the text for errors.
    fn shape(&self) -> (Shape, Range<usize>) {
        let points = self.points_m.get_ref().iter().copied().map(point);
        let points = points.collect();
        (Shape::Wall { points }, self.points_m.span())
    }
}

impl BoxTable {
    /// As [`WallTable::shape`].
    fn shape(&self) -> (Shape, Range<usize>) {
        let shape = Shape::Box {
            center: point(self.center_m),
            size: point(*self.size_m.get_ref()),
            angle: radians(self.angle_deg),
        };
        (shape, self.size_m.span())
    }
}

impl CircleTable {
    /// As [`WallTable::shape`].
    fn shape(&self) -> (Shape, Range<usize>) {
        let shape = Shape::Circle {
            center: point(self.center_m),
            radius: self.radius_m.get_ref().0,
        };
        (shape, self.radius_m.span())
    }
}

fn point(TwoNumbers([x, y]): TwoNumbers) -> Point {
    Point::new(x, y)
}

fn radians(Finite(degrees): Finite) -> f64 {
    degrees * (core::f64::consts::PI / 180.0)
}

/// The error of a start outside the walls; `None` for a valid start.
///
/// If walls are closed, one of them must enclose the start, or the start must be in the bounding
/// box of the open walls. If all walls are open, it may be at most a sonar's range outside the
/// bounding box of all shapes. Without walls every start is valid.
fn outside(world: &World) -> Option<String> {
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
        return None;
    }
    let (Point { x, y }, (low, high)) = (start, bounds);
    Some(if closed.is_empty() {
        format!(
            "the start ({x}, {y}) lies outside the world, which spans ({}, {}) to ({}, {})",
            low.x, low.y, high.x, high.y
        )
    } else {
        format!("the start ({x}, {y}) lies outside the walls that close")
    })
}

/// Whether a closed wall encloses a point: a ray from there crosses it an odd number of times.
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

/// Bounding box of points; without points, a box that contains nothing.
fn box_around(points: &[Point]) -> (Point, Point) {
    let nothing = f64::INFINITY;
    let (mut low, mut high) = (Point::new(nothing, nothing), Point::new(-nothing, -nothing));
    for point in points {
        low = Point::new(low.x.min(point.x), low.y.min(point.y));
        high = Point::new(high.x.max(point.x), high.y.max(point.y));
    }
    (low, high)
}

/// Whether a point is in a box, or at most `margin` outside it.
fn lies_in(place: Point, (low, high): (Point, Point), margin: f64) -> bool {
    let within = |at: f64, low: f64, high: f64| (low - margin..=high + margin).contains(&at);
    within(place.x, low.x, high.x) && within(place.y, low.y, high.y)
}

#[cfg(test)]
mod tests;
