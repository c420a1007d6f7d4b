//! What every step of an import shares: the file's name for errors, the warnings so far, and the memory budget.

use std::collections::BTreeSet;
use std::path::Path;

use crate::error::{Error, Result, Warning, over_limit};

/// State of one import.
#[derive(Debug)]
pub(super) struct Context<'a> {
    /// The scene file.
    pub(super) path: &'a Path,
    limit_bytes: u64,
    used_bytes: u64,
    warnings: Vec<Warning>,
    warned: BTreeSet<String>,
    /// Whether clips may move properties of materials, so that what has no effect at first must be kept.
    pub(super) animates_properties: bool,
}

impl<'a> Context<'a> {
    pub(super) fn new(path: &'a Path, limit_bytes: u64) -> Self {
        Self {
            path,
            limit_bytes,
            used_bytes: 0,
            warnings: Vec::new(),
            warned: BTreeSet::new(),
            animates_properties: false,
        }
    }

    /// A wrong value at `pointer`.
    pub(super) fn invalid(&self, pointer: impl Into<String>, message: impl Into<String>) -> Error {
        Error::invalid(self.path, pointer, message)
    }

    /// A feature that is not supported, asked for at `pointer`.
    pub(super) fn unsupported(&self, pointer: impl Into<String>, message: impl Into<String>) -> Error {
        Error::unsupported(self.path, pointer, message)
    }

    /// A limit or a safety rule that `pointer` breaks.
    pub(super) fn refused(&self, pointer: impl Into<String>, message: impl Into<String>) -> Error {
        Error::refused(self.path, pointer, message)
    }

    /// Notes something that is not honoured; the same message is noted once, at its first place.
    pub(super) fn warn(&mut self, pointer: impl Into<String>, message: impl Into<String>) {
        let message = message.into();
        if self.warned.insert(message.clone()) {
            self.warnings.push(Warning { pointer: pointer.into(), message });
        }
    }

    /// Claims memory for what `pointer` asks for, before it is allocated.
    pub(super) fn charge(&mut self, bytes: u64, pointer: &str) -> Result<()> {
        let total = self.used_bytes.saturating_add(bytes);
        if total > self.limit_bytes {
            return Err(self.too_large(total, pointer));
        }
        self.used_bytes = total;
        Ok(())
    }

    /// An empty list with room for `count` values, claimed from the budget; refused rather than aborted when the
    /// system has no such memory.
    pub(super) fn allocate<T>(&mut self, count: u64, pointer: &str) -> Result<Vec<T>> {
        let bytes = count.saturating_mul(size_of::<T>() as u64);
        self.charge(bytes, pointer)?;
        let mut list = Vec::new();
        let reserved = usize::try_from(count).ok().and_then(|count| list.try_reserve_exact(count).ok());
        match reserved {
            Some(()) => Ok(list),
            None => Err(self.too_large(bytes, pointer)),
        }
    }

    /// Bytes that may be claimed in all.
    pub(super) fn limit_bytes(&self) -> u64 {
        self.limit_bytes
    }

    /// Bytes claimed so far.
    pub(super) fn used_bytes(&self) -> u64 {
        self.used_bytes
    }

    /// Gives back what was claimed since `used_before` except `kept_bytes`, once the rest is no longer in memory.
    pub(super) fn settle(&mut self, used_before: u64, kept_bytes: u64) {
        let kept = used_before.saturating_add(kept_bytes);
        if kept < self.used_bytes {
            self.used_bytes = kept;
        }
    }

    /// Bytes that may still be claimed.
    pub(super) fn remaining_bytes(&self) -> u64 {
        self.limit_bytes.saturating_sub(self.used_bytes)
    }

    /// The refusal of something that needs `total_bytes` in all.
    pub(super) fn too_large(&self, total_bytes: u64, pointer: &str) -> Error {
        self.refused(
            pointer,
            format!(
                "all up to here needs about {}; raise --max-memory",
                over_limit(total_bytes.into(), self.limit_bytes.into())
            ),
        )
    }

    /// `index` as a subscript of a list of `length`.
    pub(super) fn subscript(&self, index: usize, length: usize, pointer: &str, what: &str) -> Result<usize> {
        if index < length {
            return Ok(index);
        }
        Err(self.invalid(pointer, format!("there is no {what} {index}, the file has {length}")))
    }

    pub(super) fn into_warnings(self) -> Vec<Warning> {
        self.warnings
    }
}
