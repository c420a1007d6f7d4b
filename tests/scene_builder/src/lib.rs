//! Writer of text glTF 2.0 scenes for the suite `scenes/` and for tests.
//!
//! [`document::Gltf`] collects the arrays of one file; meshes, materials, images and nodes add themselves to it. The crate
//! writes what those scenes need and checks nothing; the importer and the Khronos validator do that. It does not depend on
//! rayframe. The same calls give the same bytes on every machine: all arithmetic is IEEE or `libm`.

#![expect(missing_docs, reason = "fields that are named as in glTF need no more words")]

pub mod accessor;
pub mod document;
pub mod image;
pub mod json;
pub mod material;
pub mod node;
pub mod shapes;
pub mod staging;
