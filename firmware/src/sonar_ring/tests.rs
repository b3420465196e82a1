//! The driver against a simulated ranging module with the data sheet's timing.

use super::timing::{END_OF_ORDER, MAX_LATE_US, STAGGER_US};
use super::*;
use core::cell::RefCell;
use core::convert::Infallible;
use embedded_hal::digital::ErrorType;
use embedded_hal_mock::eh1::digital::{Mock, State as Level, Transaction};
use proptest::prelude::*;
use std::rc::Rc;
use std::vec::Vec;

mod serve;

/// A fault of the module, its line or its multiplexer.
#[derive(Debug, Clone, Copy, PartialEq)]
enum ModuleFault {
    Nothing,
    /// ECHO is shorted to the supply.
    StuckHigh,
    /// ECHO is shorted to ground.
    StuckLow,
    /// ECHO stays high after it has risen.
    NeverFalls,
    /// ECHO rises this long after the firing, microseconds, regardless of the blanking.
    RisesAt(u32),
    /// The multiplexer connects this transducer, whatever the address.
    Multiplexer(u8),
    /// This transducer has no supply: no burst, no ringing, no echo.
    Dead(u8),
}

/// A module, its transducers, and a record of its lines.
struct ModuleSim {
    now_us: u32,
    fault: ModuleFault,
    /// Time of flight of each transducer's echo; `None` = no echo.
    flights_us: [Option<u32>; 16],
    address: u8,
    init: bool,
    binh_us: Option<u32>,
    selected_us: u32,
    fired_us: u32,
    fallen_us: u32,
    /// The module's ECHO output, without shorts.
    latched: bool,
    caught_us: Option<u32>,
    firings: Vec<(u32, u8)>,
    readings: Vec<FiringResult>,
}

type SharedModule = Rc<RefCell<ModuleSim>>;

impl ModuleSim {
    fn new(fault: ModuleFault) -> SharedModule {
        Rc::new(RefCell::new(Self {
            now_us: u32::MAX - 200_000,
            fault,
            flights_us: core::array::from_fn(|sensor| Some(3_000 + 2_000 * sensor as u32)),
            address: 0,
            init: false,
            binh_us: None,
            selected_us: u32::MAX - 200_000,
            fired_us: 0,
            fallen_us: u32::MAX - 200_000,
            latched: false,
            caught_us: None,
            firings: Vec::new(),
            readings: Vec::new(),
        }))
    }

    fn set(&mut self, wire: ModulePin, high: bool) {
        match wire {
            ModulePin::Address(bit) => {
                let address = self.address & !(1 << bit) | u8::from(high) << bit;
                assert!(
                    address == self.address || !self.init,
                    "the address changes under a burst"
                );
                if address != self.address {
                    self.selected_us = self.now_us;
                }
                self.address = address;
            }
            ModulePin::Init if high && !self.init => {
                assert!(
                    self.now_us.wrapping_sub(self.selected_us) >= 25_000,
                    "relays swing"
                );
                assert!(
                    self.now_us.wrapping_sub(self.fallen_us) >= 1_000,
                    "no recycling"
                );
                (self.init, self.fired_us, self.binh_us) = (true, self.now_us, None);
                let heard = match self.fault {
                    ModuleFault::Multiplexer(sensor) => sensor,
                    _ => self.address,
                };
                self.firings.push((self.now_us, heard));
            }
            ModulePin::Init if !high => {
                self.fallen_us = if self.init {
                    self.now_us
                } else {
                    self.fallen_us
                };
                self.init = false;
                self.latched &= self.fault == ModuleFault::NeverFalls;
            }
            ModulePin::Binh if high => self.binh_us = Some(self.now_us),
            ModulePin::Blnk => assert!(!high, "BLNK would re-arm ECHO"),
            ModulePin::Init | ModulePin::Binh => {}
        }
    }

    /// When ECHO will rise.
    fn rise_us(&self) -> Option<u32> {
        if !self.init
            || self.latched
            || matches!(self.fault, ModuleFault::StuckLow | ModuleFault::StuckHigh)
        {
            return None;
        }
        if let ModuleFault::RisesAt(us) = self.fault {
            return Some(self.fired_us.wrapping_add(us));
        }
        let blanked_us = self
            .binh_us
            .map_or(2_380, |at| at.wrapping_sub(self.fired_us).min(2_380));
        let (_, heard) = *self.firings.last()?;
        if self.fault == ModuleFault::Dead(heard) {
            return None;
        }
        // The membrane rings for 850 µs.
        if blanked_us < 850 {
            return Some(self.fired_us.wrapping_add(blanked_us + 10));
        }
        let flight_us = self.flights_us[usize::from(heard)]?;
        (flight_us >= blanked_us).then(|| self.fired_us.wrapping_add(flight_us))
    }

    /// Advances the time to `then`, or to the rise of ECHO.
    fn pass(&mut self, then: u32) {
        let wait = then.wrapping_sub(self.now_us);
        let rise = self.rise_us().map(|at| at.wrapping_sub(self.now_us));
        match rise.filter(|&rise| rise <= wait) {
            Some(rise) => {
                self.now_us = self.now_us.wrapping_add(rise);
                self.latched = true;
                self.caught_us = Some(self.now_us);
            }
            None => self.now_us = then,
        }
    }
}

#[derive(Clone, Copy)]
enum ModulePin {
    Address(u8),
    Init,
    Binh,
    Blnk,
}

struct FakePin(SharedModule, ModulePin);

impl ErrorType for FakePin {
    type Error = Infallible;
}

impl OutputPin for FakePin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.borrow_mut().set(self.1, false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.borrow_mut().set(self.1, true);
        Ok(())
    }
}

struct SimCapture(SharedModule);

impl EchoCapture for SimCapture {
    fn now_us(&mut self) -> u32 {
        self.0.borrow().now_us
    }

    fn arm(&mut self) {
        self.0.borrow_mut().caught_us = None;
    }

    fn echo_line(&mut self) -> EchoLine {
        let module = self.0.borrow();
        EchoLine {
            high: module.latched || module.fault == ModuleFault::StuckHigh,
            rose_us: module.caught_us,
        }
    }
}

fn driver(module: &SharedModule, timing: Timing, order: FiringOrder) -> ChannelDriver<FakePin> {
    let pin = |wire| FakePin(Rc::clone(module), wire);
    let pins = RingPins {
        address: [0, 1, 2, 3].map(|bit| pin(ModulePin::Address(bit))),
        init: pin(ModulePin::Init),
        binh: pin(ModulePin::Binh),
        blnk: pin(ModulePin::Blnk),
    };
    let now_us = module.borrow().now_us;
    let Ok(driver) = ChannelDriver::new(pins, timing, order, now_us);
    driver
}

/// Runs a driver for `ms` milliseconds; run k is `late_us(k)` microseconds late.
fn run_for(module: &SharedModule, timing: Timing, ms: u32, late_us: impl Fn(usize) -> u32) {
    let mut driver = driver(module, timing, FiringOrder::NOMAD);
    let mut capture = SimCapture(Rc::clone(module));
    let began = module.borrow().now_us;
    let mut runs = 0;
    while module.borrow().now_us.wrapping_sub(began) < ms * 1_000 {
        let mut readings = Vec::new();
        let Ok(next) = driver.run(&mut capture, |reading| readings.push(reading));
        let mut module = module.borrow_mut();
        module.readings.append(&mut readings);
        module.pass(next.expect("an order"));
        let late = module.now_us.wrapping_add(late_us(runs));
        module.pass(late);
        runs += 1;
    }
}

/// Outcomes of the first ring, by transducer.
fn first_ring(
    fault: ModuleFault,
    timing: Timing,
    prepare: impl Fn(&mut ModuleSim),
) -> [FiringOutcome; 16] {
    let module = ModuleSim::new(fault);
    prepare(&mut module.borrow_mut());
    run_for(&module, timing, 1_150, |_| 0);
    let module = module.borrow();
    let of = |sensor: usize| {
        let mut all = module
            .readings
            .iter()
            .filter(|r| usize::from(r.sensor) == sensor);
        all.next().expect("a reading of each").outcome
    };
    core::array::from_fn(of)
}

#[test]
fn a_ring_is_heard_in_order_at_its_rate() {
    let module = ModuleSim::new(ModuleFault::Nothing);
    run_for(&module, Timing::relays(), 1_100, |_| 0);
    let module = module.borrow();
    let order = [0, 2, 15, 1, 14, 3, 13, 4, 12, 5, 11, 6, 10, 7, 9, 8];
    for (slot, reading) in module.readings.iter().take(16).enumerate() {
        let (fired_us, heard) = module.firings[slot];
        assert_eq!((heard, reading.sensor), (order[slot], order[slot]));
        assert_eq!(reading.fired_us, fired_us);
        assert_eq!(
            fired_us.wrapping_sub(module.firings[0].0),
            64_000 * slot as u32
        );
        let flight_us = 3_000 + 2_000 * u32::from(heard);
        assert_eq!(reading.outcome, FiringOutcome::Echo(flight_us));
    }
    assert!(module.readings.len() >= 16);
}

#[test]
fn echoes_within_the_blanking_are_not_detected() {
    let near = |module: &mut ModuleSim| module.flights_us = [Some(1_200); 16];
    let heard = first_ring(ModuleFault::Nothing, Timing::relays(), near);
    assert_eq!(heard, [FiringOutcome::Echo(1_200); 16]);
    let internal = Timing {
        blanking: Blanking::Internal,
        ..Timing::relays()
    };
    assert_eq!(
        first_ring(ModuleFault::Nothing, internal, near),
        [FiringOutcome::NoEcho; 16]
    );
    let nearer = |module: &mut ModuleSim| module.flights_us = [Some(800); 16];
    assert_eq!(
        first_ring(ModuleFault::Nothing, Timing::relays(), nearer),
        [FiringOutcome::NoEcho; 16]
    );
}

/// Each transducer's first turn is a self-test, the next ones listen; a dead one is tested again.
#[test]
fn a_dead_module_fails_the_self_test() {
    for (fault, dead) in [
        (ModuleFault::Nothing, None),
        (ModuleFault::Dead(5), Some(5)),
    ] {
        let module = ModuleSim::new(fault);
        run_for(&module, Timing::relays().with_self_test(), 3_100, |_| 0);
        let module = module.borrow();
        for sensor in 0..16_u8 {
            let mut readings = module.readings.iter().filter(|r| r.sensor == sensor);
            let outcomes = [(); 3].map(|()| readings.next().expect("three turns").outcome);
            let echo = FiringOutcome::Echo(3_000 + 2_000 * u32::from(sensor));
            let expected = match dead == Some(sensor) {
                true => [FiringOutcome::Mute; 3],
                false => [FiringOutcome::Ringing, echo, echo],
            };
            assert_eq!(outcomes, expected, "{sensor}");
        }
    }
}

/// A shorted line, or one that rises before BINH, does not pass as ringing.
#[test]
fn a_faulty_line_fails_the_self_test() {
    let timing = Timing::relays().with_self_test();
    for (fault, expected) in [
        (ModuleFault::StuckLow, FiringOutcome::Mute),
        (ModuleFault::StuckHigh, FiringOutcome::HeldHigh),
        (ModuleFault::RisesAt(399), FiringOutcome::Early),
        (ModuleFault::RisesAt(901), FiringOutcome::Mute),
    ] {
        assert_eq!(
            first_ring(fault, timing, |_| ()),
            [expected; 16],
            "{fault:?}"
        );
    }
}

#[test]
fn a_missing_echo_is_reported_and_the_delay_subtracted() {
    let one = |module: &mut ModuleSim| module.flights_us[3] = None;
    let timing = Timing {
        delay_us: 150,
        ..Timing::relays()
    };
    let heard = first_ring(ModuleFault::Nothing, timing, one);
    assert_eq!(heard[3], FiringOutcome::NoEcho);
    assert_eq!(heard[4], FiringOutcome::Echo(3_000 + 2_000 * 4 - 150));
    let beyond = |module: &mut ModuleSim| module.flights_us = [Some(37_701); 16];
    assert_eq!(
        first_ring(ModuleFault::Nothing, timing, beyond),
        [FiringOutcome::NoEcho; 16]
    );
}

#[test]
fn early_rises_are_no_echoes() {
    for us in [0, 300, 899] {
        let heard = first_ring(ModuleFault::RisesAt(us), Timing::relays(), |_| ());
        assert_eq!(heard, [FiringOutcome::Early; 16], "{us}");
    }
    let heard = first_ring(ModuleFault::RisesAt(900), Timing::relays(), |_| ());
    assert_eq!(heard, [FiringOutcome::Echo(900); 16]);
}

#[test]
fn a_line_stuck_high_prevents_firing() {
    let module = ModuleSim::new(ModuleFault::StuckHigh);
    run_for(&module, Timing::relays(), 1_150, |_| 0);
    let module = module.borrow();
    assert!(module.firings.is_empty());
    assert!(module.readings.len() >= 16);
    assert!(
        module
            .readings
            .iter()
            .all(|r| r.outcome == FiringOutcome::HeldHigh)
    );
}

#[test]
fn a_line_that_never_falls_is_reported_once_and_prevents_firing() {
    let module = ModuleSim::new(ModuleFault::NeverFalls);
    run_for(&module, Timing::relays(), 400, |_| 0);
    let module = module.borrow();
    let outcomes: Vec<_> = module.readings.iter().map(|r| r.outcome).collect();
    assert_eq!(
        outcomes[..4],
        [
            FiringOutcome::Echo(3_000),
            FiringOutcome::NotReleased,
            FiringOutcome::HeldHigh,
            FiringOutcome::HeldHigh
        ]
    );
    assert_eq!(module.firings.len(), 1);
    assert!(outcomes[4..].iter().all(|&o| o == FiringOutcome::HeldHigh));
}

#[test]
fn a_line_stuck_low_reports_no_echo() {
    assert_eq!(
        first_ring(ModuleFault::StuckLow, Timing::relays(), |_| ()),
        [FiringOutcome::NoEcho; 16]
    );
}

/// The pins cannot show this fault: all transducers report the same range.
#[test]
fn a_stuck_multiplexer_gives_equal_ranges() {
    let heard = first_ring(ModuleFault::Multiplexer(5), Timing::relays(), |_| ());
    assert_eq!(heard, [FiringOutcome::Echo(13_000); 16]);
}

#[test]
fn line_faults_are_not_reported_as_ranges() {
    let sound = SpeedOfSound::at(200);
    let heard = |outcome: FiringOutcome| outcome.report(sound);
    assert_eq!(
        heard(FiringOutcome::Echo(5_827)),
        EchoReport::Range(Some(Range::from_mm(1_000)))
    );
    assert_eq!(heard(FiringOutcome::NoEcho), EchoReport::Range(None));
    for outcome in [
        FiringOutcome::Early,
        FiringOutcome::HeldHigh,
        FiringOutcome::NotReleased,
    ] {
        assert_eq!(heard(outcome), EchoReport::Fault);
    }
}

#[test]
fn an_empty_order_rests() {
    let module = ModuleSim::new(ModuleFault::Nothing);
    let order = FiringOrder::new([END_OF_ORDER; 16]).expect("an order");
    let mut driver = driver(&module, Timing::relays(), order);
    module.borrow_mut().now_us += 2_000;
    let Ok(next) = driver.run(&mut SimCapture(Rc::clone(&module)), |_| panic!("a reading"));
    assert_eq!(next, None);
}

/// Every change of every pin within two slots, in order.
#[test]
fn the_pins_change_in_order() {
    let set = |levels: &[u8]| {
        let level = |&high: &u8| Transaction::set(if high == 1 { Level::High } else { Level::Low });
        Mock::new(&levels.iter().map(level).collect::<Vec<_>>())
    };
    // All low; transducer 0 and its slot; transducer 2 = 0b0010 and its slot.
    let pins = RingPins {
        address: [
            set(&[0, 0, 0]),
            set(&[0, 0, 1]),
            set(&[0, 0, 0]),
            set(&[0, 0, 0]),
        ],
        init: set(&[0, 1, 0, 1, 0]),
        binh: set(&[0, 1, 0, 1, 0]),
        blnk: set(&[0]),
    };
    let mut driver =
        ChannelDriver::new(pins, Timing::relays(), FiringOrder::NOMAD, 0).expect("pins");
    /// A line that never rises.
    struct Quiet(u32);
    impl EchoCapture for Quiet {
        fn now_us(&mut self) -> u32 {
            self.0
        }
        fn arm(&mut self) {}
        fn echo_line(&mut self) -> EchoLine {
            EchoLine::default()
        }
    }
    let mut capture = Quiet(0);
    let (mut times, mut heard) = (Vec::new(), Vec::new());
    while heard.len() < 2 {
        let next = driver.run(&mut capture, |reading| heard.push(reading));
        capture.0 = next.expect("pins").expect("an order");
        times.push(capture.0);
    }
    // Recycled, settled, BINH, window over; recycled, settled, slot begins, BINH, window over.
    let first = [1_000, 26_000, 26_900, 63_700, 64_700];
    let second = [89_700, 90_000, 90_900, 127_700, 128_700];
    assert_eq!(times, [first, second].concat());
    let results: Vec<_> = heard
        .iter()
        .map(|r| (r.sensor, r.outcome, r.fired_us))
        .collect();
    assert_eq!(
        results,
        [
            (0, FiringOutcome::NoEcho, 26_000),
            (2, FiringOutcome::NoEcho, 90_000)
        ]
    );
    let RingPins {
        address,
        mut init,
        mut binh,
        mut blnk,
    } = driver.into_pins();
    for mut pin in address {
        pin.done();
    }
    init.done();
    binh.done();
    blnk.done();
}

/// Four channels of a quadrant each, late in different ways: bursts are at least half the stagger
/// apart, and none is missed.
#[test]
fn four_channels_keep_their_bursts_apart() {
    let mut firings = Vec::new();
    for channel in 0..4_u8 {
        let module = ModuleSim::new(ModuleFault::Nothing);
        let timing = Timing::relays().quadrant(channel);
        let late = |run: usize| [0, 300, 40, 900, 1_700][(run + usize::from(channel)) % 5];
        run_for(&module, timing, 3_000, late);
        firings.extend(module.borrow().firings.iter().map(|&(at, _)| at));
    }
    firings.sort_unstable_by_key(|at| at.wrapping_sub(u32::MAX - 200_000));
    assert!(firings.len() > 100, "{}", firings.len());
    for pair in firings.windows(2) {
        assert!(
            pair[1].wrapping_sub(pair[0]) >= STAGGER_US - MAX_LATE_US,
            "{pair:?}"
        );
    }
}

proptest! {
    /// For any ECHO and any delay of the calls: the address is constant while INIT is high, a burst
    /// begins with ECHO low and 25 ms after the address, and INIT rises and falls alternately.
    #[test]
    fn the_address_never_changes_under_a_burst(
        events in proptest::collection::vec((0_u32..70_000, any::<bool>(), 0_u32..80_000), 1..400),
        start in any::<u32>(),
        internal in any::<bool>(), self_test in any::<bool>(),
    ) {
        let blanking = if internal { Blanking::Internal } else { Blanking::SHORT };
        let timing = Timing { blanking, self_test, ..Timing::relays() };
        let mut channel = SonarChannel::new(timing, FiringOrder::NOMAD, start);
        let (mut now, mut init, mut selected) = (start, false, None);
        for (dt, high, ago) in events {
            now = now.wrapping_add(dt);
            let rose_us = (high && ago % 2 == 0).then(|| now.wrapping_sub(ago));
            let line = EchoLine { high, rose_us };
            for turn in 0.. {
                prop_assert!(turn < 20, "it never waits");
                match channel.poll(now, line) {
                    ChannelStep::Change(PinChange::Select(sensor)) => {
                        prop_assert!(!init && sensor < 16);
                        selected = Some(now);
                    }
                    ChannelStep::Change(PinChange::Init(true)) => {
                        prop_assert!(!init && !high);
                        let at = selected.expect("an address before a burst");
                        prop_assert!(now.wrapping_sub(at) >= 25_000);
                        init = true;
                    }
                    ChannelStep::Change(PinChange::Init(false)) => {
                        prop_assert!(init);
                        init = false;
                    }
                    ChannelStep::Change(PinChange::Binh(raised)) => prop_assert!(!raised || init),
                    ChannelStep::Report(reading) => prop_assert!(!init && reading.sensor < 16),
                    ChannelStep::WaitUntil(until) => {
                        prop_assert!(until.wrapping_sub(now) <= 2 * timing.slot_us());
                        break;
                    }
                    ChannelStep::Idle => prop_assert!(false, "the order is not empty"),
                }
            }
        }
    }
}
