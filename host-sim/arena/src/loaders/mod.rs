//! Sources of worlds: files, maps, seeds, and built-in worlds.
//!
//! Adds constructors to [`World`]; the world itself does not depend on them.

use std::path::Path;

use crate::world::World;
use files::error::BadInput;

pub mod barn;
mod builtin;
mod graymap;
mod image;
pub(crate) mod occupancy;
mod pgm;
mod random;
mod random2;
pub mod rooms;
mod ros_map;
mod sdf;
mod spec;
mod toml_file;

pub use random2::WorldKind;
pub use spec::{WorldSource, parse_worlds};

impl World {
    /// Reads a world from a `.toml` world file or a ROS map_server `.yaml` or `.yml` file.
    ///
    /// # Errors
    /// When the file is missing, is not what its extension says, or describes an impossible world.
    pub fn load(path: &Path) -> Result<Self, BadInput> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        match extension.to_ascii_lowercase().as_str() {
            "toml" => toml_file::load(path),
            "yaml" | "yml" => ros_map::load(path),
            _ => Err(BadInput::file(
                path,
                "a world is a .toml world file or a .yaml map of the ROS map_server",
            )),
        }
    }

    /// Reads the text of a TOML world file; `source` names it in errors, and names the world if it
    /// has no `name` of its own.
    ///
    /// # Errors
    /// Like [`World::load`].
    pub fn from_toml(text: &str, source: &str) -> Result<Self, BadInput> {
        toml_file::parse(text, source, source)
    }
}
