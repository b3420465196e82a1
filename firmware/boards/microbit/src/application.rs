//! The program on the micro:bit: two interrupts and the main loop.

#![allow(unsafe_code)]

use crate::device::{Device, MatrixLed, MillisecondTimer, NordicUart};
use amp::body::HeldRing;
use amp::node::{Identity, NomadNode};
use amp::units::Millis;
use amp::wire::message::{Oscillator, ResetCause};
use core::cell::RefCell;
use core::panic::PanicInfo;
use core::ptr::addr_of;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use cortex_m::peripheral::{NVIC, SCB};
use cortex_m_rt::{entry, exception};
use critical_section::Mutex;
use firmware::control::Control;
use firmware::uart::{ErrorCounters, TxQueue, UartDriver};
use firmware::{BUILD, stack, status_led};
use heapless::spsc::Queue;
use nrf51_pac::{Interrupt, Peripherals, interrupt};

/// Longest time between two runs of the control task.
const CONTROL_PERIOD_MS: u32 = 10;

/// What the Hello says about this device.
const IDENTITY: Identity = Identity {
    build: BUILD,
    reset: ResetCause::Unknown,
    oscillator: Oscillator::Crystal,
    ring: false,
};

/// The serial interrupt's data.
struct SerialLink {
    driver: UartDriver<'static>,
    uart: NordicUart,
}

static SERIAL_LINK: Mutex<RefCell<Option<SerialLink>>> = Mutex::new(RefCell::new(None));
static TIMER: Mutex<RefCell<Option<MillisecondTimer>>> = Mutex::new(RefCell::new(None));
static ERRORS: ErrorCounters = ErrorCounters::new();
static NOW_MS: AtomicU32 = AtomicU32::new(0);
/// The control task has to run.
static CONTROL_PENDING: AtomicBool = AtomicBool::new(true);

#[entry]
fn main() -> ! {
    static mut NODE: NomadNode = NomadNode::new();
    static mut RX_QUEUE: Queue<u8, 256> = Queue::new();
    static mut TX_QUEUE: Queue<u8, 384> = Queue::new();

    let (received_in, received_out) = RX_QUEUE.split();
    let (to_send_in, to_send_out) = TX_QUEUE.split();
    let peripherals = Peripherals::take().unwrap();
    let mut device = Device::start(peripherals);
    let mut control: Control<'_, HeldRing> =
        Control::new(NODE, received_out, TxQueue::new(to_send_in), &ERRORS, None);
    let link = SerialLink {
        driver: UartDriver::new(received_in, to_send_out),
        uart: device.uart,
    };
    critical_section::with(|cs| {
        SERIAL_LINK.replace(cs, Some(link));
        TIMER.replace(cs, Some(device.timer));
    });
    unmask();
    control.start(IDENTITY, Millis::from_ms(0));
    loop {
        // No atomic swap needed: an interrupt in between sets it again, at the latest in 10 ms.
        if CONTROL_PENDING.load(Ordering::Relaxed) {
            CONTROL_PENDING.store(false, Ordering::Relaxed);
            run_control(&mut control, &mut device.led);
        } else {
            cortex_m::asm::wfi();
        }
    }
}

/// Runs the control task once.
fn run_control(control: &mut Control<'_, HeldRing>, led: &mut MatrixLed) {
    let now = Millis::from_ms(NOW_MS.load(Ordering::Relaxed));
    if control.run(now) {
        CONTROL_PENDING.store(true, Ordering::Relaxed);
    }
    if control.take_queued() {
        NVIC::pend(Interrupt::UART0);
    }
    control.set_stack_peak(stack_peak_bytes());
    led.set(status_led::is_lit(now, control.is_linked(), IDENTITY.reset));
}

/// Enables the interrupts. The serial interrupt has the higher priority.
fn unmask() {
    // SAFETY: no critical section of this program relies on a mask or a priority.
    unsafe {
        let mut nvic = cortex_m::Peripherals::steal().NVIC;
        nvic.set_priority(Interrupt::UART0, 0);
        nvic.set_priority(Interrupt::TIMER0, 1 << 6);
        NVIC::unmask(Interrupt::UART0);
        NVIC::unmask(Interrupt::TIMER0);
    }
}

#[interrupt]
fn UART0() {
    critical_section::with(|cs| {
        if let Some(link) = SERIAL_LINK.borrow_ref_mut(cs).as_mut()
            && link.driver.transfer(&mut link.uart, &ERRORS)
        {
            CONTROL_PENDING.store(true, Ordering::Relaxed);
        }
    });
}

#[interrupt]
fn TIMER0() {
    critical_section::with(|cs| {
        if let Some(timer) = TIMER.borrow_ref_mut(cs).as_mut() {
            timer.clear();
        }
    });
    // Only this interrupt writes it.
    let now_ms = NOW_MS.load(Ordering::Relaxed).wrapping_add(1);
    NOW_MS.store(now_ms, Ordering::Relaxed);
    if now_ms.is_multiple_of(CONTROL_PERIOD_MS) {
        CONTROL_PENDING.store(true, Ordering::Relaxed);
    }
}

unsafe extern "C" {
    /// One word above the highest word of the stack.
    static _stack_start: u32;
    /// The lowest word of the stack.
    static _stack_end: u32;
}

const _: () = assert!(
    cortex_m_rt::STACK_PAINT_VALUE == stack::PAINT,
    "start-up code paints the stack in another color"
);

/// Greatest depth of the stack, bytes.
fn stack_peak_bytes() -> u32 {
    let lowest = addr_of!(_stack_end);
    let words = (addr_of!(_stack_start).addr() - lowest.addr()) / size_of::<u32>();
    // SAFETY: all words of the stack's region are RAM. A volatile read of a word in use returns
    // some value, and any value will do.
    let peak = stack::peak_bytes(words, |index| unsafe { lowest.add(index).read_volatile() });
    peak as u32
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    SCB::sys_reset()
}

#[exception]
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    SCB::sys_reset()
}

#[exception]
unsafe fn DefaultHandler(_: i16) -> ! {
    SCB::sys_reset()
}
