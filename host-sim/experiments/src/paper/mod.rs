//! The paper, claim by claim: its figures redrawn, and every testable sentence measured.
//!
//! C. Touzet, "Modeling and Simulation of Elementary Robot Behaviors using Associative Memories",
//! International Journal of Advanced Robotic Systems 3(2), 2006, 165–170; sections 2 to 5.
//! All runs are without the shield. No seed is selected by its result.

mod aims;
pub mod any_ring;
pub mod arms;
pub mod chain;
pub mod claims;
pub mod controls;
pub mod decision;
pub mod far_goals;
pub mod gaps;
pub mod goal_switch;
pub mod measure;
pub mod miniature;
pub mod observer;
pub mod plans;
pub mod recall;
mod ring_sizes;
pub mod rooms;
pub mod topology;

use amp::config::Config;
use arena::robot::TurretMode;

/// Decisions in each room.
pub const STEPS: u32 = 1_000;

/// One reading of what the paper leaves open. Without the shield, as in the paper.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperReading {
    /// Name of the preset.
    pub name: &'static str,
    /// Its configuration.
    pub config: Config<16>,
    /// Motion of the turret while the base steers.
    pub turret: TurretMode,
}

/// The presets: the best found, the best with the paper's four steps, the most literal.
#[must_use]
pub fn readings() -> [PaperReading; 3] {
    let bare = |name, mut config: Config<16>, turret| {
        config.shield = None;
        PaperReading {
            name,
            config,
            turret,
        }
    };
    [
        bare("default", Config::recommended(), TurretMode::Held),
        bare("probe", Config::probing(), TurretMode::Held),
        bare("touzet", Config::touzet(), TurretMode::Follow),
    ]
}
