//! Where robots live: worlds, what can be heard and touched in them, and how a base moves.
//!
//! Plain geometry in meters and radians. Nothing here knows a controller, an episode or a picture.

mod direction;
pub mod noise;
pub mod robot;
pub mod rooms;
pub mod sonar;
pub mod world;
