//! The serial port of the link: any of the chip's USARTs.

use core::ops::Deref;
use firmware::uart::{UartPort, UartStatus};
use stm32f4xx_hal::pac::{Interrupt, usart1};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::serial;

/// Rate of the link; eight data bits, no parity, one stop bit.
const BAUD: u32 = 115_200;

/// The settings of the link's port.
#[must_use]
pub fn settings() -> serial::Config {
    serial::Config::default().baudrate(BAUD.bps())
}

/// A USART that interrupts for each byte.
pub struct SerialPort<U> {
    usart: U,
    #[cfg_attr(
        not(feature = "qemu"),
        expect(dead_code, reason = "a real port raises it")
    )]
    interrupt: Interrupt,
}

impl<U: Deref<Target = usart1::RegisterBlock>> SerialPort<U> {
    /// Enables the receive interrupt of a USART that is already set up.
    pub fn listen(usart: U, interrupt: Interrupt) -> Self {
        usart.cr1().modify(|_, w| w.rxneie().set_bit());
        Self { usart, interrupt }
    }
}

impl<U: Deref<Target = usart1::RegisterBlock>> UartPort for SerialPort<U> {
    fn status(&mut self) -> UartStatus {
        let register = self.usart.sr().read();
        UartStatus {
            received: register.rxne().bit_is_set(),
            overrun: register.ore().bit_is_set(),
            can_send: register.txe().bit_is_set(),
        }
    }

    fn receive(&mut self) -> u8 {
        // The upper bits are unused without parity.
        self.usart.dr().read().dr().bits() as u8
    }

    fn send(&mut self, byte: u8) {
        self.usart.dr().write(|w| w.dr().set(byte.into()));
    }

    #[cfg(not(feature = "qemu"))]
    fn enable_transmit_interrupt(&mut self, wanted: bool) {
        self.usart.cr1().modify(|_, w| w.txeie().bit(wanted));
    }

    // The emulated port raises no transmit interrupt, so software pends it.
    #[cfg(feature = "qemu")]
    fn enable_transmit_interrupt(&mut self, wanted: bool) {
        if wanted {
            rtic::pend(self.interrupt);
        }
    }
}
