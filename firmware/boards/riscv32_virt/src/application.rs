//! The program on the RISC-V machine: one loop, no interrupts.

use crate::device::{Timer, Uart16550, reset};
use amp::node::Identity;
use amp::wire::message::{Oscillator, ResetCause};
use core::panic::PanicInfo;
use firmware::BUILD;
use firmware::control::{Control, RobotNode};
use firmware::uart::{ErrorCounters, TxQueue, UartDriver};
use heapless::spsc::Queue;
use riscv_rt::entry;

/// After its last byte it stays awake for so long: the port does not wake it.
const AWAKE_MS: u32 = 100;

/// What the program is for.
#[cfg(feature = "places")]
type RobotBody = firmware::AnyBodyWithPlaces;
#[cfg(all(feature = "any-body", not(feature = "places")))]
type RobotBody = firmware::AnyBody;
#[cfg(not(feature = "any-body"))]
type RobotBody = amp::body::HeldRing;

#[entry]
fn main() -> ! {
    let (mut timer, mut uart) = (Timer::start(), Uart16550::start());
    let mut node = RobotNode::new();
    let mut received: Queue<u8, 512> = Queue::new();
    let mut to_send: Queue<u8, 2048> = Queue::new();
    let errors = ErrorCounters::new();
    let (received_in, received_out) = received.split();
    let (to_send_in, to_send_out) = to_send.split();
    let mut driver = UartDriver::new(received_in, to_send_out);
    let tx = TxQueue::new(to_send_in);
    let mut control: Control<'_, RobotBody> =
        Control::new(&mut node, received_out, tx, &errors, None);
    let identity = Identity {
        build: BUILD,
        reset: ResetCause::Unknown,
        oscillator: Oscillator::Unknown,
        ring: false,
    };
    control.start(identity, timer.now());
    let mut moved_at = timer.now();
    loop {
        let _ = driver.transfer(&mut uart, &errors);
        if uart.take_moved() {
            moved_at = timer.now();
            continue;
        }
        let more = control.run(timer.now());
        let is_idle = timer.now().after(moved_at) >= AWAKE_MS;
        if !more && !control.take_queued() && is_idle {
            timer.sleep_1_ms();
        }
    }
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    reset()
}
