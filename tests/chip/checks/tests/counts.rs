//! No call takes more instructions than allowed, and counting is repeatable.

use checks::{TARGET, cargo, rows, workspace};

fn table() -> String {
    let line = format!("run --quiet --locked --profile chip --package counts --target {TARGET}");
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
    let table = table();
    println!("{table}");
    let rows = rows(&table);
    assert_eq!(rows.len(), 17, "{table}");
    for row in rows {
        assert!(row.most <= row.allowed, "{row:?}");
    }
}
