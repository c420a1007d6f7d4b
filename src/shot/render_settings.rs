//! Render settings: size, samples, lens, lights.

use crate::error::{Error, Result};
use crate::film::{AovFlags, PixelWindow};
use crate::output::{Aov, ExrOutput};
use crate::render::{
    Adaptive, Aperture, EnvSamples, Focus, Integrator, Lens, LightSize, PathSettings, RenderSettings,
    SampleRange,
};
use crate::scene::{Camera, CameraMotion, NodeIndex, Projection, Scene, SelectedCamera, Selection};
use crate::settings::{BackgroundSource, DenoiserKind, FocusRequest, OutputFormat, SettingValues};

use super::view::named_node;

/// Default image size, pixels.
const DEFAULT_RESOLUTION: (u32, u32) = (1280, 720);

/// The render settings, without the background.
pub(crate) fn render_settings(
    args: &SettingValues,
    scene: &Scene,
    selection: &Selection,
) -> Result<RenderSettings> {
    let resolution = image_size(args, camera_aspect(scene, selection))?;
    let window = args.crop.unwrap_or(PixelWindow::full(resolution.0, resolution.1));
    if window.x1 > resolution.0 || window.y1 > resolution.1 {
        return Err(Error::setting(
            "crop",
            format!("reaches beyond the image of {}x{} pixels", resolution.0, resolution.1),
        ));
    }
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
        lens: lens(args, scene, selection)?,
        glossy_samples: args.glossy,
        env_samples: args.env_samples,
        show_background: true,
        ground: None,
        aovs: AovFlags { guides: guides || aovs.guides, ..aovs },
    })
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
    let of_path = [
        ("seed", args.seed != 0),
        ("seed_per_frame", args.seed_per_frame),
        ("noise", args.noise.is_some()),
        ("clamp_indirect", args.clamp_indirect.is_some()),
        ("regularize", args.regularize),
        ("sample_range", args.sample_range.is_some()),
        ("time_limit", args.time_limit.is_some()),
        ("denoise", args.denoise != DenoiserKind::None),
        ("checkpoint", args.checkpoint),
    ];
    let other = match args.integrator {
        Integrator::Path => {
            let of_whitted = [
                ("glossy", args.glossy > 0),
                ("env_samples", args.env_samples != EnvSamples::Auto),
                ("max_samples", args.max_samples.is_some()),
            ];
            of_whitted.into_iter().find(|(_, is_set)| *is_set).map(|(name, _)| (name, "whitted"))
        }
        Integrator::Whitted if exr_output(args).aovs.as_slice().iter().any(|aov| aov.is_of_paths()) => {
            return Err(Error::setting(
                "aovs",
                "the groups noise and denoising need `integrator = \"path\"`",
            ));
        }
        Integrator::Whitted => of_path.iter().find(|(_, is_set)| *is_set).map(|(name, _)| (*name, "path")),
    };
    match other {
        Some((name, integrator)) => {
            Err(Error::setting(name, format!("applies to `integrator = \"{integrator}\"` only")))
        }
        None => Ok(()),
    }
}

/// The samples that are rendered, where they are not all.
fn sample_range(args: &SettingValues) -> Result<Option<SampleRange>> {
    let Some(range) = args.sample_range else { return Ok(None) };
    let refuse = |why: String| Err(Error::setting("sample_range", why));
    if range.last >= args.samples {
        let SampleRange { last, .. } = range;
        return refuse(format!(
            "ends at {last}, but `samples` {} are 0 to {}",
            args.samples,
            args.samples - 1
        ));
    }
    let exr = exr_output(args);
    let has_mattes =
        exr.aovs.as_slice().iter().any(|aov| matches!(aov, Aov::CryptoObject | Aov::CryptoMaterial));
    let beside = [
        (
            args.shutter.is_some() && !args.samples.is_multiple_of(args.time_samples),
            "`samples` must be a multiple of `time_samples`",
        ),
        (args.noise.is_some(), "`noise` decides by all samples of a pixel"),
        (args.time_limit.is_some(), "`time_limit` ends at any sample"),
        (args.denoise != DenoiserKind::None, "`denoise` needs all samples"),
        (
            args.output.as_ref().is_some_and(|output| output.format() != OutputFormat::Exr),
            "only EXR files hold sums; end `output` with .exr",
        ),
        (matches!(args.background, BackgroundSource::Plate(_)), "a plate can only be put behind all samples"),
        (exr.is_split, "the sums are in one file; leave out `split_aovs`"),
        (has_mattes, "Cryptomattes cannot be added up; render them without a range"),
        (exr.compression.is_lossy(), "sums need a lossless compression such as zip"),
    ];
    match beside.into_iter().find(|(is_there, _)| *is_there) {
        Some((_, why)) => refuse(format!("cannot be used here: {why}")),
        None => Ok(Some(range)),
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

fn lens(args: &SettingValues, scene: &Scene, selection: &Selection) -> Result<Option<Lens>> {
    let Some(aperture) = args.aperture else { return Ok(None) };
    if matches!(aperture, Aperture::FNumber(_)) && (args.ortho || is_orthographic(scene, selection)) {
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

fn is_orthographic(scene: &Scene, selection: &Selection) -> bool {
    file_camera(scene, selection)
        .is_some_and(|camera| matches!(camera.projection, Projection::Orthographic { .. }))
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
    if args.width.is_some() != args.height.is_some() {
        return Ok(None);
    }
    let (width, height) = image_size(args, 1.0)?;
    Ok(Some(args.crop.unwrap_or(PixelWindow::full(width, height))))
}

/// Columns and rows after `--scale`. One side alone takes the other from the camera.
fn image_size(args: &SettingValues, camera_aspect: f64) -> Result<(u32, u32)> {
    let default = (f64::from(DEFAULT_RESOLUTION.0), f64::from(DEFAULT_RESOLUTION.1));
    let sides = |(width, height)| (f64::from(width), f64::from(height));
    let (width, height) = match (args.width.map(f64::from), args.height.map(f64::from)) {
        (Some(width), Some(height)) => (width, height),
        (Some(width), None) => (width, width / camera_aspect),
        (None, Some(height)) => (height * camera_aspect, height),
        (None, None) => args.resolution.map_or(default, sides),
    };
    let scale = args.scale.unwrap_or(1.0);
    let side = |pixels: f64| {
        let pixels = (pixels * scale).round().max(1.0);
        // OpenEXR stores corners as signed 32-bit numbers.
        if pixels > f64::from(i32::MAX) {
            return Err(Error::setting("resolution", "a side has more than 2147483647 pixels"));
        }
        Ok(pixels as u32)
    };
    Ok((side(width)?, side(height)?))
}

/// Aspect ratio of the camera: width over height.
fn camera_aspect(scene: &Scene, selection: &Selection) -> f64 {
    let default = f64::from(DEFAULT_RESOLUTION.0) / f64::from(DEFAULT_RESOLUTION.1);
    let aspect = match file_camera(scene, selection) {
        Some(camera) => match camera.projection {
            Projection::Perspective { aspect_ratio, .. } => aspect_ratio.map_or(default, f64::from),
            Projection::Orthographic { x_mag, y_mag, .. } => f64::from(x_mag) / f64::from(y_mag),
        },
        None => default,
    };
    if aspect.is_finite() && aspect > 0.0 { aspect } else { default }
}
