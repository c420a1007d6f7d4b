//! Rayframe renders animated glTF scenes to OpenEXR image sequences with a Whitted-style recursive ray tracer.
//!
//! Data flows one way: [`gltf`] imports a file into a time-free [`scene::Scene`]; [`frame::Frame`] poses it at
//! a time; [`bvh::Builder`] turns the frame's triangles into a [`bvh::Bvh`]; [`render`] runs an [`integrator`]
//! over tiles into a [`film::Film`]; [`output`] decides what the frame's file contains and [`image_file`] writes it.
//! [`sequence`] is the only room that renders more than one frame; [`merge`] joins crops that several machines rendered.
//! [`regression`] compares pictures, and renders suites of shots through [`sequence`] to compare them with references.
//!
//! The modules stand in dependency order: each uses only those above it.

pub mod cancel;

pub mod error;

pub mod geometry;

pub mod bvh;

pub mod color;

pub mod image;

pub mod image_file;

pub mod scene;

pub mod gltf;

pub mod frame;

mod scene_view;

pub mod interaction;

pub mod bsdf;

pub mod integrator;

pub mod film;

pub mod render;

pub mod output;

pub mod settings;

pub mod sequence;

pub mod shot;

pub mod merge;

pub mod regression;
