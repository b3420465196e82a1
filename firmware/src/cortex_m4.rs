//! The two loops that a decision and a training spend most of their time in, by hand for a Cortex-M4: the search for the
//! best-matching unit and the pull of a code vector, for the paper's 16 neurons and a ring of 16 transducers.
//!
//! Both do what `amp`'s portable functions do, to the bit of whatever comes out of a map. What is gained is registers and
//! loads: four components are loaded by one instruction, and the probe stays in eight registers, two values in each, from
//! the first product to the last (`SMLAWB` and `SMLAWT` take either half as it is). Compilers unpack the halves before the
//! loop, which takes sixteen registers of fourteen, and load nearly every component alone.
//!
//! | instructions, call included | portable | by hand |
//! |---|---:|---:|
//! | search | 980 | 514 |
//! | pull of a winner and its four neighbours | 765 | 499 |

#![allow(unsafe_code)]

use amp::fixed::{Fine, Weight};
use amp::som::kernels::{Group, Kernels};
use core::arch::naked_asm;

/// For [`amp::node::Node::use_kernels`].
pub static KERNELS: Kernels = Kernels { rivals, pull };

/// Two passes. The first one goes through the code vectors from the last to the first and leaves w·x of each on the
/// stack, so that they lie in order in the end, four and the number of the first at a time. The second one makes
/// ranks of them and finds the least two: most are not below the second, which costs a comparison and a branch. Only where
/// the second is a rival a third one looks for all of them.
///
/// Of each product the lowest 16 of 48 bits are left off: units of 2⁻²⁶, as of squared lengths.
// SAFETY: keeps to the calling convention: r4 to r11 and the stack pointer come back as they were, and only the arguments
// are read, whose sizes their types know. Nothing needs an alignment that they do not have: `ldr` may read from anywhere.
#[unsafe(naked)]
extern "C" fn rivals(
    code: &[[Fine; 16]; 16],
    bases: &[i32; 16],
    probe: &[Weight; 16],
    margin: i32,
) -> u32 {
    naked_asm!(
        "push  {{r4-r11, lr}}",
        "push  {{r1, r3}}",
        // Behind the last code vector; its number.
        "add   r0, r0, #1024",
        "movs  r1, #16",
        "push  {{r1}}",
        // The probe, two components to a register; at an odd place of its own only one by one.
        "lsls  r1, r2, #30",
        "bne   7f",
        "ldm   r2, {{r4, r5, r6, r7, r8, r9, r10, r11}}",
        "2:",
        ".rept 4",
        "ldmdb r0!, {{r1, r2, r3, r12}}",
        "smulwb lr, r1, r10",
        "smlawt lr, r2, r10, lr",
        "smlawb lr, r3, r11, lr",
        "smlawt lr, r12, r11, lr",
        "ldmdb r0!, {{r1, r2, r3, r12}}",
        "smlawb lr, r1, r8, lr",
        "smlawt lr, r2, r8, lr",
        "smlawb lr, r3, r9, lr",
        "smlawt lr, r12, r9, lr",
        "ldmdb r0!, {{r1, r2, r3, r12}}",
        "smlawb lr, r1, r6, lr",
        "smlawt lr, r2, r6, lr",
        "smlawb lr, r3, r7, lr",
        "smlawt lr, r12, r7, lr",
        "ldmdb r0!, {{r1, r2, r3, r12}}",
        "smlawb lr, r1, r4, lr",
        "smlawt lr, r2, r4, lr",
        "smlawb lr, r3, r5, lr",
        "smlawt lr, r12, r5, lr",
        "push  {{lr}}",
        ".endr",
        "ldr   r1, [sp, #16]",
        "subs  r1, #4",
        "push  {{r1}}",
        "bne   2b",
        // r0: bases, r1: products, r2: least, r3: its neuron, r12: second.
        "mov   r1, sp",
        "ldr   r0, [sp, #84]",
        "mvn   r2, #0x80000000",
        "mov   r12, r2",
        "3:",
        "ldmia r1!, {{r4, r5, r6, r7, r8}}",
        "ldmia r0!, {{r9, r10, r11, lr}}",
        "rsb   r5, r5, r9, asr #1",
        "rsb   r6, r6, r10, asr #1",
        "rsb   r7, r7, r11, asr #1",
        "rsb   r8, r8, lr, asr #1",
        ".macro among_least rank, place",
        "cmp   \\rank, r12",
        "bge   4f",
        "cmp   \\rank, r2",
        "ittte lt",
        "movlt r12, r2",
        "movlt r2, \\rank",
        "addlt r3, r4, #\\place",
        "movge r12, \\rank",
        "4:",
        ".endm",
        "among_least r5, 0",
        "among_least r6, 1",
        "among_least r7, 2",
        "among_least r8, 3",
        ".purgem among_least",
        "cmp   r4, #12",
        "bne   3b",
        // Rivals may have ranks up to r2.
        "ldr   r1, [sp, #88]",
        "qadd  r2, r2, r1",
        "cmp   r12, r2",
        "ble   5f",
        // There are none: the bit of the least.
        "movs  r0, #1",
        "lsl   r0, r0, r3",
        "add   sp, #92",
        "pop   {{r4-r11, pc}}",
        "5:",
        "mov   r1, sp",
        "ldr   r0, [sp, #84]",
        "movs  r3, #0",
        "6:",
        "ldmia r1!, {{r4, r5, r6, r7, r8}}",
        "ldmia r0!, {{r9, r10, r11, lr}}",
        "lsrs  r3, r3, #4",
        ".macro rival product, base, bit",
        "rsb   \\product, \\product, \\base, asr #1",
        "cmp   \\product, r2",
        "it    le",
        "orrle r3, r3, #\\bit << 12",
        ".endm",
        "rival r5, r9, 1",
        "rival r6, r10, 2",
        "rival r7, r11, 4",
        "rival r8, lr, 8",
        ".purgem rival",
        "cmp   r4, #12",
        "bne   6b",
        "mov   r0, r3",
        "add   sp, #92",
        "pop   {{r4-r11, pc}}",
        "7:",
        "ldr   r4, [r2]",
        "ldr   r5, [r2, #4]",
        "ldr   r6, [r2, #8]",
        "ldr   r7, [r2, #12]",
        "ldr   r8, [r2, #16]",
        "ldr   r9, [r2, #20]",
        "ldr   r10, [r2, #24]",
        "ldr   r11, [r2, #28]",
        "b     2b",
    )
}

/// Four components at a time: w + (x − w) · 4 gain, whose upper half is the step, and the square of its upper half.
// SAFETY: as above; rows and lengths are written for neurons below 16 only.
#[unsafe(naked)]
extern "C" fn pull(
    code: &mut [[Fine; 16]; 16],
    norms: &mut [i32; 16],
    probe: &[Weight; 16],
    groups: &[Group; 2],
) {
    naked_asm!(
        "push  {{r4-r11, lr}}",
        "sub   sp, #40",
        // The second group waits on the stack.
        "ldm   r3, {{r3, r11, r12, lr}}",
        "strd  r12, lr, [sp]",
        "lsls  r4, r2, #30",
        "bne   5f",
        // r3: 4 gain, r11: the group's neurons.
        "2:",
        "uxth  r11, r11",
        "cmp   r11, #0",
        "beq   4f",
        "3:",
        "rbit  r12, r11",
        "clz   r12, r12",
        "sub   r10, r11, #1",
        "ands  r11, r11, r10",
        "add   r12, r0, r12, lsl #6",
        ".macro four offset",
        "ldm   r12, {{r4, r5, r6, r7}}",
        "ldrd  r8, r9, [r2, #\\offset]",
        // Each value of the probe into an upper half.
        "rsb   r10, r4, r8, lsl #16",
        "bfc   r8, #0, #16",
        "sub   r8, r8, r5",
        "smmla r4, r10, r3, r4",
        "smmla r5, r8, r3, r5",
        "rsb   r10, r6, r9, lsl #16",
        "bfc   r9, #0, #16",
        "sub   r9, r9, r7",
        "smmla r6, r10, r3, r6",
        "smmla r7, r9, r3, r7",
        "stmia r12!, {{r4, r5, r6, r7}}",
        ".ifeq \\offset",
        "smultt lr, r4, r4",
        ".else",
        "smlatt lr, r4, r4, lr",
        ".endif",
        "smlatt lr, r5, r5, lr",
        "smlatt lr, r6, r6, lr",
        "smlatt lr, r7, r7, lr",
        ".endm",
        "four  0",
        "four  8",
        "four  16",
        "four  24",
        ".purgem four",
        // A row behind the neuron's.
        "sub   r12, r12, r0",
        "add   r12, r1, r12, lsr #4",
        "str   lr, [r12, #-4]",
        "bne   3b",
        // The second group, and none after it.
        "4:",
        "ldrd  r3, r11, [sp]",
        "movs  r4, #0",
        "str   r4, [sp]",
        "cmp   r3, #0",
        "bne   2b",
        "add   sp, #40",
        "pop   {{r4-r11, pc}}",
        // At an odd place pairs of words cannot be loaded: a copy of the probe.
        "5:",
        "add   r12, sp, #8",
        ".rept 8",
        "ldr   r4, [r2], #4",
        "str   r4, [r12], #4",
        ".endr",
        "add   r2, sp, #8",
        "b     2b",
    )
}
