//! The program on the RISC-V machine: one loop, no interrupts.

use crate::device::{Timer, Uart16550, reset};
use amp::node::{Identity, NomadNode};
use amp::wire::message::{Oscillator, ResetCause};
use core::panic::PanicInfo;
use firmware::BUILD;
use firmware::control::Control;
use firmware::uart::{ErrorCounters, TxQueue, UartDriver};
use heapless::spsc::Queue;
use riscv_rt::entry;

#[entry]
fn main() -> ! {
    let (mut timer, mut uart) = (Timer::start(), Uart16550::start());
    let mut node = NomadNode::new();
    let mut received: Queue<u8, 512> = Queue::new();
    let mut to_send: Queue<u8, 2048> = Queue::new();
    let errors = ErrorCounters::new();
    let (received_in, received_out) = received.split();
    let (to_send_in, to_send_out) = to_send.split();
    let mut driver = UartDriver::new(received_in, to_send_out);
    let tx = TxQueue::new(to_send_in);
    let mut control: Control<'_> = Control::new(&mut node, received_out, tx, &errors, None);
    let identity = Identity {
        build: BUILD,
        reset: ResetCause::Unknown,
        oscillator: Oscillator::Unknown,
        ring: false,
    };
    control.start(identity, timer.now());
    loop {
        let _ = driver.transfer(&mut uart, &errors);
        if uart.take_moved() {
            continue;
        }
        let more = control.run(timer.now());
        if !more && !control.take_queued() {
            timer.sleep_1_ms();
        }
    }
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    reset()
}
