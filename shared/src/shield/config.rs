//! Configuration of the shield: margins, lobes and times.

use crate::units::Bearing;
use serde::{Deserialize, Serialize};

/// Margins, lobes and times of the shield.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShieldConfig {
    /// Distance to keep between body and anything heard, millimeters.
    pub margin_mm: u16,
    /// Half the opening of a transducer's lobe.
    pub half_lobe: Bearing,
    /// Arcs kept per place of the ring, 1 … 4. The newest replaces the farthest, by the points that
    /// still count.
    pub places: u8,
    /// Echoes whose faces were less than this apart, with the same axis, come through one cone,
    /// millimeters: the newer replaces the older or contradicts all of it. Small, as a near corner
    /// leaves the lobe within a few centimeters.
    pub spacing_mm: u16,
    /// A direction is open only while the transducers that look there have been heard within this
    /// time, milliseconds.
    pub fresh_ms: u32,
    /// A transducer that was silent for longer than this may have been carried elsewhere: its arcs
    /// are dropped when it is heard again, milliseconds. While it is heard, arcs do not expire.
    pub forget_ms: u32,
    /// Displacements that would be shortened to less than this are not begun, millimeters.
    pub least_mm: u16,
    /// The shortest range the ring can report, millimeters: a reading this short may be anything
    /// nearer, so the place before it is closed as well.
    pub least_range_mm: u16,
    /// Highest speed of things that may come towards the robot, millimeters per second: every echo
    /// loses this much range per second of its age.
    pub approach_mm_s: u16,
}

impl ShieldConfig {
    /// From a face to the point that stands for all that is nearer than the shortest range,
    /// millimeters: halfway, or the margin where that is less. So nothing fits between the face and
    /// this point's margin.
    pub(super) fn before_mm(&self) -> i32 {
        (self.least_range_mm / 2).min(self.margin_mm).into()
    }
}
