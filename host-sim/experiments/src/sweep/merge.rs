//! Merges the results of shards into those of the whole sweep.

use super::results::{ResultsHeader, number_of, read_row};
use files::error::BadInput;
use files::{open_regular, unreadable};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::fs::File;
use std::io::{BufReader, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

/// Result files of shards that form one whole sweep.
#[derive(Debug)]
pub struct Merged {
    header: ResultsHeader,
    parts: Vec<ShardFile>,
}

/// One file, and its next row.
#[derive(Debug)]
struct ShardFile {
    path: PathBuf,
    input: BufReader<File>,
    row: Vec<u8>,
}

/// Checks that the files hold every episode of one sweep exactly once.
///
/// # Errors
/// A file that cannot be read, is no results file or is still being written; results of different
/// sweeps; a torn row; a missing or duplicate episode.
pub fn merge(paths: &[PathBuf]) -> Result<Merged, BadInput> {
    let mut found: Option<(ResultsHeader, &Path)> = None;
    let mut parts = Vec::new();
    for path in paths {
        let (header, part) = ShardFile::open(path)?;
        match &found {
            Some((first, other)) if *first != header => {
                let what = format!(
                    "holds results of another sweep ({}) than {} ({})",
                    header.identity(),
                    other.display(),
                    first.identity()
                );
                return Err(BadInput::file(path, what));
            }
            Some(_) => {}
            None => found = Some((header, path)),
        }
        parts.push(part);
    }
    let (header, _) =
        found.ok_or_else(|| BadInput::new("merge takes at least one results file"))?;
    let mut merged = Merged { header, parts };
    merged.rows(&mut |_| Ok::<_, BadInput>(()))?;
    Ok(merged)
}

impl Merged {
    /// The header of the whole sweep's results.
    #[must_use]
    pub fn header(&self) -> &ResultsHeader {
        &self.header
    }

    /// Passes all rows to `sink` in the order of their numbers.
    ///
    /// # Errors
    /// The first error of `sink`; a file that has changed since the check.
    pub fn rows<E: From<BadInput>>(
        &mut self,
        sink: &mut impl FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut next = BinaryHeap::new();
        for (index, part) in self.parts.iter_mut().enumerate() {
            part.rewind(self.header.text().len())?;
            next.extend(part.advance(None)?.map(|number| Reverse((number, index))));
        }
        let mut last: Option<usize> = None;
        for expected in 0..self.header.episodes() {
            let found = next.pop().map(|Reverse(found)| found);
            match found {
                Some((number, index)) if number == expected => {
                    if let Some(part) = self.parts.get_mut(index) {
                        sink(&part.row)?;
                        next.extend(
                            part.advance(Some(number))?
                                .map(|number| Reverse((number, index))),
                        );
                    }
                    last = Some(index);
                }
                Some((number, index)) if number < expected => {
                    return Err(self.double(number, index, last).into());
                }
                _ => return Err(self.gap(expected).into()),
            }
        }
        match next.pop() {
            Some(Reverse((number, index))) => Err(self.surplus(number, index, last).into()),
            None => Ok(()),
        }
    }

    /// A row after the last episode.
    fn surplus(&self, number: u64, index: usize, last: Option<usize>) -> BadInput {
        if number < self.header.episodes() {
            return self.double(number, index, last);
        }
        let what = format!(
            "episode {number} is not one of this sweep's {}",
            self.header.episodes()
        );
        BadInput::file(self.path(index), what)
    }

    fn path(&self, index: usize) -> &Path {
        self.parts
            .get(index)
            .map(|part| part.path.as_path())
            .unwrap_or(Path::new(""))
    }

    fn double(&self, number: u64, index: usize, last: Option<usize>) -> BadInput {
        let other = last.map_or(Path::new(""), |last| self.path(last));
        let what = format!("episode {number} is in {} as well", other.display());
        BadInput::file(self.path(index), what)
    }

    fn gap(&self, number: u64) -> BadInput {
        let names: Vec<_> = self
            .parts
            .iter()
            .take(8)
            .map(|part| part.path.display().to_string())
            .collect();
        let more = if self.parts.len() > names.len() {
            ", …"
        } else {
            ""
        };
        BadInput::new(format!(
            "episode {number} of {} is missing in {}{more}",
            self.header.episodes(),
            names.join(", ")
        ))
    }
}

impl ShardFile {
    fn open(path: &Path) -> Result<(ResultsHeader, Self), BadInput> {
        let file = open_regular(path)?;
        if let Err(std::fs::TryLockError::WouldBlock) = file.try_lock_shared() {
            let what = "a sweep is still adding results to it";
            return Err(BadInput::file(path, what));
        }
        let mut input = BufReader::new(file);
        let header = ResultsHeader::read(path, &mut input)?;
        let row = Vec::new();
        Ok((
            header,
            Self {
                path: path.to_owned(),
                input,
                row,
            },
        ))
    }

    fn rewind(&mut self, to: usize) -> Result<(), BadInput> {
        let moved = self.input.seek(SeekFrom::Start(to as u64));
        moved
            .map(|_| ())
            .map_err(|error| unreadable(&self.path, &error))
    }

    /// Reads the next row; returns its number, or `None` at the end of the file.
    fn advance(&mut self, last: Option<u64>) -> Result<Option<u64>, BadInput> {
        let whole = read_row(&mut self.input, &mut self.row);
        if !whole.map_err(|error| unreadable(&self.path, &error))? {
            if self.row.is_empty() {
                return Ok(None);
            }
            let what = format!("{} is torn: resume the sweep", place(last));
            return Err(BadInput::file(&self.path, what));
        }
        match (number_of(&self.row), last) {
            (None, last) => {
                let what = format!("{} is not a row of results", place(last));
                Err(BadInput::file(&self.path, what))
            }
            (Some(number), Some(last)) if number <= last => {
                let what = format!("episode {number} follows episode {last}");
                Err(BadInput::file(&self.path, what))
            }
            (number, _) => Ok(number),
        }
    }
}

fn place(last: Option<u64>) -> String {
    last.map_or("the first row".to_owned(), |last| {
        format!("the row after episode {last}")
    })
}

#[cfg(test)]
mod tests;
