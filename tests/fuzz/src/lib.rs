//! Fuzz targets of rayframe: entry points that read files of strangers, and algorithms with a reference implementation.
//!
//! [`TARGETS`] lists them. A target is a function of bytes that panics where something is wrong, so it runs under libFuzzer (`run.py`
//! beside this crate) and in the normal tests, which replay every stored find. docs/fuzzing.md describes both.
//!
//! | module | holds |
//! |---|---|
//! | `targets` | what each target does with its input |
//! | `mutation` | mutations that keep documents, containers and checksums whole |
//! | `seeds` | the inputs that a run starts from |
//! | `input`, `scratch`, `verdict` | numbers from bytes, files for the importer, the rules of what is a find |

mod input;
pub mod mutation;
mod scratch;
mod seeds;
mod table;
mod targets;
mod verdict;

pub use seeds::{Seed, dictionary};
pub use table::{TARGETS, Target, target};
pub use verdict::{PanicWatch, memory_limit};
