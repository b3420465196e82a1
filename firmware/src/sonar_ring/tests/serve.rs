//! The ring as its task sees it: when it is to be served again, and what comes into the queue.

use super::*;
use crate::line::Faults;
use heapless::spsc::{Consumer, Queue};
use std::boxed::Box;

/// A ring at the end of a queue of `N` - 1 firings.
struct Rig {
    bench: Shared,
    ring: Ring<'static, FakePin>,
    firings: Consumer<'static, Firing>,
    faults: &'static Faults,
    began_us: u32,
}

/// Milliseconds of the device's clock when the ring's clock stands at the start.
const BEGAN_MS: u32 = 5_000;

fn rig<const N: usize>(wrong: Wrong) -> Rig {
    rig_of::<N>(wrong, Timing::relays())
}

fn rig_of<const N: usize>(wrong: Wrong, timing: Timing) -> Rig {
    let bench = Bench::new(wrong);
    let began_us = bench.borrow().now_us;
    let queue: &'static mut Queue<Firing, N> = Box::leak(Box::new(Queue::new()));
    let (firings_in, firings) = queue.split();
    let faults: &'static Faults = Box::leak(Box::new(Faults::new()));
    let driver = driver(&bench, timing, FiringOrder::NOMAD);
    let sound = Sound::at(200);
    Rig {
        ring: Ring::new(driver, timing, sound, firings_in, faults),
        bench,
        firings,
        faults,
        began_us,
    }
}

impl Rig {
    fn serve(&mut self, wanted: bool) -> Option<u32> {
        let passed_us = self.bench.borrow().now_us.wrapping_sub(self.began_us);
        let now = Millis::from_ms(BEGAN_MS + passed_us / 1_000);
        let mut capture = FakeCapture(Rc::clone(&self.bench));
        let Ok(next) = self.ring.serve(&mut capture, now, wanted);
        next
    }

    /// Serves it whenever it asks for it and at least every half turn of a 16-bit timer, as the board does, so long. Returns
    /// how often that was.
    fn serve_for(&mut self, ms: u32) -> usize {
        let until = self.bench.borrow().now_us.wrapping_add(ms * 1_000);
        let mut runs = 0;
        while until.wrapping_sub(self.bench.borrow().now_us) < 1 << 31 {
            let next = self.serve(true).expect("it is wanted");
            let mut bench = self.bench.borrow_mut();
            assert_eq!(self.ring.listens(), bench.init, "between firing and drop");
            let wait = next.wrapping_sub(bench.now_us).min(32_768);
            let then = bench.now_us.wrapping_add(wait);
            bench.pass(then);
            runs += 1;
        }
        runs
    }

    fn heard(&mut self) -> Vec<Firing> {
        core::iter::from_fn(|| self.firings.dequeue()).collect()
    }
}

#[test]
fn a_ring_that_is_not_wanted_rests() {
    let mut rig = rig::<16>(Wrong::Nothing);
    assert_eq!(rig.serve(false), None);
    assert!(rig.bench.borrow().firings.is_empty());
    assert_eq!((rig.heard(), rig.faults.spoilt()), (Vec::new(), 0));
}

#[test]
fn readings_carry_the_time_of_their_firing() {
    let mut rig = rig::<32>(Wrong::Nothing);
    rig.serve_for(1_100);
    let heard = rig.heard();
    assert!(heard.len() >= 16);
    for (slot, firing) in heard.iter().take(16).enumerate() {
        let (sensor, _) = FiringOrder::NOMAD.at(slot as u8).expect("somebody");
        let flight_us = 3_000 + 2_000 * u32::from(sensor);
        // The first fires when recycled and settled, 26 ms after the start.
        let at_ms = BEGAN_MS + 26 + 64 * slot as u32;
        assert_eq!(
            *firing,
            Firing {
                sensor,
                range: Sound::at(200).range(flight_us),
                at: Millis::from_ms(at_ms),
            }
        );
    }
    assert_eq!(rig.faults.spoilt(), 0);
}

#[test]
fn what_the_line_spoils_is_counted_and_not_told() {
    for wrong in [Wrong::StuckHigh, Wrong::RisesAt(300)] {
        let mut rig = rig::<32>(wrong);
        rig.serve_for(1_100);
        assert_eq!(rig.heard(), [], "{wrong:?}");
        assert!(rig.faults.spoilt() >= 16, "{wrong:?}");
    }
}

#[test]
fn what_there_is_no_room_for_is_counted() {
    let mut rig = rig::<8>(Wrong::Nothing);
    rig.serve_for(1_100);
    let (told, lost) = (rig.heard().len() as u32, rig.faults.spoilt());
    assert_eq!(told, 7);
    assert_eq!(told + lost, rig.bench.borrow().firings.len() as u32);
}

#[test]
fn one_that_is_no_longer_wanted_drops_its_lines_and_begins_anew() {
    let mut rig = rig::<32>(Wrong::Nothing);
    // Into the first burst: recycled, settled, fired.
    for _ in 0..3 {
        let next = rig.serve(true).expect("it is wanted");
        rig.bench.borrow_mut().pass(next);
    }
    assert!(rig.bench.borrow().init);
    assert_eq!(rig.serve(false), None);
    assert!(!rig.bench.borrow().init);
    assert_eq!(rig.serve(false), None);
    rig.heard();
    rig.serve_for(200);
    let sensors: Vec<_> = rig.heard().iter().map(|firing| firing.sensor).collect();
    assert_eq!(sensors[..2], [0, 2]);
}

/// A silent firing takes six runs: recycled, settled, slot begins, BINH, half a turn of the timer, window over. An echo
/// spares one at least.
#[test]
fn a_firing_takes_six_runs_at_most() {
    for wrong in [
        Wrong::Nothing,
        Wrong::StuckLow,
        Wrong::StuckHigh,
        Wrong::NeverFalls,
        Wrong::RisesAt(300),
    ] {
        let mut rig = rig::<64>(wrong);
        rig.serve_for(1_024);
        let runs = rig.serve_for(1_024);
        // The time served may end in the middle of a firing.
        assert!((48..=97).contains(&runs), "{wrong:?}: {runs}");
    }
}

/// Once is enough: the next ring is complete after one turn.
#[test]
fn a_ring_that_is_wanted_again_is_not_tested_again() {
    let mut rig = rig_of::<64>(Wrong::Nothing, Timing::relays().self_tested());
    rig.serve_for(1_040);
    assert_eq!(rig.heard().len(), 0);
    assert_eq!(rig.serve(false), None);
    rig.serve_for(1_040);
    assert_eq!(rig.heard().len(), 16);
}

/// Without supply nothing completes the ring: silence is told by modules only that have been heard to ring.
#[test]
fn the_mind_hears_nothing_of_modules_without_supply() {
    let timing = Timing::relays().self_tested();
    for (wrong, told, spoilt) in [(Wrong::StuckLow, 0, 32), (Wrong::Nothing, 16, 0)] {
        let mut rig = rig_of::<64>(wrong, timing);
        rig.serve_for(2_074);
        assert_eq!(rig.heard().len(), told, "{wrong:?}");
        assert_eq!(rig.faults.spoilt(), spoilt, "{wrong:?}");
    }
}
