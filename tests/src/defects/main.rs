//! Breaks the code on purpose, one place at a time, and asks whether a check notices: `tests/defects.toml` lists the defects
//! and the check that has to fail for each.
//!
//! Works in a copy of the committed tree, so that nothing here changes. A check that passes with the defect, a place that is
//! not found exactly once, and a check that fails without any defect are errors. Prints a Markdown table; progress goes to
//! standard error. Exit code 0: every defect was noticed; 1: one was not.

use serde::Deserialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

/// What is to be broken, and who has to notice.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Defect {
    /// The defect in a few words.
    what: String,
    /// The file, from the top of the project.
    file: PathBuf,
    /// What stands there exactly once.
    find: String,
    /// What takes its place.
    replace: String,
    /// The command that has to fail.
    check: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    defect: Vec<Defect>,
}

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

/// Tries the defects whose description or check contains `part`. Returns whether all were noticed.
fn run(part: &str) -> Result<bool, String> {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let path = top.join("tests/defects.toml");
    let text =
        std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let list: List =
        toml::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    let chosen = |defect: &&Defect| defect.what.contains(part) || defect.check.contains(part);
    let defects: Vec<_> = list.defect.iter().filter(chosen).collect();
    let copy = tempfile::tempdir().map_err(|error| error.to_string())?;
    let copy = copy.path();
    shell(
        &top,
        &format!("git archive HEAD | tar -x -C '{}'", copy.display()),
    )?;
    let target = top.join("target/defects");

    // A check that fails anyway says nothing.
    for check in defects
        .iter()
        .map(|defect| &defect.check)
        .collect::<BTreeSet<_>>()
    {
        eprintln!("without a defect: {check}");
        if !passes(copy, &target, check)? {
            return Err(format!("`{check}` fails without any defect"));
        }
    }
    println!("| defect | check | noticed |\n| --- | --- | --- |");
    let mut all = true;
    for defect in defects {
        eprintln!("{}", defect.what);
        let noticed = !with(copy, defect, || passes(copy, &target, &defect.check))?;
        all &= noticed;
        let answer = if noticed { "yes" } else { "**no**" };
        println!("| {} | `{}` | {answer} |", defect.what, defect.check);
    }
    Ok(all)
}

/// Does something while the copy has the defect.
fn with<T>(
    copy: &Path,
    defect: &Defect,
    action: impl FnOnce() -> Result<T, String>,
) -> Result<T, String> {
    let file = copy.join(&defect.file);
    let named = |error: std::io::Error| format!("{}: {error}", defect.file.display());
    let whole = std::fs::read_to_string(&file).map_err(named)?;
    let places = whole.matches(&defect.find).count();
    if places != 1 {
        let (file, find) = (defect.file.display(), &defect.find);
        return Err(format!(
            "{file}: `{find}` stands there {places} times, not once"
        ));
    }
    std::fs::write(&file, whole.replace(&defect.find, &defect.replace)).map_err(named)?;
    let result = action();
    std::fs::write(&file, whole).map_err(named)?;
    result
}

/// Whether a check passes. Code that does not compile is no answer.
fn passes(copy: &Path, target: &Path, check: &str) -> Result<bool, String> {
    let build = check.replacen("cargo test", "cargo test --no-run", 1);
    let built = build == check || succeeds(copy, target, &build)?;
    if !built {
        return Err(format!("`{build}` fails: the defect does not compile"));
    }
    succeeds(copy, target, check)
}

fn succeeds(copy: &Path, target: &Path, command: &str) -> Result<bool, String> {
    let status = Command::new("bash")
        .args(["-c", command])
        .current_dir(copy)
        .env("CARGO_TARGET_DIR", target)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    status
        .map(|status| status.success())
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
