//! Rendering of one frame: tiles in parallel through the integrator into a film.
//!
//! A pixel is the mean of its samples: those of Whitted's tree are summed in their order by one thread, those of paths exactly in any
//! order. Tiles share nothing. So the image depends neither on threads nor on tile order nor on the rendered window. Files and sequences are not known here.

mod adaptive;
mod expected_rays;
mod filter;
mod frame;
mod lens;
mod path_frame;
mod pixel_centers;
mod pixel_noise;
mod pixel_offsets;
mod projector;
mod sample_plan;
mod sample_sink;
mod screen_bounds;
mod settings;
mod shutter_sample;
mod statistics;
mod tile;
mod tile_aovs;
mod tile_grid;
mod tile_loop;
mod tile_pixels;

pub use crate::integrator::{
    EnvSamples, EnvironmentShares, GlassShadows, Integrator, LightSize, PathSettings, SampleRange,
    SharesOfTime,
};
pub use crate::scene_view::SceneView;
pub use adaptive::Adaptive;
pub use expected_rays::expected_rays;
pub use filter::PixelFilter;
pub use frame::{render_frame, render_frame_into};
pub use lens::{Aperture, Focus, Lens};
pub(crate) use path_frame::FIRST_DECISION;
pub use path_frame::{Pass, PathFrame, PathProgress};
pub use pixel_centers::{AdjacentFrames, render_pixel_centers};
pub use settings::RenderSettings;
pub use shutter_sample::ShutterSample;
pub use statistics::RenderStatistics;
pub(crate) use tile_grid::{TILE_SIZE, tile_count};
