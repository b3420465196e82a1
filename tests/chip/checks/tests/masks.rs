//! Functions of the board's image that may mask an interrupt, found by their instructions.
//!
//! | instruction | effect |
//! | --- | --- |
//! | `cpsid i`, `cpsid f` | masks every interrupt |
//! | `msr primask`, `basepri`, `basepri_max`, `faultmask` | masks some, or restores a former mask |

use checks::board_image;
use object::{Object as _, ObjectSection as _, ObjectSymbol as _, SymbolKind};
use std::collections::BTreeSet;

/// Which interrupts an instruction masks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum MaskKind {
    /// Interrupts up to some priority.
    Some,
    /// Every interrupt.
    All,
}

/// Part of a function's name, the most it may mask, and why this does not delay a running receiver.
const KNOWN: [(&str, MaskKind, &str); 9] = [
    ("main", MaskKind::All, "start-up: tasks do not run yet"),
    (
        "rust_begin_unwind",
        MaskKind::All,
        "a panic: the program ends",
    ),
    (
        "_defmt_acquire",
        MaskKind::All,
        "start of a log line: counted in counts.rs",
    ),
    ("_defmt_release", MaskKind::All, "end of a log line"),
    // The last thing an RTIC task does is to restore the former priority.
    ("FSMC", MaskKind::Some, "end of the control task"),
    ("PVD", MaskKind::Some, "end of the supply task"),
    ("SysTick", MaskKind::Some, "end of the clock task"),
    ("TIM3", MaskKind::Some, "end of the ring task"),
    ("USART1", MaskKind::Some, "end of the serial task itself"),
];

/// What a Thumb instruction masks: CPSID i, f or both, and MSR with the special registers 16 to 19
/// (ARMv7-M Architecture Reference Manual, B5.2.3).
fn mask(first: u16, second: u16) -> Option<MaskKind> {
    if matches!(first, 0xb671..=0xb673) {
        return Some(MaskKind::All);
    }
    if first & 0xfff0 != 0xf380 || second & 0xff00 != 0x8800 {
        return None;
    }
    match second & 0xff {
        // PRIMASK, FAULTMASK.
        16 | 19 => Some(MaskKind::All),
        // BASEPRI, BASEPRI_MAX.
        17 | 18 => Some(MaskKind::Some),
        _ => None,
    }
}

/// Offsets of masking instructions in the code. Data between functions may look like one.
fn sites(code: &[u8]) -> Vec<(u64, MaskKind)> {
    let (halves, _) = code.as_chunks::<2>();
    let halves: Vec<u16> = halves.iter().copied().map(u16::from_le_bytes).collect();
    let mut sites = Vec::new();
    for (index, &half) in halves.iter().enumerate() {
        let next = halves.get(index + 1).copied().unwrap_or(0);
        sites.extend(mask(half, next).map(|mask| (2 * index as u64, mask)));
    }
    sites
}

#[test]
fn only_the_log_masks_the_receive_interrupt() {
    let elf = std::fs::read(board_image()).expect("the image");
    let file = object::File::parse(&*elf).expect("an ELF file");
    let section = file.section_by_name(".text").expect("code");
    let mut functions: Vec<_> = file
        .symbols()
        .filter(|symbol| symbol.kind() == SymbolKind::Text)
        // The lowest bit marks Thumb code.
        .map(|symbol| (symbol.address() & !1, symbol.name().unwrap_or("")))
        .collect();
    functions.sort_unstable();
    let mut found = BTreeSet::new();
    for (site, mask) in sites(section.data().expect("its bytes")) {
        let address = section.address() + site;
        let owners = functions
            .iter()
            .rev()
            .filter(|(start, _)| *start <= address);
        let owner = owners
            .map(|(_, name)| *name)
            .next()
            .unwrap_or("no function");
        let mut known = KNOWN.iter();
        let (part, ..) = known
            .find(|(part, most, _)| owner.contains(part) && mask <= *most)
            .unwrap_or_else(|| panic!("{owner} at {address:#x} may mask interrupts: {mask:?}"));
        found.insert(*part);
    }
    println!("{found:?}");
    // These certainly mask interrupts, so the search must find them.
    for part in ["_defmt_acquire", "_defmt_release", "rust_begin_unwind"] {
        assert!(found.contains(part), "{part} is not among {found:?}");
    }
}

#[test]
fn instructions_are_known_by_their_codes() {
    // cpsid i; nop; msr basepri, r0; msr primask, r1; cpsie i; mrs r0, primask; msr control, r0
    let code = [
        0xb672, 0xbf00, 0xf380, 0x8811, 0xf381, 0x8810, 0xb662, 0xf3ef, 0x8010, 0xf380, 0x8814_u16,
    ];
    let bytes: Vec<u8> = code.iter().copied().flat_map(u16::to_le_bytes).collect();
    assert_eq!(
        sites(&bytes),
        [(0, MaskKind::All), (4, MaskKind::Some), (8, MaskKind::All)]
    );
}
