//! Dimensions of the Nomad 200.

/// Radius of the disc that touches things, m (the Nomad 200 in ThinkingCap's robot file).
pub const COLLISION_RADIUS_M: f64 = 0.269;

/// Distance of the transducers' faces from the robot's center, m.
pub const FACE_RADIUS_M: f64 = 0.2305;

/// Bumper switches around the base, evenly spaced, number 0 in front, counted to the left.
pub const BUMPERS: u32 = 20;
