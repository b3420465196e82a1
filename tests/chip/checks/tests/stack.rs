//! Worst-case stack depth of the firmware's images stays within the stack's region.
//!
//! It assumes that each task is interrupted at its deepest by each task of higher priority.

use checks::stack::{Calls, Deepest};
use checks::{MICROBIT, OLIMEX_H405_ANY_BODY, OLIMEX_H405_PLACES, board_image, image};
use std::path::{Path, PathBuf};

/// The tasks of a board and its stack.
struct Load {
    name: &'static str,
    /// Interrupts and their tasks, lowest priority first.
    tasks: &'static [(&'static str, &'static str)],
    /// Bytes that the processor pushes on entry to an interrupt.
    entry: u32,
    /// Size of the stack's region, bytes.
    region: u32,
}

/// RTIC tasks. Entry: eight words, 18 of the floating-point unit, one for alignment (ARMv7-M
/// Architecture Reference Manual, B1.5.7). Region: memory.x.
const F405_LOAD: Load = Load {
    name: "F405",
    tasks: &[
        ("FSMC", "control"),
        ("SysTick", "clock"),
        ("USART1", "serial"),
    ],
    entry: 4 * (8 + 18 + 1),
    region: 8_192,
};
/// The same for sensors anywhere on the body.
const F405_ANY_BODY_LOAD: Load = Load {
    name: "F405, any body",
    ..F405_LOAD
};
/// And with a memory of places.
const F405_PLACES_LOAD: Load = Load {
    name: "F405, places",
    ..F405_LOAD
};
/// No floating-point unit (ARMv6-M Architecture Reference Manual, B1.5.6). Region: microbit.x.
const MICROBIT_LOAD: Load = Load {
    name: "micro:bit",
    tasks: &[("TIMER0", "timer"), ("UART0", "serial")],
    entry: 4 * (8 + 1),
    region: 4_608,
};

fn calls(path: &Path) -> Calls {
    let elf = std::fs::read(path).expect("the image");
    let mut calls = Calls::of(&elf).expect("an ELF file");
    // A panic ends the program, and formatting its message may panic again: no bound. The guard of
    // the stack's region catches an overflow there.
    calls.leave_out("core9panicking");
    // Only in the emulator's image, and unbounded on purpose.
    calls.leave_out("firmware10crash_test");
    calls
}

fn deepest(calls: &Calls, name: &str) -> Deepest {
    let address = calls.address(name).unwrap_or_else(|| panic!("no {name}"));
    let deepest = calls.deepest(address);
    deepest.unwrap_or_else(|round| panic!("{name} has no bound: {round:?}"))
}

fn print_frames(calls: &Calls, deepest: &Deepest) {
    for function in deepest.chain.iter().filter_map(|at| calls.function(*at)) {
        eprintln!("{:6} {}", function.frame, function.name);
    }
}

/// Fails if the tasks on top of `beneath`, or `alone`, exceed the region. Less than 2000 bytes
/// mean that calls were not followed, since a decision alone takes more.
fn check(load: &Load, calls: &Calls, beneath: u32, alone: u32) {
    let name = load.name;
    let mut table = format!("| {name} | bytes, at most |\n| --- | ---: |\n");
    table += &format!("| `main`, its start | {alone} |\n| `main`, interrupted | {beneath} |\n");
    let mut sum = beneath;
    for (interrupt, task) in load.tasks {
        let bytes = deepest(calls, interrupt).bytes;
        let entry = load.entry;
        table += &format!("| {task} | {bytes} |\n| on the way into it | {entry} |\n");
        sum += bytes + entry;
    }
    let all = sum.max(alone);
    let region = load.region;
    table +=
        &format!("| **all at once, {name}** | **{all}** |\n| the stack's region | {region} |\n");
    println!("{table}");
    assert!(sum > 2_000, "{sum} bytes: calls were not followed");
    assert!(all <= region, "{all} bytes");
}

/// Start-up runs with interrupts disabled; the tasks interrupt only the sleeping loop.
#[test]
fn the_deepest_stack_of_the_f405_stays_within_its_region() {
    // One after the other: the images replace each other.
    let any_body = || image(&OLIMEX_H405_ANY_BODY);
    let places = || image(&OLIMEX_H405_PLACES);
    let images: [(Load, &dyn Fn() -> PathBuf); 3] = [
        (F405_ANY_BODY_LOAD, &any_body),
        (F405_PLACES_LOAD, &places),
        (F405_LOAD, &board_image),
    ];
    for (load, image) in images {
        let calls = calls(&image());
        print_frames(&calls, &deepest(&calls, "FSMC"));
        let main = deepest(&calls, "main");
        let idle = calls.function(main.chain[0]).expect("main").frame;
        check(&load, &calls, idle, main.bytes);
    }
}

/// The control task is part of `main`.
#[test]
fn the_deepest_stack_of_the_microbit_stays_within_its_region() {
    let calls = calls(&image(&MICROBIT));
    let main = deepest(&calls, "main");
    print_frames(&calls, &main);
    check(&MICROBIT_LOAD, &calls, main.bytes, main.bytes);
}
