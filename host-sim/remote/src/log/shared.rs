//! A log that several write on: the mind's tap, whoever sees the robot move, whoever carries out orders.

use super::write::Log;
use std::io::{Seek, Write};
use std::sync::{Arc, Mutex, PoisonError};

/// A log shared by its writers.
pub struct SharedLog<W: Write + Seek>(Arc<Mutex<Log<W>>>);

impl<W: Write + Seek> Clone for SharedLog<W> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<W: Write + Seek> SharedLog<W> {
    /// Shares a log.
    #[must_use]
    pub fn new(log: Log<W>) -> Self {
        Self(Arc::new(Mutex::new(log)))
    }

    /// Writes; nobody else does meanwhile.
    pub fn write<T>(&self, what: impl FnOnce(&mut Log<W>) -> T) -> T {
        // A log is whole between any two of its methods.
        what(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Ends the log: the last chunk, the index. Whatever is written later is dropped.
    ///
    /// # Errors
    /// What went wrong, now or before.
    pub fn finish(&self) -> Result<(), String> {
        self.write(Log::finish)
    }
}
