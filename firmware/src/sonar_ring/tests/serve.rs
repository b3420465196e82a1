//! The ring as its task sees it: the time of the next call, and the queued readings.

use super::*;
use crate::uart::ErrorCounters;
use heapless::spsc::{Consumer, Queue};
use std::boxed::Box;

/// A ring with a queue of `N` - 1 readings.
struct RingBench {
    module: SharedModule,
    ring: SonarRing<'static, FakePin>,
    readings: Consumer<'static, RingReading>,
    errors: &'static ErrorCounters,
    start_us: u32,
}

/// The device's time when the test begins, milliseconds.
const START_MS: u32 = 5_000;

fn bench<const N: usize>(fault: ModuleFault) -> RingBench {
    bench_with::<N>(fault, Timing::relays())
}

fn bench_with<const N: usize>(fault: ModuleFault, timing: Timing) -> RingBench {
    let module = ModuleSim::new(fault);
    let start_us = module.borrow().now_us;
    let queue: &'static mut Queue<RingReading, N> = Box::leak(Box::new(Queue::new()));
    let (producer, readings) = queue.split();
    let errors: &'static ErrorCounters = Box::leak(Box::new(ErrorCounters::new()));
    let driver = driver(&module, timing, FiringOrder::NOMAD);
    let sound = SpeedOfSound::at(200);
    RingBench {
        ring: SonarRing::new(driver, timing, sound, producer, errors),
        module,
        readings,
        errors,
        start_us,
    }
}

impl RingBench {
    fn serve(&mut self, wanted: bool) -> Option<u32> {
        let passed_us = self.module.borrow().now_us.wrapping_sub(self.start_us);
        let now = Millis::from_ms(START_MS + passed_us / 1_000);
        let mut capture = SimCapture(Rc::clone(&self.module));
        let Ok(next) = self.ring.serve(&mut capture, now, wanted);
        next
    }

    /// Calls `serve` for `ms` milliseconds, whenever it is due and at least every half turn of a
    /// 16-bit timer, as the board does. Returns the number of calls.
    fn serve_for(&mut self, ms: u32) -> usize {
        let until = self.module.borrow().now_us.wrapping_add(ms * 1_000);
        let mut runs = 0;
        while until.wrapping_sub(self.module.borrow().now_us) < 1 << 31 {
            let next = self.serve(true).expect("the ring is wanted");
            let mut module = self.module.borrow_mut();
            assert_eq!(
                self.ring.is_listening(),
                module.init,
                "between firing and its end"
            );
            let wait = next.wrapping_sub(module.now_us).min(32_768);
            let then = module.now_us.wrapping_add(wait);
            module.pass(then);
            runs += 1;
        }
        runs
    }

    fn take_readings(&mut self) -> Vec<RingReading> {
        core::iter::from_fn(|| self.readings.dequeue()).collect()
    }
}

#[test]
fn an_unwanted_ring_rests() {
    let mut bench = bench::<16>(ModuleFault::Nothing);
    assert_eq!(bench.serve(false), None);
    assert!(bench.module.borrow().firings.is_empty());
    assert_eq!(
        (bench.take_readings(), bench.errors.ring_faults()),
        (Vec::new(), 0)
    );
}

#[test]
fn readings_carry_the_time_of_their_firing() {
    let mut bench = bench::<32>(ModuleFault::Nothing);
    bench.serve_for(1_100);
    let readings = bench.take_readings();
    assert!(readings.len() >= 16);
    for (slot, firing) in readings.iter().take(16).enumerate() {
        let (sensor, _) = FiringOrder::NOMAD.at(slot as u8).expect("a transducer");
        let flight_us = 3_000 + 2_000 * u32::from(sensor);
        // The first firing is 26 ms after the start: recycled and settled.
        let at_ms = START_MS + 26 + 64 * slot as u32;
        assert_eq!(
            *firing,
            RingReading {
                sensor,
                range: SpeedOfSound::at(200).range(flight_us),
                at: Millis::from_ms(at_ms),
            }
        );
    }
    assert_eq!(bench.errors.ring_faults(), 0);
}

#[test]
fn line_faults_are_counted_and_not_reported() {
    for fault in [ModuleFault::StuckHigh, ModuleFault::RisesAt(300)] {
        let mut bench = bench::<32>(fault);
        bench.serve_for(1_100);
        assert_eq!(bench.take_readings(), [], "{fault:?}");
        assert!(bench.errors.ring_faults() >= 16, "{fault:?}");
    }
}

#[test]
fn readings_are_counted_when_the_queue_is_full() {
    let mut bench = bench::<8>(ModuleFault::Nothing);
    bench.serve_for(1_100);
    let (reported, lost) = (
        bench.take_readings().len() as u32,
        bench.errors.ring_faults(),
    );
    assert_eq!(reported, 7);
    assert_eq!(reported + lost, bench.module.borrow().firings.len() as u32);
}

#[test]
fn an_interrupted_ring_sets_its_pins_low_and_starts_again() {
    let mut bench = bench::<32>(ModuleFault::Nothing);
    // Into the first burst: recycled, settled, fired.
    for _ in 0..3 {
        let next = bench.serve(true).expect("the ring is wanted");
        bench.module.borrow_mut().pass(next);
    }
    assert!(bench.module.borrow().init);
    assert_eq!(bench.serve(false), None);
    assert!(!bench.module.borrow().init);
    assert_eq!(bench.serve(false), None);
    bench.take_readings();
    bench.serve_for(200);
    let sensors: Vec<_> = bench
        .take_readings()
        .iter()
        .map(|firing| firing.sensor)
        .collect();
    assert_eq!(sensors[..2], [0, 2]);
}

/// A firing without echo takes six calls: recycled, settled, slot begins, BINH, half a turn of
/// the timer, window over. An echo saves at least one.
#[test]
fn a_firing_takes_six_runs_at_most() {
    for fault in [
        ModuleFault::Nothing,
        ModuleFault::StuckLow,
        ModuleFault::StuckHigh,
        ModuleFault::NeverFalls,
        ModuleFault::RisesAt(300),
    ] {
        let mut bench = bench::<64>(fault);
        bench.serve_for(1_024);
        let runs = bench.serve_for(1_024);
        // The time may end within a firing.
        assert!((48..=97).contains(&runs), "{fault:?}: {runs}");
    }
}

/// The self-test is not repeated: the next ring is complete after one turn.
#[test]
fn a_resumed_ring_repeats_no_self_test() {
    let mut bench = bench_with::<64>(ModuleFault::Nothing, Timing::relays().with_self_test());
    bench.serve_for(1_040);
    assert_eq!(bench.take_readings().len(), 0);
    assert_eq!(bench.serve(false), None);
    bench.serve_for(1_040);
    assert_eq!(bench.take_readings().len(), 16);
}

/// Modules without supply report nothing, so the ring stays incomplete.
#[test]
fn modules_without_supply_report_nothing() {
    let timing = Timing::relays().with_self_test();
    for (fault, reported, ring_faults) in [
        (ModuleFault::StuckLow, 0, 32),
        (ModuleFault::Nothing, 16, 0),
    ] {
        let mut bench = bench_with::<64>(fault, timing);
        bench.serve_for(2_074);
        assert_eq!(bench.take_readings().len(), reported, "{fault:?}");
        assert_eq!(bench.errors.ring_faults(), ring_faults, "{fault:?}");
    }
}
