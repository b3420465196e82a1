//! The board tests that need no device pass on the emulated chip, and a failure is reported.

use checks::{TARGET, cargo, project, target_folder};
use object::{Object as _, ObjectSection as _, ObjectSymbol as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// Builds the tests, including one that fails.
fn build() -> PathBuf {
    let line = format!(
        "test --locked --no-run --package hil --test kernels_and_storage --features qemu,failing --profile chip --target {TARGET} \
         --message-format json"
    );
    let output = cargo(&project(), &line);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    let stdout = String::from_utf8_lossy(&output.stdout);
    let (_, path) = stdout.split_once("\"executable\":\"").expect("an image");
    let (path, _) = path.split_once('"').expect("its path ends");
    target_folder().join(path)
}

/// Names and addresses of an image's tests. Each symbol's name is a JSON object, and its data
/// is the function's address.
fn tests(image: &Path) -> Vec<(String, u32)> {
    let elf = std::fs::read(image).expect("the image can be read");
    let file = object::File::parse(&*elf).expect("the image is an ELF file");
    let list = file.section_by_name(".embedded_test").expect("a list");
    let test = |symbol: object::Symbol<'_, '_>| {
        let (_, name) = symbol.name().ok()?.split_once("\"name\":\"")?;
        let word = list.data_range(symbol.address(), 4).ok()??;
        let address = u32::from_le_bytes(word.try_into().ok()?);
        Some((name.split('"').next()?.to_owned(), address))
    };
    file.symbols().filter_map(test).collect()
}

/// Runs one test after a reset, selected by its address, as `probe-rs` does.
fn run(image: &Path, address: u32) -> Output {
    let mut qemu = Command::new("timeout");
    qemu.args(["60", "qemu-system-arm", "-M", "netduinoplus2"])
        .args("-nographic -monitor none -serial none -semihosting-config".split(' '))
        .arg(format!(
            "enable=on,target=native,arg=run_addr,arg={address}"
        ))
        .arg("-kernel")
        .arg(image)
        .stdin(Stdio::null());
    qemu.output().expect("timeout and QEMU start")
}

#[test]
fn board_tests_pass_on_the_emulated_chip_and_a_failure_is_reported() {
    let image = build();
    let tests = tests(&image);
    assert_eq!(tests.len(), 5, "{tests:?}");
    for (name, address) in tests {
        let output = run(&image, address);
        let stderr = String::from_utf8_lossy(&output.stderr);
        println!("{name}: {} {stderr}", output.status);
        let fails = name == "a_failure_is_reported";
        // 124 means a test that did not end.
        assert_eq!(
            output.status.code(),
            Some(i32::from(fails)),
            "{name}: {stderr}"
        );
        assert_eq!(
            stderr.contains("kernels_and_storage.rs:"),
            fails,
            "{name}: {stderr}"
        );
    }
}
