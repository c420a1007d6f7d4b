//! sequence.
pub mod frames;
pub mod pattern;
pub mod rate;
