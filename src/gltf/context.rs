//! Import context, shared by all import steps: file path for errors, warnings so far, memory budget.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::error::{Error, Result, Warning, over_limit, readable_bytes};
use crate::scene::{SceneMemory, VariantIndex, VariantWarning};

/// State of one import.
#[derive(Debug)]
pub(super) struct Context<'a> {
    /// Path of the scene file.
    pub(super) path: &'a Path,
    limit_bytes: u64,
    used_bytes: u64,
    /// Most bytes in use so far, and those that stay with the scene.
    memory: SceneMemory,
    warnings: Vec<Warning>,
    warned: BTreeSet<String>,
    variant_warnings: Vec<VariantWarning>,
    warned_of_variants: BTreeSet<(String, Vec<Option<VariantIndex>>)>,
    /// Whether animations can change material properties. Then material extensions without an initial effect must be kept.
    pub(super) animates_properties: bool,
    /// The first element that is not finite of each accessor of floats that was read as a whole; `None` for one without.
    pub(super) first_wrong_elements: BTreeMap<usize, Option<usize>>,
    /// Accessors whose sparse indices are known to be increasing and in range.
    pub(super) checked_sparse_accessors: BTreeSet<usize>,
}

impl<'a> Context<'a> {
    pub(super) fn new(path: &'a Path, limit_bytes: u64) -> Self {
        Self {
            path,
            limit_bytes,
            used_bytes: 0,
            memory: SceneMemory::default(),
            warnings: Vec::new(),
            warned: BTreeSet::new(),
            variant_warnings: Vec::new(),
            warned_of_variants: BTreeSet::new(),
            animates_properties: false,
            first_wrong_elements: BTreeMap::new(),
            checked_sparse_accessors: BTreeSet::new(),
        }
    }

    /// Error for an invalid value at `pointer`.
    pub(super) fn invalid(&self, pointer: impl Into<String>, message: impl Into<String>) -> Error {
        Error::invalid(self.path, pointer, message)
    }

    /// Error for an unsupported feature that the file uses at `pointer`.
    pub(super) fn unsupported(&self, pointer: impl Into<String>, message: impl Into<String>) -> Error {
        Error::unsupported(self.path, pointer, message)
    }

    /// Error for a limit or a safety rule that the value at `pointer` violates.
    pub(super) fn refused(&self, pointer: impl Into<String>, message: impl Into<String>) -> Error {
        Error::refused(self.path, pointer, message)
    }

    /// Error for the value at `pointer`, which needs more memory than the limit; `instead` is what helps besides raising it.
    pub(super) fn over_memory(&self, pointer: &str, message: String, instead: Option<&'static str>) -> Error {
        Error::over_memory(self.path, pointer, message, instead)
    }

    /// Records a warning. Repeated messages are recorded once, with the pointer of the first.
    pub(super) fn warn(&mut self, pointer: impl Into<String>, message: impl Into<String>) {
        let message = message.into();
        if self.warned.insert(message.clone()) {
            self.warnings.push(Warning { pointer: pointer.into(), message });
        }
    }

    /// Records a warning that concerns the given variants alone; `None` stands for the primitives' own materials.
    pub(super) fn warn_of_variants(
        &mut self,
        pointer: &str,
        message: &str,
        variants: Vec<Option<VariantIndex>>,
    ) {
        self.warn(pointer, message);
        if self.warned_of_variants.insert((message.to_owned(), variants.clone())) {
            let warning = Warning { pointer: pointer.to_owned(), message: message.to_owned() };
            self.variant_warnings.push(VariantWarning { warning, variants });
        }
    }

    /// Reserves memory for the object at `pointer`. Call it before allocating.
    pub(super) fn charge(&mut self, bytes: u64, pointer: &str) -> Result<()> {
        let total = self.used_bytes.saturating_add(bytes);
        if total > self.limit_bytes {
            return Err(self.too_large(total, pointer));
        }
        self.used_bytes = total;
        self.memory.import_bytes = self.memory.import_bytes.max(total);
        Ok(())
    }

    /// Counts memory that is reserved and stays with the scene.
    pub(super) fn keep(&mut self, bytes: u64) {
        self.memory.kept_bytes = self.memory.kept_bytes.saturating_add(bytes);
    }

    /// Counts all memory reserved since `used_before` as staying with the scene.
    pub(super) fn keep_since(&mut self, used_before: u64) {
        self.keep(self.used_bytes.saturating_sub(used_before));
    }

    /// Memory of the scene so far.
    pub(super) fn memory(&self) -> SceneMemory {
        self.memory
    }

    /// Reserves memory for `count` values and allocates an empty list with that capacity. Returns an error rather than
    /// aborting if the system has too little memory.
    pub(super) fn allocate<T>(&mut self, count: u64, pointer: &str) -> Result<Vec<T>> {
        let bytes = count.saturating_mul(size_of::<T>() as u64);
        self.charge(bytes, pointer)?;
        let mut list = Vec::new();
        let reserved = usize::try_from(count).ok().and_then(|count| list.try_reserve_exact(count).ok());
        match reserved {
            Some(()) => Ok(list),
            None => Err(self.refused(
                pointer,
                format!(
                    "the system refuses {} of memory; the import needs about {} up to this object, the limit is {}; close \
                     other programs or use a smaller file",
                    readable_bytes(bytes.into()),
                    readable_bytes(self.used_bytes.into()),
                    readable_bytes(self.limit_bytes.into())
                ),
            )),
        }
    }

    /// Reserves memory for `count` values and allocates a list of as many times `value`. Large lists of zeros come as such from the operating
    /// system, so that whoever writes to a page first pays for it. Returns errors as [`Self::allocate`] does.
    pub(super) fn allocate_all<T: Clone>(&mut self, count: u64, value: T, pointer: &str) -> Result<Vec<T>> {
        // The list that is dropped shows whether there is memory: the second allocation would end the program.
        let reserved = self.allocate::<T>(count, pointer)?.capacity();
        Ok(vec![value; usize::try_from(count).unwrap_or(reserved)])
    }

    /// Memory limit, bytes.
    pub(super) fn limit_bytes(&self) -> u64 {
        self.limit_bytes
    }

    /// Memory reserved so far, bytes.
    pub(super) fn used_bytes(&self) -> u64 {
        self.used_bytes
    }

    /// Releases the memory reserved since `used_before` except `kept_bytes`. Call it after temporary data has been dropped.
    pub(super) fn release_temporaries(&mut self, used_before: u64, kept_bytes: u64) {
        let kept = used_before.saturating_add(kept_bytes);
        if kept < self.used_bytes {
            self.used_bytes = kept;
        }
    }

    /// Memory that can still be reserved, bytes.
    pub(super) fn remaining_bytes(&self) -> u64 {
        self.limit_bytes.saturating_sub(self.used_bytes)
    }

    /// Error for a total of `total_bytes`, which exceeds the memory limit.
    pub(super) fn too_large(&self, total_bytes: u64, pointer: &str) -> Error {
        let size = over_limit(total_bytes.into(), self.limit_bytes.into());
        let message = format!("the import needs about {size} up to this object");
        self.over_memory(pointer, message, None)
    }

    /// Checks that `index` is less than `length`; `what` names the element in the message.
    pub(super) fn check_index(
        &self,
        index: usize,
        length: usize,
        pointer: &str,
        what: &str,
    ) -> Result<usize> {
        if index < length {
            return Ok(index);
        }
        Err(self.invalid(pointer, format!("there is no {what} {index}, the file has {length}")))
    }

    /// Takes the warnings of [`Context::warn_of_variants`].
    pub(super) fn take_variant_warnings(&mut self) -> Vec<VariantWarning> {
        std::mem::take(&mut self.variant_warnings)
    }

    /// All warnings.
    pub(super) fn into_warnings(self) -> Vec<Warning> {
        self.warnings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refusals_of_the_system_state_need_total_and_limit() {
        let mut context = Context::new(Path::new("a.glb"), 1 << 62);
        context.charge(2_000_000_000, "").unwrap();
        let error = context.allocate::<u8>(1 << 61, "/accessors/0").unwrap_err();
        assert_eq!(error.exit_code(), 77);
        let text = error.to_string();
        assert!(text.contains("refuses 2305843.0 TB of memory"), "{text}");
        assert!(
            text.contains("needs about 2305843.0 TB") && text.contains("limit is 4611686.0 TB"),
            "{text}"
        );
        assert!(!text.contains("more than the limit"), "{text}");
    }
}
