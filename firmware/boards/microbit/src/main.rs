//! The firmware on a BBC micro:bit, version 1: an nRF51822 with a Cortex-M0 at 16 MHz and 16 KiB of memory.
//!
//! Two interrupts and a loop: the serial interrupt moves bytes, the timer counts milliseconds, the loop runs the control
//! task when a frame has come, each 10 ms, and while there is more to do. There is neither flash nor a ring.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod application;
#[cfg(target_os = "none")]
mod device;

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "This program is for the micro:bit: firmware/README.md says how to build and start it there or in an emulator."
    );
}
