//! Devices of the nRF51822: crystal, serial port, timer, LED. Only this file accesses registers.

#![allow(unsafe_code)]

use firmware::uart::{UartPort, UartStatus};
use nrf51_pac::generic::{Reg, RegisterSpec, Resettable, Writable};
use nrf51_pac::{GPIO, Peripherals, TIMER0, UART0};

/// Pin P0.24: transmits to the USB interface chip.
const TRANSMIT: u32 = 24;
/// Pin P0.25: receives from the USB interface chip.
const RECEIVE: u32 = 25;
/// First row of the LED matrix, active high.
const ROW: u32 = 13;
/// First column of the LED matrix, active low.
const COLUMN: u32 = 4;

/// The devices of the program.
pub struct Device {
    /// The serial port of the link.
    pub uart: NordicUart,
    /// Interrupts each millisecond.
    pub timer: MillisecondTimer,
    /// The status LED.
    pub led: MatrixLed,
}

impl Device {
    /// Starts the crystal, the port and the timer.
    pub fn start(chip: Peripherals) -> Self {
        // The internal oscillator is too inaccurate for a serial link.
        set(&chip.CLOCK.tasks_hfclkstart, 1);
        while chip.CLOCK.events_hfclkstarted.read().bits() == 0 {}
        Self {
            uart: NordicUart::start(chip.UART0),
            timer: MillisecondTimer::start(chip.TIMER0),
            led: MatrixLed::start(chip.GPIO),
        }
    }
}

/// Writes a whole register.
fn set<R>(register: &Reg<R>, value: u32)
where
    R: RegisterSpec<Ux = u32> + Writable + Resettable,
{
    // SAFETY: tasks, events, pin numbers and counts accept any value; none is an address.
    register.write(|w| unsafe { w.bits(value) });
}

/// The serial port: 115 200 baud, eight data bits, no parity, one stop bit.
pub struct NordicUart {
    registers: UART0,
    /// A byte is being sent.
    is_sending: bool,
}

impl NordicUart {
    fn start(registers: UART0) -> Self {
        set(&registers.pseltxd, TRANSMIT);
        set(&registers.pselrxd, RECEIVE);
        registers.baudrate.write(|w| w.baudrate().baud115200());
        registers.enable.write(|w| w.enable().enabled());
        registers
            .intenset
            .write(|w| w.rxdrdy().set().txdrdy().set().error().set());
        set(&registers.tasks_startrx, 1);
        set(&registers.tasks_starttx, 1);
        Self {
            registers,
            is_sending: false,
        }
    }
}

impl UartPort for NordicUart {
    fn status(&mut self) -> UartStatus {
        if self.registers.events_txdrdy.read().bits() != 0 {
            set(&self.registers.events_txdrdy, 0);
            self.is_sending = false;
        }
        let overrun = self.registers.errorsrc.read().overrun().bit_is_set();
        if self.registers.events_error.read().bits() != 0 {
            set(&self.registers.events_error, 0);
            // Ones clear the errors.
            set(&self.registers.errorsrc, 0xf);
        }
        UartStatus {
            received: self.registers.events_rxdrdy.read().bits() != 0,
            overrun,
            can_send: !self.is_sending,
        }
    }

    fn receive(&mut self) -> u8 {
        // Clears the event first: it comes again if another byte is waiting.
        set(&self.registers.events_rxdrdy, 0);
        self.registers.rxd.read().rxd().bits()
    }

    fn send(&mut self, byte: u8) {
        self.is_sending = true;
        set(&self.registers.txd, byte.into());
    }

    // The interrupt comes after every sent byte.
    fn enable_transmit_interrupt(&mut self, _: bool) {}
}

/// Timer 0: counts microseconds and restarts each millisecond.
pub struct MillisecondTimer(TIMER0);

impl MillisecondTimer {
    fn start(timer: TIMER0) -> Self {
        timer.bitmode.write(|w| w.bitmode()._16bit());
        // 16 MHz / 2^4.
        set(&timer.prescaler, 4);
        set(&timer.cc[0], 1_000);
        timer.shorts.write(|w| w.compare0_clear().enabled());
        timer.intenset.write(|w| w.compare0().set());
        set(&timer.tasks_start, 1);
        Self(timer)
    }

    /// Clears the timer's interrupt.
    pub fn clear(&mut self) {
        set(&self.0.events_compare[0], 0);
    }
}

/// The LED in the first row and column.
pub struct MatrixLed(GPIO);

impl MatrixLed {
    fn start(port: GPIO) -> Self {
        set(&port.dirset, 1 << ROW | 1 << COLUMN);
        Self(port)
    }

    /// Switches the LED on or off.
    pub fn set(&mut self, lit: bool) {
        if lit {
            set(&self.0.outset, 1 << ROW);
        } else {
            set(&self.0.outclr, 1 << ROW);
        }
    }
}
