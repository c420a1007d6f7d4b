//! Presets of obvhs (Griffin, version 0.4) that are measured.
//!
//! obvhs selects its SIMD at compile time. Its users get a plain build by default; `RUSTFLAGS='-C target-cpu=native'` is its
//! fastest. [`LIBRARY`] names the one that runs.

use obvhs::BvhBuildParams;

/// Name in tables and files.
pub const LIBRARY: &str = if cfg!(target_feature = "avx2") { "obvhs-native" } else { "obvhs" };

/// Layout of nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Two children per node.
    Binary,
    /// Eight quantized children per node.
    Compressed,
}

/// Build parameters with a name.
pub struct Preset {
    /// Name in tables and files.
    pub name: String,
    /// Parameters of the binary tree.
    pub params: BvhBuildParams,
    /// Layout of the finished hierarchy.
    pub layout: Layout,
}

/// Presets whose name is `wanted`, of every effort in both layouts; the medium ones also with splits (`slow` always splits).
pub fn presets(wanted: impl Fn(&str) -> bool) -> Vec<Preset> {
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
