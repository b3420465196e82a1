//! A part of a snapshot, as a message for viewers.

use serde::Serialize;
use std::sync::{Arc, OnceLock};

/// A part with its revision.
pub struct SnapshotPart<T> {
    name: &'static str,
    index: u64,
    revision: u64,
    pub(super) value: T,
    text: OnceLock<Arc<str>>,
}

impl<T: Serialize> SnapshotPart<T> {
    /// A part; a higher revision of the same name and index is newer.
    #[must_use]
    pub fn new(name: &'static str, index: u64, revision: u64, value: T) -> Self {
        Self {
            name,
            index,
            revision,
            value,
            text: OnceLock::new(),
        }
    }
}

impl<T: Serialize + PartialEq + Send + Sync + 'static> SnapshotPart<T> {
    /// The part with this value that was kept, or a new one, which is kept.
    pub(super) fn kept(
        kept: &mut Option<Arc<Self>>,
        name: &'static str,
        revision: u64,
        value: T,
    ) -> Arc<dyn PartMessage> {
        let part = match kept.take().filter(|part| part.value == value) {
            Some(part) => part,
            None => Arc::new(Self::new(name, 0, revision, value)),
        };
        *kept = Some(Arc::clone(&part));
        part
    }
}

/// A part of any type, as a viewer's task needs it.
pub trait PartMessage: Send + Sync {
    /// Name and index.
    fn key(&self) -> (&'static str, u64);
    /// Increases with each change.
    fn revision(&self) -> u64;
    /// The JSON text, built on the first call.
    fn text(&self) -> Arc<str>;
}

impl<T: Serialize + Send + Sync> PartMessage for SnapshotPart<T> {
    fn key(&self) -> (&'static str, u64) {
        (self.name, self.index)
    }

    fn revision(&self) -> u64 {
        self.revision
    }

    fn text(&self) -> Arc<str> {
        let make = || message(self.name, self.index, &self.value).into();
        Arc::clone(self.text.get_or_init(make))
    }
}

/// The JSON text of a part.
pub fn message(part: &str, index: u64, value: &impl Serialize) -> String {
    #[derive(Serialize)]
    struct Message<'a, T> {
        part: &'a str,
        index: u64,
        value: &'a T,
    }
    // Structs of numbers and texts always serialize.
    serde_json::to_string(&Message { part, index, value }).unwrap_or_default()
}
