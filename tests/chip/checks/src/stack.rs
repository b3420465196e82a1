//! Worst-case stack depth, computed from an image's code: frames and calls of each function.
//!
//! A frame is the sum of a function's instructions that lower the stack pointer, on any branch
//! (ARMv7-M Architecture Reference Manual, A7.7). Jumps to other functions count as calls.
//! Recursion is reported: it has no bound.

use object::{Object as _, ObjectSection as _, ObjectSymbol as _, SectionKind, SymbolKind};
use std::collections::{BTreeMap, BTreeSet};

/// Depth to which nested indirect calls are followed: as deep as formatting of text goes. An
/// indirect call may reach any function whose address is in the image's data.
const INDIRECT: usize = 2;

/// A function's use of the stack, and its calls.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Function {
    /// Name in the image.
    pub name: String,
    /// Bytes it pushes itself.
    pub frame: u32,
    /// Addresses outside itself that it calls or jumps to.
    pub calls: BTreeSet<u64>,
    /// It calls an address in a register.
    pub is_indirect: bool,
    /// It lowers the stack pointer by a register's value.
    pub is_dynamic: bool,
}

/// An image's functions, by address.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Calls {
    functions: BTreeMap<u64, Function>,
    /// Functions whose addresses are in data.
    taken: BTreeSet<u64>,
}

/// The deepest chain of calls from a function.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Deepest {
    /// Depth, bytes.
    pub bytes: u32,
    /// Addresses of the functions.
    pub chain: Vec<u64>,
}

impl Calls {
    /// Reads an image.
    ///
    /// # Errors
    /// The file is not valid ELF.
    pub fn of(elf: &[u8]) -> Result<Self, object::Error> {
        let file = object::File::parse(elf)?;
        let data = marks(&file);
        let mut calls = Self::default();
        for symbol in file.symbols() {
            if symbol.kind() != SymbolKind::Text || symbol.size() == 0 {
                continue;
            }
            // The lowest bit marks Thumb code.
            let address = symbol.address() & !1;
            let Some(section) = symbol.section_index() else {
                continue;
            };
            let code = file.section_by_index(section)?;
            let Some(bytes) = code.data_range(address, symbol.size())? else {
                continue;
            };
            let name = symbol.name().unwrap_or("").to_owned();
            let function = calls.functions.entry(address).or_default();
            *function = read(address, bytes, &data);
            function.name = name;
        }
        calls.find_taken(&file, &data)?;
        Ok(calls)
    }

    /// Finds addresses of functions in constants, statics and literal pools, but not in the
    /// vector table.
    fn find_taken(
        &mut self,
        file: &object::File<'_>,
        data: &BTreeMap<u64, bool>,
    ) -> Result<(), object::Error> {
        for section in file.sections() {
            let is_code = section.kind() == SectionKind::Text;
            let has_words = is_code
                || matches!(
                    section.kind(),
                    SectionKind::ReadOnlyData | SectionKind::Data
                );
            if !has_words || section.name() == Ok(".vector_table") {
                continue;
            }
            let (words, _) = section.data()?.as_chunks::<4>();
            for (index, word) in (0..).zip(words) {
                let address = section.address() + 4 * index;
                let target = u64::from(u32::from_le_bytes(*word));
                let is_function = target % 2 == 1 && self.functions.contains_key(&(target & !1));
                if is_function && (!is_code || is_data(data, address)) {
                    self.taken.insert(target & !1);
                }
            }
        }
        Ok(())
    }

    /// Removes functions whose names contain `part`.
    pub fn leave_out(&mut self, part: &str) {
        self.functions
            .retain(|_, function| !function.name.contains(part));
    }

    /// Address of the function with exactly this name.
    #[must_use]
    pub fn address(&self, name: &str) -> Option<u64> {
        let mut all = self.functions.iter();
        all.find(|(_, function)| function.name == name)
            .map(|(address, _)| *address)
    }

    /// The function at an address.
    #[must_use]
    pub fn function(&self, address: u64) -> Option<&Function> {
        self.functions.get(&address)
    }

    /// The deepest chain of calls from the function at `address`.
    ///
    /// # Errors
    /// There is no bound: names of the functions of a recursion, or of a function with a frame of
    /// variable size.
    pub fn deepest(&self, address: u64) -> Result<Deepest, Vec<String>> {
        let mut walk = CallWalk {
            calls: self,
            known: BTreeMap::new(),
            path: Vec::new(),
        };
        walk.from(address, INDIRECT)
    }
}

/// A depth-first search along the calls.
struct CallWalk<'a> {
    calls: &'a Calls,
    known: BTreeMap<(u64, usize), Deepest>,
    path: Vec<(u64, usize)>,
}

impl CallWalk<'_> {
    fn from(&mut self, address: u64, indirect: usize) -> Result<Deepest, Vec<String>> {
        let step = (address, indirect);
        if let Some(known) = self.known.get(&step) {
            return Ok(known.clone());
        }
        let Some(function) = self.calls.functions.get(&address) else {
            return Ok(Deepest::default());
        };
        let place = self.path.iter().position(|one| *one == step);
        if place.is_some() || function.is_dynamic {
            let round = self.path.get(place.unwrap_or(self.path.len())..);
            let names = round.unwrap_or(&[]).iter().chain([&step]);
            let name = |(address, _): &(u64, usize)| self.calls.functions.get(address);
            return Err(names.filter_map(name).map(|one| one.name.clone()).collect());
        }
        self.path.push(step);
        let direct = function.calls.iter().map(|callee| (*callee, indirect));
        let follow = function.is_indirect && indirect > 0;
        let taken = self.calls.taken.iter().filter(|_| follow);
        let all: Vec<_> = direct
            .chain(taken.map(|callee| (*callee, indirect.saturating_sub(1))))
            .collect();
        let mut below = Deepest::default();
        for (callee, indirect) in all {
            let deepest = self.from(callee, indirect)?;
            if deepest.bytes > below.bytes {
                below = deepest;
            }
        }
        self.path.pop();
        below.bytes += function.frame;
        below.chain.insert(0, address);
        self.known.insert(step, below.clone());
        Ok(below)
    }
}

/// Starts of data (true) and code (false), by the image's mapping symbols.
fn marks(file: &object::File<'_>) -> BTreeMap<u64, bool> {
    let mark = |name: &str| match name.split('.').next() {
        Some("$d") => Some(true),
        Some("$t") => Some(false),
        _ => None,
    };
    file.symbols()
        .filter_map(|symbol| Some((symbol.address(), mark(symbol.name().ok()?)?)))
        .collect()
}

fn is_data(marks: &BTreeMap<u64, bool>, address: u64) -> bool {
    let before = marks.range(..=address).next_back();
    before.is_some_and(|(_, is_data)| *is_data)
}

/// Decodes a function's instructions.
fn read(start: u64, bytes: &[u8], marks: &BTreeMap<u64, bool>) -> Function {
    let mut function = Function::default();
    let (halves, _) = bytes.as_chunks::<2>();
    let half = |index: usize| halves.get(index).copied().map(u16::from_le_bytes);
    let end = start + bytes.len() as u64;
    let mut index = 0;
    while let Some(first) = half(index) {
        let address = start + 2 * index as u64;
        if is_data(marks, address) {
            index += 1;
            continue;
        }
        let (instruction, length) = if first >= 0xe800 {
            (wide(first, half(index + 1).unwrap_or(0)), 2)
        } else {
            (narrow(first), 1)
        };
        match instruction {
            Instruction::Lowers(bytes) => function.frame += bytes,
            Instruction::Dynamic => function.is_dynamic = true,
            Instruction::Indirect => function.is_indirect = true,
            Instruction::Branch(offset) => {
                // Relative to the second instruction after this one.
                let target = address.wrapping_add_signed(4 + offset);
                if !(start..end).contains(&target) || (target == start && length == 2) {
                    function.calls.insert(target);
                }
            }
            Instruction::Other => {}
        }
        index += length;
    }
    function
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Instruction {
    /// Lowers the stack pointer by this many bytes.
    Lowers(u32),
    /// Lowers the stack pointer by a register's value.
    Dynamic,
    /// Calls or jumps to this offset from the instruction, bytes.
    Branch(i64),
    /// Calls or jumps to an address in a register.
    Indirect,
    Other,
}

fn narrow(first: u16) -> Instruction {
    match first {
        // PUSH, with or without the link register.
        0xb400..=0xb5ff => Instruction::Lowers(4 * (first & 0x1ff).count_ones()),
        // SUB SP, #imm7.
        0xb080..=0xb0ff => Instruction::Lowers(4 * u32::from(first & 0x7f)),
        // BX LR returns.
        0x4770 => Instruction::Other,
        0x4700..=0x47ff => Instruction::Indirect,
        // B, with a condition (not UDF, SVC) or without.
        0xd000..=0xddff => Instruction::Branch(i64::from(first as i8) * 2),
        0xe000..=0xe7ff => Instruction::Branch(signed(u32::from(first & 0x7ff), 11) * 2),
        // ADD SP, Rm: a Cortex-M0 allocates a large frame this way.
        _ if first & 0xff87 == 0x4485 => Instruction::Dynamic,
        _ => Instruction::Other,
    }
}

fn wide(first: u16, second: u16) -> Instruction {
    let small = u32::from(second & 0xff);
    match (first, second & 0xf00) {
        // STMDB SP!.
        (0xe92d, _) => Instruction::Lowers(4 * second.count_ones()),
        // VPUSH of single or double registers: the operand is the number of words.
        (0xed2d | 0xed6d, 0xa00 | 0xb00) => Instruction::Lowers(4 * small),
        // STR and STRD with SP lowered first.
        (0xf84d, 0xd00) => Instruction::Lowers(small),
        (0xe96d, _) => Instruction::Lowers(4 * small),
        // SUB SP, SP, with a modified or a plain constant, or a register.
        (0xf1ad | 0xf5ad, _) if second & 0x8f00 == 0x0d00 => {
            Instruction::Lowers(modified(constant(first, second)))
        }
        (0xf2ad | 0xf6ad, _) if second & 0x8f00 == 0x0d00 => {
            Instruction::Lowers(constant(first, second))
        }
        (0xebad, _) if second & 0x0f00 == 0x0d00 => Instruction::Dynamic,
        _ if first & 0xf800 == 0xf000 => branch(first, second),
        _ => Instruction::Other,
    }
}

/// The 12 bits of a constant.
fn constant(first: u16, second: u16) -> u32 {
    let (i, imm3) = (u32::from(first >> 10 & 1), u32::from(second >> 12 & 7));
    i << 11 | imm3 << 8 | u32::from(second & 0xff)
}

/// ThumbExpandImm.
fn modified(constant: u32) -> u32 {
    let byte = constant & 0xff;
    match constant >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte * 0x0101_0101,
        _ => (0x80 | constant & 0x7f).rotate_right(constant >> 7),
    }
}

/// BL; B.W with and without a condition.
fn branch(first: u16, second: u16) -> Instruction {
    let s = u32::from(first >> 10 & 1);
    let (j1, j2) = (u32::from(second >> 13 & 1), u32::from(second >> 11 & 1));
    let low = u32::from(second & 0x7ff);
    match second & 0xd000 {
        0xd000 | 0x9000 => {
            let (i1, i2) = (!(j1 ^ s) & 1, !(j2 ^ s) & 1);
            let high = u32::from(first & 0x3ff);
            let offset = s << 23 | i1 << 22 | i2 << 21 | high << 11 | low;
            Instruction::Branch(signed(offset, 24) * 2)
        }
        // Conditions 14 and 15 are other instructions.
        0x8000 if first >> 7 & 7 != 7 => {
            let high = u32::from(first & 0x3f);
            let offset = s << 19 | j2 << 18 | j1 << 17 | high << 11 | low;
            Instruction::Branch(signed(offset, 20) * 2)
        }
        _ => Instruction::Other,
    }
}

/// Sign-extends the lowest `bits` bits.
fn signed(number: u32, bits: u32) -> i64 {
    i64::from((number << (32 - bits)) as i32 >> (32 - bits))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Codes as an assembler generates them.
    #[test]
    fn instructions_are_known_by_their_codes() {
        use Instruction::{Branch, Dynamic, Indirect, Lowers, Other};
        for (code, instruction) in [
            // push {r4, r5, r7, lr}; sub sp, #16; bx lr; blx r3; bx r3; b .-4; bne .+8; add sp, #16
            (0xb5b0, Lowers(16)),
            (0xb084, Lowers(16)),
            (0x4770, Other),
            (0x4798, Indirect),
            (0x4718, Indirect),
            (0xe7fc, Branch(-8)),
            (0xd102, Branch(4)),
            (0xb004, Other),
            // add sp, r4
            (0x44a5, Dynamic),
        ] {
            assert_eq!(narrow(code), instruction, "{code:#x}");
        }
        for (first, second, instruction) in [
            // push.w {r8, r9, r10, r11}; str r11, [sp, #-4]!; vpush {d8}; vpush {d8, d9}
            (0xe92d, 0x0f00, Lowers(16)),
            (0xf84d, 0xbd04, Lowers(4)),
            (0xed2d, 0x8b02, Lowers(8)),
            (0xed2d, 0x8b04, Lowers(16)),
            // sub.w sp, sp, #676; subw sp, sp, #1212; sub.w sp, sp, #1024; sub.w sp, sp, r0
            (0xf5ad, 0x7d29, Lowers(676)),
            (0xf2ad, 0x4dbc, Lowers(1_212)),
            (0xf5ad, 0x6d80, Lowers(1_024)),
            (0xebad, 0x0d00, Dynamic),
            // bl .; b.w .+4; beq.w .+4; msr primask, r0; str r0, [sp, #4]
            (0xf7ff, 0xfffe, Branch(-4)),
            (0xf000, 0xb800, Branch(0)),
            (0xf000, 0x8000, Branch(0)),
            (0xf380, 0x8810, Other),
            (0xf8cd, 0x0004, Other),
        ] {
            assert_eq!(wide(first, second), instruction, "{first:#x} {second:#x}");
        }
    }

    fn calls(functions: &[(u64, u32, &[u64])]) -> Calls {
        let functions = functions.iter().map(|(address, frame, calls)| {
            let function = Function {
                name: format!("f{address}"),
                frame: *frame,
                calls: calls.iter().copied().collect(),
                ..Function::default()
            };
            (*address, function)
        });
        Calls {
            functions: functions.collect(),
            taken: BTreeSet::new(),
        }
    }

    #[test]
    fn the_deepest_chain_is_found_and_recursion_named() {
        let graph = calls(&[(2, 8, &[4, 6]), (4, 100, &[]), (6, 40, &[8]), (8, 64, &[])]);
        let deepest = graph.deepest(2).expect("a bound");
        assert_eq!((deepest.bytes, &deepest.chain[..]), (112, &[2, 6, 8][..]));
        let round = calls(&[(2, 8, &[4]), (4, 8, &[6]), (6, 8, &[4])]);
        let names = round.deepest(2).expect_err("no bound");
        assert_eq!(names, ["f4", "f6", "f4"]);
    }

    #[test]
    fn an_indirect_call_may_be_one_to_whatever_has_its_address_taken() {
        let mut graph = calls(&[(2, 8, &[]), (4, 100, &[]), (6, 1_000, &[])]);
        graph.taken = BTreeSet::from([4]);
        for address in [2, 4] {
            let function = graph.functions.get_mut(&address).expect("it is there");
            function.is_indirect = true;
        }
        // Each indirect call is followed to a depth of two.
        let deepest = graph.deepest(2).expect("a bound");
        assert_eq!(deepest.chain, [2, 4, 4]);
        assert_eq!(deepest.bytes, 208);
    }
}
