//! Who in the firmware's image for the board may hold off an interrupt, by the instructions that do.
//!
//! | instruction | what it does |
//! | --- | --- |
//! | `cpsid i`, `cpsid f` | holds off every interrupt |
//! | `msr primask`, `basepri`, `basepri_max`, `faultmask` | holds off some, or puts back what was before |

use checks::board_image;
use object::{Object as _, ObjectSection as _, ObjectSymbol as _, SymbolKind};
use std::collections::BTreeSet;

/// What an instruction holds off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum MaskKind {
    /// Interrupts up to some priority.
    Some,
    /// Every interrupt.
    All,
}

/// Part of a function's name in the image, what it may hold off at most, and why it is no matter for a receiver at work.
const KNOWN: [(&str, MaskKind, &str); 9] = [
    ("main", MaskKind::All, "start-up: tasks do not run yet"),
    (
        "rust_begin_unwind",
        MaskKind::All,
        "a panic: the program is over",
    ),
    (
        "_defmt_acquire",
        MaskKind::All,
        "a line of the log: counted in counts.rs",
    ),
    ("_defmt_release", MaskKind::All, "its end"),
    // RTIC puts back the priority a task was entered with, as the last thing the task does.
    ("FSMC", MaskKind::Some, "the control task's end"),
    (
        "PVD",
        MaskKind::Some,
        "the end of the task that a low supply wakes",
    ),
    ("SysTick", MaskKind::Some, "the clock's end"),
    ("TIM3", MaskKind::Some, "the ring's end"),
    ("USART1", MaskKind::Some, "the receiver's own end"),
];

/// What a Thumb instruction holds off: CPSID i, f or both, and MSR with the special registers 16 to 19 (ARMv7-M Architecture
/// Reference Manual, B5.2.3).
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

/// The offsets in the code at which interrupts may be held off; data between functions may look like it.
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
fn nothing_but_the_log_holds_off_the_receiver() {
    let elf = std::fs::read(board_image()).expect("the image");
    let file = object::File::parse(&*elf).expect("an ELF file");
    let section = file.section_by_name(".text").expect("code");
    let mut functions: Vec<_> = file
        .symbols()
        .filter(|symbol| symbol.kind() == SymbolKind::Text)
        // The lowest bit says Thumb.
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
        let owner = owners.map(|(_, name)| *name).next().unwrap_or("nobody");
        let mut known = KNOWN.iter();
        let (part, ..) = known
            .find(|(part, most, _)| owner.contains(part) && mask <= *most)
            .unwrap_or_else(|| panic!("{owner} at {address:#x} may hold off interrupts: {mask:?}"));
        found.insert(*part);
    }
    println!("{found:?}");
    // The search finds what is surely there.
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
