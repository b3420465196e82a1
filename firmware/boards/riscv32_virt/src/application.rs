//! What runs when.

use crate::device::{Timer, Uart, reset};
use amp::node::{Identity, NomadNode};
use amp::wire::message::{Oscillator, ResetCause};
use core::panic::PanicInfo;
use firmware::BUILD;
use firmware::control::Control;
use firmware::line::{Faults, FrameSink, Line};
use heapless::spsc::Queue;
use riscv_rt::entry;

#[entry]
fn main() -> ! {
    let (mut timer, mut uart) = (Timer::start(), Uart::start());
    let mut mind = NomadNode::new();
    let mut received: Queue<u8, 512> = Queue::new();
    let mut to_send: Queue<u8, 2048> = Queue::new();
    let faults = Faults::new();
    let (received_in, received_out) = received.split();
    let (to_send_in, to_send_out) = to_send.split();
    let mut line = Line::new(received_in, to_send_out);
    let outbox = FrameSink::new(to_send_in);
    let mut control: Control<'_> = Control::new(&mut mind, received_out, outbox, &faults, None);
    let identity = Identity {
        build: BUILD,
        reset: ResetCause::Unknown,
        oscillator: Oscillator::Unknown,
        ring: false,
    };
    control.start(identity, timer.now());
    loop {
        let _ = line.serve(&mut uart, &faults);
        if uart.take_moved() {
            continue;
        }
        let more = control.run(timer.now());
        if !more && !control.take_sent() {
            timer.sleep_1_ms();
        }
    }
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    reset()
}
