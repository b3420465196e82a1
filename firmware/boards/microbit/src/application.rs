//! What runs when.

#![allow(unsafe_code)]

use crate::device::{Device, MillisecondTimer, Uart};
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
use firmware::line::{Faults, FrameSink, Line};
use firmware::{BUILD, lamp, stack};
use heapless::spsc::Queue;
use nrf51_pac::{Interrupt, Peripherals, interrupt};

/// How often control runs though nothing has come.
const ROUND_MS: u32 = 10;

/// What the serial interrupt works with.
struct Link {
    line: Line<'static>,
    uart: Uart,
}

static LINK: Mutex<RefCell<Option<Link>>> = Mutex::new(RefCell::new(None));
static TIMER: Mutex<RefCell<Option<MillisecondTimer>>> = Mutex::new(RefCell::new(None));
static FAULTS: Faults = Faults::new();
static NOW_MS: AtomicU32 = AtomicU32::new(0);
/// Whether the control task is to run.
static DUE: AtomicBool = AtomicBool::new(true);

#[entry]
fn main() -> ! {
    static mut MIND: NomadNode = NomadNode::new();
    static mut RECEIVED: Queue<u8, 256> = Queue::new();
    static mut TO_SEND: Queue<u8, 384> = Queue::new();

    let (received_in, received_out) = RECEIVED.split();
    let (to_send_in, to_send_out) = TO_SEND.split();
    let peripherals = Peripherals::take().unwrap();
    let mut device = Device::start(peripherals);
    let mut control: Control<'_> = Control::new(
        MIND,
        received_out,
        FrameSink::new(to_send_in),
        &FAULTS,
        None,
    );
    let link = Link {
        line: Line::new(received_in, to_send_out),
        uart: device.uart,
    };
    critical_section::with(|cs| {
        LINK.replace(cs, Some(link));
        TIMER.replace(cs, Some(device.timer));
    });
    unmask();
    control.start(
        Identity {
            build: BUILD,
            reset: ResetCause::Unknown,
            oscillator: Oscillator::Crystal,
            ring: false,
        },
        Millis::from_ms(0),
    );
    loop {
        // Loads and stores suffice: an interrupt in between sets it again, at the latest with the next round.
        if DUE.load(Ordering::Relaxed) {
            DUE.store(false, Ordering::Relaxed);
            let now = Millis::from_ms(NOW_MS.load(Ordering::Relaxed));
            if control.run(now) {
                DUE.store(true, Ordering::Relaxed);
            }
            if control.take_sent() {
                NVIC::pend(Interrupt::UART0);
            }
            control.note_stack(stack_peak_bytes());
            let lit = lamp::is_lit(now, control.is_linked(), ResetCause::Unknown);
            device.led.set(lit);
        } else {
            cortex_m::asm::wfi();
        }
    }
}

/// Lets the interrupts come; a byte does not wait for the timer.
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
        if let Some(link) = LINK.borrow_ref_mut(cs).as_mut()
            && link.line.serve(&mut link.uart, &FAULTS)
        {
            DUE.store(true, Ordering::Relaxed);
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
    if now_ms.is_multiple_of(ROUND_MS) {
        DUE.store(true, Ordering::Relaxed);
    }
}

unsafe extern "C" {
    /// Behind the highest word of the stack.
    static _stack_start: u32;
    /// The lowest word of the stack.
    static _stack_end: u32;
}

const _: () = assert!(
    cortex_m_rt::STACK_PAINT_VALUE == stack::PAINT,
    "start-up code paints the stack in another color"
);

/// The deepest the stack has been, in bytes.
fn stack_peak_bytes() -> u32 {
    let lowest = addr_of!(_stack_end);
    let words = (addr_of!(_stack_start).addr() - lowest.addr()) / size_of::<u32>();
    // SAFETY: the words from the stack's lowest to its highest are memory; a volatile read of a word in use gives some
    // value, which suffices here.
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
