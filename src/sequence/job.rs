//! Description of a sequence.

use std::sync::Arc;

use crate::bvh::BuildSettings;
use crate::color::ToneCurve;
use crate::denoise::Denoiser;
use crate::output::{ExrOutput, PreviewLook};
use crate::render::RenderSettings;
use crate::scene::{Environment, NodeIndex, Scene, Selection};

use crate::settings::{ExistingFiles, Exposure, FrameRate, OutputPattern, Shutter};

use super::{FirstPose, KnownShares, Plates, SequenceOutputs, SharedExposure};

/// Description of a sequence of files.
#[derive(Clone, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is a setting of its own")]
pub struct SequenceJob {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The parts of the scene that are rendered.
    pub selection: Selection,
    /// Whether the camera depends on the poses of clips at other times, as one that frames the scene does.
    pub camera_follows_clips: bool,
    /// Environment light and background.
    pub environment: Environment,
    /// Whether `environment` was left to the scene. Then a hint may name others.
    pub is_environment_default: bool,
    /// Frame numbers in the order of rendering, none twice.
    pub frames: Vec<i64>,
    /// Frames per second.
    pub rate: FrameRate,
    /// Shutter of each frame.
    pub shutter: Shutter,
    /// The scene as it was posed last, before the first frame; empty where nothing was posed.
    pub first_pose: FirstPose,
    /// What is known of the traced shares of the environment's light; empty at first.
    pub known_shares: KnownShares,
    /// Image, sampling and shading.
    pub render: RenderSettings,
    /// BVH construction; never changes the image.
    pub build: BuildSettings,
    /// Names of the frame files.
    pub output: OutputPattern,
    /// Content of EXR files.
    pub exr: ExrOutput,
    /// Whether every EXR file gets a tone-mapped PNG preview.
    pub preview: bool,
    /// Movie, contact sheet and frames on the terminal.
    pub sequence_outputs: SequenceOutputs,
    /// Exposure of tone-mapped files.
    pub exposure: Exposure,
    /// What automatic exposure measures, where it is that of several sequences or runs.
    pub shared_exposure: Option<Arc<SharedExposure>>,
    /// Tone curve of tone-mapped files.
    pub tone: ToneCurve,
    /// sRGB colour behind the scene in tone-mapped files. It shows where the render is transparent.
    pub display_background: Option<[u8; 3]>,
    /// Plates behind the frames.
    pub plates: Option<Plates>,
    /// Treatment of existing files.
    pub existing: ExistingFiles,
    /// Whether other frames are rendered after one fails.
    pub keep_going: bool,
    /// Whether a pixel that is infinite or NaN fails its frame.
    pub strict: bool,
    /// Denoiser of the frames.
    pub denoiser: Option<Denoiser>,
    /// Whether finished passes of a frame of paths are kept beside it until it is done.
    pub checkpoint: bool,
    /// Whether a frame is written while the next one is rendered.
    pub write_behind: bool,
    /// Memory limit, bytes.
    pub max_memory_bytes: u64,
}

impl SequenceJob {
    /// Tone mapping at an exposure.
    pub fn look(&self, exposure_ev: f32) -> PreviewLook {
        PreviewLook { exposure_ev, tone: self.tone, background: self.display_background }
    }

    /// Whether surfaces are posed at several times, besides those of pixel centres.
    pub(super) fn poses_again(&self) -> bool {
        !self.selection.clips.is_empty() && (self.frames.len() > 1 || self.shutter.time_samples > 1)
    }

    /// Whether rendering needs the exposure: display values decide about samples, or are shown while a time limit runs.
    pub(super) fn renders_by_exposure(&self) -> bool {
        self.render.decides_by_display_values() || self.render.path.time_limit_seconds.is_some()
    }
}

/// Time of the last keyframe of the selected clips and of the camera path, seconds.
pub fn duration_seconds(scene: &Scene, selection: &Selection) -> f32 {
    selection.duration_seconds(scene)
}

/// Number of triangles below `roots`.
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
