//! Isolation of decoders of other projects, which may panic over damaged files.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs a decoder. A panic is an error.
pub(super) fn isolated<T>(decode: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(decode)).unwrap_or_else(|_| Err("its content is inconsistent".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error() {
        let indices: Vec<usize> = Vec::new();
        assert_eq!(isolated(|| Ok(indices[0])), Err("its content is inconsistent".to_owned()));
        assert_eq!(isolated(|| Ok(1)), Ok(1));
    }
}
