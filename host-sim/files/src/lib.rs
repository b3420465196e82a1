//! Reads and writes the files of all commands; bad input becomes a sentence.

pub mod error;
pub mod hex;
mod reading;
mod stream;
pub mod table;
pub mod toml_reader;
mod writing;

pub use reading::{MAX_INPUT_BYTES, open_regular, read, read_text, unreadable};
pub use writing::{create_new, save, unwritable, write};
