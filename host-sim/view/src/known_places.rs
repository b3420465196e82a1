//! A memory of places, as the page shows it.

use super::snapshot::{Rounded, Xy};
use serde::Serialize;

/// A memory of places, where the robot takes them to be in the world, meters.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct PlacesDto {
    /// Positions.
    pub places: Vec<Xy>,
    /// Indices of two places between which the robot went.
    pub links: Vec<[u16; 2]>,
    /// Indices of two places between which the way is blocked.
    pub blocked: Vec<[u16; 2]>,
    /// Open ways: from a place to where the robot has not been.
    pub frontiers: Vec<[Xy; 2]>,
    /// Where it perceived what is sought in another modality, and how strongly, 0 to 1.
    pub sensed: Vec<(Xy, Rounded)>,
    /// Where it may be after it was set down elsewhere, and how much speaks for that, 0 to 1.
    pub guesses: Vec<(Xy, Rounded)>,
}
