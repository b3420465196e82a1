//! The chip's common devices: watchdog, reset flags, status LED, supply monitor.
//!
//! An emulated chip differs in three points. It has only the internal oscillator. Its port raises
//! no transmit interrupt, so software pends it. Watchdog and reset flags have no effect.

use crate::flash::StoreFlash;
use crate::ring_timer::RingTimer;
use crate::serial::SerialPort;
use crate::{clocks, fault};
use amp::wire::message::Oscillator;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use firmware::crash::ResetFlags;
use firmware::safety::SafetyLines;
use firmware::sonar_ring::RingPins;
use stm32f4xx_hal::gpio::{ErasedPin, Input, Output, PB13, PB14, PB15, PinState};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Enable, Rcc};
use stm32f4xx_hal::watchdog::IndependentWatchdog;

/// Clock of the processor. An emulated chip also counts at this rate.
pub const CORE_HZ: u32 = 168_000_000;

/// Normal timeout of the watchdog. The tolerance of its oscillator (17 to 47 kHz, STM32F405 data
/// sheet DS8626, LSI) makes it 340 to 940 ms; every task checks in each 10 ms.
const WATCHDOG_MS: u32 = 500;

/// Timeout while flash is erased or written: 10.9 to 30.1 s. Two sectors take at most 4 s, an
/// image a quarter of a second.
const LONG_TIMEOUT_MS: u32 = 16_000;

/// The devices that the tasks use; `U` is the USART of the link.
pub struct Devices<U> {
    /// The serial port of the link.
    pub port: SerialPort<U>,
    /// The status LED.
    pub led: StatusLed,
    /// The watchdog, running.
    pub watchdog: Watchdog,
    /// The pins of the ring, all low.
    pub ring_pins: RingPins<RingPin>,
    /// The timer of the ring.
    pub ring_timer: RingTimer,
    /// The flags of the last reset.
    pub flags: ResetFlags,
    /// The oscillator that clocks the processor.
    pub oscillator: Oscillator,
    /// Emergency stop, bumper and motion permit.
    pub safety: BoardSafetyLines,
    /// The monitor of the supply voltage.
    pub supply: SupplyMonitor,
    /// The interrupt of the monitor.
    pub supply_alarm: SupplyInterrupt,
    /// The flash for saved images.
    pub flash: StoreFlash,
}

/// The chip after its start, before a board takes its pins.
pub struct StartedChip {
    /// The clocks, running.
    pub rcc: Rcc,
    /// The watchdog, running.
    pub watchdog: Watchdog,
    /// The flags of the last reset.
    pub flags: ResetFlags,
    /// The oscillator that clocks the processor.
    pub oscillator: Oscillator,
}

impl StartedChip {
    /// Starts the watchdog, then the clocks, and guards the stack.
    pub fn start(
        (iwdg, dbgmcu): (pac::IWDG, &pac::DBGMCU),
        (rcc, timer): (pac::RCC, pac::TIM11),
        mut core: cortex_m::Peripherals,
    ) -> Self {
        let mut watchdog = IndependentWatchdog::new(iwdg);
        watchdog.stop_on_debug(dbgmcu, true);
        watchdog.start(WATCHDOG_MS.millis());
        let flags = read_reset_flags(&rcc);
        let (rcc, oscillator) = clocks::start(rcc, timer, flags);
        start_millisecond_tick(&mut core.SYST);
        fault::guard_stack(&mut core.MPU);
        Self {
            rcc,
            watchdog: Watchdog(watchdog),
            flags,
            oscillator,
        }
    }
}

/// Starts the interrupt of each millisecond.
fn start_millisecond_tick(timer: &mut SYST) {
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(CORE_HZ / 1_000 - 1);
    timer.clear_current();
    timer.enable_interrupt();
    timer.enable_counter();
}

/// Reads and clears the flags of the last reset.
fn read_reset_flags(rcc: &pac::RCC) -> ResetFlags {
    let register = rcc.csr().read();
    let flags = ResetFlags {
        power: register.porrstf().bit_is_set() || register.borrstf().bit_is_set(),
        watchdog: register.wdgrstf().bit_is_set() || register.wwdgrstf().bit_is_set(),
        software: register.sftrstf().bit_is_set(),
        pin: register.padrstf().bit_is_set(),
    };
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    flags
}

/// The status LED.
pub struct StatusLed {
    pin: ErasedPin<Output>,
    lit: PinState,
}

impl StatusLed {
    /// An LED that is lit while its pin has the level `lit`.
    #[must_use]
    pub const fn new(pin: ErasedPin<Output>, lit: PinState) -> Self {
        Self { pin, lit }
    }

    /// Switches the LED on or off.
    pub fn set(&mut self, lit: bool) {
        self.pin.set_state(if lit { self.lit } else { !self.lit });
    }
}

/// The safety lines of a board.
pub type BoardSafetyLines = SafetyLines<ErasedPin<Input>, ErasedPin<Output>>;

/// The safety lines at the same pins of each board: emergency stop, bumper, motion permit.
pub fn safety_lines(emergency_stop: PB13, bumper: PB14, permit: PB15) -> BoardSafetyLines {
    SafetyLines::new(
        emergency_stop.into_pull_up_input().erase(),
        bumper.into_pull_up_input().erase(),
        permit.into_push_pull_output().erase(),
    )
}

/// The monitor of the supply voltage: the chip's voltage detector (PVD).
pub struct SupplyMonitor(pac::PWR);

impl SupplyMonitor {
    /// Monitors for less than 2.9 V, the highest threshold (RM0090, 5.4.1).
    pub fn watch(power: pac::PWR, rcc: &mut Rcc) -> Self {
        pac::PWR::enable(rcc);
        power.cr().modify(|_, w| w.pls().set(7).pvde().set_bit());
        Self(power)
    }

    /// Whether the voltage is too low at present.
    pub fn is_low(&self) -> bool {
        self.0.csr().read().pvdo().bit_is_set()
    }
}

/// The interrupt of the voltage detector.
pub struct SupplyInterrupt(pac::EXTI);

impl SupplyInterrupt {
    /// Interrupts when the voltage falls too low: the detector's output then rises on line 16
    /// (RM0090, 5.2.3 and 12.2.5).
    pub fn listen(lines: pac::EXTI) -> Self {
        lines.rtsr().modify(|_, w| w.tr16().set_bit());
        lines.imr().modify(|_, w| w.mr16().set_bit());
        Self(lines)
    }

    /// Clears the interrupt.
    pub fn clear(&mut self) {
        // Ones clear; zeros leave the other lines unchanged.
        self.0.pr().write(|w| w.pr16().clear_bit_by_one());
    }
}

/// A pin of the ring.
pub type RingPin = ErasedPin<Output>;

/// The watchdog.
pub struct Watchdog(IndependentWatchdog);

impl Watchdog {
    /// Restarts the timeout.
    pub fn feed(&mut self) {
        self.0.feed();
    }

    /// Sets the long timeout [`LONG_TIMEOUT_MS`], or the normal one [`WATCHDOG_MS`], from now on.
    // Not inlined: one copy in flash.
    #[inline(never)]
    pub fn set_long_timeout(&mut self, long: bool) {
        let timeout_ms = if long { LONG_TIMEOUT_MS } else { WATCHDOG_MS };
        // A change takes the watchdog 0.3 ms, during which it accepts no other: wait for it, then
        // feed, so that the new timeout begins now.
        let _ = self.0.interval();
        self.0.start(timeout_ms.millis());
        let _ = self.0.interval();
        self.0.feed();
    }
}
