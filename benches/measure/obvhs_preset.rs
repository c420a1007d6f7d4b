//! obvhs (Griffin, version 0.4), the peer in the same run: its presets that are measured.
//!
//! The library chooses its SIMD when it is compiled: a plain build is what its users get by default, and one with
//! `RUSTFLAGS='-C target-cpu=native'` is its best. [`LIBRARY`] says which one runs.

use obvhs::BvhBuildParams;

/// The name in tables and files.
pub(crate) const LIBRARY: &str = if cfg!(target_feature = "avx2") { "obvhs-native" } else { "obvhs" };

/// Which structure is walked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Layout {
    /// Two children a node.
    Binary,
    /// Eight quantized children a node.
    Compressed,
}

/// A way to build.
pub(crate) struct Preset {
    /// As it stands in tables and files.
    pub(crate) name: String,
    pub(crate) params: BvhBuildParams,
    pub(crate) layout: Layout,
}

/// Every effort of the library as both structures, the middle ones with splits too (`slow` always splits): those that are
/// wanted by name.
pub(crate) fn presets(wanted: impl Fn(&str) -> bool) -> Vec<Preset> {
    let mut presets = Vec::new();
    for (layout, prefix) in [(Layout::Binary, "bvh2"), (Layout::Compressed, "cwbvh")] {
        let split = |params| BvhBuildParams { pre_split: true, ..params };
        let efforts = [
            ("fastest", BvhBuildParams::fastest_build()),
            ("veryfast", BvhBuildParams::very_fast_build()),
            ("fast", BvhBuildParams::fast_build()),
            ("fast+split", split(BvhBuildParams::fast_build())),
            ("medium", BvhBuildParams::medium_build()),
            ("medium+split", split(BvhBuildParams::medium_build())),
            ("slow", BvhBuildParams::slow_build()),
        ];
        let named = |(effort, params)| Preset { name: format!("{prefix}-{effort}"), params, layout };
        presets.extend(efforts.map(named).into_iter().filter(|preset| wanted(&preset.name)));
    }
    presets
}
