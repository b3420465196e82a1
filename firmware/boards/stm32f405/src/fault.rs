//! Crash handlers: panic, fault, stack overflow and a stopped crystal leave a record and reset.
//!
//! No motor is stopped here, because none is driven from here: the base stops when the time to
//! live of its last motion ends.

#![allow(unsafe_code)]

use core::arch::naked_asm;
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use core::ptr::{addr_of, addr_of_mut};
use cortex_m::peripheral::{MPU, SCB};
use cortex_m_rt::exception;
use firmware::clock::{CrystalTrial, TrialRecord};
use firmware::crash::{Crash, CrashCause, CrashRecord, CrashText, FaultRegisters};
use firmware::stack;

/// Not initialized by start-up code.
#[unsafe(link_section = ".uninit.crash")]
static mut RECORD: MaybeUninit<CrashRecord> = MaybeUninit::uninit();

/// What earlier runs say about the crystal. Not initialized by start-up code.
#[unsafe(link_section = ".uninit.crystal")]
static mut CRYSTAL: MaybeUninit<TrialRecord> = MaybeUninit::uninit();

unsafe extern "C" {
    /// One word above the highest word of the stack.
    static _stack_start: u32;
    /// The lowest word of the stack.
    static _stack_end: u32;
}

/// Size of the guard at the low end of the stack's region, bytes.
const GUARD_BYTES: u32 = 32;

/// Makes the low end of the stack's region read-only, so that a stack overflow faults at once
/// (ARMv7-M Architecture Reference Manual, B3.5).
pub fn guard_stack(mpu: &mut MPU) {
    /// The address is that of region 0, which is selected with it.
    const REGION_0: u32 = 1 << 4;
    /// Read-only, not executable, 2^(4 + 1) bytes, enabled.
    const READ_ONLY_32_BYTES: u32 = 1 << 28 | 0b101 << 24 | 4 << 1 | 1;
    /// Enabled; all other memory keeps the default map.
    const ON_WITH_DEFAULT_MAP: u32 = 1 << 2 | 1;
    let lowest = addr_of!(_stack_end).addr() as u32;
    // SAFETY: only a stack overflow writes there.
    unsafe {
        mpu.rbar.write(lowest | REGION_0);
        mpu.rasr.write(READ_ONLY_32_BYTES);
        mpu.ctrl.write(ON_WITH_DEFAULT_MAP);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

const _: () = assert!(
    cortex_m_rt::STACK_PAINT_VALUE == stack::PAINT,
    "start-up code paints the stack in another color"
);

/// Takes the record of the crash that ended the last run.
pub fn take_crash() -> Option<Crash> {
    let record = addr_of_mut!(RECORD).cast::<CrashRecord>();
    // SAFETY: the memory is valid, aligned, and every bit pattern is a record. Only this function
    // (called once, with interrupts off) and the crash handlers (which never return) access it.
    let crash = unsafe { record.read_volatile() }.crash();
    // SAFETY: as above.
    unsafe { record.write_volatile(CrashRecord::EMPTY) };
    crash
}

/// What earlier runs say about the crystal.
pub fn read_trial() -> TrialRecord {
    // SAFETY: the memory is valid, aligned, and every bit pattern is a record; see `write_trial`.
    unsafe { addr_of!(CRYSTAL).cast::<TrialRecord>().read_volatile() }
}

/// Replaces what is recorded about the crystal.
pub fn write_trial(record: TrialRecord) {
    // SAFETY: the memory is valid and aligned. Start-up runs before the one task that calls this,
    // and the crash handlers never return.
    unsafe {
        addr_of_mut!(CRYSTAL)
            .cast::<TrialRecord>()
            .write_volatile(record)
    }
}

/// Greatest depth of the stack, bytes.
pub fn stack_peak_bytes() -> u32 {
    let lowest = addr_of!(_stack_end);
    let words = (addr_of!(_stack_start).addr() - lowest.addr()) / size_of::<u32>();
    // SAFETY: all words of the stack's region are RAM. A volatile read of a word in use returns
    // some value, and any value will do.
    let peak = stack::peak_bytes(words, |index| unsafe { lowest.add(index).read_volatile() });
    peak as u32
}

fn save_and_reset(crash: &Crash) -> ! {
    #[cfg(feature = "hil")]
    fail_test(crash);
    write_trial(TrialRecord::of(read_trial().trial().on_crash()));
    // SAFETY: see `take_crash`; nothing else runs any more.
    unsafe {
        addr_of_mut!(RECORD)
            .cast::<CrashRecord>()
            .write_volatile(CrashRecord::of(crash));
    }
    SCB::sys_reset()
}

/// Reports the crash to the debugger and ends the test as failed.
#[cfg(feature = "hil")]
fn fail_test(crash: &Crash) {
    use cortex_m_semihosting::{debug, heprintln};
    heprintln!("{} {:#x}", crash.text.as_str(), crash.program_counter);
    debug::exit(debug::EXIT_FAILURE);
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    let mut text = CrashText::new();
    if let Some(place) = info.location() {
        let path = place.file();
        let name = path.rfind('/').and_then(|slash| path.get(slash + 1..));
        text.push(name.unwrap_or(path));
        text.push(":");
        text.push_number(place.line());
    }
    if let Some(message) = info.message().as_str() {
        text.push(" ");
        text.push(message);
    }
    save_and_reset(&Crash {
        cause: CrashCause::Panic,
        program_counter: 0,
        text,
    })
}

/// Resets the stack pointer first, since the stack may be what failed, and passes on the old one.
// SAFETY: the vector table refers to this name; the body never returns.
#[unsafe(no_mangle)]
#[unsafe(naked)]
extern "C" fn HardFault() -> ! {
    naked_asm!(
        "mrs r0, msp",
        "ldr r1, ={stack_start}",
        "msr msp, r1",
        "b {fault}",
        stack_start = sym _stack_start,
        fault = sym fault,
    )
}

extern "C" fn fault(stack_pointer: *const u32) -> ! {
    let start = addr_of!(_stack_start).addr() as u32;
    let end = addr_of!(_stack_end).addr() as u32 + GUARD_BYTES;
    // SAFETY: reading these registers has no side effects.
    let scb = unsafe { &*SCB::PTR };
    let fault = FaultRegisters {
        status: scb.cfsr.read(),
        protected: scb.mmfar.read(),
        bus: scb.bfar.read(),
    };
    let cause = fault.cause(stack_pointer.addr() as u32, start, end);
    let (mut program_counter, mut text) = (0, CrashText::new());
    if cause == CrashCause::HardFault {
        // SAFETY: the processor has pushed eight words to a stack in RAM; word 5 is the link
        // register, word 6 the program counter. The handler's own stack overlaps them only if the
        // fault came within a few words of the stack's start.
        let (link, counter) = unsafe {
            (
                stack_pointer.add(5).read_volatile(),
                stack_pointer.add(6).read_volatile(),
            )
        };
        program_counter = counter;
        fault.describe(link, &mut text);
    } else {
        text.push("the stack left its region");
    }
    save_and_reset(&Crash {
        cause,
        program_counter,
        text,
    })
}

/// The crystal has stopped, and the chip has switched to the slow internal oscillator. The restart
/// uses the internal oscillator at the full clock and does not try the crystal again.
#[exception]
unsafe fn NonMaskableInt() -> ! {
    write_trial(TrialRecord::of(CrystalTrial::Failed));
    let mut text = CrashText::new();
    text.push("the crystal has stopped");
    save_and_reset(&Crash {
        cause: CrashCause::Panic,
        program_counter: 0,
        text,
    })
}

/// An interrupt without a handler.
#[exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    let mut text = CrashText::new();
    // Exceptions of the core are -15 to -1; interrupts of the chip start at 0.
    text.push(if number < 0 {
        "no task for interrupt -"
    } else {
        "no task for interrupt "
    });
    text.push_number(number.unsigned_abs().into());
    save_and_reset(&Crash {
        cause: CrashCause::Panic,
        program_counter: 0,
        text,
    })
}
