//! Kernels of `tinysom` for a Cortex-M4: BMU search and update of 16 neurons with 16 components.
//!
//! Results are those of the portable code, bit for bit. One instruction loads four components, and
//! the probe stays in eight registers, two values in each (`SMLAWB` and `SMLAWT` take either half
//! as it is). The crate is empty on every other processor.
#![no_std]
#![cfg(all(target_arch = "arm", target_os = "none"))]
#![allow(unsafe_code)]

use core::arch::naked_asm;
use tinysom::kernels::{Group, Kernels};
use tinysom::{Weight, Weight32};

/// For [`amp::node::Node::use_kernels`].
pub static KERNELS: Kernels = Kernels { candidates, update };

/// Two passes. The first one goes through the code vectors from the last to the first and leaves
/// w·x of each on the stack, so that they lie in order in the end, in two rounds of eight: no
/// instruction of a round changes the flags, and they tell the first from the second. The second
/// pass makes ranks of them. Most are above the least so far by more than the margin, which costs a
/// comparison and a branch. Only where one is closer to it are all gone through again.
///
/// Of each product the lowest 16 of 48 bits are left off: units of 2⁻²⁶, as of squared lengths.
// SAFETY: keeps to the calling convention: r4 to r11 and the stack pointer come back as they were,
// and only the arguments are read, whose sizes their types know. Nothing needs an alignment that
// they do not have: `ldr` may read from anywhere.
#[unsafe(naked)]
extern "C" fn candidates(
    code: &[[Weight32; 16]; 16],
    bases: &[i32; 16],
    probe: &[Weight; 16],
    margin: i32,
) -> u32 {
    naked_asm!(
        "push  {{r1, r3, r4-r11, lr}}",
        // Behind the last code vector.
        "add   r0, r0, #1024",
        // The probe, two components to a register; at an odd place of its own only one by one.
        "lsls  r1, r2, #30",
        "bne   7f",
        "ldm   r2, {{r4, r5, r6, r7, r8, r9, r10, r11}}",
        // Equal: the first round.
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
        // r12: products, r3: bases, r1: margin, lr: twice that, r2: the least rank and the margin,
        // r0: its neuron.
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
        // Some are so close that all have to be seen: the least rank, then who is above it by the
        // margin at most. The last bit that leaves r0 ends the loops.
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

/// The neurons of a group from the last to the first, four components at a time: w + (x − w) · 4
/// gain, whose upper half is the step, and the upper half of its square. What both halves of a
/// register hold of the probe is subtracted from twice: from the register, shifted, and from a copy
/// without its lower half, which is on the stack beside it.
// SAFETY: as above; rows and lengths are written for neurons below 16 only.
#[unsafe(naked)]
extern "C" fn update(
    code: &mut [[Weight32; 16]; 16],
    norms: &mut [i32; 16],
    probe: &[Weight; 16],
    groups: &[Group; 2],
) {
    naked_asm!(
        // Behind the last code vector and the last length.
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
        // r3: 4 gain, r12: the group's neurons, the last in the uppermost bit.
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
        // The second group, and none after it: r12 is 0.
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
        // At an odd place words are loaded one by one only.
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
