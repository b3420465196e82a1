//! Who in the firmware's image for the board may hold off an interrupt, by the instructions that do.
//!
//! | instruction | what it does |
//! | --- | --- |
//! | `cpsid i`, `cpsid f` | holds off every interrupt |
//! | `msr primask`, `basepri`, `basepri_max`, `faultmask` | holds off some, or puts back what was before |

use checks::board_image;
use object::{Object as _, ObjectSection as _, ObjectSymbol as _, SymbolKind};
use std::collections::BTreeSet;

/// Part of a function's name in the image, and why it is no matter for a receiver at work.
const KNOWN: [(&str, &str); 9] = [
    ("main", "start-up: tasks do not run yet"),
    ("rust_begin_unwind", "a panic: the program is over"),
    ("_defmt_acquire", "a line of the log: counted in counts.rs"),
    ("_defmt_release", "its end"),
    // RTIC puts back the priority a task was entered with, as the last thing the task does.
    ("FSMC", "the control task's end"),
    ("PVD", "the end of the task that a low supply wakes"),
    ("SysTick", "the clock's end"),
    ("TIM3", "the ring's end"),
    ("USART1", "the receiver's own end"),
];

/// Whether a 32-bit Thumb instruction writes one of the masks (ARMv7-M Architecture Reference Manual, B5.2.3: MSR, with
/// the special registers 16 to 19).
fn writes_a_mask(first: u16, second: u16) -> bool {
    first & 0xfff0 == 0xf380 && second & 0xff00 == 0x8800 && (16..=19).contains(&(second & 0xff))
}

/// The offsets in the code at which interrupts may be held off; data between functions may look like it.
fn sites(code: &[u8]) -> Vec<u64> {
    let (halves, _) = code.as_chunks::<2>();
    let halves: Vec<u16> = halves.iter().copied().map(u16::from_le_bytes).collect();
    let mut sites = Vec::new();
    for (index, &half) in halves.iter().enumerate() {
        let next = halves.get(index + 1).copied().unwrap_or(0);
        // CPSID i, f or both.
        if matches!(half, 0xb671..=0xb673) || writes_a_mask(half, next) {
            sites.push(2 * index as u64);
        }
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
    for site in sites(section.data().expect("its bytes")) {
        let address = section.address() + site;
        let owners = functions
            .iter()
            .rev()
            .filter(|(start, _)| *start <= address);
        let owner = owners.map(|(_, name)| *name).next().unwrap_or("nobody");
        let known = KNOWN.iter().find(|(part, _)| owner.contains(part));
        let (part, _) =
            known.unwrap_or_else(|| panic!("{owner} at {address:#x} may mask interrupts"));
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
    // cpsid i; nop; msr basepri, r0; msr primask, r1; cpsie i; mrs r0, primask
    let code = [
        0xb672, 0xbf00, 0xf380, 0x8811, 0xf381, 0x8810, 0xb662, 0xf3ef, 0x8010_u16,
    ];
    let bytes: Vec<u8> = code.iter().copied().flat_map(u16::to_le_bytes).collect();
    assert_eq!(sites(&bytes), [0, 4, 8]);
}
