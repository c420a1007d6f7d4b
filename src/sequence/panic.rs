//! Panics of worker code as errors of a frame.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::error::{Error, Result};

/// Runs `work` for `frame`. A panic becomes [`Error::Internal`].
pub(super) fn catch_panic<T>(frame: i64, work: impl FnOnce() -> Result<T>) -> Result<T> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|payload| Err(panic_error(frame, payload.as_ref())))
}

fn panic_error(frame: i64, payload: &(dyn Any + Send)) -> Error {
    let text = payload
        .downcast_ref::<&str>()
        .map(ToString::to_string)
        .or_else(|| payload.downcast_ref::<String>().cloned());
    let text = text.unwrap_or_else(|| "a worker panicked".to_owned());
    Error::Internal { message: format!("frame {frame}: {text}") }
}
