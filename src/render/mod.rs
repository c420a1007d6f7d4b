//! One frame: tiles in parallel through the integrator into a film.
//!
//! A pixel is the mean of its samples, summed in sample order by one thread; tiles share nothing. So the picture does not
//! depend on threads, tile order or the window that is rendered. Files and sequences are not known here.

mod adaptive;
mod filter;
mod lens;
mod pixel_centers;
mod plan;
mod projector;
mod sampling;
mod tile;
mod tile_aovs;

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use crate::cancel::{CancelFlag, Cancelled};
use crate::film::{AovFlags, Film, PixelWindow};
use crate::integrator::{CameraRays, IntegratorContext, IntegratorSettings, IntegratorStatistics};

pub use crate::integrator::{GlassShadows, LightSize};
pub use crate::scene_view::SceneView;
pub use adaptive::Adaptive;
pub use filter::PixelFilter;
pub use lens::{Aperture, Focus, Lens};
pub use pixel_centers::{AdjacentFrames, render_pixel_centers};
pub use plan::ShutterSample;

use plan::SamplePlan;
use tile::{RenderedTile, TILE_SIZE, TileRenderer};

/// What decides the picture besides the frame itself.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Size of the whole picture, pixels.
    pub resolution: (u32, u32),
    /// The part that is rendered.
    pub window: PixelWindow,
    /// Samples a pixel.
    pub samples: u32,
    /// More samples for pixels on edges.
    pub adaptive: Option<Adaptive>,
    /// How samples count by where they lie.
    pub filter: PixelFilter,
    /// The camera's lens; without one all is sharp.
    pub lens: Option<Lens>,
    /// Deepest reflection or refraction; 0 shows only what the camera sees.
    pub max_depth: u32,
    /// Shadows under glass.
    pub glass_shadows: GlassShadows,
    /// Multiplies punctual lights.
    pub light_scale: f32,
    /// How large lights are.
    pub light_size: LightSize,
    /// Rays that follow a rough mirror or frosted glass where it is seen first; 0 looks the environment up instead.
    pub glossy_samples: u32,
    /// Whether camera rays that leave the scene see the environment; else they are transparent.
    pub show_background: bool,
    /// What is recorded besides colour and coverage; changes neither of them.
    pub aovs: AovFlags,
}

impl Default for RenderSettings {
    /// What `rayframe render` does unless it is told otherwise.
    fn default() -> Self {
        Self {
            resolution: (1280, 720),
            window: PixelWindow::full(1280, 720),
            samples: 4,
            adaptive: None,
            filter: PixelFilter::Box,
            lens: None,
            max_depth: 8,
            glass_shadows: GlassShadows::Straight,
            light_scale: 1.0,
            light_size: LightSize::default(),
            glossy_samples: 0,
            show_background: true,
            aovs: AovFlags::NONE,
        }
    }
}

/// What rendering one frame did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderStatistics {
    /// Rays, nodes, triangles and dropped weight.
    pub integrator: IntegratorStatistics,
    /// Pixels that came out infinite or not a number, and were set to black.
    pub non_finite_pixels: u64,
    /// Seconds of tracing and shading.
    pub trace_seconds: f64,
}

impl RenderStatistics {
    /// Adds another pass of the same frame.
    pub fn add(&mut self, other: &Self) {
        self.integrator.add(&other.integrator);
        self.non_finite_pixels += other.non_finite_pixels;
        self.trace_seconds += other.trace_seconds;
    }
}

/// Renders one frame with its layers, in parallel on the current rayon pool. There are no frames around it, so nothing
/// moves.
///
/// `on_progress` is called from worker threads with the share of the picture that is finished, 0 to 1.
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

/// One pass of [`render_frame`] into a film of the settings' resolution and window, whose pixels do not matter. Light by parts
/// and coverage are recorded where the film has them; the middles of pixels are left to [`render_pixel_centers`].
pub fn render_frame_into(
    film: &mut Film,
    view: &SceneView<'_>,
    settings: &RenderSettings,
    pass: ShutterSample,
    cancel: &CancelFlag,
    on_progress: &(dyn Fn(f32) + Sync),
) -> Result<RenderStatistics, Cancelled> {
    debug_assert!(film.resolution == settings.resolution && film.window == settings.window);
    let start = Instant::now();
    let integrator_settings = IntegratorSettings {
        max_depth: settings.max_depth,
        glass_shadows: settings.glass_shadows,
        show_background: settings.show_background,
        light_scale: settings.light_scale,
        light_size: settings.light_size,
        glossy_samples: settings.glossy_samples,
    };
    let posed = view.frame.image_light.as_ref().and_then(|pose| view.environment.posed(pose));
    let environment = posed.as_ref().unwrap_or(view.environment);
    let context = IntegratorContext::new(SceneView { environment, ..*view }, integrator_settings);
    let lens = settings.lens.and_then(|lens| lens.at(view, settings.resolution));
    let time_seconds = view.frame.time_seconds as f32;
    let camera = CameraRays::new(&view.frame.camera, settings.resolution, time_seconds, lens)
        .sharing_pixels(settings.samples);
    let plan = SamplePlan::new(settings, pass);

    // Tiles, each by one task
    let request = film.aovs.flags();
    let renderer = || TileRenderer::new(&context, &camera, &plan, settings.resolution).recording(request);
    let tiles = tiles(settings.window);
    let finished = AtomicUsize::new(0);
    let rendered: Vec<RenderedTile> = tiles
        .par_iter()
        .map_init(renderer, |renderer, tile| {
            let result = renderer.render(*tile, cancel)?;
            let done = finished.fetch_add(1, Ordering::Relaxed) + 1;
            on_progress(done as f32 / tiles.len() as f32);
            Ok(result)
        })
        .collect::<Result<_, Cancelled>>()?;

    // The film, in tile order
    let mut statistics = RenderStatistics::default();
    for (tile, rendered) in tiles.iter().zip(&rendered) {
        film.write_tile(*tile, &rendered.pixels);
        film.write_aov_tile(*tile, &rendered.layers);
        statistics.integrator.add(&rendered.statistics);
    }
    statistics.non_finite_pixels = film.blacken_non_finite();
    statistics.trace_seconds = start.elapsed().as_secs_f64();
    Ok(statistics)
}

/// Cuts a window along a grid that is fixed in the whole picture, row by row.
fn tiles(window: PixelWindow) -> Vec<PixelWindow> {
    let starts = |low: u32, high: u32| (low / TILE_SIZE * TILE_SIZE..high).step_by(TILE_SIZE as usize);
    let rows = starts(window.y0, window.y1);
    rows.flat_map(|y| starts(window.x0, window.x1).map(move |x| (x, y)))
        .map(|(x, y)| PixelWindow {
            x0: x.max(window.x0),
            y0: y.max(window.y0),
            x1: (x.saturating_add(TILE_SIZE)).min(window.x1),
            y1: (y.saturating_add(TILE_SIZE)).min(window.y1),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_of_the_window_once() {
        for window in [
            PixelWindow::full(33, 17),
            PixelWindow { x0: 5, y0: 16, x1: 40, y1: 31 },
            PixelWindow { x0: 15, y0: 15, x1: 16, y1: 16 },
        ] {
            let mut count = 0;
            for tile in tiles(window) {
                assert!(tile.x0 < tile.x1 && tile.x1 <= window.x1 && tile.x0 >= window.x0);
                assert!(tile.y0 < tile.y1 && tile.y1 <= window.y1 && tile.y0 >= window.y0);
                assert_eq!(tile.x0 / TILE_SIZE, (tile.x1 - 1) / TILE_SIZE);
                count += tile.width() * tile.height();
            }
            assert_eq!(count, window.width() * window.height());
        }
    }
}
