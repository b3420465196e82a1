//! Builds the firmware's image for the emulator from the project's sources.

use super::{LinkError, Machine};
use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const PROFILE: &str = "chip";

/// Builds the image for a machine and returns its path. It has its own target folder, so the
/// board's image stays; what both are linked from is compiled once.
///
/// # Errors
/// [`LinkError::Open`] without the sources, without cargo, or when the build fails.
pub fn build(machine: &Machine) -> Result<PathBuf, LinkError> {
    let root = project().ok_or_else(|| {
        open_error("the firmware's sources are not here: start this in the project's folder, or give an image with --firmware ELF")
    })?;
    let folder = root.join("target").join(machine.target_folder());
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"));
    let built = Command::new(&cargo)
        .current_dir(&root)
        .args(["build", "--quiet", "-p", machine.package])
        .args(["--bin", machine.program, "--features", machine.features])
        .args(["--profile", PROFILE, "--target", machine.target])
        .arg("--target-dir")
        .arg(&folder)
        .env("CARGO_BUILD_BUILD_DIR", root.join("target"))
        .stdin(Stdio::null())
        // The compiler writes to standard error; standard output is for results.
        .stdout(Stdio::null())
        .status();
    match built {
        Ok(status) if status.success() => {
            let folder = folder.join(machine.target).join(PROFILE);
            Ok(folder.join(machine.program))
        }
        Ok(_) => Err(open_error(&format!(
            "the firmware could not be built, see above (once: `rustup target add {}`)",
            machine.target
        ))),
        Err(error) if error.kind() == ErrorKind::NotFound => Err(open_error(
            "there is no cargo to build the firmware with: install Rust (https://rustup.rs), or give an image with --firmware ELF",
        )),
        Err(error) => Err(open_error(&format!("cargo cannot be started: {error}"))),
    }
}

fn open_error(why: &str) -> LinkError {
    LinkError::Open { why: why.into() }
}

/// The project's folder: where this program was built, or else around the working folder.
fn project() -> Option<PathBuf> {
    let built_from = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let here = std::env::current_dir().unwrap_or_default();
    let mut folders = std::iter::once(built_from).chain(here.ancestors());
    let found = folders.find(|folder| folder.join("firmware/Cargo.toml").is_file());
    // Without the `..`, because it appears in messages.
    found.and_then(|folder| folder.canonicalize().ok())
}
