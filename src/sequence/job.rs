//! What a sequence is made from.

use std::sync::Arc;

use crate::bvh::BuildSettings;
use crate::color::ToneCurve;
use crate::output::ExrOutput;
use crate::render::RenderSettings;
use crate::scene::{Environment, NodeIndex, Scene, Selection};

use super::{ExistingFiles, FrameRate, OutputPattern, SequenceOutputs, Shutter};

/// How bright previews are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// Found from a few small renders, the same for the whole animation.
    Auto,
    /// Stops.
    Ev(f32),
}

/// Everything that decides a sequence of files.
#[derive(Clone, Debug)]
pub struct SequenceJob {
    /// What is rendered.
    pub scene: Arc<Scene>,
    /// Which part of it.
    pub selection: Selection,
    /// What surrounds it.
    pub environment: Environment,
    /// What `environment` was made from, in words that differ whenever it does.
    pub environment_key: String,
    /// Frame numbers in the order of rendering, none twice.
    pub frames: Vec<i64>,
    /// Frames a second.
    pub rate: FrameRate,
    /// How long each frame looks.
    pub shutter: Shutter,
    /// The picture.
    pub render: RenderSettings,
    /// The hierarchy; never changes the picture.
    pub build: BuildSettings,
    /// Names.
    pub output: OutputPattern,
    /// What EXR files hold.
    pub exr: ExrOutput,
    /// Whether a tone-mapped PNG lies beside every EXR.
    pub preview: bool,
    /// Movie, contact sheet and frames on the terminal.
    pub sequence_outputs: SequenceOutputs,
    /// Brightness of tone-mapped files.
    pub exposure: Exposure,
    /// Curve of tone-mapped files.
    pub tone: ToneCurve,
    /// What becomes of files that are there already.
    pub existing: ExistingFiles,
    /// Whether the others are rendered when a frame fails.
    pub keep_going: bool,
    /// Whether a pixel that is infinite or not a number fails its frame.
    pub strict: bool,
    /// Most memory that may be used, bytes.
    pub max_memory_bytes: u64,
}

/// Time of the last key of all selected clips, seconds.
pub fn duration_seconds(scene: &Scene, selection: &Selection) -> f32 {
    selection
        .clips
        .iter()
        .filter_map(|clip| scene.animations.get(clip.index()))
        .map(crate::scene::Animation::duration_seconds)
        .fold(0.0, |a, b| if b > a { b } else { a })
}

/// Triangles that the nodes below `roots` draw.
pub fn triangle_count(scene: &Scene, roots: &[NodeIndex]) -> u64 {
    let mut pending = roots.to_vec();
    let mut count = 0;
    while let Some(node) = pending.pop().and_then(|index| scene.nodes.get(index.index())) {
        if let Some(mesh) = node.mesh.and_then(|mesh| scene.meshes.get(mesh.index())) {
            let instances = node.instances.as_ref().map_or(1, |instances| instances.len() as u64);
            count += mesh.primitives.iter().map(|p| p.triangles.len() as u64).sum::<u64>() * instances;
        }
        pending.extend_from_slice(&node.children);
    }
    count
}
