//! Pictures of what a robot did and what its maps learned, as SVG text drawn from recorded values only.
//!
//! Every picture function takes plain records and returns one SVG document; [`png::render`] turns any of them into a
//! bitmap with the bundled font. The same data give the same bytes on every machine: numbers are printed with fixed
//! decimals, angles go through `libm`, nothing is iterated in hash order.
//!
//! Pictures are laid out for a page of 800 px: no text is smaller than 11 px there. Colors are the color-blind-safe
//! ones of Okabe and Ito, with viridis and cividis for continuous values. World y points up the page; in rosettes the
//! front of the ring points up and its left to the left.

mod action_map;
mod behaviors;
mod code_vectors;
mod confusion;
mod curves;
pub mod demo;
mod dots;
pub mod draw;
mod labeled_map;
pub mod page;
mod path;
pub mod png;
mod scatter;
mod sequence;
mod sequence_panels;
mod situation_map;
mod sizes;
mod u_matrix;
mod worlds;

#[cfg(test)]
pub(crate) mod fixture;

pub use action_map::action_map;
pub use behaviors::{Shown, behaviors};
pub use code_vectors::code_vectors;
pub use confusion::confusion;
pub use curves::{Curves, Key, curves};
pub use dots::{DotPanel, DotSection, dot_plot};
pub use labeled_map::{LabeledMap, labeled_map};
pub use page::{Figure, index_html};
pub use path::path;
pub use scatter::scatter;
pub use sequence::sequence;
pub use situation_map::{MapMarks, situation_map};
pub use sizes::sizes;
pub use u_matrix::u_matrix;
pub use worlds::worlds;
