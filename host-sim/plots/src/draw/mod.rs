//! Drawing primitives: SVG text, colors, page layout, rosettes of a ring, worlds seen from above.

pub mod color;
pub mod layout;
pub mod marks;
pub mod rosette;
pub mod scene;
pub mod stretch;
pub mod svg;
