//! The file of a sweep's results: two header lines, then one CSV row per episode in order.
//!
//! Rows are only appended. After a crash the file has whole rows and at most one torn row, which is
//! cut off before the next write. A field with a line feed (a world's name) is quoted.

use super::Shard;
use files::error::BadInput;
use files::unreadable;
use sim::episode::EpisodeReport;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufRead, BufReader, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest time between two syncs to disk: the most that a power failure can lose.
const SYNC_EVERY: Duration = Duration::from_secs(5);
/// Longest header, bytes.
const MAX_HEAD: u64 = 1 << 20;
/// Start of the first line.
const MARK: &str = "# host-sim sweep ";

/// The first two lines of a results file: sweep with version and hash, and the columns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ResultsHeader {
    text: String,
    episodes: u64,
}

impl ResultsHeader {
    /// The header of the sweep `name` with this hash.
    pub fn new(
        name: &str,
        hash: &str,
        episodes: u64,
        columns: impl Iterator<Item = String>,
    ) -> Self {
        let version = env!("CARGO_PKG_VERSION");
        let columns: Vec<_> = std::iter::once("episode".to_owned())
            .chain(columns)
            .collect();
        let columns = columns.join(",");
        Self {
            text: format!(
                "{MARK}{name}, hash {hash}, version {version}, {episodes} episodes\n{columns}\n"
            ),
            episodes,
        }
    }

    /// Both lines with their line feeds.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The line that identifies the sweep.
    #[must_use]
    pub fn identity(&self) -> &str {
        self.text
            .lines()
            .next()
            .unwrap_or_default()
            .trim_start_matches("# ")
    }

    /// The names of the columns.
    pub fn columns(&self) -> impl Iterator<Item = &str> {
        self.text.lines().nth(1).unwrap_or_default().split(',')
    }

    /// Number of the sweep's episodes.
    #[must_use]
    pub fn episodes(&self) -> u64 {
        self.episodes
    }

    /// Reads the header of the file `path`.
    ///
    /// # Errors
    /// When it cannot be read or has no such header.
    pub fn read(path: &Path, input: &mut impl BufRead) -> Result<Self, BadInput> {
        let stranger = || BadInput::file(path, "is not a results file of `host-sim sweep`");
        let mut text = String::new();
        let mut head = input.take(MAX_HEAD);
        for _ in 0..2 {
            head.read_line(&mut text)
                .map_err(|error| match error.kind() {
                    io::ErrorKind::InvalidData => stranger(),
                    _ => unreadable(path, &error),
                })?;
        }
        let episodes = text.strip_prefix(MARK).and_then(|rest| {
            let (first, columns) = rest.split_once('\n')?;
            let whole = columns.starts_with("episode,") && columns.ends_with('\n');
            let (_, count) = first.strip_suffix(" episodes")?.rsplit_once(' ')?;
            count.parse().ok().filter(|_| whole)
        });
        Ok(Self {
            episodes: episodes.ok_or_else(stranger)?,
            text,
        })
    }
}

/// Reads the next row with its line feed into `row`; returns whether it is whole. An empty row
/// means the end of the file.
///
/// # Errors
/// When the input cannot be read.
pub fn read_row(input: &mut impl BufRead, row: &mut Vec<u8>) -> io::Result<bool> {
    row.clear();
    let mut quotes = 0;
    loop {
        let from = row.len();
        let count = input.read_until(b'\n', row)?;
        let new = row.get(from..).unwrap_or_default();
        quotes += new.iter().filter(|&&byte| byte == b'"').count();
        match row.last() {
            Some(b'\n') if quotes % 2 == 0 && count > 0 => return Ok(true),
            _ if count == 0 => return Ok(false),
            _ => {}
        }
    }
}

/// The episode's number at the start of a row.
#[must_use]
pub fn number_of(row: &[u8]) -> Option<u64> {
    let digits = row.split(|&byte| byte == b',').next()?;
    std::str::from_utf8(digits).ok()?.parse().ok()
}

/// Formats a row: the episode's number, its point's values, its metrics.
///
/// # Errors
/// None in practice: CSV can hold every value.
pub fn row(number: u64, cells: &[String], report: &EpisodeReport) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::WriterBuilder::new()
        .has_headers(false)
        .from_writer(Vec::new());
    writer.serialize((number, cells, report))?;
    writer
        .into_inner()
        .map_err(|error| error.into_error().into())
}

/// A results file opened for appending, locked against other writers.
#[derive(Debug)]
pub struct ResultsFile {
    file: File,
    path: PathBuf,
    synced: Instant,
}

impl ResultsFile {
    /// Opens or creates the file of a shard and cuts off a torn row. Returns how many of the
    /// shard's episodes it holds.
    ///
    /// # Errors
    /// When it cannot be created, read or written, is locked by another process, or holds anything
    /// but the first episodes of this shard of this sweep.
    pub fn open(
        path: &Path,
        header: &ResultsHeader,
        shard: Shard,
    ) -> Result<(Self, u64), BadInput> {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
        }
        let file = open_locked(path)?;
        let (whole, done) = scan_rows(path, &file, header, shard)?;
        let mut results = Self {
            file,
            path: path.to_owned(),
            synced: Instant::now(),
        };
        results
            .cut(whole)
            .map_err(|error| unwritable(path, &error))?;
        if whole == 0 {
            results.add(header.text().as_bytes())?;
        }
        Ok((results, done))
    }

    fn cut(&mut self, length: u64) -> io::Result<()> {
        self.file.set_len(length)?;
        self.file.seek(SeekFrom::Start(length))?;
        Ok(())
    }

    /// Appends a whole row.
    ///
    /// # Errors
    /// When it cannot be written completely.
    pub fn add(&mut self, row: &[u8]) -> Result<(), BadInput> {
        self.file
            .write_all(row)
            .map_err(|error| unwritable(&self.path, &error))?;
        if self.synced.elapsed() < SYNC_EVERY {
            return Ok(());
        }
        self.synced = Instant::now();
        self.file
            .sync_data()
            .map_err(|error| unwritable(&self.path, &error))
    }

    /// Writes all data to the disk.
    ///
    /// # Errors
    /// When that fails.
    pub fn finish(self) -> Result<(), BadInput> {
        self.file
            .sync_all()
            .map_err(|error| unwritable(&self.path, &error))
    }
}

fn open_locked(path: &Path) -> Result<File, BadInput> {
    let opened = OpenOptions::new()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .open(path);
    let file = opened.map_err(|error| unwritable(path, &error))?;
    if !file.metadata().is_ok_and(|about| about.is_file()) {
        return Err(BadInput::file(
            path,
            "is not a file that results can be added to",
        ));
    }
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => {
            let what = "another process is adding results to it";
            Err(BadInput::file(path, what))
        }
        // Some network file systems have no locks.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
    }
}

fn unwritable(path: &Path, error: &io::Error) -> BadInput {
    BadInput::file(path, format!("cannot be written: {error}"))
}

fn another_sweep(path: &Path, input: &mut impl BufRead, header: &ResultsHeader) -> BadInput {
    let other = match ResultsHeader::read(path, input) {
        Ok(other) => other,
        Err(error) => return error,
    };
    let what = format!(
        "holds results of another sweep ({}), not of {}",
        other.identity(),
        header.identity()
    );
    BadInput::file(path, what)
}

/// Length of the whole rows, and their number.
fn scan_rows(
    path: &Path,
    file: &File,
    header: &ResultsHeader,
    shard: Shard,
) -> Result<(u64, u64), BadInput> {
    let mut input = BufReader::new(file);
    let mut start = Vec::new();
    let length = header.text().len() as u64;
    let read = input.by_ref().take(length).read_to_end(&mut start);
    read.map_err(|error| unreadable(path, &error))?;
    if start != header.text().as_bytes() {
        // The process was killed while it wrote the header.
        if header.text().as_bytes().starts_with(&start) {
            return Ok((0, 0));
        }
        input.rewind().map_err(|error| unreadable(path, &error))?;
        return Err(another_sweep(path, &mut input, header));
    }
    let (mut whole, mut done) = (length, 0);
    let mut row = Vec::new();
    while read_row(&mut input, &mut row).map_err(|error| unreadable(path, &error))? {
        let expected = shard.number(done);
        let found = number_of(&row);
        if found != Some(expected) || expected >= header.episodes() {
            let found = found.map_or("no episode".to_owned(), |number| {
                format!("episode {number}")
            });
            let what = format!(
                "row {} holds {found}, but shard {shard} of this sweep has episode {expected} there",
                done + 1
            );
            return Err(BadInput::file(path, what));
        }
        whole += row.len() as u64;
        done += 1;
    }
    Ok((whole, done))
}

#[cfg(test)]
mod tests;
