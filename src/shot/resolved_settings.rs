//! All settings of a job, with what the scene decides in their places.

use crate::film::PixelWindow;
use crate::render::RenderSettings;
use crate::scene::{BuiltInLight, SelectedCamera};
use crate::sequence::{FrameSpec, SequenceJob};
use crate::settings::{Assigned, EnvironmentSource, Placeholder, Settings, parse};

use super::resolve::RenderJob;
use super::shot_settings::ShotSettings;

/// Settings that make the same files as the `jobs` of `shot`, wherever they are read: defaults included, files by absolute paths.
/// What differs between jobs stays as it was given.
pub fn resolved_settings(shot: &ShotSettings, jobs: &[RenderJob]) -> Settings {
    let mut settings = shot.settings.clone();
    let Some(RenderJob { sequence: first, outline, .. }) = jobs.first() else { return settings };
    if jobs.iter().all(|job| job.sequence.frames == first.frames) {
        clear(&mut settings, &["all", "start", "end", "step"]);
        settings.frames = Some(FrameSpec::Listed(first.frames.clone()).into());
    }
    if jobs.iter().all(|job| job.sequence.render.resolution == first.render.resolution) {
        clear(&mut settings, &["width", "height", "scale"]);
        settings.resolution = Some(first.render.resolution.into());
    }
    if settings.crop_gives_way && jobs.iter().all(is_whole) {
        clear(&mut settings, &["crop"]);
    }
    // The printed file is another shot file.
    let files =
        [&mut settings.movie, &mut settings.contact_sheet, &mut settings.stats, &mut settings.manifest];
    for file in files.into_iter().flatten() {
        file.value = outline.output_names.fill_shot(&file.value);
    }
    let origin = settings.origin_of("output").cloned().unwrap_or_default();
    let value = outline.pattern.with_names(&outline.output_names, &[Placeholder::Scene, Placeholder::Shot]);
    settings.output = Some(Assigned { value, origin });
    if settings.camera_path.is_none() {
        settings.camera.get_or_insert_with(|| parse::camera(&camera(first)).into());
    }
    if settings.env.is_none() && first.selection.image_light.is_none() {
        let has_lights = first.selection.has_lights(&first.scene);
        let studio = EnvironmentSource::BuiltIn(BuiltInLight::Studio);
        let source = if has_lights { EnvironmentSource::None } else { studio };
        settings.env = Some(source.into());
    }
    settings.with_defaults(&std::env::current_dir().unwrap_or_default())
}

/// Whether all pixels of the image are rendered.
fn is_whole(job: &RenderJob) -> bool {
    let RenderSettings { resolution: (width, height), window, .. } = job.sequence.render;
    window == PixelWindow::full(width, height)
}

fn clear(settings: &mut Settings, names: &[&str]) {
    for name in names {
        settings.clear(name);
    }
}

/// The camera that is selected by default: the first camera of the scene graph.
fn camera(job: &SequenceJob) -> String {
    let SelectedCamera::Node(node) = job.selection.camera else {
        return "auto".to_owned();
    };
    let camera = job.scene.nodes.get(node.index()).and_then(|node| node.camera);
    camera.map_or_else(|| "auto".to_owned(), |camera| format!("#{}", camera.index()))
}
