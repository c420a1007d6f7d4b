//! The combinations of builder and splitting that are measured.

use rayframe::bvh::{BuildSettings, BuilderKind, Refit, Split};

/// A row of the table of configurations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Configuration {
    /// As it stands in tables and files.
    pub(crate) name: &'static str,
    builder: BuilderKind,
    split: Split,
}

/// All that are measured.
pub(crate) const CONFIGURATIONS: [Configuration; 6] = [
    // The tree of the paper, by the faster pass.
    Configuration { name: "lbvh", builder: BuilderKind::Lbvh, split: Split::Off },
    // The same over split triangles.
    Configuration { name: "lbvh-split", builder: BuilderKind::Lbvh, split: Split::Auto },
    // The paper's own algorithm.
    Configuration { name: "karras", builder: BuilderKind::Karras, split: Split::Off },
    // The better tree.
    Configuration { name: "ploc", builder: BuilderKind::Ploc, split: Split::Off },
    Configuration { name: "ploc-split", builder: BuilderKind::Ploc, split: Split::Auto },
    // What `rayframe render` does.
    Configuration { name: "auto", builder: BuilderKind::Auto, split: Split::Auto },
];

impl Configuration {
    /// Settings of the builder.
    pub(crate) fn settings(&self) -> BuildSettings {
        // The same triangles again and again would only ever be refitted.
        let refit = Refit::Off;
        BuildSettings { builder: self.builder, split: self.split, refit, ..BuildSettings::default() }
    }
}
