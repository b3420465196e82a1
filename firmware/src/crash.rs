//! The record of a crash, kept over the reset that follows it, and the cause of a reset.
//!
//! The record is in RAM that start-up code does not initialize. After power-on this RAM holds
//! random data: a record is valid only with its magic number, a plausible length and its checksum.

use amp::wire::message::ResetCause;

/// Capacity of the text, bytes.
const TEXT_BYTES: usize = 64;

/// Marks a record; an arbitrary number.
const MAGIC: u32 = 0x5eed_c4a5;

/// What caused a crash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrashCause {
    /// The program panicked.
    Panic,
    /// The processor faulted.
    HardFault,
    /// The stack left its region.
    StackOverflow,
}

impl CrashCause {
    const fn code(self) -> u32 {
        match self {
            Self::Panic => 1,
            Self::HardFault => 2,
            Self::StackOverflow => 3,
        }
    }

    const fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            1 => Self::Panic,
            2 => Self::HardFault,
            3 => Self::StackOverflow,
            _ => return None,
        })
    }
}

/// A short text, cut off at its capacity. `core::fmt` would cost 3 KiB of flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CrashText {
    bytes: [u8; TEXT_BYTES],
    length: usize,
}

impl Default for CrashText {
    fn default() -> Self {
        Self::new()
    }
}

impl CrashText {
    /// The empty text.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            bytes: [0; TEXT_BYTES],
            length: 0,
        }
    }

    /// Appends a text.
    pub fn push(&mut self, text: &str) {
        let room = self.bytes.get_mut(self.length..).unwrap_or_default();
        for (place, byte) in room.iter_mut().zip(text.bytes()) {
            *place = byte;
            self.length += 1;
        }
    }

    /// Appends a number in decimal digits.
    pub fn push_number(&mut self, number: u32) {
        let mut digits = [b'0'; 10];
        let mut left = number;
        for digit in digits.iter_mut().rev() {
            *digit += (left % 10) as u8;
            left /= 10;
        }
        let text = str::from_utf8(&digits).unwrap_or_default();
        let significant = text.trim_start_matches('0');
        self.push(if significant.is_empty() {
            "0"
        } else {
            significant
        });
    }

    /// Appends a number as `0x` and eight hexadecimal digits.
    pub fn push_hex(&mut self, number: u32) {
        self.push("0x");
        for shift in (0..8).rev() {
            let digit = char::from_digit(number >> (4 * shift) & 0xf, 16).unwrap_or('?');
            self.push(digit.encode_utf8(&mut [0; 4]));
        }
    }

    /// The text, without a character that was cut in half at the end.
    #[must_use]
    pub fn as_str(&self) -> &str {
        let bytes = self.bytes.get(..self.length).unwrap_or_default();
        let whole = bytes.utf8_chunks().next();
        whole.map_or("", |chunk| chunk.valid())
    }
}

/// A crash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Crash {
    /// What caused it.
    pub cause: CrashCause,
    /// Program counter; 0 = unknown.
    pub program_counter: u32,
    /// Description for the log.
    pub text: CrashText,
}

/// A crash as it is kept in RAM. Every bit pattern is a valid value of this type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct CrashRecord {
    magic: u32,
    cause: u32,
    program_counter: u32,
    length: u32,
    text: [u8; TEXT_BYTES],
    checksum: u32,
}

impl CrashRecord {
    /// No crash.
    pub const EMPTY: Self = Self {
        magic: 0,
        cause: 0,
        program_counter: 0,
        length: 0,
        text: [0; TEXT_BYTES],
        checksum: 0,
    };

    /// The record of a crash.
    #[must_use]
    pub fn of(crash: &Crash) -> Self {
        let mut record = Self {
            magic: MAGIC,
            cause: crash.cause.code(),
            program_counter: crash.program_counter,
            length: crash.text.length as u32,
            text: crash.text.bytes,
            checksum: 0,
        };
        record.checksum = record.expected_checksum();
        record
    }

    /// The crash, if the record is valid.
    #[must_use]
    pub fn crash(&self) -> Option<Crash> {
        let length = self.length as usize;
        if self.magic != MAGIC || length > TEXT_BYTES || self.checksum != self.expected_checksum() {
            return None;
        }
        Some(Crash {
            cause: CrashCause::from_code(self.cause)?,
            program_counter: self.program_counter,
            text: CrashText {
                bytes: self.text,
                length,
            },
        })
    }

    /// FNV-1a (G. Fowler, L. C. Noll, K.-P. Vo) over all fields but the checksum.
    fn expected_checksum(&self) -> u32 {
        let words = [self.magic, self.cause, self.program_counter, self.length];
        let head = words.into_iter().flat_map(u32::to_le_bytes);
        head.chain(self.text).fold(0x811c_9dc5, |sum, byte| {
            (sum ^ u32::from(byte)).wrapping_mul(0x0100_0193)
        })
    }
}

/// The processor's fault registers (ARMv7-M Architecture Reference Manual, B3.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaultRegisters {
    /// CFSR: configurable fault status.
    pub status: u32,
    /// MMFAR: address of a memory protection fault; valid with MMARVALID.
    pub protected: u32,
    /// BFAR: address of a bus fault; valid with BFARVALID.
    pub bus: u32,
}

impl FaultRegisters {
    /// MMARVALID in CFSR.
    const PROTECTED_VALID: u32 = 1 << 7;
    /// BFARVALID in CFSR.
    const BUS_VALID: u32 = 1 << 15;

    /// The cause of the fault. It is a stack overflow if the guard below `stack_end` was hit or the
    /// stack pointer is outside the stack. `stack_pointer` is the value after the processor has
    /// pushed its registers.
    #[must_use]
    pub const fn cause(&self, stack_pointer: u32, stack_start: u32, stack_end: u32) -> CrashCause {
        let guard_was_hit = self.status & Self::PROTECTED_VALID != 0 && self.protected < stack_end;
        if guard_was_hit || stack_pointer < stack_end || stack_pointer >= stack_start {
            CrashCause::StackOverflow
        } else {
            CrashCause::HardFault
        }
    }

    /// Appends the fault status, the address of a bus fault if valid, and the link register.
    pub fn describe(&self, link: u32, text: &mut CrashText) {
        text.push("CFSR ");
        text.push_hex(self.status);
        if self.status & Self::BUS_VALID != 0 {
            text.push(" BFAR ");
            text.push_hex(self.bus);
        }
        text.push(" LR ");
        text.push_hex(link);
    }
}

/// The chip's reset flags.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ResetFlags {
    /// Power-on or brown-out.
    pub power: bool,
    /// One of the watchdogs.
    pub watchdog: bool,
    /// The program itself.
    pub software: bool,
    /// The reset pin. The chip sets this flag with every reset, so it is checked last.
    pub pin: bool,
}

/// The cause of a reset, by the chip's flags and the record of a crash.
#[must_use]
pub const fn reset_cause(flags: ResetFlags, crash: Option<&Crash>) -> ResetCause {
    if flags.power {
        return ResetCause::PowerOn;
    }
    match crash {
        Some(crash) => match crash.cause {
            CrashCause::Panic => ResetCause::Panic,
            CrashCause::HardFault => ResetCause::HardFault,
            CrashCause::StackOverflow => ResetCause::StackOverflow,
        },
        None if flags.watchdog => ResetCause::Watchdog,
        None if flags.software => ResetCause::Requested,
        None if flags.pin => ResetCause::Pin,
        None => ResetCause::Unknown,
    }
}

/// A reset cause in words for the log: "build … starts …".
#[must_use]
pub const fn reset_name(reset: ResetCause) -> &'static str {
    match reset {
        ResetCause::Unknown => "for an unknown reason",
        ResetCause::PowerOn => "after power-on",
        ResetCause::Pin => "by the reset pin",
        ResetCause::Requested => "by request",
        ResetCause::Watchdog => "by the watchdog",
        ResetCause::Panic => "after a panic",
        ResetCause::HardFault => "after a fault",
        ResetCause::StackOverflow => "after a stack overflow",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crash(cause: CrashCause) -> Crash {
        let mut text = CrashText::new();
        text.push("ring.rs:");
        text.push_number(12);
        Crash {
            cause,
            program_counter: 0x0800_1234,
            text,
        }
    }

    #[test]
    fn a_crash_survives_its_record() {
        for cause in [
            CrashCause::Panic,
            CrashCause::HardFault,
            CrashCause::StackOverflow,
        ] {
            let crash = crash(cause);
            assert_eq!(CrashRecord::of(&crash).crash(), Some(crash));
        }
        assert_eq!(crash(CrashCause::Panic).text.as_str(), "ring.rs:12");
    }

    #[test]
    fn memory_after_power_on_is_no_crash() {
        assert_eq!(CrashRecord::EMPTY.crash(), None);
        let ones = CrashRecord {
            magic: MAGIC,
            cause: u32::MAX,
            program_counter: u32::MAX,
            length: u32::MAX,
            text: [255; TEXT_BYTES],
            checksum: u32::MAX,
        };
        assert_eq!(ones.crash(), None);
    }

    #[test]
    fn a_record_with_one_changed_bit_is_invalid() {
        let record = CrashRecord::of(&crash(CrashCause::HardFault));
        for bit in 0..32 {
            let flip = 1 << bit;
            for changed in [
                CrashRecord {
                    magic: record.magic ^ flip,
                    ..record
                },
                CrashRecord {
                    cause: record.cause ^ flip,
                    ..record
                },
                CrashRecord {
                    program_counter: record.program_counter ^ flip,
                    ..record
                },
                CrashRecord {
                    length: record.length ^ flip,
                    ..record
                },
                CrashRecord {
                    checksum: record.checksum ^ flip,
                    ..record
                },
            ] {
                assert_eq!(changed.crash(), None);
            }
        }
        for place in 0..TEXT_BYTES {
            let mut changed = record;
            changed.text[place] ^= 4;
            assert_eq!(changed.crash(), None);
        }
    }

    #[test]
    fn a_long_text_is_cut_between_characters() {
        let mut text = CrashText::new();
        for _ in 0..TEXT_BYTES {
            text.push("äöü!");
        }
        assert!((TEXT_BYTES - 1..=TEXT_BYTES).contains(&text.as_str().len()));
    }

    #[test]
    fn numbers_in_decimal_digits() {
        for number in [0, 7, 10, 1_203, u32::MAX] {
            let mut text = CrashText::new();
            text.push_number(number);
            assert_eq!(text.as_str(), std::format!("{number}"));
        }
    }

    #[test]
    fn numbers_in_hexadecimal_digits() {
        for number in [0, 7, 0x0800_1a2f, u32::MAX] {
            let mut text = CrashText::new();
            text.push_hex(number);
            assert_eq!(text.as_str(), std::format!("{number:#010x}"));
        }
    }

    #[test]
    fn a_stack_pointer_outside_the_stack_is_an_overflow() {
        let cause = |pointer| fault(0x0000_8200).cause(pointer, 0x2000_2000, 0x2000_0020);
        assert_eq!(cause(0x1fff_ffe0), CrashCause::StackOverflow);
        assert_eq!(cause(0x2000_001c), CrashCause::StackOverflow);
        assert_eq!(cause(0x2000_0020), CrashCause::HardFault);
        assert_eq!(cause(0x2000_1fe0), CrashCause::HardFault);
        assert_eq!(cause(0x2000_2000), CrashCause::StackOverflow);
    }

    /// A fault with this status; its addresses are in the guard and of no device.
    fn fault(status: u32) -> FaultRegisters {
        FaultRegisters {
            status,
            protected: 0x2000_0010,
            bus: 0xdead_beec,
        }
    }

    #[test]
    fn a_fault_in_the_guard_is_an_overflow_if_its_address_is_valid() {
        let cause = |fault: FaultRegisters| fault.cause(0x2000_1000, 0x2000_2000, 0x2000_0020);
        // DACCVIOL with and without MMARVALID; MSTKERR with it.
        assert_eq!(cause(fault(0x82)), CrashCause::StackOverflow);
        assert_eq!(cause(fault(0x90)), CrashCause::StackOverflow);
        assert_eq!(cause(fault(0x02)), CrashCause::HardFault);
        let above = FaultRegisters {
            protected: 0x2000_0020,
            ..fault(0x82)
        };
        assert_eq!(cause(above), CrashCause::HardFault);
    }

    #[test]
    fn a_fault_is_described_with_the_address_only_where_it_is_one() {
        let described = |status| {
            let mut text = CrashText::new();
            fault(status).describe(0x0800_4321, &mut text);
            std::string::String::from(text.as_str())
        };
        // PRECISERR with BFARVALID, IMPRECISERR without, UNDEFINSTR.
        assert_eq!(
            described(0x8200),
            "CFSR 0x00008200 BFAR 0xdeadbeec LR 0x08004321"
        );
        assert_eq!(described(0x0400), "CFSR 0x00000400 LR 0x08004321");
        assert_eq!(described(0x0001_0000), "CFSR 0x00010000 LR 0x08004321");
    }

    #[test]
    fn reset_causes_by_flags_and_crash() {
        let crash = crash(CrashCause::Panic);
        let pin = ResetFlags {
            pin: true,
            ..ResetFlags::default()
        };
        let software = ResetFlags {
            software: true,
            ..pin
        };
        let watchdog = ResetFlags {
            watchdog: true,
            ..pin
        };
        let power = ResetFlags { power: true, ..pin };
        assert_eq!(reset_cause(power, Some(&crash)), ResetCause::PowerOn);
        assert_eq!(reset_cause(software, Some(&crash)), ResetCause::Panic);
        assert_eq!(reset_cause(software, None), ResetCause::Requested);
        assert_eq!(reset_cause(watchdog, None), ResetCause::Watchdog);
        assert_eq!(reset_cause(pin, None), ResetCause::Pin);
        assert_eq!(
            reset_cause(ResetFlags::default(), None),
            ResetCause::Unknown
        );
    }
}
