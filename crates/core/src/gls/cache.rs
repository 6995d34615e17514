//! Cache of the values that were computed last.

use crate::error::Error;
use std::sync::{Arc, Mutex, PoisonError};

/// The values that were computed last, by key.
pub(crate) struct Cache<K, V> {
    entries: Mutex<Vec<(K, Arc<V>)>>,
    max_entries: usize,
}

impl<K: PartialEq, V> Cache<K, V> {
    pub(crate) const fn new(max_entries: usize) -> Self {
        Self { entries: Mutex::new(Vec::new()), max_entries }
    }

    /// The value of a key. It is computed without the lock, so that two threads may compute the same value.
    pub(crate) fn get(&self, key: K, compute: impl FnOnce() -> Result<V, Error>) -> Result<Arc<V>, Error> {
        if let Some(value) = self.find(&key) {
            return Ok(value);
        }
        let value = Arc::new(compute()?);
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        if entries.len() >= self.max_entries {
            entries.remove(0);
        }
        entries.push((key, Arc::clone(&value)));
        Ok(value)
    }

    /// The value of a key, which becomes the most recent one.
    fn find(&self, key: &K) -> Option<Arc<V>> {
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        let index = entries.iter().position(|(other, _)| other == key)?;
        entries[index..].rotate_left(1);
        entries.last().map(|(_, value)| Arc::clone(value))
    }
}
