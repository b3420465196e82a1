//! The lines that are written while the link is up, over and over.

use crate::ring;
use crate::stopwatch::{InstructionStats, Stopwatch};
use core::hint::black_box;
use core::panic::PanicInfo;
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use defmt_rtt as _;
use firmware::control::LogEvent;
use stm32f4xx_hal as _;

/// Enough for the logger's ring of 1 KiB to come round some times, so that lines are cut at its end as well.
const ROUNDS: u32 = 200;

/// A byte at 1 Mbaud takes 1680 cycles.
const ALLOWED: u32 = 1_000;

#[entry]
fn main() -> ! {
    let chip = cortex_m::Peripherals::take().expect("nobody else took them");
    let watch = Stopwatch::new(chip.SYST);
    hprintln!("| call | calls | instructions, mean | most | allowed |");
    hprintln!("| --- | ---: | ---: | ---: | ---: |");
    for (call, counted, allowed) in [
        ("a line of the log", count(&watch), ALLOWED),
        ("a run of the ring", ring::count(&watch), ring::ALLOWED),
    ] {
        let (calls, mean, most) = (counted.calls(), counted.mean(), counted.most());
        hprintln!("| {call} | {calls} | {mean} | {most} | {allowed} |");
    }
    debug::exit(debug::EXIT_SUCCESS);
    loop {
        cortex_m::asm::wfi();
    }
}

/// Whole calls: a little more than what is held off.
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
