//! Crashes on request, for tests of the crash record in an emulator.
//!
//! Each request is a word between two zeros. No valid frame matches one: COBS would place the
//! next zero behind the end of the word.

#![allow(unsafe_code)]

use core::hint::black_box;

/// Overflows the stack.
pub const OVERFLOW: &[u8] = b"!overflow";
/// Panics.
pub const PANIC: &[u8] = b"!panic";
/// Writes to the lowest word of the stack's region.
pub const GUARD: &[u8] = b"!guard";
/// Executes an undefined instruction.
pub const FAULT: &[u8] = b"!fault";

/// Crashes if the frame is a request.
pub fn run_if_requested(frame: &[u8]) {
    match frame {
        OVERFLOW => {
            black_box(fill_stack(frame.len()));
        }
        PANIC => panic!("requested"),
        #[cfg(all(target_arch = "arm", target_os = "none"))]
        GUARD => write_below_the_stack(),
        #[cfg(all(target_arch = "arm", target_os = "none"))]
        // SAFETY: the instruction faults; nothing after it runs.
        FAULT => unsafe { core::arch::asm!("udf #0", options(noreturn)) },
        _ => {}
    }
}

#[cfg(all(target_arch = "arm", target_os = "none"))]
fn write_below_the_stack() {
    unsafe extern "C" {
        static mut _stack_end: u32;
    }
    // SAFETY: the word is RAM that the stack never reaches. Where it is guarded, the write faults.
    unsafe { core::ptr::addr_of_mut!(_stack_end).write_volatile(0) }
}

/// Recurses without end.
#[inline(never)]
#[allow(unconditional_recursion)]
fn fill_stack(depth: usize) -> usize {
    let mut ballast = [depth; 16];
    let reached = fill_stack(black_box(&mut ballast)[0].wrapping_add(1));
    reached.wrapping_add(black_box(&ballast)[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::wire::cobs;

    #[test]
    fn no_frame_looks_like_a_request() {
        for word in [OVERFLOW, PANIC, GUARD, FAULT] {
            assert_eq!(cobs::decode(word, &mut [0; 256]), None);
        }
    }
}
