//! Counts the instructions of the mind's calls on an emulated chip and prints them as a table in Markdown.
//!
//! Everything is counted one call at a time on the data of an episode that is driven on the spot: the same program counts
//! the same on every run. Instructions are not cycles: a Cortex-M4 takes from 1 to some 1.5 of these per instruction.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod episode;
#[cfg(target_os = "none")]
mod link;
#[cfg(target_os = "none")]
mod maps;
#[cfg(target_os = "none")]
mod reference;
#[cfg(target_os = "none")]
mod room;
#[cfg(target_os = "none")]
mod stopwatch;
#[cfg(target_os = "none")]
mod table;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this program is for the chip: run `cargo count` in tests/chip");
}
