//! Worlds of the BARN benchmark: fields of cylinders between two side walls.
//!
//! D. Perille et al., *Benchmarking metric ground navigation*, SSRR 2020, 116–121: 300 worlds. They
//! are read as published, `world_N.world` (Gazebo's SDF), or from a table `world,ix,iy` of filled
//! cells. Start and goal are those of the BARN Challenge: from (−2, 3) m along y, to (−2, 13) m.

use std::f64::consts::FRAC_PI_2;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use super::sdf;
use crate::geometry::{Point, Pose};
use crate::shapes::Shape;
use crate::world::World;
use files::error::BadInput;
use files::table::{Records, Table};
use files::{MAX_INPUT_BYTES, read_text};

/// Side of a cell, m; half of it is a cylinder's radius.
const CELL_M: f64 = 0.15;
/// Largest index of a cell.
const MAX_CELLS: u16 = 1_000;
/// Start of the robot, m.
const START_M: Point = Point::new(-2.0, 3.0);
/// Goal of the robot, m.
const GOAL_M: Point = Point::new(-2.0, 13.0);

/// One world of a published file, folder or table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BarnSource {
    /// The file or folder.
    pub path: PathBuf,
    /// The world's number.
    pub number: u32,
}

/// The worlds at `path` with numbers in `wanted` (`None` = all), by number. At least one of them
/// must exist.
///
/// # Errors
/// A path that cannot be read or holds no such world; a table with a bad row.
pub fn sources(
    path: &Path,
    wanted: Option<&RangeInclusive<u32>>,
) -> Result<Vec<BarnSource>, BadInput> {
    let mut numbers = if path.is_dir() {
        folder(path)?
    } else if is_sdf(path) {
        vec![number_of(path).unwrap_or(0)]
    } else {
        let cells = cells(path)?;
        cells.into_iter().map(|(number, _)| number).collect()
    };
    numbers.sort_unstable();
    numbers.dedup();
    let held = match (numbers.first(), numbers.last()) {
        (Some(first), Some(last)) => format!("{} worlds, {first} to {last}", numbers.len()),
        _ => "no world".to_owned(),
    };
    numbers.retain(|number| wanted.is_none_or(|wanted| wanted.contains(number)));
    if numbers.is_empty() {
        let asked = wanted.map_or("world".to_owned(), |wanted| {
            match (wanted.start(), wanted.end()) {
                (first, last) if first == last => format!("world {first}"),
                (first, last) => format!("world from {first} to {last}"),
            }
        });
        return Err(BadInput::file(
            path,
            format!("there is no {asked}: it holds {held}"),
        ));
    }
    let source = |number| BarnSource {
        path: path.to_owned(),
        number,
    };
    Ok(numbers.into_iter().map(source).collect())
}

/// Parses `FILE#N`, `FILE#A..=B` or `FILE`: the part of a world's name after `barn:`.
///
/// # Errors
/// As [`sources`]; an invalid number, an empty range.
pub(super) fn parse(text: &str) -> Result<Vec<BarnSource>, BadInput> {
    let Some((path, numbers)) = text.rsplit_once('#') else {
        return sources(Path::new(text), None);
    };
    sources(Path::new(path), Some(&range(numbers)?))
}

/// Parses `N` or `A..=B`.
///
/// # Errors
/// An invalid number, an empty range.
pub fn range(text: &str) -> Result<RangeInclusive<u32>, BadInput> {
    let number = |digits: &str| {
        let plain = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
        let number = if plain { digits.parse().ok() } else { None };
        number.ok_or_else(|| {
            let what = "is not the number of a world (N or A..=B, whole numbers)";
            BadInput::new(format!("\"{digits}\" {what}"))
        })
    };
    let (first, last) = text.split_once("..=").unwrap_or((text, text));
    let range = number(first)?..=number(last)?;
    if range.is_empty() {
        return Err(BadInput::new(format!(
            "\"{text}\": the range of worlds is empty"
        )));
    }
    Ok(range)
}

impl BarnSource {
    /// Builds the world; it is called `barn:N`.
    ///
    /// # Errors
    /// A file that cannot be read, is not what it should be, or does not hold the world.
    pub fn load(&self) -> Result<World, BadInput> {
        let shapes = if self.path.is_dir() {
            sdf::load(&self.path.join(format!("world_{}.world", self.number)))?
        } else if is_sdf(&self.path) {
            sdf::load(&self.path)?
        } else {
            let cells = cells(&self.path)?.into_iter();
            let own = cells.filter(|(number, _)| *number == self.number);
            own.map(|(_, cell)| cylinder(cell)).collect()
        };
        let start = Pose::new(START_M, FRAC_PI_2);
        let world = World::new(format!("barn:{}", self.number), start, shapes);
        let named = |error| BadInput::file(&self.path, format!("world {}: {error}", self.number));
        Ok(world.map_err(named)?.with_goal(GOAL_M))
    }
}

impl std::fmt::Display for BarnSource {
    /// As in a command: `barn:FILE#N`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "barn:{}#{}", self.path.display(), self.number)
    }
}

/// Filled cell (ix, iy) of the table: centered at x = −0.075 m − 0.15 m · ix, y = 0.075 m + 0.15 m
/// · iy.
fn cylinder([ix, iy]: [u16; 2]) -> Shape {
    let along = |index: u16| CELL_M * (f64::from(index) + 0.5);
    Shape::Circle {
        center: Point::new(-along(ix), along(iy)),
        radius: CELL_M / 2.0,
    }
}

fn is_sdf(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str());
    extension.is_some_and(|e| matches!(e.to_ascii_lowercase().as_str(), "world" | "sdf"))
}

/// N of `world_N.world`.
fn number_of(path: &Path) -> Option<u32> {
    let name = path.file_name()?.to_str()?;
    name.strip_prefix("world_")?
        .strip_suffix(".world")?
        .parse()
        .ok()
}

fn folder(path: &Path) -> Result<Vec<u32>, BadInput> {
    let unreadable = |error| BadInput::file(path, format!("cannot be read: {error}"));
    let mut numbers = Vec::new();
    for entry in std::fs::read_dir(path).map_err(unreadable)? {
        numbers.extend(number_of(&entry.map_err(unreadable)?.path()));
    }
    Ok(numbers)
}

/// Number of a world, and one of its filled cells.
type WorldCell = (u32, [u16; 2]);

fn cells(path: &Path) -> Result<Vec<WorldCell>, BadInput> {
    let source = path.display().to_string();
    let text = read_text(path, MAX_INPUT_BYTES)?;
    let records = Records::parse(&source, &text, None)?;
    if records.heading != ["world", "ix", "iy"] {
        let what = "a table of filled cells has the heading world,ix,iy";
        return Err(BadInput::line(&source, 1, what));
    }
    let row = |(line, fields): &(usize, Vec<&str>)| {
        let number = |column: usize, most: u32| {
            let field = fields.get(column).copied().unwrap_or_default();
            let number = field.parse::<u32>().ok().filter(|number| *number <= most);
            number.ok_or_else(|| {
                let what = format!("\"{field}\" is not a whole number from 0 to {most}");
                Table::cell(&source, *line, column, what)
            })
        };
        let most = u32::from(MAX_CELLS);
        Ok((
            number(0, u32::MAX)?,
            [number(1, most)? as u16, number(2, most)? as u16],
        ))
    };
    records.rows.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CSV: &str = "world,ix,iy\n3,0,0\n3,12,40\n7,29,65\n";

    fn put(name: &str, text: &str) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        (folder, path)
    }

    #[test]
    fn cells_become_cylinders_at_their_positions() {
        let (_folder, path) = put("cells.csv", CSV);
        let all = sources(&path, None).unwrap();
        assert_eq!(
            all.iter().map(|source| source.number).collect::<Vec<_>>(),
            [3, 7]
        );
        let world = all[0].load().unwrap();
        assert_eq!((world.name(), world.shapes().len()), ("barn:3", 2));
        let Shape::Circle { center, radius } = world.shapes()[1] else {
            panic!("a cylinder");
        };
        assert!(center.distance(Point::new(-1.875, 6.075)) < 1e-12);
        assert_eq!(
            (radius, world.start().position, world.goal()),
            (0.075, START_M, Some(GOAL_M))
        );
        let named = parse(&format!("{}#0..=5", path.display())).unwrap();
        assert_eq!(named, all[..1]);
        assert_eq!(named[0].to_string(), format!("barn:{}#3", path.display()));
    }

    #[test]
    fn published_files_give_the_same_world_as_cells() {
        let (folder, path) = put("cells.csv", "world,ix,iy\n3,0,0\n3,1,0\n");
        let model = |x: f64| {
            format!(
                "<model name='c'><static>1</static><pose frame=''>{x:.6} 0.075000 0 0 0 0</pose><link name='link'>\
             <collision name='c'><geometry><cylinder><radius>0.075</radius><length>1</length></cylinder></geometry>\
             </collision><visual name='v'><geometry><cylinder><radius>9</radius></cylinder></geometry></visual></link></model>\n"
            )
        };
        let text = format!(
            "<sdf version='1.6'><world name='default'>\n{}{}</world></sdf>",
            model(-0.075),
            model(-0.225)
        );
        std::fs::write(folder.path().join("world_3.world"), text).unwrap();
        let from_cells = sources(&path, None).unwrap()[0].load().unwrap();
        for source in [
            folder.path().to_owned(),
            folder.path().join("world_3.world"),
        ] {
            let found = sources(&source, Some(&(0..=9))).unwrap();
            let world = found[0].load().unwrap();
            assert_eq!((world.name(), world.shapes().len()), (from_cells.name(), 2));
            for (a, b) in world.shapes().iter().zip(from_cells.shapes()) {
                let (Shape::Circle { center: a, .. }, Shape::Circle { center: b, .. }) = (a, b)
                else {
                    panic!("cylinders");
                };
                assert!(a.distance(*b) < 1e-9);
            }
        }
    }

    #[test]
    fn errors_name_what_is_missing() {
        let (_folder, path) = put("cells.csv", CSV);
        let name = path.display();
        for (text, why) in [
            (
                format!("{name}#4"),
                "cells.csv: there is no world 4: it holds 2 worlds, 3 to 7",
            ),
            (format!("{name}#8..=20"), "no world from 8 to 20"),
            (format!("{name}#"), "\"\" is not the number of a world"),
            (format!("{name}#x"), "\"x\" is not the number of a world"),
            (format!("{name}#7..=3"), "empty"),
            ("nowhere.csv#1".to_owned(), "nowhere.csv: "),
            ("nowhere.world".to_owned(), "nowhere.world: "),
        ] {
            let found = parse(&text).and_then(|sources| sources[0].load().map(|_| ()));
            let error = found.expect_err(&text).to_string();
            assert!(error.contains(why), "{error}");
        }
        for (text, why) in [
            (
                "a,b,c\n1,2,3\n",
                "line 1: a table of filled cells has the heading world,ix,iy",
            ),
            ("1,2,3\n", "line 1: a table"),
            (
                "world,ix,iy\n1,2,3\n1,-2,3\n",
                "line 3, column 2: \"-2\" is not a whole number from 0 to 1000",
            ),
            ("world,ix,iy\n1,2,1001\n", "line 2, column 3"),
            (
                "world,ix,iy\n1,2\n",
                "line 2: 2 fields where the heading has 3",
            ),
            (
                "world,ix,iy\n1,13,20\n",
                "the robot would start inside something",
            ),
        ] {
            let (_folder, path) = put("bad.csv", text);
            let found = sources(&path, None).and_then(|sources| sources[0].load());
            let error = found.expect_err(text).to_string();
            assert!(error.contains("bad.csv") && error.contains(why), "{error}");
        }
    }
}
