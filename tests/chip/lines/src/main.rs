//! Counts the instructions of the firmware's lines of the log with the board's logger, which holds off every interrupt for
//! as long as a line takes, and those of the ring's driver.
//!
//! An image of its own: beside the firmware's packages the mind's calls would be compiled a little differently.
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
