//! Tables that materials have in common.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::sync::{Mutex, PoisonError};

/// Tables by what they are made of. Each is made the first time that it is asked for, and kept for the rest
/// of the program, so that a BSDF of numbers may point to it.
pub(super) struct Kept<K: 'static, T: 'static>(Mutex<BTreeMap<K, &'static T>>);

impl<K: Ord, T> Kept<K, T> {
    pub const fn new() -> Self {
        Self(Mutex::new(BTreeMap::new()))
    }

    /// The table of a key.
    pub fn get(&self, key: K, make: impl FnOnce() -> T) -> &'static T {
        let Ok(table) = self.try_get(key, || Ok::<T, Infallible>(make()));
        table
    }

    /// The same where a table may fail to be made.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn try_get<E>(&self, key: K, make: impl FnOnce() -> Result<T, E>) -> Result<&'static T, E> {
        // A map in which a table is missing is still a map.
        let tables = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = tables().get(&key).copied();
        if let Some(known) = known {
            return Ok(known);
        }
        // Not under the lock: a thread that waits for others takes up work that may ask for a table.
        let made = make()?;
        Ok(tables().entry(key).or_insert_with(|| Box::leak(Box::new(made))))
    }
}
