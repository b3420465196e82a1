//! What the base is asked to do, and what it did.

/// A displacement to carry out, in the ring frame of the moment it is given.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BaseMotion {
    /// Along sonar 0, m.
    pub dx_m: f64,
    /// To the left of it, m.
    pub dy_m: f64,
    /// Speed not to be exceeded, m/s.
    pub speed_m_s: f64,
}

/// What the base really did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Executed {
    /// Whether the disc touched something; the motion ended there.
    pub touched: bool,
    /// Bit i: bumper switch i was pressed, 18°·i to the left of the base's front.
    pub bumpers: u32,
    /// Whether the base is still under way.
    pub moving: bool,
    /// Length of the way traveled, m.
    pub traveled_m: f64,
    /// Least gap between the disc and any surface along the way, m; perhaps infinite where it is
    /// [not wanted](super::Base::tell_gaps_below).
    pub min_clearance_m: f64,
}

impl Executed {
    /// Nothing, and no gap reported.
    pub(super) fn nothing_yet() -> Self {
        Self {
            touched: false,
            bumpers: 0,
            moving: false,
            traveled_m: 0.0,
            min_clearance_m: f64::INFINITY,
        }
    }
}
