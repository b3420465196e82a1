//! The controller cannot panic: it links for the chip without a panic handler.

use checks::{TARGET, cargo, workspace};
use std::process::Output;

fn link(features: &str) -> Output {
    let line =
        format!("build --locked --profile chip --package panics --target {TARGET} {features}");
    cargo(&workspace(), &line)
}

#[test]
fn the_controller_has_no_path_to_a_panic() {
    let output = link("");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "see README.md beside this workspace:\n{stderr}"
    );
}

#[test]
fn a_path_to_a_panic_is_found() {
    let output = link("--features deliberate-panic");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success(), "it linked");
    assert!(
        stderr.contains("a_path_to_a_panic_is_left"),
        "another error:\n{stderr}"
    );
}
