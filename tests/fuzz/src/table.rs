//! The table of all targets.

use crate::mutation::Mutation;
use crate::seeds::{self, Seed};
use crate::targets::{bvh, compare, decoders, image_files, render, scene_files, text_files};

/// A fuzz target.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name, and that of its folder of finds.
    pub name: &'static str,
    /// Runs it on one input; a panic is a find.
    pub run: fn(&[u8]),
    /// How its inputs are mutated.
    pub mutation: Mutation,
    /// The inputs that a run starts from.
    pub seeds: fn() -> Vec<Seed>,
}

const fn entry(name: &'static str, run: fn(&[u8]), mutation: Mutation, seeds: fn() -> Vec<Seed>) -> Target {
    Target { name, run, mutation, seeds }
}

/// All targets.
#[rustfmt::skip]
pub const TARGETS: [Target; 25] = [
    entry("glb", scene_files::glb, Mutation::BinaryScene, seeds::binary_scenes),
    entry("gltf", scene_files::gltf, Mutation::JsonWithResources, seeds::scenes_with_resources),
    entry("draco", decoders::draco, Mutation::Bytes, seeds::draco),
    entry("meshopt", decoders::meshopt, Mutation::Bytes, seeds::meshopt),
    entry("png", decoders::png, Mutation::PngChunks, seeds::pngs),
    entry("jpeg", decoders::jpeg, Mutation::Bytes, seeds::jpegs),
    entry("webp", decoders::webp, Mutation::Bytes, seeds::webps),
    entry("ktx2", decoders::ktx2, Mutation::Bytes, seeds::ktx2s),
    entry("hdr", image_files::hdr, Mutation::Bytes, seeds::hdrs),
    entry("exr", image_files::exr, Mutation::Bytes, seeds::exrs),
    entry("merge", image_files::merge, Mutation::Bytes, seeds::tiles),
    entry("shot", text_files::shot, Mutation::Bytes, seeds::shots),
    entry("suite", text_files::suite, Mutation::Bytes, seeds::suites),
    entry("definitions", text_files::definitions, Mutation::Bytes, seeds::definitions),
    entry("patterns", text_files::patterns, Mutation::Bytes, seeds::patterns),
    entry("approvals", text_files::approvals, Mutation::Json, seeds::approvals),
    entry("rendered", text_files::rendered, Mutation::Json, seeds::rendered),
    entry("archive", text_files::archive, Mutation::Bytes, seeds::archives),
    entry("shard", text_files::shard, Mutation::Json, seeds::shards),
    entry("manifest", text_files::manifest, Mutation::Json, seeds::manifests),
    entry("render", render::render, Mutation::OptionsAndJson, seeds::renders),
    entry("bvh", bvh::bvh, Mutation::Bytes, seeds::triangles),
    entry("split", bvh::split, Mutation::Bytes, seeds::triangles),
    entry("diff", compare::diff, Mutation::Bytes, seeds::image_pairs),
    entry("camera_path", text_files::camera_path, Mutation::Bytes, seeds::camera_paths),
];

/// The target called `name`.
pub fn target(name: &str) -> Option<&'static Target> {
    TARGETS.iter().find(|target| target.name == name)
}
