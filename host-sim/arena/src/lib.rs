//! Simulated worlds, sonars in them, and motion of a base.
//!
//! Plain geometry in meters and radians, independent of controllers, episodes and pictures.
//! Dependencies: geometry ← shapes ← surfaces ← caster ← world ← {robot, robot_model, loaders},
//! robot_model ← sonar.

mod caster;
mod direction;
mod geometry;
pub mod loaders;
pub mod noise;
mod nomad;
#[cfg(test)]
mod reference;
pub mod robot;
pub mod robot_model;
pub mod route;
mod shapes;
pub mod sonar;
pub mod sources;
mod surfaces;
pub mod world;
