//! Conformance tests after the test models of Khronos (glTF Sample Assets).
//!
//! The models put cards side by side that must look alike. A [`sheet::Sheet`] does the same: one card of each pair uses the
//! feature under test, the other has its result written out, or a value that follows from the specification is expected.

mod geometry;
mod materials;
mod motion;
mod sheet;
mod textures;
