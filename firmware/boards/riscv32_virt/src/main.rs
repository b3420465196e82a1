//! The firmware on the emulated RISC-V machine `virt` of QEMU.
//!
//! One loop without interrupts moves bytes and runs the control task, each millisecond at least. It
//! has no flash for saved images and no ring.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod application;
#[cfg(target_os = "none")]
mod device;

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "This program is for an emulated machine: firmware/README.md says how to build and start it there."
    );
}
