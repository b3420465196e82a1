//! No call takes more instructions than allowed.

use checks::{CountRow, TARGET, cargo, rows, workspace};

/// Limits by the start of a row: instructions, mean and of the longest call.
const BUDGETS: [(&str, u64, u64); 15] = [
    ("best-matching unit, 16 × 16, by kernels", 500, 500),
    ("situation map learns, winner and 4 neighbors", 450, 450),
    (
        "**decision** (last echo of the ring): avoid",
        20_000,
        30_000,
    ),
    ("decision: along a wall", 20_000, 30_000),
    ("decision: to a place", 20_000, 30_000),
    ("decision: obstacles on the right", 20_000, 30_000),
    ("decision: after a leader", 20_000, 30_000),
    ("decision: avoid by the paper's four steps", 20_000, 30_000),
    ("**learning**", 30_000_000, 30_000_000),
    ("body: echo at rest", 21_500, 36_000),
    ("body: of an echo, keeping", 20_000, 21_800),
    // 1 ms of an STM32F405, and 60 ms.
    ("places: a slice", 168_000, 168_000),
    ("places: a slice that decides", 168_000, 168_000),
    ("places: last echo of the ring", 168_000, 168_000),
    ("places: all slices, led", 10_000_000, 10_000_000),
];

fn table(package: &str) -> String {
    let line = format!("run --quiet --locked --profile chip --package {package} --target {TARGET}");
    let output = cargo(&workspace(), &line);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "qemu-system-arm 7.2 or later is needed:\n{stderr}"
    );
    String::from_utf8(output.stdout).expect("the table is UTF-8")
}

#[test]
fn no_call_takes_more_instructions_than_allowed() {
    let table = table("counts");
    within_bounds(&table, 40);
    let rows = rows(&table);
    for (call, mean, most) in BUDGETS {
        let row = rows.iter().find(|row| row.call.starts_with(call));
        let row = row.unwrap_or_else(|| panic!("{call} is not counted"));
        assert!(row.mean <= mean && row.most <= most, "{row:?}");
    }
    as_documented(&rows);
}

/// The README's table is that of this program, to within a twentieth: another compiler counts
/// differently.
fn as_documented(counted: &[CountRow]) {
    let readme = std::fs::read_to_string(workspace().join("README.md")).expect("a README");
    let documented = rows(&readme);
    for row in counted {
        let told = documented.iter().find(|told| told.call == row.call);
        let told = told.unwrap_or_else(|| panic!("README.md: no row {:?}", row.call));
        let is_near = |told: u64, count: u64| told.abs_diff(count) * 20 <= count;
        assert!(
            told.allowed == row.allowed
                && is_near(told.mean, row.mean)
                && is_near(told.most, row.most),
            "README.md tells {told:?}, counted {row:?}"
        );
    }
}

/// Nothing else masks the receive interrupt: see `masks.rs`.
#[test]
fn no_log_line_masks_the_receive_interrupt_for_long() {
    within_bounds(&table("lines"), 2);
}

fn within_bounds(table: &str, calls: usize) {
    println!("{table}");
    let rows = rows(table);
    assert_eq!(rows.len(), calls, "{table}");
    for row in rows {
        assert!(row.most <= row.allowed, "{row:?}");
    }
}
