//! The portable firmware: what it decides, apart from any chip. Everything here builds and is tested on a desktop machine.
//!
//! ```text
//!            serial interrupt              control                       serial interrupt
//! bytes ─► uart::Line ─► queue ─► control::Control ─► amp::node::Node ─► uart::TxQueue ─► queue ─► uart::Line ─► bytes
//! ```
//!
//! | module | what it decides |
//! |---|---|
//! | [`clock`] | which oscillator clocks the processor |
//! | [`control`] | what is done with received bytes and with passing time |
//! | [`crash`] | what is kept over a reset, whether to believe it, and what to call the reset |
//! | [`status_led`] | when the lamp is lit |
//! | [`uart`] | how the serial interrupt moves bytes |
//! | [`persist`] | where in flash an image of the mind goes, and which one is the newest |
//! | [`safety`] | what emergency stop, bumper and motion permit do |
//! | [`sonar_ring`] | when which sonar fires, and what its echo means |
//! | [`stack`] | how deep the stack has been |
//! | [`task_monitor`] | whether the watchdog may be fed |
//!
//! The packages in `boards/` own the chips: each says what runs when, and is the only place that touches pins and clocks.
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
pub mod sonar_ring;
pub mod stack;
pub mod status_led;
pub mod task_monitor;
pub mod uart;

/// The commit this was built from, as eight characters; the version where there is no commit.
pub const BUILD: [u8; 8] = match env!("FIRMWARE_BUILD").as_bytes().first_chunk() {
    Some(name) => *name,
    None => panic!("build.rs writes eight characters"),
};
