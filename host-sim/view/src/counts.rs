//! Counts of a drive, as the page shows them.

use super::snapshot::Rounded;
use serde::Serialize;

/// Counts since the start.
#[derive(Debug, Clone, Default, Serialize)]
pub struct DriveCounts {
    /// Random moves, and those with a contact.
    pub explored: [u32; 2],
    /// Decisions with a goal.
    pub steps: u32,
    /// Those with a contact.
    pub contacts: u32,
    /// Those that the shield shortened.
    pub shielded: u32,
    /// Those at the goal.
    pub at_goal: u32,
    /// Path length, meters.
    pub distance_m: Rounded,
    /// Least gap to any surface, meters.
    pub clearance_m: Option<Rounded>,
    /// Area swept, square meters, if known.
    pub coverage_m2: Option<Rounded>,
}
