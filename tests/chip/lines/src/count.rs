//! Counts the instructions of the log lines that are written while the link is up.

use crate::ring;
use crate::stopwatch::{InstructionStats, Stopwatch};
use core::hint::black_box;
use core::panic::PanicInfo;
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use defmt_rtt as _;
use firmware::control::LogEvent;
use stm32f4xx_hal as _;

/// Enough for RTT's ring buffer of 1 KiB to wrap several times, which splits some lines.
const ROUNDS: u32 = 200;

/// A byte at 1 Mbaud takes 1680 cycles.
const ALLOWED: u32 = 1_000;

#[entry]
fn main() -> ! {
    let chip = cortex_m::Peripherals::take().expect("not taken yet");
    let watch = Stopwatch::new(chip.SYST);
    hprintln!("| call | calls | instructions, mean | most | allowed |");
    hprintln!("| --- | ---: | ---: | ---: | ---: |");
    for (call, stats, allowed) in [
        ("a line of the log", count(&watch), ALLOWED),
        ("a run of the ring", ring::count(&watch), ring::ALLOWED),
    ] {
        let (calls, mean, most) = (stats.calls(), stats.mean(), stats.most());
        hprintln!("| {call} | {calls} | {mean} | {most} | {allowed} |");
    }
    debug::exit(debug::EXIT_SUCCESS);
    loop {
        cortex_m::asm::wfi();
    }
}

/// Counts whole calls: some instructions more than the masked part.
fn count(watch: &Stopwatch) -> InstructionStats {
    let mut stats = InstructionStats::default();
    for round in 0..ROUNDS {
        let lost = LogEvent::BytesLost(u32::MAX >> (round % 32));
        for log_event in [LogEvent::Linked, LogEvent::Unlinked, lost] {
            let (instructions, ()) = watch.count(|| black_box(log_event).log());
            stats.add(instructions);
        }
    }
    stats
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    hprintln!("{info}");
    debug::exit(debug::EXIT_FAILURE);
    loop {
        cortex_m::asm::wfi();
    }
}
