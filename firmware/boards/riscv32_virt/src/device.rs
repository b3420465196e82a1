//! Devices of the RISC-V machine: UART, timer, reset. Only this file accesses registers.
//!
//! The addresses are those of `hw/riscv/virt.c` in QEMU.

#![allow(unsafe_code)]

use amp::units::Millis;
use core::ptr::with_exposed_provenance_mut;
use firmware::uart::{UartPort, UartStatus};

/// The serial port, compatible with a 16550.
const UART: usize = 0x1000_0000;
/// Its registers: data, FIFO control, line control, line status.
const DATA: usize = 0;
/// While the latch is open: the two bytes of the rate's divisor.
const DIVISOR: [usize; 2] = [0, 1];
/// Bit of the line control that opens the latch.
const LATCH: u8 = 1 << 7;
const FIFO_CONTROL: usize = 2;
const LINE_CONTROL: usize = 3;
const LINE_STATUS: usize = 5;
/// The core-local interruptor: compare register and time, 64 bits each.
const COMPARE: usize = 0x0200_4000;
const TIME: usize = 0x0200_bff8;
/// Ticks of the timer per millisecond.
const TICKS_PER_MS: u64 = 10_000;
/// The device that resets the machine.
const TEST_DEVICE: usize = 0x10_0000;
/// The command for a reset.
const RESET: u32 = 0x7777;

/// The serial port.
pub struct Uart16550 {
    moved: bool,
}

impl Uart16550 {
    /// Eight data bits, no parity, one stop bit; FIFOs of 16 bytes. At the greatest rate: the
    /// emulator keeps to it.
    pub fn start() -> Self {
        write8(LINE_CONTROL, LATCH);
        for (register, byte) in DIVISOR.into_iter().zip([1, 0]) {
            write8(register, byte);
        }
        write8(LINE_CONTROL, 0b011);
        write8(FIFO_CONTROL, 0b111);
        Self { moved: false }
    }

    /// Whether a byte was moved since the last call.
    pub fn take_moved(&mut self) -> bool {
        core::mem::take(&mut self.moved)
    }
}

impl UartPort for Uart16550 {
    fn status(&mut self) -> UartStatus {
        let status = read8(LINE_STATUS);
        UartStatus {
            received: status & 1 != 0,
            overrun: status & 1 << 1 != 0,
            can_send: status & 1 << 5 != 0,
        }
    }

    fn receive(&mut self) -> u8 {
        self.moved = true;
        read8(DATA)
    }

    fn send(&mut self, byte: u8) {
        self.moved = true;
        write8(DATA, byte);
    }

    // The loop polls the port.
    fn enable_transmit_interrupt(&mut self, _: bool) {}
}

/// The core's timer.
pub struct Timer {}

impl Timer {
    /// Lets the timer wake the core. Its interrupt is never taken, because interrupts are disabled.
    pub fn start() -> Self {
        // SAFETY: with interrupts disabled, this bit only decides whether the core wakes.
        unsafe { riscv::register::mie::set_mtimer() };
        Self {}
    }

    /// Time since the start; wraps after 49.7 days.
    pub fn now(&self) -> Millis {
        Millis::from_ms((ticks() / TICKS_PER_MS) as u32)
    }

    /// Sleeps for a millisecond.
    pub fn sleep_1_ms(&mut self) {
        let then = ticks() + TICKS_PER_MS;
        // The upper half goes last, and no intermediate value is earlier than `then`.
        write32(COMPARE + 4, u32::MAX);
        write32(COMPARE, then as u32);
        write32(COMPARE + 4, (then >> 32) as u32);
        riscv::asm::wfi();
    }
}

/// Resets the machine.
pub fn reset() -> ! {
    write32(TEST_DEVICE, RESET);
    loop {
        riscv::asm::wfi();
    }
}

/// Ticks since the start.
fn ticks() -> u64 {
    loop {
        let (high, low) = (read32(TIME + 4), read32(TIME));
        // The lower half may have overflowed in between.
        if read32(TIME + 4) == high {
            return u64::from(high) << 32 | u64::from(low);
        }
    }
}

fn read8(register: usize) -> u8 {
    // SAFETY: a register of the port; reading it does not affect memory.
    unsafe { with_exposed_provenance_mut::<u8>(UART + register).read_volatile() }
}

fn write8(register: usize, value: u8) {
    // SAFETY: as in `read8`.
    unsafe { with_exposed_provenance_mut::<u8>(UART + register).write_volatile(value) }
}

fn read32(address: usize) -> u32 {
    // SAFETY: a register of the timer; reading it does not affect memory.
    unsafe { with_exposed_provenance_mut::<u32>(address).read_volatile() }
}

fn write32(address: usize, value: u32) {
    // SAFETY: a register of the timer or the test device; writing it does not affect memory.
    unsafe { with_exposed_provenance_mut::<u32>(address).write_volatile(value) }
}
