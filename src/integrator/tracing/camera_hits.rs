//! Camera rays: one query for a batch of samples, the background where nothing is hit, and ray states only where something is.

use std::ops::Range;
use std::time::Instant;

use glam::Vec3;

use super::tracer::{SampleValue, Tracer, seconds_since};
use crate::geometry::{ActiveLanes, LANES, Ray, Vec3Lanes, vectorized};
use crate::integrator::camera::DifferentialLanes;
use crate::integrator::wavefront::{FollowedRay, RaySignature, Wavefront};
use crate::integrator::{
    CameraRays, CameraSamples, IntegratorContext, LightPass, MediaStack, RayState, Seed,
};
use crate::interaction::alpha_at;
use crate::scene::LookupLanes;

impl Tracer<'_, '_> {
    /// Finds all surfaces that the camera rays of a batch see, in the order of its samples and along each ray. `wavefront` receives
    /// the rays that hit anything.
    pub(super) fn find_camera_hits(
        &mut self,
        camera: &CameraRays,
        samples: &CameraSamples<'_>,
        wavefront: &mut Wavefront,
    ) {
        let media = self.context.camera_media();
        let background = Background::new(self.context, media.as_ref());
        self.statistics.camera_rays += samples.len() as u64;
        let sees_background_alone =
            !samples.may_hit && media.is_some() && self.context.settings.ground.is_none();
        if sees_background_alone && !background.depends_on_direction() {
            return self.add_background(&background, camera, &[], 0..samples.len());
        }

        // Closest hits
        let mut batch = std::mem::take(&mut self.camera_rays);
        batch.fill(self.context.view.bvh.simd_level(), camera, samples);
        let rays = batch.rays();
        if samples.may_hit {
            self.trace_camera_rays(rays);
        } else {
            self.camera_hits.clear();
            self.camera_hits.resize(rays.len(), None);
        }
        let mut followed = std::mem::take(&mut self.followed);
        self.list_followed(rays, media.is_some(), &mut followed);

        // The background between the rays that are followed
        let mut first = 0;
        for &sample in &followed {
            self.add_background(&background, camera, rays, first..sample as usize);
            first = sample as usize + 1;
        }
        self.add_background(&background, camera, rays, first..rays.len());

        self.follow_camera_rays((camera, samples), media.as_ref(), (rays, &followed), wavefront);
        (self.camera_rays, self.followed) = (batch, followed);
    }

    /// Follows the `followed` ones of the camera rays to the surfaces that they see.
    fn follow_camera_rays(
        &mut self,
        (camera, samples): (&CameraRays, &CameraSamples<'_>),
        media: Option<&MediaStack>,
        (rays, followed): (&[Ray], &[u32]),
        wavefront: &mut Wavefront,
    ) {
        let level = self.context.view.bvh.simd_level();
        let mut directions = Vec3Lanes::default();
        let mut differentials = DifferentialLanes::default();
        for followed in followed.chunks(LANES) {
            for (lane, &sample) in followed.iter().enumerate() {
                directions.set(lane, rays[sample as usize].direction);
            }
            vectorized!(level, camera.differentials(&directions, &mut differentials));
            if let Some(points) = &self.context.sample_points {
                for &sample in followed {
                    self.sequences[sample as usize] = samples.sequence(points, sample);
                }
            }
            let context = self.context;
            let states = followed.iter().enumerate().map(|(lane, &sample)| {
                let around_start = || context.media_around_start(&rays[sample as usize]);
                let media = media.cloned().unwrap_or_else(around_start);
                let seed = if context.uses_seeds { samples.seed(camera, sample) } else { Seed::default() };
                RayState::primary(differentials.get(lane), media, sample, seed)
            });
            let rays = followed.iter().map(|&sample| rays[sample as usize]);
            wavefront.extend(RaySignature::CAMERA, rays, states);
        }
        if self.context.has_receivers {
            return self.follow_all(wavefront, |tracer, _, state| tracer.camera_hits[state.sample as usize]);
        }
        for &slot in wavefront.in_order() {
            let (ray, state) = wavefront.ray(slot);
            let followed = FollowedRay { ray, state, last: None };
            self.follow(slot, followed, self.camera_hits[state.sample as usize], None);
        }
    }

    /// Finds the closest hit of each camera ray.
    fn trace_camera_rays(&mut self, rays: &[Ray]) {
        let view = self.context.view;
        let hits = &mut self.camera_hits;
        hits.resize(rays.len(), None);
        let start = Instant::now();
        view.bvh.closest_hits(rays, |_, hit| alpha_at(view, hit) > 0.0, hits, &mut self.counters);
        self.statistics.query_seconds += seconds_since(start);
        self.statistics.camera_hits += hits.iter().filter(|hit| hit.is_some()).count() as u64;
    }

    /// Lists the samples whose rays hit a surface or the ground, or start in media that are not known.
    fn list_followed(&self, rays: &[Ray], media_are_known: bool, followed: &mut Vec<u32>) {
        followed.clear();
        let ground = self.context.settings.ground;
        let hits = (0_u32..).zip(&self.camera_hits);
        if ground.is_none() && media_are_known {
            followed.extend(hits.filter(|(_, hit)| hit.is_some()).map(|(sample, _)| sample));
        } else {
            let is_seen =
                |ray: &Ray| !media_are_known || ground.is_some_and(|ground| ground.hit(ray).is_some());
            let hits = hits.zip(rays).filter(|((_, hit), ray)| hit.is_some() || is_seen(ray));
            followed.extend(hits.map(|((sample, _), _)| sample));
        }
    }

    /// Adds the background to consecutive samples whose rays hit nothing.
    fn add_background(
        &mut self,
        background: &Background,
        camera: &CameraRays,
        rays: &[Ray],
        span: Range<usize>,
    ) {
        if !background.is_visible || span.is_empty() {
            return;
        }
        let environment = self.context.view.environment;
        let values = &mut self.values[span.clone()];
        let add = |value: &mut SampleValue, radiance: Vec3| {
            value.radiance += background.weight * radiance;
            value.coverage = 1.0;
        };
        if let Some(radiance) = background.constant {
            for value in values {
                add(value, radiance);
            }
        } else {
            let level = self.context.view.bvh.simd_level();
            let (mut directions, mut radiances) = (Vec3Lanes::default(), Vec3Lanes::default());
            let mut differentials = DifferentialLanes::default();
            for (values, rays) in values.chunks_mut(LANES).zip(rays[span.clone()].chunks(LANES)) {
                for (lane, ray) in rays.iter().enumerate() {
                    directions.set(lane, ray.direction);
                }
                if background.is_filtered {
                    vectorized!(level, camera.differentials(&directions, &mut differentials));
                }
                let lanes = ActiveLanes::first(rays.len());
                let lookups = LookupLanes { level, directions: &directions, lanes };
                environment.backgrounds(&lookups, &differentials.direction, &mut radiances);
                for (lane, value) in values.iter_mut().enumerate() {
                    add(value, radiances.get(lane));
                }
            }
        }
        if self.aovs.records_light() {
            for sample in span {
                self.aovs.add(sample as u32, LightPass::Environment, self.values[sample].radiance);
            }
        }
    }
}

/// What camera rays see that hit nothing.
struct Background {
    is_visible: bool,
    /// The radiance where it is the same in every direction.
    constant: Option<Vec3>,
    is_filtered: bool,
    /// Multiplies the radiance.
    weight: Vec3,
}

impl Background {
    /// The background of rays that start in `media`.
    fn new(context: &IntegratorContext<'_>, media: Option<&MediaStack>) -> Self {
        let environment = context.view.environment;
        Self {
            is_visible: context.settings.show_background,
            constant: environment.constant_background(),
            is_filtered: environment.background_is_filtered(),
            weight: media.map_or(Vec3::ONE, |media| media.transmittance(f32::INFINITY)),
        }
    }

    /// Whether it differs between rays.
    fn depends_on_direction(&self) -> bool {
        self.is_visible && self.constant.is_none()
    }
}
