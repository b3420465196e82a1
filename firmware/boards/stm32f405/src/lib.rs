//! The firmware on an STM32F405; each board adds its crystal and its pins.
//!
//! | module | what it is |
//! |---|---|
//! | `application` | the tasks, as a macro that each board's program calls |
//! | `chip` | watchdog, reset flags, LED, supply monitor |
//! | `clocks` | crystal or internal oscillator |
//! | `fault` | crash handlers and the crash record |
//! | [`feather_f405`] | Adafruit Feather STM32F405 Express |
//! | `flash` | the two sectors for saved images |
//! | `log` | the transport of the log |
//! | [`olimex_h405`] | Olimex STM32-H405 |
//! | [`pinout`] | pin tables of the boards |
//! | `ring_timer` | the timer of the ring of sonars |
//! | `serial` | the serial port of the link |
//!
//! On a desktop machine only the pin tables are built.
#![no_std]

#[cfg(test)]
extern crate std;

/// What the program is for.
#[cfg(feature = "places")]
pub type RobotBody = firmware::AnyBodyWithPlaces;
/// What the program is for.
#[cfg(all(feature = "any-body", not(feature = "places")))]
pub type RobotBody = firmware::AnyBody;
/// What the program is for.
#[cfg(not(feature = "any-body"))]
pub type RobotBody = amp::body::HeldRing;

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
