//! **Associative memory programming**: a robot explores with 100 random moves, and from then on any
//! behavior is had at once by naming a *goal situation*.
//!
//! The method is that of C. Touzet, "Modeling and Simulation of Elementary Robot Behaviors using
//! Associative Memories", International Journal of Advanced Robotic Systems 3(2), 2006, 165–170
//! (doi 10.5772/5742); *the paper* below. Two self-organizing maps (T. Kohonen, *Self-Organizing
//! Maps*, Springer 2001) of 16 neurons do the work:
//!
//! * the **situation map** knows what can be perceived: its code vectors are situations;
//! * the **action map** knows which action brings which change of situation: its code vectors are
//!   (change, action) pairs.
//!
//! # The way of the data
//!
//! ```text
//! echoes ─► Scan ─► Situation ─► Controller ──────────────────────► Shield ─► Motion
//!                                 │ Explore: random action, remember (S, a, S')
//!                                 │ Learn:   memory ─► situation map, action map
//!                                 └ Seek:    goal ─► neuron ─► neighbor ─► change ─► action
//! ```
//!
//! [`controller::handle`] is the whole robot as one pure function of configuration, state and
//! event: integer arithmetic, no clock, no global randomness, no input or output. The same events
//! give the same bytes on a microcontroller and on a desktop machine.
//!
//! # Modules
//!
//! | module | what it knows |
//! |---|---|
//! | [`fixed`] | the number formats of the maps, dot products, roots, exponentials |
//! | [`units`] | millimeters, milliseconds, bearings, displacements |
//! | [`robot`] | ring geometry and limits: the robots differ in data only |
//! | [`scan`] | ranges with age and validity, and the situation made of them |
//! | [`som`] | self-organizing maps: the crate `tinysom` |
//! | [`action_map`] | the map of (change of situation, action) |
//! | [`memory`] | the lazy memory of samples |
//! | [`goal`] | behaviors as goal situations |
//! | `graph` | which situation followed which, by what displacement (feature `graph`) |
//! | [`modality`] | what else is perceived, where and when: a scent, the light |
//! | [`places`] | where the robot was, and the way back by sub-goals |
//! | [`sequence`] | sequences of patterns, recalled by a pair of associative memories |
//! | [`planner`] | the paper's four steps, with every intermediate value |
//! | [`faults`] | detects faulty transducers |
//! | [`calibration`] | where the sensors of a body look, learned from random moves |
//! | [`points`] | points of echoes in the odometry frame, and a ring of sectors read off them |
//! | [`shield`] | limits how far and how fast, by the echoes of the ring |
//! | [`turret`] | any body's sensors as a ring that keeps its bearing in the world |
//! | [`config`] | every open choice of the method as a named value; the presets |
//! | [`controller`] | modes and events: the robot as a function |
//! | [`couple`] | two maps for any body: an action is one value per actuator |
//! | [`wire`] | messages and frames of the link to the base |
//! | [`link`] | session, order and age of frames, and whether the host is alive |
//! | [`parameters`] | configuration values by name: over the link, and the table of settings |
//! | [`node`] | the controller behind a link: frames in, frames out |
//! | [`store`] | the saved image: configuration, body, maps, memory, places and goals |
//!
//! # Features
//!
//! | feature | default | brings |
//! |---|---|---|
//! | `link` | yes | [`wire`], [`link`], [`node`]: the controller behind a serial link (needs `store`) |
//! | `store` | yes | [`store`]: the saved image |
//! | `faults` | yes | fault detection; without it [`faults::Detector`] detects nothing |
//! | `graph` | no | plans over the graph of traversed situations (`PlannerKind::Traversed`) |
//! | `defmt` | no | `defmt::Format` for units, motions, modes, refusals and faults |
//!
//! # Limits
//!
//! Rings of at most 32 transducers; maps of at most 32 neurons inside the controller ([`som`] has
//! no such limit). No `unsafe`, no allocation, and no panic that data can reach.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)
)]

#[cfg(test)]
extern crate std;

#[cfg(all(
    test,
    not(all(feature = "faults", feature = "link", feature = "store"))
))]
compile_error!("the tests of this crate need the features faults, link and store");

/// The examples of the crate's page run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub mod action_map;
pub mod actuation;
mod arrays;
pub mod body;
pub mod calibration;
#[cfg(feature = "store")]
mod checksum;
pub mod config;
pub mod controller;
pub mod couple;
mod disc;
#[cfg(feature = "faults")]
pub mod faults;
#[cfg(not(feature = "faults"))]
#[path = "faults/absent.rs"]
pub mod faults;
pub mod goal;
#[cfg(feature = "graph")]
pub mod graph;
#[cfg(feature = "link")]
pub mod link;
pub mod memory;
pub mod modality;
#[cfg(feature = "link")]
pub mod node;
pub mod parameters;
pub mod places;
pub mod planner;
pub mod points;
pub mod robot;
pub mod scan;
pub mod sequence;
pub mod shield;
#[cfg(feature = "store")]
pub mod store;
pub mod turret;
pub mod units;
#[cfg(feature = "link")]
pub mod wire;

pub use tinysom::{self as som, fixed};
