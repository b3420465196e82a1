//! Motion commands and their results.

/// A commanded displacement, in the ring frame at the time of the command.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BaseMotion {
    /// Along sonar 0, m.
    pub dx_m: f64,
    /// To the left of it, m.
    pub dy_m: f64,
    /// Maximum speed, m/s.
    pub speed_m_s: f64,
}

/// Result of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Executed {
    /// Whether the disc touched something; the motion ended there.
    pub touched: bool,
    /// Bit i: bumper switch i was pressed, 18°·i to the left of the base's front.
    pub bumpers: u32,
    /// Whether the base is still under way.
    pub moving: bool,
    /// Distance traveled, m.
    pub traveled_m: f64,
    /// Smallest gap between the disc and any surface along the path, m. May be infinite above the
    /// [limit of reported gaps](super::Base::limit_reported_gaps).
    pub min_clearance_m: f64,
}

impl Executed {
    /// No motion, and no gap reported.
    pub fn none() -> Self {
        Self {
            touched: false,
            bumpers: 0,
            moving: false,
            traveled_m: 0.0,
            min_clearance_m: f64::INFINITY,
        }
    }
}
