//! The paper, claim by claim: its figures made anew, and what each sentence of its sections 2, 3 and 5.1 that can be
//! tested comes to when it is measured.
//!
//! C. Touzet, "Modeling and Simulation of Elementary Robot Behaviors using Associative Memories", International Journal of
//! Advanced Robotic Systems 3(2), 2006, 165–170.
//!
//! | module | what it makes |
//! |---|---|
//! | [`chain`] | Fig. 1: a chain of 32 neurons over points in space |
//! | [`miniature`] | Fig. 2: the situation map of a robot with eight sensors, driven by [`any_ring`] |
//! | [`decision`] | Fig. 3: one decision with every value in it |
//! | [`rooms`] | avoidance in many rooms, each decision watched: [`plans`], [`order`], [`gaps`], [`knowing`] |
//! | [`at_once`] | what a change of goal does to memory, maps and the next decision |
//! | [`measure`](mod@measure) | all measurements, from one seed |
//! | [`claims`] | the table: claim, measurement, verdict |
//!
//! Figures 4 and 5 are drawn from a recorded episode in the arena after Fig. 5. Everything is the maps alone, without the
//! shield. No seed is chosen by its result: the first is given, each room has the next one.

pub mod any_ring;
pub mod at_once;
pub mod chain;
pub mod claims;
pub mod decision;
pub mod gaps;
pub mod knowing;
pub mod measure;
pub mod miniature;
pub mod order;
pub mod plans;
pub mod rooms;
pub mod watch;

use amp::config::Config;
use arena::robot::TurretMode;

/// Decisions in each room.
pub const STEPS: u32 = 1_000;

/// One way to read what the paper leaves open; without the shield, for the paper has none.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// The preset's name.
    pub name: &'static str,
    /// Its open choices.
    pub config: Config<16>,
    /// What the ring does while the base steers.
    pub turret: TurretMode,
}

/// The presets: the best found, the best with the paper's four steps, the most literal.
#[must_use]
pub fn readings() -> [Reading; 3] {
    let bare = |name, mut config: Config<16>, turret| {
        config.shield = None;
        Reading {
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
