//! What is checked here is what is built on top: the same profile and the same versions of packages.

use checks::{project, workspace};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

fn read(folder: &Path, file: &str) -> String {
    fs::read_to_string(folder.join(file)).expect("a readable file")
}

/// The settings of the profile, one per line.
fn profile(manifest: &str) -> Vec<&str> {
    let lines = manifest
        .lines()
        .skip_while(|line| *line != "[profile.chip]");
    lines.take_while(|line| !line.is_empty()).collect()
}

#[test]
fn the_profile_is_the_firmwares() {
    let (ours, firmwares) = (
        read(&workspace(), "Cargo.toml"),
        read(&project(), "Cargo.toml"),
    );
    assert!(profile(&ours).len() > 1);
    assert_eq!(profile(&ours), profile(&firmwares));
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
fn packages_have_the_versions_they_have_on_top() {
    let (ours, tops) = (
        read(&workspace(), "Cargo.lock"),
        read(&project(), "Cargo.lock"),
    );
    let tops = versions(&tops);
    for (name, ours) in versions(&ours) {
        let Some(tops) = tops.get(name) else {
            continue;
        };
        assert!(
            ours.iter().all(|version| tops.contains(version)),
            "{name}: {ours:?} here, {tops:?} on top"
        );
    }
}
