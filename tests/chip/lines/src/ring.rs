//! The runs of the ring's task but for the timer's registers: two rings, in which half of the transducers hear something.

use crate::stopwatch::{Stopwatch, Tally};
use amp::units::Millis;
use core::convert::Infallible;
use core::hint::black_box;
use embedded_hal::digital::{ErrorType, OutputPin};
use firmware::line::Faults;
use firmware::sonar_ring::{Capture, Driver, Firing, FiringOrder, Line, Pins, Ring, Sound, Timing};
use heapless::spsc::Queue;

/// At 168 MHz a tenth of the 87 µs that a byte takes at 115 200 baud, were every instruction one cycle: what the clock, of the
/// same priority, may be late by.
pub const ALLOWED: u32 = 1_460;

/// A pin like the chip's: setting it is a store.
struct Pin(bool);

impl ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        *black_box(&mut self.0) = false;
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        *black_box(&mut self.0) = true;
        Ok(())
    }
}

/// The test's clock, and what its line does.
struct Clock {
    now_us: u32,
    line: Line,
}

impl Capture for Clock {
    fn now_us(&mut self) -> u32 {
        *black_box(&mut self.now_us)
    }

    fn arm(&mut self) {
        self.line.rose_us = None;
    }

    fn line(&mut self) -> Line {
        *black_box(&mut self.line)
    }
}

/// Every run until both rings are over.
pub fn count(watch: &Stopwatch) -> Tally {
    let mut queue: Queue<Firing, 64> = Queue::new();
    let (firings, _) = queue.split();
    let pin = || Pin(false);
    let pins = Pins {
        address: [pin(), pin(), pin(), pin()],
        init: pin(),
        binh: pin(),
        blnk: pin(),
    };
    let (timing, faults) = (Timing::relays(), Faults::new());
    let Ok(driver) = Driver::new(pins, timing, FiringOrder::NOMAD, 0);
    let mut ring = Ring::new(driver, timing, Sound::at(200), firings, &faults);
    let mut clock = Clock {
        now_us: 0,
        line: Line::default(),
    };
    let mut tally = Tally::default();
    for run in 0.. {
        let now = Millis::from_ms(clock.now_us / 1_000);
        let (instructions, next) = watch.count(|| {
            let (ring, clock) = black_box((&mut ring, &mut clock));
            ring.serve(clock, now, true)
        });
        tally.add(instructions);
        let Ok(Some(next_us)) = next else { break };
        if clock.now_us > 2_048_000 {
            break;
        }
        // An echo comes while the window lasts, in every other slot.
        let waits_for_echo = next_us.wrapping_sub(clock.now_us) > 30_000;
        clock.line = Line::default();
        clock.now_us = next_us;
        if waits_for_echo && run % 2 == 0 {
            clock.now_us -= 20_000;
            clock.line = Line {
                high: true,
                rose_us: Some(clock.now_us - 10),
            };
        }
    }
    tally
}
