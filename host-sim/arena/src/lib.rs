//! Where robots live: worlds, what can be heard and touched in them, and how a base moves.
//!
//! Plain geometry in meters and radians. Nothing here knows a controller, an episode or a picture.
//! Who may use whom: geometry ← shapes ← surfaces ← caster ← world ← {sonar, robot, loaders}.

mod caster;
mod direction;
mod geometry;
pub mod loaders;
pub mod noise;
mod nomad;
#[cfg(test)]
mod reference;
pub mod robot;
mod shapes;
pub mod sonar;
mod surfaces;
pub mod world;
