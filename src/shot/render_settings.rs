//! Render settings: size, samples, lens, lights.

use crate::error::{Error, Result};
use crate::film::{AovFlags, PixelWindow};
use crate::output::ExrOutput;
use crate::render::{
    Adaptive, Aperture, Focus, Integrator, Lens, LightSize, PathSettings, RenderSettings, SampleRange,
};
use crate::scene::{
    Camera, CameraMotion, NodeIndex, Projection, Scene, SelectedCamera, Selection, ViewRequest,
};
use crate::settings::{
    DEFAULT_RESOLUTION, DenoiserKind, FocusRequest, Named as _, OF_INTEGRATORS, OfIntegrator, SettingValues,
};

use super::view::named_node;

/// The render settings, without the background.
pub(crate) fn render_settings(
    args: &SettingValues,
    scene: &Scene,
    selection: &Selection,
    view: &ViewRequest,
) -> Result<RenderSettings> {
    let of_file = file_camera(scene, selection).filter(|_| !view.replaces_camera());
    let resolution = args.image_size(camera_aspect(of_file))?;
    let window = pixel_window(args, resolution)?;
    check_path_settings(args)?;
    let aovs = exr_output(args).aov_flags();
    let guides = args.denoise != DenoiserKind::None;
    Ok(RenderSettings {
        resolution,
        window,
        samples: args.samples,
        integrator: args.integrator,
        path: path_settings(args)?,
        max_depth: args.depth,
        glass_shadows: args.glass_shadows,
        light_scale: args.light_scale,
        light_size: LightSize { radius: args.light_radius, sun_angle_radians: args.sun_angle.to_radians() },
        adaptive: adaptive(args)?,
        filter: args.filter,
        lens: lens(args, scene, of_file)?,
        glossy_samples: args.glossy,
        env_samples: args.env_samples,
        environment_shares: None,
        noise_time: None,
        // Found with the first frame that needs it.
        exposure_ev: 0.0,
        show_background: true,
        ground: None,
        aovs: AovFlags { guides: guides || aovs.guides, ..aovs },
    })
}

/// The pixels that are rendered. A crop that reaches beyond the image gives way to a stronger setting of its size.
fn pixel_window(args: &SettingValues, (width, height): (u32, u32)) -> Result<PixelWindow> {
    match args.crop {
        Some(crop) if crop.x1 <= width && crop.y1 <= height => Ok(crop),
        Some(crop) if !args.crop_gives_way => {
            let message = format!(
                "{},{},{},{} reaches beyond the image of {width}x{height} pixels, which is 0,0,{width},{height}",
                crop.x0, crop.y0, crop.x1, crop.y1
            );
            Err(Error::setting("crop", message))
        }
        _ => Ok(PixelWindow::full(width, height)),
    }
}

/// Settings of paths.
pub(super) fn path_settings(args: &SettingValues) -> Result<PathSettings> {
    Ok(PathSettings {
        seed: args.seed,
        seed_per_frame: args.seed_per_frame,
        noise: args.noise,
        clamp_indirect: args.clamp_indirect.unwrap_or(f32::INFINITY),
        regularize: args.regularize,
        sample_range: sample_range(args)?,
        time_limit_seconds: args.time_limit,
    })
}

/// Refuses settings of one integrator beside another.
fn check_path_settings(args: &SettingValues) -> Result<()> {
    let has_aovs_of_paths = exr_output(args).aovs.as_slice().iter().any(|aov| aov.is_of_paths());
    if args.integrator == Integrator::Whitted && has_aovs_of_paths {
        let why = "the groups noise and denoising need `integrator` path";
        return Err(Error::setting("aovs", why));
    }
    let is_of_another =
        |setting: &&OfIntegrator| setting.integrator != args.integrator && (setting.is_set)(args);
    OF_INTEGRATORS.iter().find(is_of_another).map_or(Ok(()), |OfIntegrator { name, integrator, .. }| {
        let why = format!("has an effect with `integrator` {} only", integrator.choice_name());
        Err(Error::setting(name, why))
    })
}

/// The samples that are rendered, where they are not all.
fn sample_range(args: &SettingValues) -> Result<Option<SampleRange>> {
    match args.sample_range_refusal() {
        Some(why) => Err(Error::setting("sample_range", why)),
        None => Ok(args.sample_range),
    }
}

/// Content and encoding of EXR files.
pub(super) fn exr_output(args: &SettingValues) -> ExrOutput {
    let (samples, compression) = args.exr.unwrap_or_default();
    ExrOutput {
        aovs: args.aovs.clone().unwrap_or_default(),
        samples,
        compression,
        is_split: args.split_aovs,
        is_stamped: args.stamp,
        lists_content: false,
    }
}

fn adaptive(args: &SettingValues) -> Result<Option<Adaptive>> {
    match args.max_samples {
        Some(most) if most < args.samples => Err(Error::setting(
            "max_samples",
            format!("{most} are fewer than the {} of `samples`", args.samples),
        )),
        max => Ok(max.map(|max_samples| Adaptive { max_samples, threshold: args.aa_threshold })),
    }
}

fn lens(args: &SettingValues, scene: &Scene, of_file: Option<&Camera>) -> Result<Option<Lens>> {
    let Some(aperture) = args.aperture else { return Ok(None) };
    if matches!(aperture, Aperture::FNumber(_)) && is_parallel(args, of_file) {
        return Err(Error::setting(
            "aperture",
            "an orthographic camera has no f-number; write the lens's radius in metres",
        ));
    }
    let focus = match &args.focus {
        FocusRequest::Center => Focus::Center,
        FocusRequest::Metres(distance) => Focus::Metres(*distance),
        FocusRequest::Node(name) => Focus::Node(named_node(
            scene,
            "focus",
            name,
            "metres, center, '#0' for the first node, or a name",
        )?),
    };
    Ok(Some(Lens { aperture, focus }))
}

/// Whether the view is parallel. A field of view makes an orthographic camera of the file perspective.
fn is_parallel(args: &SettingValues, of_file: Option<&Camera>) -> bool {
    let is_orthographic = |camera: &Camera| matches!(camera.projection, Projection::Orthographic { .. });
    let has_field_of_view = args.fov.is_some() || args.focal_length.is_some();
    args.ortho || !has_field_of_view && of_file.is_some_and(is_orthographic)
}

/// The selected camera, where it is one of the scene, or of the file of a camera path.
fn file_camera<'a>(scene: &'a Scene, selection: &'a Selection) -> Option<&'a Camera> {
    let of_node = |scene: &'a Scene, node: NodeIndex| {
        let camera = scene.nodes.get(node.index())?.camera?;
        scene.cameras.get(camera.index())
    };
    match &selection.camera {
        SelectedCamera::Node(node) => of_node(scene, *node),
        SelectedCamera::Path(path) => match &path.motion {
            CameraMotion::Scene { scene, node, .. } => of_node(scene, *node),
            CameraMotion::Keys(_) => None,
        },
        _ => None,
    }
}

/// The pixel window, where it does not depend on the scene's camera.
pub(crate) fn known_window(args: &SettingValues) -> Result<Option<PixelWindow>> {
    let size = args.known_image_size()?;
    Ok(size.map(|(width, height)| args.crop.unwrap_or(PixelWindow::full(width, height))))
}

/// Aspect ratio of the camera: width over height.
fn camera_aspect(of_file: Option<&Camera>) -> f64 {
    let default = f64::from(DEFAULT_RESOLUTION.0) / f64::from(DEFAULT_RESOLUTION.1);
    let aspect = match of_file {
        Some(camera) => match camera.projection {
            Projection::Perspective { aspect_ratio, .. } => aspect_ratio.map_or(default, f64::from),
            Projection::Orthographic { x_mag, y_mag, .. } => f64::from(x_mag) / f64::from(y_mag),
        },
        None => default,
    };
    if aspect.is_finite() && aspect > 0.0 { aspect } else { default }
}
