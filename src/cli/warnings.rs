//! Warnings of a run, and their refusal under `--strict`.

use crate::progress::print_warning;
use rayframe::error::{Result, Warning};
use rayframe::shot::refusal;

/// Prints every warning once. Under `--strict` the first one is an error that counts the others.
pub(super) fn report_warnings(path: &std::path::Path, warnings: &[Warning], is_strict: bool) -> Result<()> {
    let unique = unique_warnings(warnings);
    // Under --strict the error says the first one.
    for warning in unique.iter().skip(usize::from(is_strict)) {
        print_warning(&format!("{}: {warning}", path.display()));
    }
    match refusal(path, warnings) {
        Some(error) if is_strict => Err(error),
        _ => Ok(()),
    }
}

/// Every warning once, in order.
pub(super) fn unique_warnings(warnings: &[Warning]) -> Vec<Warning> {
    let unique: std::collections::BTreeSet<_> = warnings.iter().cloned().collect();
    unique.into_iter().collect()
}
