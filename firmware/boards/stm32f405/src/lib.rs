//! The firmware on an STM32F405: tasks, clocks, flash, faults, log. A board adds its crystal and its pins.
//!
//! | module | what it is |
//! |---|---|
//! | `application` | the tasks, as a macro that each board's program calls |
//! | `chip` | watchdog, reset flags, devices |
//! | `clocks` | crystal or internal oscillator |
//! | `fault` | what is kept of a crash |
//! | [`feather_f405`] | Adafruit Feather STM32F405 Express |
//! | `flash` | the two sectors that outlive a loss of power |
//! | `log` | where the log goes |
//! | [`olimex_h405`] | Olimex STM32-H405 |
//! | [`pinout`] | what each board uses its pins for |
//! | `ring_timer` | the clock of the ring of sonars |
//! | `serial` | the serial port of the link |
//!
//! On a desktop machine only the pin tables are built.
#![no_std]

#[cfg(test)]
extern crate std;

#[cfg(target_os = "none")]
mod application;
#[cfg(target_os = "none")]
pub mod chip;
#[cfg(target_os = "none")]
pub mod clocks;
#[cfg(target_os = "none")]
pub mod fault;
pub mod feather_f405;
#[cfg(target_os = "none")]
pub mod flash;
#[cfg(target_os = "none")]
mod log;
pub mod olimex_h405;
pub mod pinout;
#[cfg(target_os = "none")]
pub mod ring_timer;
#[cfg(target_os = "none")]
pub mod serial;
