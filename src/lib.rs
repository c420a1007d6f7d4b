//! Renders animated glTF scenes to images with a Whitted-style recursive ray tracer or a path tracer.
//!
//! [`Renderer`] opens a scene, renders frames to memory, and renders sequences of OpenEXR files:
//!
//! ```
//! use rayframe::Renderer;
//!
//! fn main() -> rayframe::Result<()> {
//!     let path = std::env::temp_dir().join("rayframe-front-page.exr");
//!     let frame = Renderer::open("scenes/demo/whitted_1980.gltf")?.size(64, 36).frame(0)?;
//!     assert_eq!(frame.pixels().len(), 64 * 36);
//!     frame.write_exr(path)
//! }
//! ```
//!
//! - Images: [`RenderedFrame`] holds linear pixels and, with [`Renderer::aovs`], depth, normals, ids and more as channels of an
//!   [`image::Image`].
//! - Settings: [`Renderer::set`] takes every setting of `rayframe render` by its name; [`settings`] defines them.
//! - Sequences: [`Renderer::sequence`] writes numbered files and reports [`sequence::SequenceEvent`]s.
//! - Comparison: [`regression`] measures how images differ and tests suites of scenes against reference images.
//! - Errors: [`Error`] has a kind for each cause, names file and place, and mostly a remedy.
//!
//! Equal scenes, settings and versions give equal bytes, whatever the number of threads and the processor.
//!
//! # Features
//!
//! All are on by default. `cli` is the program and its dependencies; libraries switch it off. `draco` and `basis` are the decoders of
//! `KHR_draco_mesh_compression` and `KHR_texture_basisu`.
//!
//! # Inside
//!
//! Data flows one way: `gltf` imports a file into a time-free [`scene::Scene`]; `frame::Frame` poses it at a time;
//! [`bvh::Builder`] builds a [`bvh::Bvh`] over its triangles; `render` runs an `integrator` over tiles into a `film::Film`;
//! [`output`] makes files of it and [`sequence`] repeats that for many frames. The modules are listed in dependency order in
//! docs/architecture.md. Modules that this page does not list are public for the program, tests and benchmarks only, and may change
//! in any version.

pub mod cancel;
mod canonical_path;
mod child_process;
#[doc(hidden)]
pub mod count_text;
pub mod denoise;
pub mod error;
pub mod geometry;
mod lock_file;
mod parallel_read;
mod parallel_resize;
mod sha256;
#[doc(hidden)]
pub mod terminal;
mod uneven;

pub mod bvh;

#[doc(hidden)]
pub mod color;
pub mod image;
#[doc(hidden)]
pub mod image_file;

pub mod scene;

mod asset_cache;

#[doc(hidden)]
pub mod gltf;

#[doc(hidden)]
pub mod frame;
#[doc(hidden)]
pub mod framing;
mod scene_view;

#[doc(hidden)]
pub mod bsdf;
#[doc(hidden)]
pub mod interaction;

#[doc(hidden)]
pub mod film;
#[doc(hidden)]
pub mod integrator;
#[doc(hidden)]
pub mod render;

pub mod output;
pub mod sequence;
pub mod settings;
#[doc(hidden)]
pub mod shot;

mod renderer;

#[doc(hidden)]
pub mod merge;
pub mod regression;

#[doc(hidden)]
pub mod asset_diff;

pub use error::{Error, Result};
pub use renderer::{RenderedFrame, Renderer, SequenceRenderer};

#[cfg(doctest)]
#[doc = include_str!("../docs/library.md")]
mod library_guide {}
#[cfg(doctest)]
#[doc = include_str!("../docs/suites.md")]
mod suites_guide {}
#[cfg(doctest)]
#[doc = include_str!("../docs/regression.md")]
mod regression_guide {}
