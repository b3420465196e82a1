//! Reads input files: regular files up to a size limit, and streams that end.
//!
//! Refuses folders, FIFOs without a writer and streams without end.

use crate::error::BadInput;
use crate::stream::read_stream;
use std::fs::{self, File, Metadata};
use std::io::{self, ErrorKind, Read as _};
use std::path::Path;

/// Default size limit of an input file, bytes.
pub const MAX_INPUT_BYTES: u64 = 256 << 20;

/// Reads an input file.
///
/// # Errors
/// A missing or unreadable file, a folder, more than `limit` bytes, a stream that times out.
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

/// Reads a text file.
///
/// # Errors
/// As [`read`]; bytes that are not UTF-8, or NUL characters.
pub fn read_text(path: &Path, limit: u64) -> Result<String, BadInput> {
    match String::from_utf8(read(path, limit)?) {
        Ok(text) if !text.contains('\0') => Ok(text),
        _ => Err(BadInput::file(path, "is not a text file")),
    }
}

/// Opens a regular file that is too large for memory.
///
/// # Errors
/// When it is missing, unreadable or no regular file.
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

/// Reads at most one byte more than `limit`.
fn read_regular(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let file = File::open(path)?;
    if file.metadata()?.len() > limit {
        // Too large: the content does not matter.
        return Ok(vec![0; limit as usize + 1]);
    }
    file.take(limit + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
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
}
