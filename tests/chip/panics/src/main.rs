//! Every entry point of the mind, linked for the chip with a panic handler that calls a function nobody has.
//!
//! The linker drops what is unreachable. If it finds the handler unreachable, this links, and the mind has no path to a
//! panic for any input; if it does not, the function is missing. Never run: it is the linking that counts.
//!
//! Every argument goes through [`black_box`] and every result into it, so that the compiler may assume nothing of either.
#![no_std]
#![no_main]

mod arithmetic;
mod maps;
mod robot;
mod wire;

use core::hint::black_box;
use core::panic::PanicInfo;

#[expect(unsafe_code, reason = "whoever calls it must not link")]
// SAFETY: there is no such function.
unsafe extern "C" {
    safe fn a_path_to_a_panic_is_left() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    a_path_to_a_panic_is_left()
}

#[expect(unsafe_code, reason = "the linker looks for this name")]
// SAFETY: nothing else in this program has the name.
#[unsafe(no_mangle)]
extern "C" fn _start() -> ! {
    arithmetic::all();
    maps::all();
    robot::all();
    wire::all();
    #[cfg(feature = "deliberate-panic")]
    sink(black_box(&BYTES[..])[any(3_usize)]);
    loop {
        core::hint::spin_loop();
    }
}

/// Room for bytes of which the compiler knows neither length nor content.
static BYTES: [u8; 512] = [0; 512];

/// Any bytes.
fn bytes() -> &'static [u8] {
    black_box(&BYTES[..])
}

/// Any value of a type.
fn any<T>(value: T) -> T {
    black_box(value)
}

/// Keeps a result from being optimized away.
fn sink<T>(value: T) {
    let _ = black_box(value);
}

/// Keeps a text from being optimized away.
fn format_text(text: impl core::fmt::Display) {
    struct Nowhere;
    impl core::fmt::Write for Nowhere {
        fn write_str(&mut self, text: &str) -> core::fmt::Result {
            sink(text);
            black_box(Ok(()))
        }
    }
    sink(core::fmt::write(&mut Nowhere, format_args!("{text}")));
}
