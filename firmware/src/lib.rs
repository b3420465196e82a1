//! What the firmware decides, apart from the chip: everything here builds and is tested on a desktop machine.
//!
//! ```text
//!            serial interrupt              control                       serial interrupt
//! bytes ─► line::Line ─► queue ─► control::Control ─► amp::node::Node ─► line::Outbox ─► queue ─► line::Line ─► bytes
//! ```
//!
//! | module | what it decides |
//! |---|---|
//! | [`control`] | what is done with received bytes and with passing time |
//! | `cortex_m4` | kernels of the maps written for the processor |
//! | [`crash`] | what is kept over a reset, whether to believe it, and what to call the reset |
//! | [`lamp`] | when the lamp is lit |
//! | [`line`](mod@line) | how the serial interrupt moves bytes |
//! | [`persist`] | where in flash an image of the mind goes, and which one is the newest |
//! | [`pinout`] | which pin does what, and which pins must be left alone |
//! | [`sonar_ring`] | when which sonar fires, and what its echo means |
//! | [`stack`] | how deep the stack has been |
//! | [`vigil`] | whether the watchdog may be fed |
//!
//! The binary beside this library owns the chip: `main.rs` says which task runs when, `board.rs` is the only file that
//! touches pins and clocks.
#![no_std]
#![deny(unsafe_code)]
#![deny(missing_docs)]

#[cfg(test)]
extern crate std;

pub mod control;
#[cfg(all(target_arch = "arm", target_os = "none"))]
pub mod cortex_m4;
pub mod crash;
pub mod lamp;
pub mod line;
pub mod persist;
pub mod pinout;
#[cfg(feature = "qemu")]
pub mod provoke;
pub mod sonar_ring;
pub mod stack;
pub mod vigil;
