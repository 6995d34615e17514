//! Values that were computed last.

use crate::error::Error;
use std::sync::{Arc, Mutex, PoisonError};

/// Values that were computed last, by key.
pub(crate) struct Kept<K, V> {
    known: Mutex<Vec<(K, Arc<V>)>>,
    most: usize,
}

impl<K: PartialEq, V> Kept<K, V> {
    pub(crate) const fn new(most: usize) -> Self {
        Self { known: Mutex::new(Vec::new()), most }
    }

    /// The value of a key; computed without the lock, so that two threads may compute the same one.
    pub(crate) fn get(&self, key: K, compute: impl FnOnce() -> Result<V, Error>) -> Result<Arc<V>, Error> {
        if let Some(found) = self.find(&key) {
            return Ok(found);
        }
        let value = Arc::new(compute()?);
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if known.len() >= self.most {
            known.remove(0);
        }
        known.push((key, Arc::clone(&value)));
        Ok(value)
    }

    /// The value of a key, which becomes the last to be dropped.
    fn find(&self, key: &K) -> Option<Arc<V>> {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let at = known.iter().position(|(one, _)| one == key)?;
        known[at..].rotate_left(1);
        known.last().map(|(_, value)| Arc::clone(value))
    }
}
