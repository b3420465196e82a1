//! Counts the controller's instructions on an emulated chip and prints them as a Markdown table.
//!
//! Single calls are counted on the data of an episode, with the same result in every run.
//! Instructions are not cycles: a Cortex-M4 takes 1 to 1.5 cycles per instruction.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod body;
#[cfg(target_os = "none")]
mod driven;
#[cfg(target_os = "none")]
mod episode;
#[cfg(target_os = "none")]
mod link;
#[cfg(target_os = "none")]
mod maps;
#[cfg(target_os = "none")]
mod modality;
#[cfg(target_os = "none")]
mod places;
#[cfg(target_os = "none")]
mod points;
#[cfg(target_os = "none")]
mod reference;
#[cfg(target_os = "none")]
mod room;
#[cfg(target_os = "none")]
mod stopwatch;
#[cfg(target_os = "none")]
mod table;

#[cfg(target_os = "none")]
use firmware as _;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this program is for the chip: run `cargo count` in tests/chip");
}
