//! Input files and output files of all commands.
//!
//! An input file is read whole, up to a size bound. It is a regular file or a stream that ends; a folder, a FIFO without a
//! writer and a device without end are refused.
//!
//! An output file appears completely or not at all: a temporary neighbor is written, brought to the disk and renamed. The
//! mode of an existing file is kept, a symbolic link is followed, and a device or FIFO is written to as it is.

pub mod error;
pub mod hex;
pub mod table;
pub mod toml_reader;

use error::BadInput;
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};

/// Largest input file of a reader without a bound of its own, bytes.
pub const MAX_INPUT_BYTES: u64 = 256 << 20;

/// How long a stream is waited for.
const STREAM_LIMITS: StreamLimits = StreamLimits {
    writer: Duration::from_secs(5),
    silence: Duration::from_secs(60),
    whole: Duration::from_secs(10 * 60),
};

/// Bytes of a stream read at once.
const STREAM_CHUNK_BYTES: usize = 1 << 16;

/// Most symbolic links on the way to a file, as in the Linux kernel.
const MAX_LINKS: u32 = 40;

/// The bytes of an input file.
///
/// # Errors
/// A file that is absent, unreadable, a folder or larger than `limit` bytes, or a stream that does not deliver.
pub fn read(path: &Path, limit: u64) -> Result<Vec<u8>, BadInput> {
    let about = metadata(path)?;
    let bytes = if about.is_dir() {
        return Err(BadInput::file(path, "is a folder, not a file"));
    } else if about.is_file() {
        read_regular(path, limit)
    } else {
        read_stream(path, limit)
    };
    let bytes = bytes.map_err(|error| unreadable(path, &error))?;
    if bytes.len() as u64 > limit {
        return Err(BadInput::file(
            path,
            format!("is larger than {}", size(limit)),
        ));
    }
    Ok(bytes)
}

/// The text of an input file.
///
/// # Errors
/// As [`read`]; bytes that are not UTF-8, or NUL characters.
pub fn read_text(path: &Path, limit: u64) -> Result<String, BadInput> {
    match String::from_utf8(read(path, limit)?) {
        Ok(text) if !text.contains('\0') => Ok(text),
        _ => Err(BadInput::file(path, "is not a text file")),
    }
}

/// Opens an input file that is too large to be read whole: a regular file.
///
/// # Errors
/// When it is absent, unreadable or anything else than a regular file.
pub fn open_regular(path: &Path) -> Result<File, BadInput> {
    let about = metadata(path)?;
    if about.is_dir() {
        return Err(BadInput::file(path, "is a folder, not a file"));
    }
    if !about.is_file() {
        return Err(BadInput::file(path, "is not a regular file"));
    }
    File::open(path).map_err(|error| unreadable(path, &error))
}

/// An error about an input file.
pub fn unreadable(path: &Path, error: &io::Error) -> BadInput {
    match error.kind() {
        ErrorKind::NotFound => BadInput::file(path, "there is no such file"),
        _ => BadInput::file(path, format!("cannot be read: {error}")),
    }
}

fn metadata(path: &Path) -> Result<Metadata, BadInput> {
    fs::metadata(path).map_err(|error| unreadable(path, &error))
}

fn size(bytes: u64) -> String {
    format!("{} MiB", bytes.div_ceil(1 << 20))
}

/// At most one byte more than `limit`.
fn read_regular(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let file = File::open(path)?;
    if file.metadata()?.len() > limit {
        // Too large already: the content does not matter.
        return Ok(vec![0; limit as usize + 1]);
    }
    file.take(limit + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// How long a stream is waited for.
struct StreamLimits {
    /// Longest wait for a writer at the other end of a FIFO.
    writer: Duration,
    /// Longest silence.
    silence: Duration,
    /// Longest time from its beginning to its end.
    whole: Duration,
}

/// What a stream's thread reports.
enum StreamEvent {
    Opened,
    Chunk(Vec<u8>),
    End,
}

/// At most one chunk more than `limit`. Opening and reading may block for ever, so a thread of their own does both.
fn read_stream(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let (sender, receiver) = sync_channel(1);
    let path = path.to_owned();
    std::thread::spawn(move || {
        if let Err(error) = send_stream(&path, &sender) {
            // The receiver may have given up.
            let _ = sender.send(Err(error));
        }
    });
    collect_stream(&receiver, limit, &STREAM_LIMITS)
}

fn send_stream(path: &Path, to: &SyncSender<io::Result<StreamEvent>>) -> io::Result<()> {
    let mut file = File::open(path)?;
    let mut is_wanted = to.send(Ok(StreamEvent::Opened)).is_ok();
    while is_wanted {
        let mut chunk = vec![0; STREAM_CHUNK_BYTES];
        let count = file.read(&mut chunk)?;
        chunk.truncate(count);
        let event = match count {
            0 => StreamEvent::End,
            _ => StreamEvent::Chunk(chunk),
        };
        is_wanted = to.send(Ok(event)).is_ok() && count > 0;
    }
    Ok(())
}

fn collect_stream(
    from: &Receiver<io::Result<StreamEvent>>,
    limit: u64,
    limits: &StreamLimits,
) -> io::Result<Vec<u8>> {
    let timed_out = |why: String| Err(io::Error::new(ErrorKind::TimedOut, why));
    let mut bytes = Vec::new();
    // When the stream has to end, once it has begun.
    let mut end: Option<Instant> = None;
    while bytes.len() as u64 <= limit {
        let left = end.map(|end| end.saturating_duration_since(Instant::now()));
        if left == Some(Duration::ZERO) {
            let seconds = limits.whole.as_secs();
            return timed_out(format!("it has not ended within {seconds} s"));
        }
        let patience = left.map_or(limits.writer, |left| left.min(limits.silence));
        match from.recv_timeout(patience) {
            Ok(Ok(StreamEvent::Opened)) => end = Some(Instant::now() + limits.whole),
            Ok(Ok(StreamEvent::Chunk(chunk))) => bytes.extend(chunk),
            Ok(Ok(StreamEvent::End)) | Err(RecvTimeoutError::Disconnected) => break,
            Ok(Err(error)) => return Err(error),
            Err(RecvTimeoutError::Timeout) if left.is_none() => {
                return timed_out("no program writes to it".to_owned());
            }
            Err(RecvTimeoutError::Timeout) if patience == limits.silence => {
                let seconds = limits.silence.as_secs();
                return timed_out(format!("nothing has come from it for {seconds} s"));
            }
            // Its time is over.
            Err(RecvTimeoutError::Timeout) => {}
        }
    }
    Ok(bytes)
}

/// Where the bytes for an output file go.
enum Destination {
    /// A regular file, which may not exist yet; symbolic links are resolved.
    Regular(PathBuf),
    /// A device, a FIFO or an open file of this process: written to as it is.
    Stream,
}

/// Writes an output file.
///
/// # Errors
/// When it cannot be written completely; an older file of that name stays as it was.
pub fn write(path: &Path, content: &[u8]) -> io::Result<()> {
    write_with(path, |mut file| file.write_all(content))
}

/// Writes one file of this name into a folder, as [`write`](write()); returns its path.
///
/// # Errors
/// When it cannot be written; an older file of that name stays as it was.
pub fn save(folder: &Path, name: &str, content: &[u8]) -> Result<PathBuf, BadInput> {
    let path = folder.join(name);
    match write(&path, content) {
        Ok(()) => Ok(path),
        Err(error) => Err(unwritable(&path, &error)),
    }
}

/// Why a file or folder cannot be written, as a sentence.
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
    let written = fill(&file).and_then(|()| finish(&mut System, &file, &temporary, &target));
    if written.is_err() {
        // The first error is the one to report.
        let _ = fs::remove_file(&temporary);
    }
    written
}

/// Creates an output file that is written piece by piece. A device or FIFO is opened as it is.
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
        // A broken link is followed like any other.
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

/// Whether a path names an open file of a process, as /dev/stdout does: renaming cannot replace that.
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

/// A new file beside `target`, with the mode of `target` if that exists.
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

/// What has to happen in a certain order, so that tests can look on.
trait Disk {
    fn sync(&mut self, file: &File) -> io::Result<()>;
    fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()>;
}

/// The disk as it is.
struct System;

impl Disk for System {
    fn sync(&mut self, file: &File) -> io::Result<()> {
        file.sync_all()
    }

    fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)
    }
}

/// Brings the content to the disk before the name, so that a power failure leaves the old file or the new one.
fn finish(disk: &mut impl Disk, file: &File, temporary: &Path, target: &Path) -> io::Result<()> {
    disk.sync(file)?;
    disk.rename(temporary, target)?;
    if let Ok(folder) = File::open(folder(target)) {
        // Some file systems cannot do this; the file is complete all the same.
        let _ = disk.sync(&folder);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_are_read_up_to_their_bound() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("input");
        let say = |limit| read(&path, limit).unwrap_err().to_string();
        assert!(say(4).ends_with("input: there is no such file"));
        fs::write(&path, "1234").unwrap();
        assert_eq!(read(&path, 4).unwrap(), b"1234");
        assert!(say(3).ends_with("input: is larger than 1 MiB"));
        assert_eq!(read_text(&path, 4).unwrap(), "1234");
        for content in [&[0x89, 0x50, 0xff][..], b"1,2\n\0,3\n"] {
            fs::write(&path, content).unwrap();
            let why = read_text(&path, 100).unwrap_err().to_string();
            assert!(why.ends_with("input: is not a text file"), "{why}");
        }
        let why = read(folder.path(), 4).unwrap_err().to_string();
        assert!(why.ends_with("is a folder, not a file"), "{why}");
        let why = open_regular(folder.path()).unwrap_err().to_string();
        assert!(why.ends_with("is a folder, not a file"), "{why}");
    }

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

    /// A stream from which a byte comes every 10 ms, without end.
    fn trickle() -> Receiver<io::Result<StreamEvent>> {
        let (sender, receiver) = sync_channel(1);
        std::thread::spawn(move || {
            let mut next = StreamEvent::Opened;
            while sender.send(Ok(next)).is_ok() {
                std::thread::sleep(Duration::from_millis(10));
                next = StreamEvent::Chunk(vec![0]);
            }
        });
        receiver
    }

    #[test]
    fn a_stream_without_end_is_given_up_however_slowly_it_comes() {
        let limits = |silence_ms, whole_ms| StreamLimits {
            writer: Duration::from_secs(5),
            silence: Duration::from_millis(silence_ms),
            whole: Duration::from_millis(whole_ms),
        };
        let began = Instant::now();
        let given_up = collect_stream(&trickle(), 1_000, &limits(60_000, 1_000));
        let why = given_up.unwrap_err().to_string();
        assert_eq!(why, "it has not ended within 1 s");
        assert!(began.elapsed() < Duration::from_secs(3));
        let given_up = collect_stream(&trickle(), 1_000, &limits(1, 60_000));
        let why = given_up.unwrap_err().to_string();
        assert!(why.starts_with("nothing has come from it for"), "{why}");
        let read = collect_stream(&trickle(), 3, &limits(60_000, 60_000));
        assert_eq!(read.unwrap(), [0; 4]);
        assert_eq!(STREAM_LIMITS.whole, Duration::from_secs(600));
    }

    /// Writes down what happens, and refuses to sync if it is told so.
    #[derive(Default)]
    struct Noted {
        happened: Vec<&'static str>,
        refuses: bool,
    }

    impl Disk for Noted {
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
            let mut disk = Noted {
                refuses,
                ..Noted::default()
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
