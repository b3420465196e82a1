//! How deep the stack of the firmware's image can become, by its code.
//!
//! Whatever runs may be interrupted by whatever has a higher priority, each at its deepest; `main` beneath them is only the loop
//! that sleeps, because start-up runs with interrupts off.

use checks::board_image;
use checks::stack::Calls;

/// The tasks, by the interrupts they are bound to, lowest priority first.
const TASKS: [(&str, &str); 3] = [
    ("FSMC", "control"),
    ("SysTick", "clock"),
    ("USART1", "serial"),
];
/// What the processor pushes on its way into an interrupt: eight words, the floating-point unit's 18, and a word to align them
/// (ARMv7-M Architecture Reference Manual, B1.5.7).
const ENTRY: u32 = 4 * (8 + 18 + 1);
/// The region of the stack (memory.x).
const REGION: u32 = 8 * 1_024;

#[test]
fn the_deepest_stack_stays_within_its_region() {
    let elf = std::fs::read(board_image()).expect("the image");
    let mut calls = Calls::of(&elf).expect("an ELF file");
    // A panic is the end of the program, and formatting its words may panic again: it has no bound. Whether its record still
    // fits is seen to by the region's lower end.
    calls.leave_out("core9panicking");
    // In the emulator's image alone, and without a bound on purpose.
    calls.leave_out("firmware10crash_test");
    let deepest = |name: &str| {
        let address = calls.address(name).unwrap_or_else(|| panic!("no {name}"));
        let found = calls.deepest(address);
        found.unwrap_or_else(|round| panic!("{name} has no bound: {round:?}"))
    };
    let main = deepest("main");
    let beneath = calls.function(main.chain[0]).expect("main").frame;
    println!("| what | bytes, at most |\n| --- | ---: |");
    println!("| start-up | {} |\n| idle | {beneath} |", main.bytes);
    let mut sum = beneath;
    for (interrupt, task) in TASKS {
        let task_at_most = deepest(interrupt);
        println!("| {task} | {} |", task_at_most.bytes);
        sum += ENTRY + task_at_most.bytes;
        if task == "control" {
            for function in task_at_most
                .chain
                .iter()
                .filter_map(|at| calls.function(*at))
            {
                eprintln!("{:6} {}", function.frame, function.name);
            }
        }
    }
    println!("| on the way into three interrupts | {} |", 3 * ENTRY);
    let all = sum.max(main.bytes);
    println!("| **all at once** | **{all}** |\n| the stack's region | {REGION} |");
    assert!(all <= REGION, "{all} bytes");
    // The mind's decisions are in it.
    assert!(sum > 2_000, "{sum} bytes: calls were not followed");
}
