//! Dimensions of the Nomad 200.

/// Radius of the robot's disc for collisions, m (the Nomad 200 in ThinkingCap's robot file).
pub const COLLISION_RADIUS_M: f64 = 0.269;

/// Distance of the transducers' faces from the robot's center, m.
pub const FACE_RADIUS_M: f64 = 0.2305;

/// Number of bumper switches around the base, evenly spaced. Number 0 is in front; numbers increase
/// to the left.
pub const BUMPERS: u32 = 20;
