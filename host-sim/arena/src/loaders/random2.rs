//! Random worlds of twelve kinds: corridors, rooms, mazes, traps, furniture and more.
//!
//! The seed selects the kind and draws its sizes; the same seed gives a bit-identical world on
//! every machine. See docs/worlds.md.

use crate::geometry::{Point, Pose};
use crate::noise::Noise;
use crate::shapes::Shape;
use crate::world::World;
use reach::reaches;

mod furniture;
mod grid;
mod halls;
mod loops;
mod reach;
mod scattered;
mod site;
mod spine;
#[cfg(test)]
mod tests;

/// Smallest distance of any surface from the start, m.
const START_CLEARANCE_M: f64 = 0.6;
/// Smallest and largest longer side of a world, m.
const SIDE_M: (f64, f64) = (6.0, 20.0);

/// Kind of a world of [`World::random2`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum WorldKind {
    /// A narrow corridor with bends behind a small lobby; it ends blind.
    Corridor,
    /// Rooms connected by doors.
    Rooms,
    /// A long hall with two rows of pillars.
    Hall,
    /// Dead ends in the shape of a U; the first opens toward the start.
    Traps,
    /// Round posts of all sizes.
    Posts,
    /// Convex and concave polygons at any angle.
    Polygons,
    /// A maze on a grid of squares.
    Maze,
    /// Barriers from both sides of a hall in turn.
    Slalom,
    /// Many small things close together.
    Clutter,
    /// A corridor around one or more blocks.
    Loops,
    /// Diagonal walls that narrow and widen.
    Wedges,
    /// Thin legs of tables and chairs, and cabinets at the walls.
    Furniture,
}

impl WorldKind {
    /// All kinds; that of a seed stands at the seed modulo their number.
    pub const ALL: [Self; 12] = [
        Self::Corridor,
        Self::Rooms,
        Self::Hall,
        Self::Traps,
        Self::Posts,
        Self::Polygons,
        Self::Maze,
        Self::Slalom,
        Self::Clutter,
        Self::Loops,
        Self::Wedges,
        Self::Furniture,
    ];

    /// The kind of the world `random2:SEED`.
    #[must_use]
    pub fn of_seed(seed: u64) -> Self {
        Self::ALL[(seed % Self::ALL.len() as u64) as usize]
    }

    /// Its name in tables: one word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Corridor => "corridor",
            Self::Rooms => "rooms",
            Self::Hall => "hall",
            Self::Traps => "traps",
            Self::Posts => "posts",
            Self::Polygons => "polygons",
            Self::Maze => "maze",
            Self::Slalom => "slalom",
            Self::Clutter => "clutter",
            Self::Loops => "loops",
            Self::Wedges => "wedges",
            Self::Furniture => "furniture",
        }
    }

    fn draw(self, noise: &mut Noise) -> Floor {
        match self {
            Self::Corridor => spine::corridor(noise),
            Self::Rooms => grid::rooms(noise),
            Self::Hall => halls::hall(noise),
            Self::Traps => scattered::traps(noise),
            Self::Posts => scattered::posts(noise),
            Self::Polygons => scattered::polygons(noise),
            Self::Maze => grid::maze(noise),
            Self::Slalom => halls::slalom(noise),
            Self::Clutter => scattered::clutter(noise),
            Self::Loops => loops::loops(noise),
            Self::Wedges => spine::wedges(noise),
            Self::Furniture => furniture::furniture(noise),
        }
    }
}

/// What a kind draws.
struct Floor {
    /// The shapes; the first is the outer wall.
    shapes: Vec<Shape>,
    /// Where the robot starts; it looks along x.
    start: Point,
}

impl World {
    /// A closed world of the kind [`WorldKind::of_seed`], 6 … 20 m long, named `random2:SEED`.
    /// Nothing is nearer to the start than 0.6 m, and a disc of 0.35 m radius covers at least 8 m²
    /// from there.
    #[must_use]
    pub fn random2(seed: u64) -> Self {
        let kind = WorldKind::of_seed(seed);
        let mut noise = Noise::new(seed);
        // Most drawings are sound, so this ends soon.
        loop {
            let Floor { shapes, start } = kind.draw(&mut noise);
            let pose = Pose::new(start, 0.0);
            let world = Self::unchecked(format!("random2:{seed}"), pose, shapes);
            if is_sound(&world) {
                return world;
            }
        }
    }
}

fn is_sound(world: &World) -> bool {
    let start = world.start().position;
    let (low, high) = world.bounds();
    let longer = (high.x - low.x).max(high.y - low.y);
    (SIDE_M.0..=SIDE_M.1).contains(&longer)
        && !world.is_inside(start)
        && world.clearance(start) >= START_CLEARANCE_M
        && reaches(world, start)
}
