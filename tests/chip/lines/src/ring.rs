//! Counts the instructions of the ring's task, without the timer's registers, over two rings.

use crate::stopwatch::{InstructionStats, Stopwatch};
use amp::units::Millis;
use core::convert::Infallible;
use core::hint::black_box;
use embedded_hal::digital::{ErrorType, OutputPin};
use firmware::sonar_ring::{
    ChannelDriver, EchoCapture, EchoLine, FiringOrder, RingPins, RingReading, SonarRing,
    SpeedOfSound, Timing,
};
use firmware::uart::ErrorCounters;
use heapless::spsc::Queue;

/// A tenth of the 87 µs per byte at 115 200 baud and 168 MHz, at one cycle per instruction: the
/// acceptable delay of the clock task, which has the same priority.
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

/// The test's time, and the ECHO line.
struct FakeCapture {
    now_us: u32,
    line: EchoLine,
}

impl EchoCapture for FakeCapture {
    fn now_us(&mut self) -> u32 {
        *black_box(&mut self.now_us)
    }

    fn arm(&mut self) {
        self.line.rose_us = None;
    }

    fn echo_line(&mut self) -> EchoLine {
        *black_box(&mut self.line)
    }
}

/// Counts every call until two rings are complete. Every other transducer hears an echo.
pub fn count(watch: &Stopwatch) -> InstructionStats {
    let mut queue: Queue<RingReading, 64> = Queue::new();
    let (firings, _) = queue.split();
    let pin = || Pin(false);
    let pins = RingPins {
        address: [pin(), pin(), pin(), pin()],
        init: pin(),
        binh: pin(),
        blnk: pin(),
    };
    let (timing, errors) = (Timing::relays(), ErrorCounters::new());
    let Ok(driver) = ChannelDriver::new(pins, timing, FiringOrder::NOMAD, 0);
    let mut ring = SonarRing::new(driver, timing, SpeedOfSound::at(200), firings, &errors);
    let mut capture = FakeCapture {
        now_us: 0,
        line: EchoLine::default(),
    };
    let mut stats = InstructionStats::default();
    for run in 0.. {
        let now = Millis::from_ms(capture.now_us / 1_000);
        let (instructions, next) = watch.count(|| {
            let (ring, capture) = black_box((&mut ring, &mut capture));
            ring.serve(capture, now, true)
        });
        stats.add(instructions);
        let Ok(Some(next_us)) = next else { break };
        if capture.now_us > 2_048_000 {
            break;
        }
        // In every other slot an echo comes within the window.
        let waits_for_echo = next_us.wrapping_sub(capture.now_us) > 30_000;
        capture.line = EchoLine::default();
        capture.now_us = next_us;
        if waits_for_echo && run % 2 == 0 {
            capture.now_us -= 20_000;
            capture.line = EchoLine {
                high: true,
                rose_us: Some(capture.now_us - 10),
            };
        }
    }
    stats
}
