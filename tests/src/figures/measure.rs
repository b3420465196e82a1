//! Runs a command and records machine, commit and date.

use crate::page::MeasuredFigure;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Output of `run` on both streams; an error if it fails.
pub fn output(root: &Path, run: &str) -> Result<String, String> {
    let spinner = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("        {spinner} {elapsed}") {
        spinner.set_style(style);
    }
    spinner.enable_steady_tick(Duration::from_millis(200));
    let mut shell = Command::new("sh");
    shell
        .args(["-c", run])
        .current_dir(root)
        .stdin(Stdio::null());
    let output = shell.output().map_err(|error| format!("sh: {error}"))?;
    spinner.finish_and_clear();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    if !output.status.success() {
        let last: Vec<_> = text(&output.stderr)
            .lines()
            .rev()
            .take(5)
            .map(String::from)
            .collect();
        let last: Vec<_> = last.into_iter().rev().collect();
        return Err(format!(
            "`{run}` failed ({}):\n{}",
            output.status,
            last.join("\n")
        ));
    }
    Ok(text(&output.stdout) + &text(&output.stderr))
}

/// Machine, commit and date of a measurement.
#[derive(Debug)]
pub struct MeasurementSite {
    day: String,
    commit: String,
    machine: String,
}

impl MeasurementSite {
    /// Today, the current commit (`+` with uncommitted changes), this machine.
    pub fn here(root: &Path) -> Result<Self, String> {
        let ask = |run: &str| output(root, run).map(|text| text.trim().to_string());
        let changed = !ask("git status --porcelain -- . ':!docs/FIGURES.md'")?.is_empty();
        let commit = ask("git rev-parse --short=9 HEAD")?;
        let name = ask("sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1")?;
        let name = if name.is_empty() {
            ask("uname -m")?
        } else {
            name
        };
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let compiler = ask("rustc --version")?;
        Ok(Self {
            day: ask("date -u +%F")?,
            commit: commit + if changed { "+" } else { "" },
            machine: format!(
                "{name}, {cores} cores, {}",
                compiler.split(" (").next().unwrap_or("")
            ),
        })
    }

    /// A figure measured here and now.
    pub fn measured(&self, value: String, command: &str) -> MeasuredFigure {
        MeasuredFigure {
            value,
            day: self.day.clone(),
            commit: self.commit.clone(),
            machine: self.machine.clone(),
            command: command.into(),
        }
    }
}
