//! What the base is asked to do, and what it did.

/// A displacement to carry out, in the ring frame of the moment it is given.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// Along sonar 0, m.
    pub dx_m: f64,
    /// To the left of it, m.
    pub dy_m: f64,
    /// Speed not to be exceeded, m/s.
    pub speed_m_s: f64,
}

/// What the base really did, in the ring frame as it was at the beginning.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Executed {
    /// True displacement along sonar 0, m.
    pub dx_m: f64,
    /// True displacement to the left of it, m.
    pub dy_m: f64,
    /// Displacement along sonar 0 as the odometry has it, m: without slip.
    pub odometry_dx_m: f64,
    /// Displacement to the left as the odometry has it, m.
    pub odometry_dy_m: f64,
    /// How far the ring turned, rad in [−π, π), to the left.
    pub turned_rad: f64,
    /// Whether the disc touched something; the motion ended there.
    pub touched: bool,
    /// Bit i: bumper switch i was pressed, 18°·i to the left of the base's front.
    pub bumpers: u32,
    /// Whether the base is still under way.
    pub moving: bool,
    /// Length of the way travelled, m.
    pub travelled_m: f64,
    /// Least gap between the disc and any surface along the way, m; perhaps infinite where
    /// [nobody asked](super::Base::tell_gaps_below).
    pub min_clearance_m: f64,
}
