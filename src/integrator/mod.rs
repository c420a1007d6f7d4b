//! From samples of a tile to radiance.
//!
//! An integrator is handed the camera rays of a batch of samples and returns each sample's radiance and coverage, a pure
//! function of (frame, settings, pixel, sample) that does not depend on how samples are batched. [`whitted`] is the one
//! there is. It knows nothing of pixels, films or files.

mod camera;
mod crossings;
mod light_pass;
mod lights;
mod media;
mod path;
mod random;
mod shadow;
pub mod whitted;

use crate::bvh::Bvh;
use crate::geometry::{Aabb, Ray};
use crate::interaction::PosedScene;
use crate::scene::{Environment, Projection};

use lights::PreparedLight;
use media::Interiors;

pub use camera::{CameraRays, ThinLens};
pub use light_pass::{LightPass, LightPasses};
pub use media::{MediaStack, Medium, VolumeId};
pub use path::{Path, PathClass, Spectrum};
pub use random::{R2, Seed};
pub use shadow::PASS_THROUGH_LIMIT;

/// How volumes and thin glass darken what is behind them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GlassShadows {
    /// Light passes straight through, coloured by the glass.
    #[default]
    Straight,
    /// Glass casts full shadows.
    Opaque,
}

/// What decides the radiance of a ray besides the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegratorSettings {
    /// Deepest reflection or refraction; 0 shows only what the camera sees.
    pub max_depth: u32,
    /// Shadows under glass.
    pub glass_shadows: GlassShadows,
    /// Whether camera rays that leave the scene see the environment; else they are transparent.
    pub show_background: bool,
    /// Multiplies the frame's own lights.
    pub light_scale: f32,
    /// How soft shadows are.
    pub light_size: LightSize,
    /// Rays that follow a rough lobe of the first surface; 0 looks the environment up instead.
    pub glossy_samples: u32,
}

impl Default for IntegratorSettings {
    /// What `rayframe render` does unless it is told otherwise.
    fn default() -> Self {
        Self {
            max_depth: 8,
            glass_shadows: GlassShadows::Straight,
            show_background: true,
            light_scale: 1.0,
            light_size: LightSize::default(),
            glossy_samples: 0,
        }
    }
}

/// How large lights are; where that is nothing their shadows are hard.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightSize {
    /// Radius of points and spots, metres.
    pub radius: f32,
    /// Angle that directional lights, and the environment's key light, take up in the sky, radians.
    pub sun_angle_radians: f32,
}

/// Everything that light interacts with in one frame.
#[derive(Clone, Debug)]
pub struct World<'a> {
    /// Surfaces and materials.
    pub posed: PosedScene<'a>,
    /// The hierarchy over the frame's triangles.
    pub bvh: &'a Bvh,
    /// What surrounds the scene.
    pub environment: &'a Environment,
    /// The frame's lights, scaled, and the environment's key light.
    lights: Vec<PreparedLight>,
    /// What fills the frame's volumes.
    interiors: Interiors,
    /// What lies around all of their surfaces.
    volume_bounds: Aabb,
    /// The volumes that the camera is in, outermost first.
    camera_media: Vec<Medium>,
    /// Settings.
    pub settings: IntegratorSettings,
}

impl<'a> World<'a> {
    /// Prepares lights and volumes, and finds the volumes that the camera is in.
    pub fn new(
        posed: PosedScene<'a>,
        bvh: &'a Bvh,
        environment: &'a Environment,
        settings: IntegratorSettings,
    ) -> Self {
        let camera_position = posed.frame.camera.world_from_camera.w_axis.truncate();
        let interiors = Interiors::of(&posed.frame.materials);
        let volume_bounds = interiors.bounds(posed.frame);
        let camera_media = MediaStack::around(posed, bvh, (&interiors, &volume_bounds), camera_position);
        let lights = lights::gather(posed.frame, environment, &settings);
        Self { posed, bvh, environment, lights, interiors, volume_bounds, camera_media, settings }
    }

    /// The volumes that a camera ray starts in: those around the camera, unless parallel rays start beside it.
    pub fn media_around_start(&self, ray: &Ray) -> MediaStack {
        match self.posed.frame.camera.projection {
            Projection::Perspective { .. } => MediaStack::new(self.camera_media.clone()),
            Projection::Orthographic { .. } => {
                let start = ray.at(ray.t_min);
                let volumes = (&self.interiors, &self.volume_bounds);
                MediaStack::new(MediaStack::around(self.posed, self.bvh, volumes, start))
            }
        }
    }
}

/// What an integrator did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IntegratorStatistics {
    /// Rays from the camera.
    pub camera_rays: u64,
    /// Those of them that meet anything.
    pub camera_hits: u64,
    /// Mirror rays.
    pub reflection_rays: u64,
    /// Rays through glass.
    pub refraction_rays: u64,
    /// Shadow rays.
    pub shadow_rays: u64,
    /// Wide nodes visited by all rays.
    pub nodes: u64,
    /// Triangles tested by all rays.
    pub triangles: u64,
    /// Sample weight that the depth limit and the cut-off dropped, in units of whole samples.
    pub dropped_weight: f64,
    /// Rays whose chain of see-through surfaces reached its limit.
    pub pass_through_limit_reached: u64,
    /// Seconds inside the hierarchy's batch queries, summed over threads. Single rays behind see-through surfaces and
    /// the probes of what touches glass are not counted.
    pub query_seconds: f64,
}

impl IntegratorStatistics {
    /// Adds another batch; call in a fixed order, since one of the counts is in floating point.
    pub fn add(&mut self, other: &Self) {
        self.camera_rays += other.camera_rays;
        self.camera_hits += other.camera_hits;
        self.reflection_rays += other.reflection_rays;
        self.refraction_rays += other.refraction_rays;
        self.shadow_rays += other.shadow_rays;
        self.nodes += other.nodes;
        self.triangles += other.triangles;
        self.dropped_weight += other.dropped_weight;
        self.pass_through_limit_reached += other.pass_through_limit_reached;
        self.query_seconds += other.query_seconds;
    }
}
