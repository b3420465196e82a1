//! Names the build after its commit.

use std::env;
use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let package = env::var("CARGO_MANIFEST_DIR").expect("cargo names the package's folder");
    name_the_build(&Path::new(&package).join(".."));
    // The default of defmt is errors only.
    println!("cargo:rerun-if-env-changed=DEFMT_LOG");
    if env::var_os("DEFMT_LOG").is_none() {
        println!("cargo:rustc-env=DEFMT_LOG=info");
    }
}

/// Eight characters: the commit, or the version where there is none (a source archive).
fn name_the_build(root: &Path) {
    for file in [".git/HEAD", ".git/logs/HEAD"] {
        let file = root.join(file);
        if file.exists() {
            println!("cargo:rerun-if-changed={}", file.display());
        }
    }
    let commit = Command::new("git")
        .args(["rev-parse", "--short=8", "HEAD"])
        .current_dir(root)
        .output()
        .ok()
        .filter(|output| output.status.success())
        .and_then(|output| String::from_utf8(output.stdout).ok());
    let version = env::var("CARGO_PKG_VERSION").expect("cargo names the version");
    let name = commit.as_deref().map_or(version.as_str(), str::trim);
    println!("cargo:rustc-env=FIRMWARE_BUILD={name:-<8.8}");
}
