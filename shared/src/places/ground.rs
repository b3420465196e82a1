//! The ground around the robot, as its points tell.

use crate::points::PointMemory;
use crate::units::Displacement;

/// Where the body may go.
#[derive(Clone, Copy)]
pub(super) struct Ground<'p, const POINTS: usize> {
    pub(super) points: &'p PointMemory<POINTS>,
    /// Radius of the body and the room it keeps, millimeters.
    pub(super) radius_mm: u16,
    /// Narrow ways count as well: what returned an echo stands where beams have left it, not on
    /// its beam's axis.
    pub(super) is_narrow: bool,
}

impl<const POINTS: usize> Ground<'_, POINTS> {
    /// So many ways take as long as `steps` wide ones.
    pub(super) const fn steps(&self, steps: u16) -> u16 {
        if self.is_narrow {
            steps.div_ceil(2)
        } else {
            steps
        }
    }

    /// How far the body may go from a position beside the robot, millimeters.
    pub(super) fn free_mm(&self, from: Displacement, way: Displacement) -> u16 {
        if self.is_narrow {
            self.points.likely_free_mm(from, way, self.radius_mm)
        } else {
            self.points.free_from_mm(from, way, self.radius_mm)
        }
    }

    /// Whether the body may go this way from here.
    pub(super) fn fits(&self, way: Displacement) -> bool {
        self.free_mm(Displacement::ZERO, way) >= way.length_mm()
    }

    /// Whether it may with so much more room, millimeters.
    pub(super) fn fits_with(&self, room_mm: u16, way: Displacement) -> bool {
        let radius_mm = self.radius_mm.saturating_add(room_mm);
        Self { radius_mm, ..*self }.fits(way)
    }
}
