//! Reads `tests/defects.toml`: deliberate defects, each with the check that must fail.

use crate::root;
use remote::link::Machine;
use serde::Deserialize;
use std::path::PathBuf;

/// A deliberate defect and its check.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeliberateDefect {
    /// Short description.
    pub what: String,
    /// The file, relative to the project's root.
    pub file: PathBuf,
    /// Text that occurs exactly once in the file.
    pub find: String,
    /// Its replacement.
    pub replace: String,
    /// The command that must fail.
    pub check: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct DefectList {
    defect: Vec<DeliberateDefect>,
}

/// Reads the whole list.
///
/// # Errors
/// When it cannot be read.
pub fn list() -> Result<Vec<DeliberateDefect>, String> {
    let path = root().join("tests/defects.toml");
    let named = |error: &dyn std::fmt::Display| format!("tests/defects.toml: {error}");
    let text = std::fs::read_to_string(path).map_err(|error| named(&error))?;
    let list: DefectList = toml::from_str(&text).map_err(|error| named(&error))?;
    Ok(list.defect)
}

impl DeliberateDefect {
    /// The defect's row in the table.
    #[must_use]
    pub fn row(&self, detected: bool) -> String {
        let answer = if detected { "yes" } else { "**no**" };
        format!("| {} | `{}` | {answer} |", self.what, self.check)
    }

    /// Inserts the defect into a file's text.
    ///
    /// # Errors
    /// When the text does not occur exactly once, or nothing would change.
    pub fn put_into(&self, text: &str) -> Result<String, String> {
        let (file, find) = (self.file.display(), &self.find);
        if find == &self.replace {
            return Err(format!("{file}: `{find}` would stay as it is"));
        }
        match text.matches(find.as_str()).count() {
            1 => Ok(text.replace(find.as_str(), &self.replace)),
            places => Err(format!(
                "{file}: `{find}` occurs there {places} times, not once"
            )),
        }
    }
}

/// The build commands of a check. Code that does not compile would fail every check.
///
/// # Errors
/// When the builds of a check are unknown.
pub fn builds(check: &str) -> Result<Vec<String>, String> {
    let mut commands = Vec::new();
    if check.starts_with("cargo test ") {
        commands.push(check.replacen("cargo test", "cargo test --no-run", 1));
    } else if check.starts_with("tests/campaign ") {
        commands.push("cargo build --locked -p tests --bin campaign".to_owned());
    } else if check.starts_with("cd tests/chip && cargo test ") {
        commands.push(check.replacen("cargo test", "cargo test --no-run", 1));
        commands.extend(BOARDS.map(board_image));
        return Ok(commands);
    } else {
        return Err(format!("`{check}`: the builds of this check are unknown"));
    }
    // Some checks build images while they run.
    let machines: &[Machine] = if check.contains("chip_architectures") {
        &[
            Machine::OLIMEX_H405,
            Machine::MICROBIT,
            Machine::RISCV32_VIRT,
        ]
    } else if check.contains("chip") || check.contains("bridge::") {
        &[Machine::OLIMEX_H405]
    } else {
        &[]
    };
    commands.extend(machines.iter().map(image));
    Ok(commands)
}

/// Packages, programs and targets of the images for the checks in tests/chip.
const BOARDS: [[&str; 3]; 2] = [
    ["stm32f405", "olimex_h405", "thumbv7em-none-eabihf"],
    ["microbit", "microbit", "thumbv6m-none-eabi"],
];

/// Where all images keep what they are linked from, as in the checks.
const SHARED: &str = "CARGO_BUILD_BUILD_DIR=target";

fn board_image([package, program, target]: [&str; 3]) -> String {
    format!(
        "{SHARED} cargo build --locked -p {package} --bin {program} --profile chip --target {target}"
    )
}

/// Builds an image at the place where the check expects it.
fn image(machine: &Machine) -> String {
    let Machine {
        package,
        program,
        features,
        target,
        ..
    } = machine;
    format!(
        "{SHARED} cargo build --locked -p {package} --bin {program} --features '{features}' --profile chip --target {target} --target-dir target/qemu"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_found_once_or_not_at_all() {
        let defect = |find: &str, replace: &str| DeliberateDefect {
            what: String::new(),
            file: "a.rs".into(),
            find: find.to_owned(),
            replace: replace.to_owned(),
            check: String::new(),
        };
        assert_eq!(defect("b", "x").put_into("abc"), Ok("axc".to_owned()));
        for (find, replace) in [("d", "x"), ("a", "x"), ("b", "b")] {
            let broken = defect(find, replace).put_into("aba");
            assert!(broken.is_err(), "{find} {replace}");
        }
    }

    #[test]
    fn whatever_a_check_builds_is_built_before() {
        let count = |check| builds(check).map(|commands| commands.len());
        assert_eq!(count("cargo test -p amp-mind --lib -- shield"), Ok(1));
        assert_eq!(count("tests/campaign drift"), Ok(1));
        assert_eq!(count("tests/campaign chip-link --count 300"), Ok(2));
        assert_eq!(count("cargo test -p tests --test all bridge::"), Ok(2));
        assert_eq!(count("cargo test -p tests --test all chip_faults::"), Ok(2));
        assert_eq!(
            count("cargo test -p tests --test all chip_architectures::"),
            Ok(4)
        );
        assert_eq!(count("cd tests/chip && cargo test --test stack"), Ok(3));
        assert!(count("tests/miri").is_err());
        let built = builds("cargo test -p amp-mind --lib -- a").expect("a command");
        assert_eq!(built, ["cargo test --no-run -p amp-mind --lib -- a"]);
    }
}
