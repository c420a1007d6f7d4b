//! The frame renderer: one frame into a film.

use std::sync::{Mutex, PoisonError};

use super::path_frame::PathFrame;
use super::pixel_centers::{AdjacentFrames, render_pixel_centers};
use super::sample_plan::SamplePlan;
use super::settings::RenderSettings;
use super::shutter_sample::ShutterSample;
use super::statistics::RenderStatistics;
use super::tile::TileRenderer;
use super::tile_loop::render_tiles;
use crate::cancel::{CancelFlag, Cancelled};
use crate::film::{Film, PixelWindow};
use crate::integrator::Integrator;
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
    let statistics = match settings.integrator {
        Integrator::Whitted => {
            render_frame_into(&mut film, view, settings, ShutterSample::ONLY, cancel, on_progress)?
        }
        Integrator::Path => {
            let mut frame = PathFrame::new(settings, ShutterSample::ONLY.count);
            let mut statistics = RenderStatistics::default();
            while let Some(pass) = frame.next_pass(u32::MAX) {
                let added = frame.add(view, settings, (&pass, ShutterSample::ONLY), cancel, on_progress)?;
                statistics.add(&added);
                frame.finish(&pass);
            }
            frame.sums().resolve_into(&mut film);
            statistics
        }
    };
    render_pixel_centers(&mut film, view, AdjacentFrames { before: view.frame, after: view.frame }, cancel)?;
    Ok((film, statistics))
}

/// Renders one shutter sample of a frame by Whitted's tree into a film of the settings' resolution and window, whose pixels are overwritten.
/// Light passes and coverage are recorded where the film has them. Pixel-centre samples are left to [`render_pixel_centers`]. Pixels of
/// several shutter samples are sums with [`Film::weights`], where the filter has negative lobes, or else means.
pub fn render_frame_into(
    film: &mut Film,
    view: &SceneView<'_>,
    settings: &RenderSettings,
    shutter_sample: ShutterSample,
    cancel: &CancelFlag,
    on_progress: &(dyn Fn(f32) + Sync),
) -> Result<RenderStatistics, Cancelled> {
    debug_assert!(film.resolution == settings.resolution && film.window == settings.window);
    let plan = SamplePlan::new(settings, shutter_sample);
    let flags = film.aovs.flags();
    film.weights = plan.leaves_sums.then(|| {
        let weights = film.weights.take();
        weights.unwrap_or_else(|| vec![0.0; film.window.pixel_count()])
    });
    let shared_film = Mutex::new(&mut *film);
    let render = |renderer: &mut TileRenderer<'_, '_>, tile: PixelWindow| {
        let rendered = renderer.render(tile, &plan, cancel)?;
        let mut film = shared_film.lock().unwrap_or_else(PoisonError::into_inner);
        film.write_tile(tile, rendered.pixels);
        film.write_weight_tile(tile, rendered.weights);
        film.write_aov_tile(tile, &rendered.aovs);
        Ok(RenderStatistics { integrator: rendered.statistics, ..RenderStatistics::default() })
    };
    let mut statistics = render_tiles(view, settings, flags, on_progress, render)?;
    statistics.non_finite_pixels = film.blacken_non_finite();
    Ok(statistics)
}
