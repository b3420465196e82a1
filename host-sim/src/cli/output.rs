//! Output folders, worker threads and progress bars of all commands.

use files::error::BadInput;
use indicatif::{ProgressBar, ProgressStyle};
use rayon::ThreadPool;
use std::path::Path;

/// Creates the folder and checks that files can be written there, before the long computation.
///
/// # Errors
/// When it cannot be created or written.
pub fn prepare(dir: &Path) -> Result<(), BadInput> {
    let refuse = |error: std::io::Error| BadInput::file(dir, format!("cannot be written: {error}"));
    std::fs::create_dir_all(dir).map_err(refuse)?;
    let probe = dir.join(format!(".probe-{}", std::process::id()));
    std::fs::write(&probe, []).map_err(refuse)?;
    std::fs::remove_file(&probe).map_err(refuse)
}

/// A pool of this many worker threads, or one per core.
///
/// # Errors
/// When they cannot be started.
pub fn pool(threads: Option<u16>) -> Result<ThreadPool, BadInput> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.map_or(0, usize::from))
        .build();
    pool.map_err(|error| BadInput::new(format!("--threads: {error}")))
}

/// A progress bar on standard error that counts to `length`; hidden without a terminal.
#[must_use]
pub fn bar(length: u64, what: &'static str) -> ProgressBar {
    let template =
        "{prefix:>8} {wide_bar:.cyan/blue} {pos}/{len} {elapsed_precise} (left {eta_precise})";
    let style =
        ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(length).with_style(style).with_prefix(what)
}
