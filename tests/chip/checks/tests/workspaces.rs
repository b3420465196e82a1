//! This workspace has the same profile and package versions as the main one.

use checks::{project, workspace};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

fn read(folder: &Path, file: &str) -> String {
    fs::read_to_string(folder.join(file)).expect("a readable file")
}

/// The lines of the profile.
fn profile(manifest: &str) -> Vec<&str> {
    let lines = manifest
        .lines()
        .skip_while(|line| *line != "[profile.chip]");
    lines.take_while(|line| !line.is_empty()).collect()
}

#[test]
fn the_profile_equals_that_of_the_firmware() {
    let (ours, main) = (
        read(&workspace(), "Cargo.toml"),
        read(&project(), "Cargo.toml"),
    );
    assert!(profile(&ours).len() > 1);
    assert_eq!(profile(&ours), profile(&main));
    for manifest in [&ours, &main] {
        assert!(manifest.contains("\nfirmware = { opt-level = \"z\" }\n"));
    }
}

/// Versions by package; a package may have several.
fn versions(lock: &str) -> BTreeMap<&str, Vec<&str>> {
    let mut versions = BTreeMap::<_, Vec<_>>::new();
    for package in lock.split("[[package]]\n").skip(1) {
        let value = |key: &str| package.lines().find_map(|line| line.strip_prefix(key));
        if let (Some(name), Some(version)) = (value("name = "), value("version = ")) {
            versions.entry(name).or_default().push(version);
        }
    }
    versions
}

#[test]
fn package_versions_equal_those_of_the_main_workspace() {
    let (ours, main) = (
        read(&workspace(), "Cargo.lock"),
        read(&project(), "Cargo.lock"),
    );
    let main = versions(&main);
    for (name, ours) in versions(&ours) {
        let Some(main) = main.get(name) else {
            continue;
        };
        assert!(
            ours.iter().all(|version| main.contains(version)),
            "{name}: {ours:?} here, {main:?} in the main workspace"
        );
    }
}
