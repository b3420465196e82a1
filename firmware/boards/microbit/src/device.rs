//! The chip: crystal, serial port, timer, one LED. The only file that touches registers.

#![allow(unsafe_code)]

use firmware::uart::{UartPort, UartStatus};
use nrf51_pac::generic::{Reg, RegisterSpec, Resettable, Writable};
use nrf51_pac::{GPIO, Peripherals, TIMER0, UART0};

/// Pin of the port P0 that transmits to the interface chip, which hands it to the USB.
const TRANSMIT: u32 = 24;
/// Pin of the port P0 that receives from there.
const RECEIVE: u32 = 25;
/// First row of the LEDs: high lights it.
const ROW: u32 = 13;
/// First column of the LEDs: low lights it.
const COLUMN: u32 = 4;

/// The devices the program works with.
pub struct Device {
    /// The serial port of the link.
    pub uart: NordicUart,
    /// Raises an interrupt each millisecond.
    pub timer: MillisecondTimer,
    /// The status LED.
    pub led: MatrixLed,
}

impl Device {
    /// Starts the crystal, the port and the timer.
    pub fn start(chip: Peripherals) -> Self {
        // The internal oscillator would be too inexact for a serial line.
        set(&chip.CLOCK.tasks_hfclkstart, 1);
        while chip.CLOCK.events_hfclkstarted.read().bits() == 0 {}
        Self {
            uart: NordicUart::start(chip.UART0),
            timer: MillisecondTimer::start(chip.TIMER0),
            led: MatrixLed::start(chip.GPIO),
        }
    }
}

/// Writes a register whole.
fn set<R>(register: &Reg<R>, value: u32)
where
    R: RegisterSpec<Ux = u32> + Writable + Resettable,
{
    // SAFETY: tasks, events, pin numbers and counts take any value; none of them leads to memory.
    register.write(|w| unsafe { w.bits(value) });
}

/// The serial port: 115 200 baud, eight data bits, no parity, one stop bit.
pub struct NordicUart {
    registers: UART0,
    /// A byte is on its way out.
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
            // Ones take away the errors they stand for.
            set(&self.registers.errorsrc, 0xf);
        }
        UartStatus {
            received: self.registers.events_rxdrdy.read().bits() != 0,
            overrun,
            can_send: !self.is_sending,
        }
    }

    fn receive(&mut self) -> u8 {
        // First the event: it comes again if a further byte lies behind this one.
        set(&self.registers.events_rxdrdy, 0);
        self.registers.rxd.read().rxd().bits()
    }

    fn send(&mut self, byte: u8) {
        self.is_sending = true;
        set(&self.registers.txd, byte.into());
    }

    // The interrupt comes after each byte, whether there is another one or not.
    fn enable_transmit_interrupt(&mut self, _: bool) {}
}

/// Timer 0, which counts microseconds and begins anew each millisecond.
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

    /// Forgets why it has called.
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

    /// Lights it or puts it out.
    pub fn set(&mut self, lit: bool) {
        if lit {
            set(&self.0.outset, 1 << ROW);
        } else {
            set(&self.0.outclr, 1 << ROW);
        }
    }
}
