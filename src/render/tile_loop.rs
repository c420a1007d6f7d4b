//! The loop over the tiles of an image, in parallel.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use super::screen_bounds::ScreenBounds;
use super::settings::RenderSettings;
use super::statistics::RenderStatistics;
use super::tile::{TileRenderer, TileSettings};
use super::tile_grid::tiles;
use crate::cancel::Cancelled;
use crate::film::{AovFlags, PixelWindow};
use crate::integrator::{CameraRays, IntegratorContext, IntegratorSettings};
use crate::scene_view::SceneView;

/// Tiles of a job of the pool: few enough that a thread is soon back which encodes the frame before and takes a job in between.
const TILES_A_JOB: usize = 16;

/// Calls `render` for every tile of the settings' window, in parallel, and adds up the statistics in the order of the tiles.
pub(super) fn render_tiles(
    view: &SceneView<'_>,
    settings: &RenderSettings,
    aovs: AovFlags,
    on_progress: &(dyn Fn(f32) + Sync),
    render: impl Fn(&mut TileRenderer<'_, '_>, PixelWindow) -> Result<RenderStatistics, Cancelled> + Sync,
) -> Result<RenderStatistics, Cancelled> {
    let start = Instant::now();

    // Integrator and camera
    let posed_environment = view.frame.image_light.as_ref().and_then(|pose| view.environment.posed(pose));
    let environment = posed_environment.as_ref().unwrap_or(view.environment);
    let context = IntegratorContext::new(SceneView { environment, ..*view }, integrator_settings(settings));
    let lens = settings.lens.and_then(|lens| lens.at(view, settings.resolution));
    let time_seconds = settings.noise_time.unwrap_or(view.frame.time_seconds) as f32;
    let camera = CameraRays::new(&view.frame.camera, settings.resolution, time_seconds, lens)
        .sharing_pixels(settings.samples);
    let screen = match lens {
        Some(_) => ScreenBounds::EVERYWHERE,
        None => ScreenBounds::new(view, settings.resolution),
    };

    // Tiles, each by the next free worker: what a tile takes is not known before, and differs by orders of magnitude
    let tile_settings =
        TileSettings { camera: &camera, resolution: settings.resolution, screen: &screen, aovs };
    let tiles = tiles(settings.window);
    let (next, finished) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let next_tiles = |_| {
        let mut renderer = None;
        let mut rendered = Vec::new();
        for _ in 0..TILES_A_JOB {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(tile) = tiles.get(index) else { break };
            let renderer = renderer.get_or_insert_with(|| TileRenderer::new(&context, tile_settings));
            rendered.push((index, render(renderer, *tile)?));
            let done = finished.fetch_add(1, Ordering::Relaxed) + 1;
            on_progress(done as f32 / tiles.len() as f32);
        }
        Ok(rendered)
    };
    // With a job to spare for each thread, none is out of jobs while another still has several tiles.
    let jobs = tiles.len().div_ceil(TILES_A_JOB) + rayon::current_num_threads();
    let by_job: Vec<Vec<(usize, RenderStatistics)>> =
        (0..jobs).into_par_iter().with_max_len(1).map(next_tiles).collect::<Result<_, Cancelled>>()?;

    // Statistics, in tile order
    let mut by_tile: Vec<(usize, RenderStatistics)> = by_job.into_iter().flatten().collect();
    by_tile.sort_unstable_by_key(|(index, _)| *index);
    let mut statistics = RenderStatistics::default();
    for (_, tile) in &by_tile {
        statistics.add(tile);
    }
    statistics.trace_seconds = start.elapsed().as_secs_f64();
    Ok(statistics)
}

fn integrator_settings(settings: &RenderSettings) -> IntegratorSettings {
    IntegratorSettings {
        integrator: settings.integrator,
        path: settings.path,
        noise_time: settings.noise_time,
        samples: settings.samples,
        max_samples: settings.adaptive.map_or(settings.samples, |adaptive| adaptive.max_samples),
        max_depth: settings.max_depth,
        glass_shadows: settings.glass_shadows,
        show_background: settings.show_background,
        ground: settings.ground,
        light_scale: settings.light_scale,
        light_size: settings.light_size,
        glossy_samples: settings.glossy_samples,
        env_samples: settings.env_samples,
        environment_shares: settings.environment_shares.clone(),
    }
}
