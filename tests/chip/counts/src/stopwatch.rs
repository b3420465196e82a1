//! Counts instructions: the emulator's time goes on by 8 ns with each instruction (`-icount shift=3`), and its SysTick
//! counts 168 000 000 times in a second of it, which is 1.344 times per instruction.

use core::hint::black_box;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// SysTick counts per 1000 instructions.
const TICKS_PER_1000_INSTRUCTIONS: u32 = 1_344;
/// SysTick counts down through 24 bits.
const MAX_TICKS: u32 = (1 << 24) - 1;

/// A running SysTick.
pub struct Stopwatch {
    /// What it costs to look twice, ticks.
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

    /// Instructions of a call, at most 12 million, and its result. Whatever the call reads should come out of a
    /// [`black_box`] inside it, or the compiler may do some of the work before.
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
        // By reference: a result should not be copied for the sake of being counted.
        black_box(&result);
        let end = SYST::get_current();
        (begin.wrapping_sub(end) & MAX_TICKS, result)
    }
}

/// Counts of one kind of call.
#[derive(Clone, Copy, Default)]
pub struct InstructionStats {
    calls: u32,
    sum: u32,
    most: u32,
}

impl InstructionStats {
    /// One more call.
    pub fn add(&mut self, instructions: u32) {
        self.calls += 1;
        self.sum += instructions;
        self.most = self.most.max(instructions);
    }

    /// Number of calls.
    pub fn calls(self) -> u32 {
        self.calls
    }

    /// Instructions of all of them.
    pub fn sum(self) -> u32 {
        self.sum
    }

    /// Instructions of a call on average, rounded.
    pub fn mean(self) -> u32 {
        (self.sum + self.calls / 2)
            .checked_div(self.calls)
            .unwrap_or(0)
    }

    /// Instructions of the longest one.
    pub fn most(self) -> u32 {
        self.most
    }
}
