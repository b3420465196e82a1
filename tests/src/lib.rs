//! Harness of the integration tests: runs the program as a user does, in its own folder.

pub mod board;
pub mod browser;
pub mod campaign;
pub mod chip;
pub mod defects;
pub mod hostile;
pub mod nomad;
pub mod pty;
pub mod twin;
pub mod viewed;

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// The `host-sim` program in an empty working folder.
#[macro_export]
macro_rules! host_sim {
    () => {
        $crate::Program::new(env!("CARGO_BIN_EXE_host-sim-under-test"))
    };
}

/// A program and its temporary working folder.
#[derive(Debug)]
pub struct Program {
    path: PathBuf,
    folder: TempDir,
}

/// Result of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProgramOutput {
    /// Exit code; `None` if a signal ended it.
    pub code: Option<i32>,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Program {
    /// The program at `path`, in a new empty folder.
    ///
    /// # Panics
    /// When no temporary folder can be created.
    #[must_use]
    pub fn new(path: &str) -> Self {
        Self {
            path: path.into(),
            folder: tempfile::tempdir().expect("a temporary folder"),
        }
    }

    /// Its working folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Writes a file into the working folder.
    ///
    /// # Panics
    /// When it cannot be written.
    pub fn put(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.folder().join(name);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).expect("a folder for the file");
        }
        fs::write(path, content).expect("a file in the working folder");
    }

    /// The command, not yet started, without standard input.
    #[must_use]
    pub fn command<A: AsRef<OsStr>>(&self, args: &[A]) -> Command {
        let mut command = Command::new(&self.path);
        command
            .args(args)
            .current_dir(self.folder())
            .stdin(Stdio::null());
        command
    }

    /// Runs the program to its end.
    ///
    /// # Panics
    /// When it cannot be started or its output is not UTF-8.
    #[must_use]
    pub fn run<A: AsRef<OsStr>>(&self, args: &[A]) -> ProgramOutput {
        let done = self.command(args).output().expect("the program starts");
        let text = |bytes| String::from_utf8(bytes).expect("output is UTF-8");
        ProgramOutput {
            code: done.status.code(),
            stdout: text(done.stdout),
            stderr: text(done.stderr),
        }
    }

    /// Runs the words of `line` and returns standard output.
    ///
    /// # Panics
    /// When the exit code is not 0.
    #[must_use]
    pub fn ok(&self, line: &str) -> String {
        let output = self.run(&words(line));
        assert_eq!(output.code, Some(0), "{line}: {}", output.stderr);
        output.stdout
    }

    /// All files below `name` in the working folder with their bytes, by path; empty if the folder
    /// does not exist.
    ///
    /// # Panics
    /// When a file cannot be read.
    #[must_use]
    pub fn files(&self, name: &str) -> Vec<(String, Vec<u8>)> {
        let root = self.folder().join(name);
        let mut files = Vec::new();
        let mut folders = vec![root.clone()];
        while let Some(folder) = folders.pop() {
            let Ok(entries) = fs::read_dir(&folder) else {
                continue;
            };
            for entry in entries {
                let path = entry.expect("a readable folder").path();
                if path.is_dir() {
                    folders.push(path);
                } else {
                    let inner = path.strip_prefix(&root).expect("inside the folder");
                    let bytes = fs::read(&path).expect("a readable file");
                    files.push((inner.display().to_string(), bytes));
                }
            }
        }
        files.sort_unstable();
        files
    }
}

/// Splits a command line; double or single quotes keep blanks together.
#[must_use]
pub fn words(line: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut quote = None;
    for c in line.chars() {
        match (quote, c) {
            (Some(mark), _) if c == mark => quote = None,
            (None, '"' | '\'') => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (None, _) if c.is_whitespace() => words.extend(word.take()),
            _ => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    words
}

/// The project's root folder.
#[must_use]
pub fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

#[cfg(test)]
mod tests {
    use super::words;

    #[test]
    fn quotes_keep_blanks_together() {
        assert_eq!(
            words(" run  --only 'a b'\t--set far=\"1 2\" '' "),
            ["run", "--only", "a b", "--set", "far=1 2", ""]
        );
    }
}
