//! Combinations of builder and splitting that are measured.

use rayframe::bvh::{BuildSettings, BuilderKind, Refit, Split};

/// Builder and splitting with a name.
#[derive(Clone, Copy, Debug)]
pub struct Configuration {
    /// Name in tables and files.
    pub name: &'static str,
    builder: BuilderKind,
    split: Split,
}

/// All measured configurations.
pub const CONFIGURATIONS: [Configuration; 6] = [
    // Radix tree in one pass.
    Configuration { name: "lbvh", builder: BuilderKind::Lbvh, split: Split::Off },
    // The same over split triangles.
    Configuration { name: "lbvh-split", builder: BuilderKind::Lbvh, split: Split::Auto },
    // Radix tree node by node, as in the paper.
    Configuration { name: "karras", builder: BuilderKind::Karras, split: Split::Off },
    // Clustering.
    Configuration { name: "ploc", builder: BuilderKind::Ploc, split: Split::Off },
    Configuration { name: "ploc-split", builder: BuilderKind::Ploc, split: Split::Auto },
    // Default of `rayframe render`.
    Configuration { name: "auto", builder: BuilderKind::Auto, split: Split::Auto },
];

impl Configuration {
    /// Settings of the builder.
    pub fn settings(&self) -> BuildSettings {
        // Unchanged triangles would always be refitted.
        let refit = Refit::Off;
        BuildSettings { builder: self.builder, split: self.split, refit, ..BuildSettings::default() }
    }
}
