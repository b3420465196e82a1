//! Pictures of recorded episodes and maps, as SVG; [`png::render`] makes bitmaps of them.
//!
//! Same data, same bytes: fixed decimals, `libm` for angles, no hash order. Pages are 800 px wide,
//! text is at least 11 px. Colors: Okabe and Ito, viridis and cividis. World y points up the page;
//! in rosettes the ring's front points up and its left to the left.

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
mod save;
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
pub use behaviors::{ShownBehavior, behaviors};
pub use code_vectors::code_vectors;
pub use confusion::confusion;
pub use curves::{CurveKey, Curves, curves};
pub use dots::{DotPanel, DotSection, dot_plot};
pub use labeled_map::{LabeledMap, labeled_map};
pub use page::{Figure, index_html};
pub use path::path;
pub use save::save_picture;
pub use scatter::scatter;
pub use sequence::sequence;
pub use situation_map::{MapMarks, situation_map};
pub use sizes::sizes;
pub use u_matrix::u_matrix;
pub use worlds::worlds;
