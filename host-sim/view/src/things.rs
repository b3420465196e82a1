//! What stands in the world, and what else can be perceived there, as the page shows it.

use super::snapshot::{Rounded, Xy};
use serde::Serialize;

/// A shape of the world.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ShapeDto {
    /// A chain of straight segments.
    Wall(Vec<Xy>),
    /// The corners of a box, which can be moved.
    Box(Vec<Xy>),
    /// Center and radius of a post, which can be moved.
    Circle(Xy, Rounded),
}

/// A source of something that can be perceived. It can be moved.
#[derive(Debug, Clone, Serialize)]
pub struct SourceDto {
    /// `floor`, `scent` or `light`.
    pub kind: &'static str,
    /// Its center.
    pub at: Xy,
    /// Over this distance a scent falls to 1/e and light to a half, meters.
    pub reach_m: Rounded,
    /// The corners of colored floor.
    pub outline: Vec<Xy>,
    /// Color of the floor, `#rrggbb`.
    pub color: Option<String>,
}

/// What can be perceived where the robot is, 0 to 1.
#[derive(Debug, Clone, Serialize)]
pub struct SensedDto {
    /// Strength of the scent.
    pub scent: Rounded,
    /// Brightness.
    pub light: Rounded,
    /// Color of the floor, `#rrggbb`.
    pub floor: String,
}
