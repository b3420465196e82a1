//! Maps of the ROS `map_server`: a YAML file that names an image, its resolution and its place.
//!
//! Cells between the thresholds are unknown and stop neither sound nor robot. Maps carry no start:
//! the robot starts where it has 0.5 m of room, as near as possible to the middle of the free area,
//! or where it has most room.

use std::path::Path;

use serde::Deserialize;

use super::graymap::Graymap;
use super::image;
use super::occupancy::{Occupancy, OccupancyCell};
use crate::geometry::{Point, Pose};
use crate::shapes::Shape;
use crate::world::{MAX_COORDINATE_M, MAX_SHAPES, World};
use files::error::BadInput;
use files::{self, MAX_INPUT_BYTES};

/// Room wanted around the start, m.
const START_CLEARANCE_M: f64 = 0.5;

/// The keys of the YAML file as they stand there; keys of other tools are ignored.
#[derive(Debug, Deserialize)]
struct Keys {
    image: Option<String>,
    resolution: Option<f64>,
    origin: Option<Vec<f64>>,
    negate: Option<Flag>,
    occupied_thresh: Option<f64>,
    free_thresh: Option<f64>,
    mode: Option<String>,
}

/// `0` or `1`, `false` or `true`.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Flag {
    Bool(bool),
    Number(i64),
}

/// The checked content of the YAML file.
#[derive(Debug)]
struct MapInfo {
    image: String,
    resolution: f64,
    origin: Pose,
    negate: bool,
    occupied_above: f64,
    free_below: f64,
}

/// Loads the map described by the YAML file at `path`; the world is called after the file.
pub(super) fn load(path: &Path) -> Result<World, BadInput> {
    let text = files::read_text(path, MAX_INPUT_BYTES)?;
    let info = parse_info(&text).map_err(|what| BadInput::file(path, what))?;
    let image_path = path.parent().unwrap_or(Path::new("")).join(&info.image);
    let image = image::parse(&files::read(&image_path, MAX_INPUT_BYTES)?)
        .map_err(|what| BadInput::file(&image_path, what))?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    build(&name, &info, &image).map_err(|error| BadInput::file(path, error))
}

fn parse_info(text: &str) -> Result<MapInfo, String> {
    let options = serde_saphyr::options! { with_snippet: false };
    let keys: Keys = serde_saphyr::from_str_with_options(text, options).map_err(|error| {
        let message = error.to_string();
        message.lines().next().unwrap_or("is not YAML").to_owned()
    })?;
    let missing = |key: &str| format!("the key \"{key}\" is missing");
    let origin = keys.origin.ok_or_else(|| missing("origin"))?;
    let [x, y, yaw] = origin[..] else {
        return Err(format!(
            "origin must be three numbers: [x, y, yaw], not {}",
            origin.len()
        ));
    };
    let info = MapInfo {
        image: keys.image.ok_or_else(|| missing("image"))?,
        resolution: keys.resolution.ok_or_else(|| missing("resolution"))?,
        origin: Pose::new(Point::new(x, y), yaw),
        negate: match keys.negate.ok_or_else(|| missing("negate"))? {
            Flag::Bool(negate) => negate,
            Flag::Number(number) => number != 0,
        },
        occupied_above: keys
            .occupied_thresh
            .ok_or_else(|| missing("occupied_thresh"))?,
        free_below: keys.free_thresh.ok_or_else(|| missing("free_thresh"))?,
    };
    check(&info, keys.mode.as_deref().unwrap_or("trinary"))?;
    Ok(info)
}

fn check(info: &MapInfo, mode: &str) -> Result<(), String> {
    if !matches!(mode, "trinary" | "scale") {
        return Err(format!("mode must be trinary or scale, not {mode}"));
    }
    if !(info.resolution >= 1e-3 && info.resolution <= 1e3) {
        return Err(format!(
            "resolution must lie between 0.001 and 1000 m, not {}",
            info.resolution
        ));
    }
    let thresholds = 0.0 <= info.free_below
        && info.free_below <= info.occupied_above
        && info.occupied_above <= 1.0;
    if !thresholds {
        return Err("0 <= free_thresh <= occupied_thresh <= 1 does not hold".into());
    }
    let Pose { position, heading } = info.origin;
    let near = |c: f64| c.abs() <= MAX_COORDINATE_M;
    if !(near(position.x) && near(position.y) && heading.is_finite()) {
        return Err(format!("origin must lie within ±{MAX_COORDINATE_M} m"));
    }
    Ok(())
}

/// A pixel's occupancy is `(white − v) / white`, or `v / white` when `negate` is set. Above
/// `occupied_thresh` the cell is occupied, below `free_thresh` free, in between unknown.
fn classify(image: &Graymap, info: &MapInfo) -> Occupancy {
    let white = f64::from(image.max_value);
    let cell = |&pixel: &u16| {
        let lit = f64::from(pixel) / white;
        let occupancy = if info.negate { lit } else { 1.0 - lit };
        if occupancy > info.occupied_above {
            OccupancyCell::Occupied
        } else if occupancy < info.free_below {
            OccupancyCell::Free
        } else {
            OccupancyCell::Unknown
        }
    };
    let rows = image.pixels.chunks_exact(image.width).rev();
    Occupancy {
        width: image.width,
        height: image.height,
        cells: rows.flatten().map(cell).collect(),
    }
}

fn build(name: &str, info: &MapInfo, image: &Graymap) -> Result<World, BadInput> {
    let map = classify(image, info);
    let along = Point::unit(info.origin.heading);
    let place = |column: f64, row: f64| {
        info.origin.position + (Point::new(column, row) * info.resolution).turned(along)
    };
    let outlines = map.outlines();
    if outlines.is_empty() {
        return Err(BadInput::new("no cell of the map is occupied"));
    }
    if outlines.len() > MAX_SHAPES {
        return Err(BadInput::new(format!(
            "the map has more than {MAX_SHAPES} edges"
        )));
    }
    let shapes = outlines.into_iter().map(|(from, to)| Shape::Outline {
        from: place(from.0 as f64, from.1 as f64),
        to: place(to.0 as f64, to.1 as f64),
    });
    // One cell more, because the grid measures from cell center to cell center.
    let clearance = libm::ceil(START_CLEARANCE_M / info.resolution).clamp(1.0, 100.0) as u8 + 1;
    let Some((column, row)) = map.start(clearance) else {
        return Err(BadInput::new("no cell of the map is free"));
    };
    let start = Pose::new(place(column as f64 + 0.5, row as f64 + 0.5), 0.0);
    World::new(name, start, shapes.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const YAML: &str = "image: room.pgm\nresolution: 0.5\norigin: [-2.0, -1.0, 0.0]\nnegate: 0\n\
                        occupied_thresh: 0.65\nfree_thresh: 0.196\n";

    /// A room of 6 × 4 free cells with walls one cell thick.
    fn room(binary: bool, negate: bool) -> Vec<u8> {
        let (wall, free) = if negate { (255, 0) } else { (0, 254) };
        let pixels = (0..48u8).map(|i| {
            let (column, row) = (i % 8, i / 8);
            let border = column == 0 || column == 7 || row == 0 || row == 5;
            if border { wall } else { free }
        });
        if binary {
            let mut bytes = b"P5\n8 6\n255\n".to_vec();
            bytes.extend(pixels);
            bytes
        } else {
            let words: Vec<_> = pixels.map(|pixel: u8| pixel.to_string()).collect();
            format!("P2\n8 6\n255\n{}\n", words.join(" ")).into_bytes()
        }
    }

    fn load_room(yaml: &str, image: &[u8]) -> Result<World, BadInput> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("room.pgm"), image).unwrap();
        let path = folder.path().join("lab.yaml");
        std::fs::write(&path, yaml).unwrap();
        World::load(&path)
    }

    #[test]
    fn both_kinds_of_image_give_the_same_eight_pieces() {
        let world = load_room(YAML, &room(true, false)).unwrap();
        assert_eq!(world, load_room(YAML, &room(false, false)).unwrap());
        let negated = YAML.replace("negate: 0", "negate: true");
        assert_eq!(world, load_room(&negated, &room(true, true)).unwrap());
        assert_eq!((world.name(), world.segments().count()), ("lab", 8));
        assert_eq!(
            world.bounds(),
            (Point::new(-2.0, -1.0), Point::new(2.0, 2.0))
        );
        // The walls are solid, the room is not.
        assert!(world.is_inside(Point::new(-1.75, 0.0)) && world.is_inside(Point::new(0.0, 1.75)));
        assert!(!world.is_inside(Point::new(0.0, 0.5)) && !world.is_inside(Point::new(0.0, 2.25)));
        assert_eq!(world.clearance(Point::new(0.0, 0.25)), 0.75);
        let start = world.start();
        assert!(world.clearance(start.position) >= START_CLEARANCE_M && start.heading == 0.0);
        assert!(start.position.distance(Point::new(0.0, 0.5)) < 0.5);
    }

    #[test]
    fn the_origins_yaw_turns_the_map() {
        let yaml = YAML.replace("[-2.0, -1.0, 0.0]", "[0.0, 0.0, 1.5707963267948966]");
        let world = load_room(&yaml, &room(true, false)).unwrap();
        let (low, high) = world.bounds();
        assert!(
            low.distance(Point::new(-3.0, 0.0)) < 1e-12
                && high.distance(Point::new(0.0, 4.0)) < 1e-12
        );
    }

    #[test]
    fn broken_maps_are_named() {
        let good = room(true, false);
        for (from, to, words) in [
            ("image: room.pgm\n", "", "\"image\" is missing"),
            ("room.pgm", "hall.pgm", "no such file"),
            ("0.5", "0", "resolution"),
            ("0.5", ".nan", "resolution"),
            ("0.5", "wide", "lab.yaml"),
            ("[-2.0, -1.0, 0.0]", "[1.0, 2.0]", "origin"),
            ("0.65", "0.1", "free_thresh <= occupied_thresh"),
            ("negate: 0", "negate: 0\nmode: raw", "mode"),
            (YAML, "", "lab.yaml"),
            (YAML, "- 1\n- 2\n", "lab.yaml"),
            (YAML, "{", "lab.yaml"),
        ] {
            let error = load_room(&YAML.replace(from, to), &good)
                .unwrap_err()
                .to_string();
            assert!(error.contains(words) && !error.contains('\n'), "{error}");
        }
        let error = load_room(YAML, b"P5").unwrap_err().to_string();
        assert!(error.contains("room.pgm"), "{error}");
        let white = b"P2 2 2 255 255 255 255 255";
        let error = load_room(YAML, white).unwrap_err().to_string();
        assert!(error.contains("no cell of the map is occupied"), "{error}");
    }
}
