//! The firmware on a BBC micro:bit, version 1: nRF51822, Cortex-M0 at 16 MHz, 16 KiB of RAM.
//!
//! The serial interrupt moves bytes and the timer counts milliseconds. The main loop runs the
//! control task when a frame has arrived, each 10 ms, and while work is left. It has no flash for
//! saved images and no ring.
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
