//! What the fault detector reports.

use serde::{Deserialize, Serialize};

/// What is wrong with a transducer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SensorFault {
    /// It hears nothing any more.
    Dead,
    /// Its range never changes.
    Stuck,
    /// Its ranges are far below those of its neighbors.
    Short,
    /// Its range changes by more than the robot has moved.
    Jumping,
    /// It has never heard anything: it is dead, or nothing was in range.
    Unheard,
}

/// What the detector has decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SensorVerdict {
    /// Transducer.
    pub sensor: u8,
    /// Why it is disabled; `None` = it is enabled again.
    pub fault: Option<SensorFault>,
}
