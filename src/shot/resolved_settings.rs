//! All settings of a job, with what the scene decides in their places.

use crate::scene::SelectedCamera;
use crate::sequence::{FrameSpec, SequenceJob};
use crate::settings::{EnvironmentSource, Settings, parse};

use super::shot_settings::ShotSettings;

/// Settings that make the same files, wherever they are read: defaults included, files by absolute paths.
pub fn resolved_settings(shot: &ShotSettings, job: &SequenceJob) -> Settings {
    let mut settings = shot.settings.clone();
    for replaced in ["all", "start", "end", "step", "width", "height", "scale"] {
        settings.clear(replaced);
    }
    settings.frames = Some(FrameSpec::Listed(job.frames.clone()).into());
    settings.resolution = Some(job.render.resolution.into());
    settings.output.get_or_insert_with(|| job.output.clone().into());
    if settings.camera_path.is_none() {
        settings.camera.get_or_insert_with(|| parse::camera(&camera(job)).into());
    }
    if settings.env.is_none() && job.selection.image_light.is_none() {
        let has_lights = job.selection.has_lights(&job.scene);
        let source = if has_lights { EnvironmentSource::None } else { EnvironmentSource::Studio };
        settings.env = Some(source.into());
    }
    settings.with_defaults(&std::env::current_dir().unwrap_or_default())
}

/// The camera that is selected by default: the first camera of the scene graph.
fn camera(job: &SequenceJob) -> String {
    let SelectedCamera::Node(node) = job.selection.camera else {
        return "auto".to_owned();
    };
    let camera = job.scene.nodes.get(node.index()).and_then(|node| node.camera);
    camera.map_or_else(|| "auto".to_owned(), |camera| format!("#{}", camera.index()))
}
