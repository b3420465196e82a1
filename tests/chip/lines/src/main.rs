//! Counts the instructions of the firmware's log lines, with the board's logger, and of its ring.
//!
//! A log line masks every interrupt while it is written. This image is separate from `counts`,
//! because the firmware's packages would change the code that is counted there.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod count;
#[cfg(target_os = "none")]
mod ring;
#[cfg(target_os = "none")]
#[path = "../../counts/src/stopwatch.rs"]
#[expect(dead_code, reason = "not every figure is printed here")]
mod stopwatch;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this program is for the chip: run `cargo count-lines` in tests/chip");
}
