//! Mutation test: inserts the defects of `tests/defects.toml` and expects their checks to fail.
//!
//! Works in a copy of the committed tree. Errors: a check that passes with the defect or fails
//! without it, text not found exactly once, code that does not compile. Prints a Markdown table;
//! exit code 1 if a defect is not detected.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, ExitCode, Output, Stdio};
use std::time::Instant;
use tests::defects::{DeliberateDefect, builds, list};
use tests::root;

fn main() -> ExitCode {
    match run(std::env::args().nth(1).as_deref().unwrap_or("")) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::FAILURE
        }
    }
}

/// Tests the defects whose description or check contains `part`. Returns whether all were detected.
fn run(part: &str) -> Result<bool, String> {
    let mut defects = list()?;
    defects.retain(|defect| defect.what.contains(part) || defect.check.contains(part));
    let copy = tempfile::tempdir().map_err(|error| error.to_string())?;
    let copy = copy.path();
    // `tar -m` sets the current time: cargo would take files older than its last build for built.
    shell(
        root(),
        &format!("git archive HEAD | tar -xm -C '{}'", copy.display()),
    )?;
    let target = root().join("target/defects");

    // A check that fails without a defect, such as one without an emulator, proves nothing.
    let checks: BTreeSet<_> = defects.iter().map(|defect| &defect.check).collect();
    for check in checks {
        eprintln!("without a defect: {check}");
        if !timed(|| passes(copy, &target, check))? {
            return Err(format!("`{check}` fails without any defect"));
        }
    }
    println!("| defect | check | detected |\n| --- | --- | --- |");
    let mut all = true;
    for defect in &defects {
        eprintln!("{}", defect.what);
        let tried = timed(|| with(copy, defect, || passes(copy, &target, &defect.check)));
        let detected = !tried.map_err(|why| format!("{}: {why}", defect.what))?;
        all &= detected;
        println!("{}", defect.row(detected));
    }
    Ok(all)
}

/// Runs `action` and prints its duration.
fn timed<T>(action: impl FnOnce() -> T) -> T {
    let began = Instant::now();
    let result = action();
    eprintln!("    {:.1} s", began.elapsed().as_secs_f64());
    result
}

/// Runs `action` while the copy has the defect.
fn with<T>(
    copy: &Path,
    defect: &DeliberateDefect,
    action: impl FnOnce() -> Result<T, String>,
) -> Result<T, String> {
    let file = copy.join(&defect.file);
    let named = |error: std::io::Error| format!("{}: {error}", defect.file.display());
    let whole = std::fs::read_to_string(&file).map_err(named)?;
    std::fs::write(&file, defect.put_into(&whole)?).map_err(named)?;
    let result = action();
    std::fs::write(&file, whole).map_err(named)?;
    result
}

/// Whether a check passes. An error if host or chip code does not compile.
fn passes(copy: &Path, target: &Path, check: &str) -> Result<bool, String> {
    for build in builds(check)? {
        let built = output(copy, target, &build)?;
        if !built.status.success() {
            let why = String::from_utf8_lossy(&built.stderr);
            return Err(format!("`{build}` fails, which is no answer:\n{why}"));
        }
    }
    match output(copy, target, check)?.status.code() {
        Some(0) => Ok(true),
        Some(1..128) => Ok(false),
        _ => Err(format!("`{check}` was killed, which is no answer")),
    }
}

fn output(copy: &Path, target: &Path, command: &str) -> Result<Output, String> {
    Command::new("bash")
        .args(["-c", command])
        .current_dir(copy)
        .env("CARGO_TARGET_DIR", target)
        .stdin(Stdio::null())
        .output()
        .map_err(|error| format!("bash: {error}"))
}

fn shell(folder: &Path, command: &str) -> Result<(), String> {
    let status = Command::new("bash")
        .args(["-c", command])
        .current_dir(folder)
        .status();
    match status {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("`{command}`: {status}")),
        Err(error) => Err(format!("bash: {error}")),
    }
}
