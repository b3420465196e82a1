//! No call takes more instructions than allowed, and counting is repeatable.

use checks::{TARGET, cargo, rows, workspace};

/// Aimed at for a decision by the paper's four steps, on average.
const FOUR_STEPS: u64 = 6_000;

fn table(package: &str) -> String {
    let line = format!("run --quiet --locked --profile chip --package {package} --target {TARGET}");
    let output = cargo(&workspace(), &line);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "qemu-system-arm 7.2 or later is needed:\n{said}"
    );
    String::from_utf8(output.stdout).expect("the table is UTF-8")
}

#[test]
fn no_call_takes_more_instructions_than_allowed() {
    let table = table("counts");
    within_bounds(&table, 20);
    let rows = rows(&table);
    let probe = rows.iter().find(|row| row.call.contains("`probe`"));
    let probe = probe.expect("the paper's four steps are counted");
    assert!(probe.mean <= FOUR_STEPS, "{probe:?}");
}

/// Nothing else holds off the receiver: see `masks.rs`.
#[test]
fn no_line_of_the_log_holds_off_the_receiver_for_long() {
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
