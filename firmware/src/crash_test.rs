//! Crashes on demand, for tests in an emulator: what is kept of a crash is tested by crashing.
//!
//! A word between two zeros requests each crash. No frame looks like that: its first byte says how far away its next zero
//! is, and these words end before.

#![allow(unsafe_code)]

use core::hint::black_box;

/// Fills the stack.
pub const OVERFLOW: &[u8] = b"!overflow";
/// Panics.
pub const PANIC: &[u8] = b"!panic";
/// Writes to the lowest word of the stack's region.
pub const GUARD: &[u8] = b"!guard";
/// Runs an instruction that no processor has.
pub const FAULT: &[u8] = b"!fault";

/// Crashes if the frame requests it.
pub fn run_if_requested(frame: &[u8]) {
    match frame {
        OVERFLOW => {
            black_box(fill_stack(frame.len()));
        }
        PANIC => panic!("asked to"),
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
    // SAFETY: the word is memory that the stack never reaches; where it is guarded, nothing after the write runs.
    unsafe { core::ptr::addr_of_mut!(_stack_end).write_volatile(0) }
}

/// Takes some stack, then some more, until there is none.
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
