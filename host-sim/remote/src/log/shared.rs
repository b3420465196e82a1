//! A log with several writers, behind a lock.

use super::write::LogWriter;
use std::io::{Seek, Write};
use std::sync::{Arc, Mutex, PoisonError};

/// A log with several writers.
pub struct SharedLog<W: Write + Seek>(Arc<Mutex<LogWriter<W>>>);

impl<W: Write + Seek> Clone for SharedLog<W> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<W: Write + Seek> SharedLog<W> {
    /// Shares a log.
    #[must_use]
    pub fn new(log: LogWriter<W>) -> Self {
        Self(Arc::new(Mutex::new(log)))
    }

    /// Locks the log and writes.
    pub fn write<T>(&self, what: impl FnOnce(&mut LogWriter<W>) -> T) -> T {
        // A panic leaves the log valid: each method writes whole messages.
        what(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Ends the log with the last chunk and the index. Later writes are ignored.
    ///
    /// # Errors
    /// What went wrong, now or before.
    pub fn finish(&self) -> Result<(), String> {
        self.write(LogWriter::finish)
    }
}
