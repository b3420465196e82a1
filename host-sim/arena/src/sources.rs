//! What else than obstacles can be perceived in a world: light, scents, the color of the floor.

use crate::geometry::Point;
use crate::shapes::{Shape, point_defect};
use crate::world::{MAX_COORDINATE_M, World};
use core::f64::consts::SQRT_2;
use files::error::BadInput;
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// Side of a cell of the grid on which a scent spreads, m.
const CELL_M: f64 = 0.1;
/// A scent spreads where no surface is nearer, m: diagonal cells have no wall between them.
const GAP_M: f64 = 0.075;
/// A scent spreads over so many times its reach: there is less than a hundredth left.
const SPREAD: f64 = 5.0;
/// Light falls to a half at this distance from below the lamp, m.
pub const LAMP_M: f64 = 1.0;
/// Reach of a scent whose file says nothing, m.
pub const SCENT_REACH_M: f64 = 2.0;
/// Colors of the floor by name: red, green and blue, 0 … 1.
pub const COLORS: [(&str, [f64; 3]); 8] = [
    ("red", [0.9, 0.1, 0.1]),
    ("green", [0.1, 0.8, 0.1]),
    ("blue", [0.1, 0.1, 0.9]),
    ("yellow", [0.9, 0.9, 0.1]),
    ("cyan", [0.1, 0.9, 0.9]),
    ("magenta", [0.9, 0.1, 0.9]),
    ("white", [1.0, 1.0, 1.0]),
    ("black", [0.0, 0.0, 0.0]),
];
/// Color of the floor where nothing lies on it.
pub const BARE_FLOOR: [f64; 3] = [0.5; 3];

/// A lamp. What stands between throws a shadow.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Light {
    /// Where it hangs.
    pub position: Point,
    /// Brightness below it, 0 … 1.
    pub brightness: f64,
    /// It goes out then, s.
    pub until_s: Option<f64>,
}

/// A source of a scent, which spreads around what stands in its way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scent {
    /// Where it is.
    pub position: Point,
    /// It falls to 1/e over so long a way, m.
    pub reach_m: f64,
}

/// A colored rectangle on the floor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FloorPatch {
    /// Its center.
    pub center: Point,
    /// Its width and depth, m.
    pub size: Point,
    /// Its turn, rad.
    pub angle: f64,
    /// Red, green and blue, 0 … 1.
    pub color: [f64; 3],
}

/// Lamps, scents and colored floor of a world.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Sources {
    /// The lamps; their light adds up.
    pub lights: Vec<Light>,
    /// The sources of the scent; the strongest counts.
    pub scents: Vec<Scent>,
    /// Colored rectangles; later ones lie on earlier ones.
    pub floor: Vec<FloorPatch>,
}

/// The color with this name.
///
/// # Errors
/// When there is none.
pub fn named_color(name: &str) -> Result<[f64; 3], BadInput> {
    let found = COLORS.iter().find(|(known, _)| *known == name);
    let known = COLORS.map(|(known, _)| known);
    found.map_or_else(
        || Err(BadInput::unknown("color", name, &known)),
        |(_, color)| Ok(*color),
    )
}

/// A color as `#rrggbb`.
#[must_use]
pub fn hex(color: [f64; 3]) -> String {
    let [red, green, blue] = color.map(|share| libm::rint(255.0 * share) as u8);
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// What can be perceived at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensed {
    /// Strength of the scent, 0 … 1.
    pub scent: f64,
    /// Brightness, 0 … 1.
    pub light: f64,
    /// Color of the floor: red, green and blue, 0 … 1.
    pub floor: [f64; 3],
}

impl Sources {
    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The defect of one of them, if any.
    pub(crate) fn defect(&self) -> Option<String> {
        let place = |point: Point| point_defect(point, MAX_COORDINATE_M);
        let lights = self.lights.iter().find_map(|light| {
            let brightness = light.brightness;
            let is_sound = brightness > 0.0 && brightness <= 1.0;
            let bad =
                || format!("a light's brightness must be above 0 and at most 1, not {brightness}");
            place(light.position).or_else(|| (!is_sound).then(bad))
        });
        let scents = || {
            self.scents.iter().find_map(|scent| {
                let reach_m = scent.reach_m;
                let is_sound = (0.1..=100.0).contains(&reach_m);
                let bad = || format!("a scent's reach must lie in 0.1..=100 m, not {reach_m}");
                place(scent.position).or_else(|| (!is_sound).then(bad))
            })
        };
        let floor = || {
            self.floor
                .iter()
                .find_map(|patch| patch.shape().defect(MAX_COORDINATE_M))
                .map(|defect| defect.replace("a box", "a patch"))
        };
        lights.or_else(scents).or_else(floor)
    }
}

impl Light {
    /// What it gives at a point, 0 … 1.
    pub(crate) fn at(&self, world: &World, point: Point, time_s: f64) -> f64 {
        let way = self.position - point;
        let away_m = way.length();
        let is_out = self.until_s.is_some_and(|until_s| time_s >= until_s);
        if is_out || world.is_hidden(point, self.position) {
            return 0.0;
        }
        self.brightness / (1.0 + (away_m / LAMP_M) * (away_m / LAMP_M))
    }
}

impl FloorPatch {
    /// The rectangle.
    #[must_use]
    pub fn shape(&self) -> Shape {
        Shape::Box {
            center: self.center,
            size: self.size,
            angle: self.angle,
        }
    }
}

/// How far a scent has to go to each cell of a grid around its source, m.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cloud {
    source: Point,
    reach_m: f64,
    ways_m: BTreeMap<(i32, i32), f64>,
}

impl Cloud {
    /// Spreads a scent, by Dijkstra's search.
    pub(crate) fn of(scent: &Scent, world: &World) -> Self {
        let mut cloud = Self {
            source: scent.position,
            reach_m: scent.reach_m,
            ways_m: BTreeMap::new(),
        };
        // Tenths of a millimeter: a heap takes whole numbers.
        let limit = (SPREAD * scent.reach_m * 1e4) as u32;
        let mut ahead = BinaryHeap::from([Reverse((0_u32, (0, 0)))]);
        while let Some(Reverse((way, cell))) = ahead.pop() {
            if cloud.ways_m.contains_key(&cell) {
                continue;
            }
            cloud.ways_m.insert(cell, f64::from(way) / 1e4);
            for (dx, dy) in NEIGHBORS {
                let next = (cell.0 + dx, cell.1 + dy);
                let step = if dx != 0 && dy != 0 { SQRT_2 } else { 1.0 } * CELL_M * 1e4;
                let place = cloud.place(next);
                let is_free = || world.clearance(place) >= GAP_M && !world.is_inside(place);
                let far = way + step as u32;
                if far <= limit && !cloud.ways_m.contains_key(&next) && is_free() {
                    ahead.push(Reverse((far, next)));
                }
            }
        }
        cloud
    }

    /// Its strength at a point, 0 … 1: 0 where it does not come.
    pub(crate) fn at(&self, point: Point) -> f64 {
        let away = (point - self.source) * (1.0 / CELL_M);
        let (column, row) = (libm::rint(away.x) as i32, libm::rint(away.y) as i32);
        let cells = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (column + dx, row + dy)));
        let ways = cells.filter_map(|cell| {
            let way_m = self.ways_m.get(&cell)?;
            Some(way_m + self.place(cell).distance(point))
        });
        let way_m = ways.fold(f64::INFINITY, f64::min);
        libm::exp(-way_m / self.reach_m)
    }

    fn place(&self, (column, row): (i32, i32)) -> Point {
        self.source + Point::new(f64::from(column), f64::from(row)) * CELL_M
    }
}

const NEIGHBORS: [(i32, i32); 8] = [
    (1, 0),
    (1, 1),
    (0, 1),
    (-1, 1),
    (-1, 0),
    (-1, -1),
    (0, -1),
    (1, -1),
];

#[cfg(test)]
mod tests;
