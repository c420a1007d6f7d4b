//! Settings of a run: one definition each of name, type, default and help.

mod progress_style;

pub use progress_style::ProgressStyle;
