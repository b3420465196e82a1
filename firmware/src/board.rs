//! The board: clocks, pins, the serial port, the watchdog. The only file that touches them.
//!
//! Which pin does what stands in [`firmware::pinout`], where a test holds this file to it.
//!
//! An emulated chip differs in three points: its oscillators are never ready, so it stays on the internal one; its port
//! raises no interrupt when it takes a byte, so this is done by software; watchdog and reset flags do nothing.

use crate::flash::Kept;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use firmware::crash::Flags;
use firmware::line::{Port, Status};
use stm32f4xx_hal::gpio::{Output, PC12, PinState, Pull};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;
use stm32f4xx_hal::serial;
use stm32f4xx_hal::watchdog::IndependentWatchdog;

/// Clock of the processor. An emulated chip counts its clock at this rate too, whatever its oscillator is.
const CORE_HZ: u32 = 168_000_000;

/// Rate of the link, with eight data bits, no parity and one stop bit.
const BAUD: u32 = 115_200;

/// The watchdog bites after this time. Its oscillator (17 to 47 kHz, STM32F405 data sheet DS8626, LSI) makes it 340 to 940
/// ms; every task shows itself each 10 ms.
const WATCHDOG_MS: u32 = 500;

/// The watchdog bites after this time while flash is erased or written: 10.9 to 30.1 s, and two sectors take 8 s at most, an
/// image less than a second.
const PATIENT_MS: u32 = 16_000;

/// The devices the tasks work with.
pub struct Board {
    /// The serial port of the link.
    pub port: SerialPort,
    /// The lamp.
    pub lamp: Lamp,
    /// The watchdog, running.
    pub watchdog: Watchdog,
    /// What the chip remembers of the last reset.
    pub flags: Flags,
    /// What outlives a loss of power.
    pub kept: Kept,
}

impl Board {
    /// Starts the watchdog, then everything else: a crystal that does not swing ends in a reset, not in silence.
    pub fn init(device: pac::Peripherals, mut core: cortex_m::Peripherals) -> Self {
        let mut watchdog = IndependentWatchdog::new(device.IWDG);
        watchdog.stop_on_debug(&device.DBGMCU, true);
        watchdog.start(WATCHDOG_MS.millis());

        let flags = take_flags(&device.RCC);
        let mut rcc = device.RCC.freeze(oscillator());
        count_milliseconds(&mut core.SYST);

        let gpioa = device.GPIOA.split(&mut rcc);
        let gpioc = device.GPIOC.split(&mut rcc);
        let lamp = gpioc.pc12.into_push_pull_output_in_state(PinState::High);
        // An open wire would be noise; the idle line is high.
        let receive = gpioa.pa10.into_alternate().internal_resistor(Pull::Up);
        let settings = serial::Config::default().baudrate(BAUD.bps());
        let serial = device
            .USART1
            .serial::<u8>((gpioa.pa9, receive), settings, &mut rcc)
            .expect("every clock used here can make this rate");
        Self {
            port: SerialPort::listen(serial.release().0),
            lamp: Lamp(lamp),
            watchdog: Watchdog(watchdog),
            flags,
            kept: Kept::new(device.FLASH),
        }
    }
}

/// The crystal, multiplied to the chip's highest clock.
#[cfg(not(feature = "qemu"))]
fn oscillator() -> Config {
    Config::hse(8.MHz()).sysclk(CORE_HZ.Hz())
}

/// The internal oscillator, as it is after a reset.
#[cfg(feature = "qemu")]
fn oscillator() -> Config {
    Config::hsi()
}

/// Lets the core's timer raise an interrupt each millisecond.
fn count_milliseconds(timer: &mut SYST) {
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(CORE_HZ / 1_000 - 1);
    timer.clear_current();
    timer.enable_interrupt();
    timer.enable_counter();
}

/// Reads and clears what the chip remembers of the last reset.
fn take_flags(rcc: &pac::RCC) -> Flags {
    let register = rcc.csr().read();
    let flags = Flags {
        power: register.porrstf().bit_is_set() || register.borrstf().bit_is_set(),
        watchdog: register.wdgrstf().bit_is_set() || register.wwdgrstf().bit_is_set(),
        software: register.sftrstf().bit_is_set(),
        pin: register.padrstf().bit_is_set(),
    };
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    flags
}

/// The green lamp; it is lit when its pin is low.
pub struct Lamp(PC12<Output>);

impl Lamp {
    /// Lights it or puts it out.
    pub fn light(&mut self, lit: bool) {
        self.0.set_state(PinState::from(!lit));
    }
}

/// The watchdog.
pub struct Watchdog(IndependentWatchdog);

impl Watchdog {
    /// Gives it as much time again.
    pub fn feed(&mut self) {
        self.0.feed();
    }

    /// Makes it bite after [`PATIENT_MS`] from now on, or after [`WATCHDOG_MS`] again.
    // One copy of it in the program.
    #[inline(never)]
    pub fn be_patient(&mut self, patient: bool) {
        let bite_ms = if patient { PATIENT_MS } else { WATCHDOG_MS };
        // A change takes the watchdog some cycles of its own clock, 0.3 ms, during which it takes no other: it is waited for,
        // and then it is fed, so that it counts from the new time.
        let _ = self.0.interval();
        self.0.start(bite_ms.millis());
        let _ = self.0.interval();
        self.0.feed();
    }
}

/// The serial port of the link.
pub struct SerialPort(pac::USART1);

impl SerialPort {
    fn listen(usart: pac::USART1) -> Self {
        usart.cr1().modify(|_, w| w.rxneie().set_bit());
        Self(usart)
    }
}

impl Port for SerialPort {
    fn status(&mut self) -> Status {
        let register = self.0.sr().read();
        Status {
            received: register.rxne().bit_is_set(),
            overrun: register.ore().bit_is_set(),
            can_send: register.txe().bit_is_set(),
        }
    }

    fn receive(&mut self) -> u8 {
        // The upper bits are the parity's and empty.
        self.0.dr().read().dr().bits() as u8
    }

    fn send(&mut self, byte: u8) {
        self.0.dr().write(|w| w.dr().set(byte.into()));
    }

    #[cfg(not(feature = "qemu"))]
    fn call_to_send(&mut self, wanted: bool) {
        self.0.cr1().modify(|_, w| w.txeie().bit(wanted));
    }

    #[cfg(feature = "qemu")]
    fn call_to_send(&mut self, wanted: bool) {
        if wanted {
            rtic::pend(pac::Interrupt::USART1);
        }
    }
}
