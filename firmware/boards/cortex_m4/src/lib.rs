//! Kernels of `tinysom` for a Cortex-M4: BMU search and update of 16 neurons with 16 components.
//!
//! Results are bit-identical to those of the portable code. One instruction loads four components.
//! The probe stays in eight registers, two values in each: `SMLAWB` and `SMLAWT` multiply by the
//! lower and the upper half. The crate is empty on all other processors.
#![no_std]
#![cfg(all(target_arch = "arm", target_os = "none"))]
#![allow(unsafe_code)]

use core::arch::naked_asm;
use tinysom::kernels::{Group, Kernels};
use tinysom::{Weight, Weight32};

/// For [`amp::node::Node::use_kernels`].
pub static KERNELS: Kernels = Kernels { candidates, update };

/// Finds the candidates for the BMU in two passes.
///
/// The first pass pushes w·x of each code vector, from the last to the first, so the stack holds
/// them in order. It has two rounds of eight. No instruction of a round changes the flags; they
/// distinguish the first round from the second. The second pass computes the ranks. Most exceed the
/// lowest rank so far by more than the margin, which costs a comparison and a branch. A third pass
/// over all ranks runs only if one is within the margin.
///
/// The lowest 16 of the 48 bits of each product are dropped: units of 2⁻²⁶, as in squared lengths.
// SAFETY: follows the calling convention: restores r4 to r11 and the stack pointer. Reads only the
// arguments, whose sizes are in their types, and writes only its own stack. `ldr` needs no
// alignment, and `ldm` of the probe runs only if it is aligned to 4 bytes.
#[unsafe(naked)]
extern "C" fn candidates(
    code: &[[Weight32; 16]; 16],
    bases: &[i32; 16],
    probe: &[Weight; 16],
    margin: i32,
) -> u32 {
    naked_asm!(
        "push  {{r1, r3, r4-r11, lr}}",
        // r0: end of the code vectors.
        "add   r0, r0, #1024",
        // r4 to r11: the probe, two components each. `ldm` needs an address aligned to 4 bytes.
        "lsls  r1, r2, #30",
        "bne   7f",
        "ldm   r2, {{r4, r5, r6, r7, r8, r9, r10, r11}}",
        // Flags "equal": the first round.
        "2:",
        ".rept 8",
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
        "bne   3f",
        "movs  r1, #1",
        "b     2b",
        // r12: products, r3: bases, r1: margin, lr: 2 · margin, r2: lowest rank + margin, r0:
        // neuron of the lowest rank.
        "3:",
        "mov   r12, sp",
        "ldrd  r3, r1, [sp, #64]",
        ".macro ranks",
        "ldmia r12!, {{r4, r5, r6, r7}}",
        "ldmia r3!, {{r8, r9, r10, r11}}",
        "rsb   r4, r4, r8, asr #1",
        "rsb   r5, r5, r9, asr #1",
        "rsb   r6, r6, r10, asr #1",
        "rsb   r7, r7, r11, asr #1",
        ".endm",
        ".macro among rank, neuron",
        "cmp   \\rank, r2",
        "bgt   4f",
        "qadd  r8, \\rank, lr",
        "cmp   r8, r2",
        "bge   5f",
        "qadd  r2, \\rank, r1",
        "movs  r0, #\\neuron",
        "4:",
        ".endm",
        "ranks",
        "lsl   lr, r1, #1",
        "qadd  r2, r4, r1",
        "movs  r0, #0",
        "among r5, 1",
        "among r6, 2",
        "among r7, 3",
        "ranks",
        "among r4, 4",
        "among r5, 5",
        "among r6, 6",
        "among r7, 7",
        "ranks",
        "among r4, 8",
        "among r5, 9",
        "among r6, 10",
        "among r7, 11",
        "ranks",
        "among r4, 12",
        "among r5, 13",
        "among r6, 14",
        "among r7, 15",
        "add   sp, #64",
        "pop   {{r1, r3, r4-r11, pc}}",
        // Some ranks are within the margin: finds the lowest rank, then all within the margin of
        // it. A bit shifted out of r0 ends each loop.
        "5:",
        "mov   r12, sp",
        "ldr   r3, [sp, #64]",
        "mvn   r2, #0x80000000",
        "mov   r0, #0x8000",
        "6:",
        "ranks",
        ".irp rank, r4, r5, r6, r7",
        "cmp   \\rank, r2",
        "it    lt",
        "movlt r2, \\rank",
        ".endr",
        "lsrs  r0, r0, #4",
        "bcc   6b",
        "qadd  r2, r2, r1",
        "mov   r12, sp",
        "ldr   r3, [sp, #64]",
        "mov   r0, #0x8000",
        "8:",
        "ranks",
        ".macro rival rank, bit",
        "cmp   \\rank, r2",
        "it    le",
        "orrle r0, r0, #\\bit << 16",
        ".endm",
        "rival r4, 1",
        "rival r5, 2",
        "rival r6, 4",
        "rival r7, 8",
        ".purgem rival",
        "lsrs  r0, r0, #4",
        "bcc   8b",
        ".purgem among",
        ".purgem ranks",
        "lsls  r0, r0, #16",
        "add   sp, #64",
        "pop   {{r1, r3, r4-r11, pc}}",
        "7:",
        "ldr   r4, [r2]",
        "ldr   r5, [r2, #4]",
        "ldr   r6, [r2, #8]",
        "ldr   r7, [r2, #12]",
        "ldr   r8, [r2, #16]",
        "ldr   r9, [r2, #20]",
        "ldr   r10, [r2, #24]",
        "ldr   r11, [r2, #28]",
        "cmp   r0, r0",
        "b     2b",
    )
}

/// Updates the neurons of each group, from the last to the first, four components at a time.
///
/// The step is the upper half of (x − w) · 4 gain; the norm sums the upper halves of the squares.
/// The stack holds each register of the probe twice: as it is, for the lower value (shifted up),
/// and with its lower half cleared, for the upper value.
// SAFETY: as `candidates`. Writes code vectors and norms of neurons below 16 only.
#[unsafe(naked)]
extern "C" fn update(
    code: &mut [[Weight32; 16]; 16],
    norms: &mut [i32; 16],
    probe: &[Weight; 16],
    groups: &[Group; 2],
) {
    naked_asm!(
        // r0: end of the code vectors, r1: end of the norms.
        "add   r0, r0, #1024",
        "adds  r1, #64",
        "push  {{r0, r1, r3, r4-r11, lr}}",
        "lsls  r4, r2, #30",
        "bne   6f",
        "ldm   r2, {{r4, r5, r6, r7, r8, r9, r10, r11}}",
        "2:",
        "movs  r2, #0",
        "pkhbt r12, r2, r10",
        "pkhbt lr, r2, r11",
        "push  {{r10, r11, r12, lr}}",
        "pkhbt r10, r2, r8",
        "pkhbt r11, r2, r9",
        "push  {{r8, r9, r10, r11}}",
        "pkhbt r8, r2, r6",
        "pkhbt r9, r2, r7",
        "push  {{r6, r7, r8, r9}}",
        "pkhbt r6, r2, r4",
        "pkhbt r7, r2, r5",
        "push  {{r4, r5, r6, r7}}",
        "add   r2, sp, #64",
        "ldrd  r3, r12, [r3]",
        // r3: 4 gain, r12: neurons of the group, neuron 15 in the highest bit.
        "lsls  r12, r12, #16",
        "beq   5f",
        "4:",
        "clz   lr, r12",
        "lsl   r12, r12, lr",
        "lsls  r12, r12, #1",
        "sub   r0, r0, lr, lsl #6",
        "sub   r1, r1, lr, lsl #2",
        ".macro four first",
        "ldmdb r0!, {{r4, r5, r6, r7}}",
        "ldmdb r2!, {{r8, r9, r10, r11}}",
        "rsb   r8, r4, r8, lsl #16",
        "sub   r10, r10, r5",
        "rsb   r9, r6, r9, lsl #16",
        "sub   r11, r11, r7",
        "smmla r4, r8, r3, r4",
        "smmla r5, r10, r3, r5",
        "smmla r6, r9, r3, r6",
        "smmla r7, r11, r3, r7",
        "stm   r0, {{r4, r5, r6, r7}}",
        ".if \\first",
        "smmul lr, r4, r4",
        ".else",
        "smmla lr, r4, r4, lr",
        ".endif",
        "smmla lr, r5, r5, lr",
        "smmla lr, r6, r6, lr",
        "smmla lr, r7, r7, lr",
        ".endm",
        "four  1",
        "four  0",
        "four  0",
        "four  0",
        ".purgem four",
        "str   lr, [r1, #-4]!",
        "add   r2, r2, #64",
        "bne   4b",
        // Takes the second group, then marks that no group is left: r12 is 0.
        "5:",
        "ldr   r4, [sp, #72]",
        "cbz   r4, 7f",
        "str   r12, [sp, #72]",
        "ldrd  r0, r1, [sp, #64]",
        "ldrd  r3, r12, [r4, #8]",
        "lsls  r12, r12, #16",
        "bne   4b",
        "7:",
        "add   sp, #76",
        "pop   {{r4-r11, pc}}",
        // Loads the probe word by word from an unaligned address.
        "6:",
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
