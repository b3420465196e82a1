//! Writes output files: a file appears completely or not at all.
//!
//! Writes a temporary file in the same folder, syncs it to disk and renames it. Keeps the mode of
//! an existing file and follows symbolic links. Writes devices and FIFOs directly.

use crate::error::BadInput;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Write as _};
use std::path::{Path, PathBuf};

/// Largest number of symbolic links to follow, as in the Linux kernel.
const MAX_LINKS: u32 = 40;

/// Kind of an output file.
enum Destination {
    /// A regular file, which may not exist yet; symbolic links are resolved.
    Regular(PathBuf),
    /// A device, a FIFO or an open file of this process: written directly.
    Stream,
}

/// Writes an output file.
///
/// # Errors
/// When it cannot be written completely; an existing file does not change.
pub fn write(path: &Path, content: &[u8]) -> io::Result<()> {
    write_with(path, |mut file| file.write_all(content))
}

/// Writes a file into a folder, as [`write`](write()); returns its path.
///
/// # Errors
/// When it cannot be written; an existing file does not change.
pub fn save(folder: &Path, name: &str, content: &[u8]) -> Result<PathBuf, BadInput> {
    let path = folder.join(name);
    match write(&path, content) {
        Ok(()) => Ok(path),
        Err(error) => Err(unwritable(&path, &error)),
    }
}

/// An error about an output file or folder.
pub fn unwritable(path: &Path, error: &io::Error) -> BadInput {
    BadInput::file(path, format!("cannot be written: {error}"))
}

/// As [`write`](write()), with the content from `fill`.
fn write_with(path: &Path, fill: impl FnOnce(&File) -> io::Result<()>) -> io::Result<()> {
    let target = match destination(path)? {
        Destination::Stream => return fill(&open_stream(path)?),
        Destination::Regular(target) => target,
    };
    let (file, temporary) = create_temporary(&target)?;
    let written = fill(&file).and_then(|()| finish(&mut RealDisk, &file, &temporary, &target));
    if written.is_err() {
        // The first error is the one to report.
        let _ = fs::remove_file(&temporary);
    }
    written
}

/// Creates an output file for incremental writing. Opens a device or FIFO directly.
///
/// # Errors
/// `AlreadyExists` for a regular file that exists; when the file cannot be written.
pub fn create_new(path: &Path) -> io::Result<File> {
    match destination(path)? {
        Destination::Stream => open_stream(path),
        Destination::Regular(target) => File::create_new(target),
    }
}

fn destination(path: &Path) -> io::Result<Destination> {
    match fs::metadata(path) {
        Ok(about) if about.is_dir() => {
            return Err(io::Error::new(ErrorKind::IsADirectory, "it is a folder"));
        }
        Ok(about) if !about.is_file() => return Ok(Destination::Stream),
        // A broken link is followed as well.
        _ => {}
    }
    let mut target = path.to_owned();
    for _ in 0..MAX_LINKS {
        if is_open_file(&target) {
            return Ok(Destination::Stream);
        }
        let Ok(link) = fs::read_link(&target) else {
            return Ok(Destination::Regular(target));
        };
        target = folder(&target).join(link);
    }
    Err(io::Error::other("too many symbolic links"))
}

/// Whether a path names an open file of a process, such as /dev/stdout: a rename cannot replace it.
fn is_open_file(path: &Path) -> bool {
    path.starts_with("/proc") || path.starts_with("/dev/fd")
}

fn open_stream(path: &Path) -> io::Result<File> {
    OpenOptions::new().append(true).open(path)
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// A new file in the same folder as `target`, with the mode of `target` if that exists.
fn create_temporary(target: &Path) -> io::Result<(File, PathBuf)> {
    let Some(name) = target.file_name() else {
        let what = "it is not the name of a file";
        return Err(io::Error::new(ErrorKind::InvalidInput, what));
    };
    let name = name.to_string_lossy();
    let temporary = target.with_file_name(format!(".{name}.{}.tmp", std::process::id()));
    let file = File::create(&temporary)?;
    if let Ok(about) = fs::metadata(target) {
        file.set_permissions(about.permissions())?;
    }
    Ok((file, temporary))
}

/// Disk operations whose order tests check.
trait Disk {
    fn sync(&mut self, file: &File) -> io::Result<()>;
    fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()>;
}

/// The real disk.
struct RealDisk;

impl Disk for RealDisk {
    fn sync(&mut self, file: &File) -> io::Result<()> {
        file.sync_all()
    }

    fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)
    }
}

/// Syncs the content before the rename: a power failure leaves the old or the new file.
fn finish(disk: &mut impl Disk, file: &File, temporary: &Path, target: &Path) -> io::Result<()> {
    disk.sync(file)?;
    disk.rename(temporary, target)?;
    if let Ok(folder) = File::open(folder(target)) {
        // Some file systems cannot sync folders; the file is complete anyway.
        let _ = disk.sync(&folder);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_output_is_there_completely_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("output");
        write(&path, b"first").unwrap();
        let failed = write_with(&path, |mut file| {
            file.write_all(b"sec")?;
            Err(io::Error::other("the source failed"))
        });
        assert_eq!(failed.unwrap_err().to_string(), "the source failed");
        assert_eq!(fs::read(&path).unwrap(), b"first");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        write(&path, b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        let error = write(folder.path(), b"").unwrap_err();
        assert_eq!(error.kind(), ErrorKind::IsADirectory);
        let error = create_new(&path).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::AlreadyExists);
    }

    /// Records the operations; fails to sync if `refuses`.
    #[derive(Default)]
    struct RecordingDisk {
        happened: Vec<&'static str>,
        refuses: bool,
    }

    impl Disk for RecordingDisk {
        fn sync(&mut self, file: &File) -> io::Result<()> {
            let is_folder = file.metadata()?.is_dir();
            self.happened
                .push(if is_folder { "folder" } else { "content" });
            match self.refuses {
                true => Err(io::Error::other("the disk is full")),
                false => file.sync_all(),
            }
        }

        fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()> {
            self.happened.push("name");
            fs::rename(from, to)
        }
    }

    #[test]
    fn the_content_is_on_the_disk_before_the_name() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("output");
        for refuses in [false, true] {
            let mut disk = RecordingDisk {
                refuses,
                ..RecordingDisk::default()
            };
            let (file, temporary) = create_temporary(&target).unwrap();
            let done = finish(&mut disk, &file, &temporary, &target);
            assert_eq!(done.is_err(), refuses);
            let expected: &[_] = match refuses {
                true => &["content"],
                false => &["content", "name", "folder"],
            };
            assert_eq!(disk.happened, expected);
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_that_lead_in_a_circle_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let [one, two] = ["one", "two"].map(|name| folder.path().join(name));
        std::os::unix::fs::symlink("two", &one).unwrap();
        std::os::unix::fs::symlink("one", &two).unwrap();
        let why = write(&one, b"").unwrap_err().to_string();
        assert_eq!(why, "too many symbolic links");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn open_files_are_written_to_as_they_are() {
        for path in ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1", "/dev/null"] {
            let destination = destination(Path::new(path)).unwrap();
            assert!(matches!(destination, Destination::Stream), "{path}");
        }
    }
}
