//! Warnings about rendered frames that may not look as intended.

use glam::Vec3;

use crate::bvh::BuildStatistics;
use crate::color::{exposure_scale, luminance};
use crate::error::{Error, Result, Warning};
use crate::film::Film;
use crate::integrator::TRANSPARENCY_LIMIT;
use crate::render::RenderStatistics;
use crate::scene::{Environment, SelectedCamera};

use super::memory::reference_budget;
use super::{SequenceJob, Summary, triangle_count};

/// Luminance that counts as black at an exposure of 0: sRGB 6 of 255.
const BLACK: f32 = 0.002;

/// Warnings of the frames of a run, each given once.
#[derive(Debug, Default)]
pub(crate) struct FrameWarnings {
    given: Vec<Warning>,
    /// Whether the warning that the camera sees nothing was given.
    warned_of_empty_view: bool,
    /// Whether the hint at the studio was given.
    hinted_at_studio: bool,
}

impl FrameWarnings {
    /// Warnings from a frame's statistics that were not given before.
    ///
    /// # Errors
    /// [`Error::Internal`] for pixels that are not finite if `job.strict`.
    pub(crate) fn of_frame(
        &mut self,
        job: &SequenceJob,
        frame: i64,
        tree: &BuildStatistics,
        rays: &RenderStatistics,
    ) -> Result<Vec<Warning>> {
        let mut messages = non_finite_messages(frame, rays, job.strict)?;
        if rays.integrator.camera_hits == 0 && !self.warned_of_empty_view {
            let message = empty_view(job, frame, tree);
            self.warned_of_empty_view = message.is_some();
            messages.extend(message);
        }
        if rays.integrator.transparency_limit_reached > 0 {
            messages.push(format!(
                "some samples hit more than {TRANSPARENCY_LIMIT} transparent surfaces; what lies behind them is missing"
            ));
        }
        if tree.budget_reached {
            messages.push(format!(
                "`split`: the area would make more than {} boxes a triangle and was raised; raise `split_budget` or `max_memory` \
                 to keep it",
                reference_budget(job)
            ));
        }
        let mut warnings: Vec<_> = messages.into_iter().map(Warning::of_file).collect();
        warnings.retain(|warning| !self.given.contains(warning));
        self.given.extend_from_slice(&warnings);
        Ok(warnings)
    }

    /// Hint at the studio, once, where the file's own lights leave most of what the camera sees black. `lit` counts the frame's pixels.
    pub(super) fn studio_hint(
        &mut self,
        job: &SequenceJob,
        rays: &RenderStatistics,
        lit: impl FnOnce() -> LitPixels,
    ) -> Option<Warning> {
        let is_lit_by_file = job.is_environment_default && matches!(job.environment, Environment::None);
        // Shadow catchers are black by intent, and nobody knows the share of pixels that show them.
        let has_catchers = job.scene.materials.iter().any(|material| material.is_shadow_catcher);
        if self.hinted_at_studio || !is_lit_by_file || has_catchers || rays.integrator.camera_hits == 0 {
            return None;
        }
        // Without an environment the background is black as well, so lit pixels show surfaces.
        let surface_share = rays.integrator.camera_hits as f64 / rays.integrator.camera_rays as f64;
        let LitPixels { lit, all } = lit();
        let black_share = 1.0 - lit as f64 / (all as f64 * surface_share);
        self.hinted_at_studio = black_share > 0.5;
        let percent = (black_share * 100.0) as u32;
        self.hinted_at_studio.then(|| {
            Warning::of_file(format!(
                "the file's own lights leave {percent} % of what is seen black; `env` studio adds the studio's light, \
                 `env_intensity` scales it"
            ))
        })
    }
}

/// Why a frame shows no surface; `None` where only a part of it is rendered, or where the scene has none.
fn empty_view(job: &SequenceJob, frame: i64, tree: &BuildStatistics) -> Option<String> {
    if tree.triangles == 0 {
        return (triangle_count(&job.scene, &job.selection.roots) > 0).then(|| {
            format!("nothing is visible in frame {frame}: all meshes are hidden or have no area, such as by a scale of 0")
        });
    }
    let is_whole = job.render.window.size() == job.render.resolution;
    is_whole.then(|| {
        let camera = match job.selection.camera {
            SelectedCamera::Node(_) => job.selection.camera_label(&job.scene),
            _ => "the camera".to_owned(),
        };
        format!(
            "{camera} sees nothing in frame {frame}: the scene lies behind or beside the camera or beyond its znear or zfar, \
             faces away from it, is transparent, or lies between the samples"
        )
    })
}

/// Pixels of a frame that are not black.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct LitPixels {
    lit: usize,
    all: usize,
}

impl LitPixels {
    /// Counts the pixels of a film at an exposure.
    pub(super) fn of(film: &Film, exposure_ev: f32) -> Self {
        let black = BLACK / exposure_scale(exposure_ev);
        let is_lit = |[r, g, b, _]: &&[f32; 4]| luminance(Vec3::new(*r, *g, *b)) > black;
        Self { lit: film.pixels.iter().filter(is_lit).count(), all: film.pixels.len() }
    }

    /// Adds those of another band.
    pub(super) fn add(&mut self, other: &Self) {
        self.lit += other.lit;
        self.all += other.all;
    }
}

/// Warning that the depth limit cut off more than a hundredth of the light.
pub(super) fn depth_warning(summary: &Summary, max_depth: u32) -> Option<Warning> {
    let (dropped, samples) = summary.written.iter().fold((0.0, 0), |(dropped, samples), frame| {
        (dropped + frame.rays.dropped_weight, samples + frame.rays.camera)
    });
    let share = dropped / samples as f64;
    (share > 0.01).then(|| {
        let percent = share * 100.0;
        Warning::of_file(format!(
            "{percent:.0} % of the light was cut off at depth {max_depth}: raise `depth`"
        ))
    })
}

/// What to say of pixels and samples that are not finite.
///
/// # Errors
/// [`Error::Internal`] for any if `is_strict`.
fn non_finite_messages(frame: i64, rays: &RenderStatistics, is_strict: bool) -> Result<Vec<String>> {
    let counts = [
        ("pixels", rays.non_finite_pixels, "are black"),
        ("samples", rays.non_finite_samples, "are left out"),
    ];
    let mut messages = Vec::new();
    for (what, count, outcome) in counts.into_iter().filter(|(_, count, _)| *count > 0) {
        let message = format!("frame {frame}: {count} {what} were infinite or not a number");
        if is_strict {
            return Err(Error::Internal { message });
        }
        messages.push(format!("{message} and {outcome}; this is a bug worth reporting"));
    }
    Ok(messages)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::renderer::Renderer;
    use crate::sequence::{FrameReport, Phases, RayReport, TreeReport};

    fn frame(camera: u64, dropped_weight: f64) -> FrameReport {
        FrameReport {
            frame: 0,
            time_seconds: 0.0,
            path: "a.exr".into(),
            sha256: String::new(),
            bytes: 0,
            aov_files: Vec::new(),
            seconds: Phases::default(),
            tree: TreeReport::default(),
            rays: RayReport { camera, dropped_weight, ..RayReport::default() },
            peak_memory_bytes: None,
        }
    }

    #[test]
    fn cut_off_light_is_a_warning_beyond_a_hundredth() {
        let message = |written: Vec<FrameReport>| {
            depth_warning(&Summary { written, ..Summary::default() }, 8).map(|warning| warning.message)
        };
        // 8 of 200 samples over both frames.
        let text = message(vec![frame(100, 0.5), frame(100, 7.5)]).unwrap();
        assert_eq!(text, "4 % of the light was cut off at depth 8: raise `depth`");
        assert_eq!(message(vec![frame(100, 1.0)]), None);
        assert_eq!(message(Vec::new()), None);
    }

    #[test]
    fn frames_without_visible_triangles_are_told() {
        // A triangle, of which a camera sees the front.
        let document = |node: &str| {
            format!(
                r#"{{"asset": {{"version": "2.0"}}, "extensionsUsed": ["KHR_node_visibility"],
                "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0{node}}}],
                "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
                "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                    "min": [0, 0, 0], "max": [1, 1, 0]}}],
                "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
                "buffers": [{{"byteLength": 36, "uri":
                    "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}}]}}"#
            )
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.gltf");
        let warnings = |node: &str| -> Vec<String> {
            std::fs::write(&path, document(node)).unwrap();
            let frame = Renderer::open(&path).unwrap().size(8, 8).samples(1).frame(0).unwrap();
            frame.warnings().iter().map(|warning| warning.message.clone()).collect()
        };
        assert_eq!(warnings(""), [""; 0]);
        let hidden = r#", "extensions": {"KHR_node_visibility": {"visible": false}}"#;
        for node in [hidden, r#", "scale": [0, 0, 0]"#] {
            let expected = "nothing is visible in frame 0: all meshes are hidden or have no area, such as by a scale of 0";
            assert_eq!(warnings(node), [expected], "{node}");
        }
    }

    #[test]
    fn pixels_that_are_not_finite_are_a_warning_or_an_internal_error() {
        let rays =
            RenderStatistics { non_finite_pixels: 2, non_finite_samples: 3, ..RenderStatistics::default() };
        let expected = [
            "frame 7: 2 pixels were infinite or not a number and are black; this is a bug worth reporting",
            "frame 7: 3 samples were infinite or not a number and are left out; this is a bug worth reporting",
        ];
        assert_eq!(non_finite_messages(7, &rays, false).unwrap(), expected);
        assert_eq!(non_finite_messages(7, &RenderStatistics::default(), true).unwrap(), [""; 0]);
        for (pixels, samples) in [(1, 0), (0, 1)] {
            let rays = RenderStatistics { non_finite_pixels: pixels, non_finite_samples: samples, ..rays };
            assert_eq!(non_finite_messages(7, &rays, true).unwrap_err().exit_code(), 70);
        }
    }
}
