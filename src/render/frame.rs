//! The frame renderer: spreads tiles over threads and collects them in a film.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use rayon::prelude::*;

use super::pixel_centers::{AdjacentFrames, render_pixel_centers};
use super::sample_plan::{SamplePlan, ShutterSample};
use super::screen_bounds::ScreenBounds;
use super::settings::RenderSettings;
use super::statistics::RenderStatistics;
use super::tile::{TileRenderer, TileSettings};
use super::tile_grid::tiles;
use crate::cancel::{CancelFlag, Cancelled};
use crate::film::Film;
use crate::integrator::{CameraRays, IntegratorContext, IntegratorSettings, IntegratorStatistics};
use crate::scene_view::SceneView;

/// Renders one frame with its AOVs, in parallel on the current rayon pool. There are no adjacent frames, so the motion AOVs
/// are zero.
///
/// `on_progress` is called from worker threads with the finished share of the image, 0 to 1.
pub fn render_frame(
    view: &SceneView<'_>,
    settings: &RenderSettings,
    cancel: &CancelFlag,
    on_progress: &(dyn Fn(f32) + Sync),
) -> Result<(Film, RenderStatistics), Cancelled> {
    let mut film = Film::with_aovs(settings.resolution, settings.window, settings.aovs);
    let statistics = render_frame_into(&mut film, view, settings, ShutterSample::ONLY, cancel, on_progress)?;
    render_pixel_centers(&mut film, view, AdjacentFrames { before: view.frame, after: view.frame }, cancel)?;
    Ok((film, statistics))
}

/// Renders one shutter sample of a frame into a film of the settings' resolution and window, whose pixels are overwritten.
/// Light passes and coverage are recorded where the film has them. Pixel-centre samples are left to [`render_pixel_centers`].
pub fn render_frame_into(
    film: &mut Film,
    view: &SceneView<'_>,
    settings: &RenderSettings,
    shutter_sample: ShutterSample,
    cancel: &CancelFlag,
    on_progress: &(dyn Fn(f32) + Sync),
) -> Result<RenderStatistics, Cancelled> {
    debug_assert!(film.resolution == settings.resolution && film.window == settings.window);
    let start = Instant::now();

    // Integrator, camera and samples
    let posed_environment = view.frame.image_light.as_ref().and_then(|pose| view.environment.posed(pose));
    let environment = posed_environment.as_ref().unwrap_or(view.environment);
    let context = IntegratorContext::new(SceneView { environment, ..*view }, integrator_settings(settings));
    let lens = settings.lens.and_then(|lens| lens.at(view, settings.resolution));
    let time_seconds = view.frame.time_seconds as f32;
    let camera = CameraRays::new(&view.frame.camera, settings.resolution, time_seconds, lens)
        .sharing_pixels(settings.samples);
    let plan = SamplePlan::new(settings, shutter_sample);
    let screen = match lens {
        Some(_) => ScreenBounds::EVERYWHERE,
        None => ScreenBounds::new(view, settings.resolution),
    };

    // Tiles, each by one task
    let tile_settings = TileSettings {
        camera: &camera,
        plan: &plan,
        resolution: settings.resolution,
        screen: &screen,
        aovs: film.aovs.flags(),
    };
    let renderer = || TileRenderer::new(&context, tile_settings);
    let tiles = tiles(settings.window);
    let finished = AtomicUsize::new(0);
    let shared_film = Mutex::new(&mut *film);
    let counters: Vec<IntegratorStatistics> = tiles
        .par_iter()
        .map_init(renderer, |renderer, tile| {
            let rendered = renderer.render(*tile, cancel)?;
            let mut film = shared_film.lock().unwrap_or_else(PoisonError::into_inner);
            film.write_tile(*tile, rendered.pixels);
            film.write_aov_tile(*tile, &rendered.aovs);
            drop(film);
            let done = finished.fetch_add(1, Ordering::Relaxed) + 1;
            on_progress(done as f32 / tiles.len() as f32);
            Ok(rendered.statistics)
        })
        .collect::<Result<_, Cancelled>>()?;

    // Statistics, in tile order
    let mut statistics = RenderStatistics::default();
    for tile in &counters {
        statistics.integrator.add(tile);
    }
    statistics.non_finite_pixels = film.blacken_non_finite();
    statistics.trace_seconds = start.elapsed().as_secs_f64();
    Ok(statistics)
}

fn integrator_settings(settings: &RenderSettings) -> IntegratorSettings {
    IntegratorSettings {
        integrator: settings.integrator,
        path: settings.path,
        max_samples: settings.adaptive.map_or(settings.samples, |adaptive| adaptive.max_samples),
        max_depth: settings.max_depth,
        glass_shadows: settings.glass_shadows,
        show_background: settings.show_background,
        ground: settings.ground,
        light_scale: settings.light_scale,
        light_size: settings.light_size,
        glossy_samples: settings.glossy_samples,
        env_samples: settings.env_samples,
    }
}
