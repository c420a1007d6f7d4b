//! What the test models of Khronos show, on sheets of our own: each card of a sheet is one square metre that has to look as
//! another one, or as a value that follows from the specification.
//!
//! The models judge themselves by cards that must look alike. Here the pairs are made anew, each with one thing that is
//! tested beside the same thing written out.

mod geometry;
mod materials;
mod motion;
mod sheet;
mod textures;
