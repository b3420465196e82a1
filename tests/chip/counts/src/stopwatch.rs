//! Counts instructions by the emulator's clock, which advances 8 ns each (`-icount shift=3`).
//!
//! Its SysTick counts at 168 MHz, which is 1.344 ticks per instruction.

use core::hint::black_box;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// SysTick counts per 1000 instructions.
const TICKS_PER_1000_INSTRUCTIONS: u32 = 1_344;
/// SysTick counts down through 24 bits.
const MAX_TICKS: u32 = (1 << 24) - 1;

/// A running SysTick.
pub struct Stopwatch {
    /// Ticks of an empty measurement.
    overhead: u32,
}

impl Stopwatch {
    /// Starts the timer.
    pub fn new(mut timer: SYST) -> Self {
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(MAX_TICKS);
        timer.clear_current();
        timer.enable_counter();
        let mut watch = Self { overhead: 0 };
        watch.overhead = watch.ticks(|| ()).0;
        watch
    }

    /// Instructions of a call, at most 12 million, and its result. Inputs of the call should pass
    /// through a [`black_box`] inside it, or the compiler may compute a part in advance.
    pub fn count<T>(&self, call: impl FnOnce() -> T) -> (u32, T) {
        let (ticks, result) = self.ticks(call);
        let thousands = ticks.saturating_sub(self.overhead) * 1_000;
        let half = TICKS_PER_1000_INSTRUCTIONS / 2;
        ((thousands + half) / TICKS_PER_1000_INSTRUCTIONS, result)
    }

    #[inline(always)]
    fn ticks<T>(&self, call: impl FnOnce() -> T) -> (u32, T) {
        let begin = SYST::get_current();
        let result = call();
        // By reference, so that the result is not copied.
        black_box(&result);
        let end = SYST::get_current();
        (begin.wrapping_sub(end) & MAX_TICKS, result)
    }
}

/// Instruction counts of one kind of call.
#[derive(Clone, Copy, Default)]
pub struct InstructionStats {
    calls: u32,
    sum: u32,
    most: u32,
}

impl InstructionStats {
    /// Adds a call.
    pub fn add(&mut self, instructions: u32) {
        self.calls += 1;
        self.sum += instructions;
        self.most = self.most.max(instructions);
    }

    /// Number of calls.
    pub fn calls(self) -> u32 {
        self.calls
    }

    /// Sum of instructions.
    pub fn sum(self) -> u32 {
        self.sum
    }

    /// Mean instructions per call, rounded.
    pub fn mean(self) -> u32 {
        (self.sum + self.calls / 2)
            .checked_div(self.calls)
            .unwrap_or(0)
    }

    /// Instructions of the longest call.
    pub fn most(self) -> u32 {
        self.most
    }
}
