//! The portable part of the firmware: every decision that does not depend on a chip.
//! It builds and is tested on a desktop machine, and never touches a register.
//!
//! ```text
//! received bytes: interrupt, uart::UartDriver ─► queue ─► control::Control ─► amp::node::Node
//! sent bytes:     amp::node::Node ─► uart::TxQueue ─► queue ─► interrupt, uart::UartDriver
//! ```
//!
//! | module | what it decides |
//! |---|---|
//! | [`clock`] | which oscillator clocks the processor |
//! | [`control`] | how received bytes and elapsed time are processed |
//! | [`crash`] | what a crash record holds, whether it is valid, and the cause of a reset |
//! | [`persist`] | where in flash an image goes, and which image is the newest |
//! | [`safety`] | what emergency stop, bumper and motion permit do |
//! | [`sonar_ring`] | when each sonar fires, and what its echo means |
//! | [`stack`] | how deep the stack has been |
//! | [`status_led`] | when the status LED is lit |
//! | [`task_monitor`] | whether the watchdog may be fed |
//! | [`uart`] | how the serial interrupt moves bytes |
//!
//! Each package in `boards/` owns a chip: its tasks, pins and clocks.
#![no_std]
#![deny(unsafe_code)]
#![deny(missing_docs)]

#[cfg(test)]
extern crate std;

pub mod clock;
pub mod control;
pub mod crash;
#[cfg(feature = "crash-test")]
pub mod crash_test;
pub mod persist;
pub mod safety;
pub mod seldom;
pub mod sonar_ring;
pub mod stack;
pub mod status_led;
pub mod task_monitor;
pub mod uart;

/// Sensors anywhere on a body, at most 16: with the feature `any-body` of a board.
pub type AnyBody = amp::body::MountedSensors<16, 16, 256, 0>;

/// The same with a memory of 256 places: with the feature `places` of a board.
pub type AnyBodyWithPlaces = amp::body::MountedSensors<16, 16, 256, 256>;

/// Commit of this build, eight characters; the package version where there is no commit.
pub const BUILD: [u8; 8] = match env!("FIRMWARE_BUILD").as_bytes().first_chunk() {
    Some(name) => *name,
    None => panic!("build.rs writes eight characters"),
};
