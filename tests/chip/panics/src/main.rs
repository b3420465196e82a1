//! Every entry point of the controller, linked with a panic handler that calls a missing function.
//!
//! The linker drops unreachable code. If no input can reach a panic, the handler is unreachable and
//! this links; otherwise linking fails. The program is never run. Every argument and every result
//! passes through [`black_box`], so that the compiler can assume nothing about it.
#![no_std]
#![no_main]

mod arithmetic;
mod maps;
mod robot;
mod wire;

use core::hint::black_box;
use core::panic::PanicInfo;

#[expect(unsafe_code, reason = "a program that calls it must not link")]
// SAFETY: there is no such function.
unsafe extern "C" {
    safe fn a_path_to_a_panic_is_left() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    a_path_to_a_panic_is_left()
}

#[expect(unsafe_code, reason = "the linker looks for this name")]
// SAFETY: nothing else in this program has this name.
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

/// Bytes whose number and content the compiler does not know.
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

/// Keeps formatting a value from being optimized away.
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
