//! regression.
