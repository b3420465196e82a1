//! The worlds that come with the program, as world files.

use super::toml_file;
use crate::world::World;
use files::error::BadInput;

/// Name and text of each built-in world.
pub(super) const WORLDS: &[(&str, &str)] = &[
    ("paper", include_str!("../../../worlds/paper.toml")),
    ("room", include_str!("../../../worlds/room.toml")),
    ("corridor", include_str!("../../../worlds/corridor.toml")),
    ("office", include_str!("../../../worlds/office.toml")),
    ("posts", include_str!("../../../worlds/posts.toml")),
];

impl World {
    /// The built-in world called `name`.
    ///
    /// # Errors
    /// When there is none of that name; the sentence suggests the nearest one.
    pub fn builtin(name: &str) -> Result<Self, BadInput> {
        match WORLDS.iter().find(|(known, _)| *known == name) {
            Some((known, text)) => toml_file::parse(text, known, known),
            None => Err(BadInput::unknown("world", name, &Self::builtin_names())),
        }
    }

    /// The arena of the paper's Fig. 5 (Touzet 2006): a room with walls and smaller obstacles; the
    /// robot starts in the center and moves to the right.
    ///
    /// # Errors
    /// None in practice: the text is part of the program, and tested.
    pub fn paper() -> Result<Self, BadInput> {
        Self::builtin("paper")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::COLLISION_RADIUS_M;

    #[test]
    fn every_builtin_world_loads_under_its_own_name_with_room_to_start() {
        for (name, _) in WORLDS {
            let world = World::builtin(name).unwrap();
            assert_eq!(world.name(), *name);
            let start = world.start();
            assert!(
                world.clearance(start.position) > 2.0 * COLLISION_RADIUS_M,
                "{name}"
            );
        }
        let error = World::builtin("offce").unwrap_err().to_string();
        assert!(error.contains("did you mean \"office\"?"), "{error}");
    }

    #[test]
    fn the_papers_robot_starts_in_the_center_and_looks_right() {
        let world = World::paper().unwrap();
        let (low, high) = world.bounds();
        let start = world.start();
        assert!(((low + high) * 0.5).distance(start.position) < 1e-9);
        assert_eq!(start.heading, 0.0);
    }
}
