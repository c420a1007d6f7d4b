//! The environment that mirror and refraction rays see, ray by ray and in blocks of the rays of a wavefront.

use glam::Vec3;

use crate::bvh::Hit;
use crate::geometry::{ActiveLanes, F32Lanes, LANES, Ray, Vec3Lanes};
use crate::integrator::prefiltered_lobe::PrefilteredLobe;
use crate::integrator::tracing::Tracer;
use crate::integrator::wavefront::{RaySlot, Wavefront};
use crate::integrator::{Integrator, LightPass, RayKind, RayState};
use crate::scene::LookupLanes;

/// α of the narrowest prefiltered lobe, of roughness 1/8.
const NARROWEST_ALPHA: f32 = 1.0 / 64.0;

/// What a ray sees of the environment, blurred by the rough lobes that it stands for.
#[derive(Clone, Copy, Debug)]
struct ReflectedView {
    direction: Vec3,
    /// Roughness of the prefiltered lobe.
    roughness: f32,
    /// Its share. Lobes narrower than the narrowest prefiltered one have a part of it, by the square of their width; the rest is what the
    /// differentials of the ray span.
    share: f32,
}

impl ReflectedView {
    fn new(ray: &Ray, state: &RayState) -> Self {
        let (direction, blur) = match state.environment_lobe {
            Some(PrefilteredLobe { direction, roughness }) => {
                (direction, state.blur + (roughness * roughness) * (roughness * roughness))
            }
            None => (ray.direction, state.blur),
        };
        let alpha = blur.sqrt();
        Self {
            direction,
            roughness: alpha.max(NARROWEST_ALPHA).sqrt().min(1.0),
            share: (alpha / NARROWEST_ALPHA).min(1.0),
        }
    }

    /// The radiance from that of both lookups.
    #[inline(always)]
    fn radiance(&self, sharp: impl FnOnce() -> Vec3, blurred: impl FnOnce() -> Vec3) -> Vec3 {
        if self.share == 0.0 {
            sharp()
        } else if self.share < 1.0 {
            blurred() * self.share + sharp() * (1.0 - self.share)
        } else {
            blurred()
        }
    }
}

/// Rays of a wavefront whose environment is looked up together.
#[derive(Debug)]
struct ViewBlock {
    /// Numbers of the rays in the order of the wavefront.
    rays: [usize; LANES],
    views: [ReflectedView; LANES],
    directions: Vec3Lanes,
    differentials: [Vec3Lanes; 2],
    roughness: F32Lanes,
    /// Lanes of rays that see peaks.
    peaks: ActiveLanes,
    count: usize,
}

impl Default for ViewBlock {
    fn default() -> Self {
        let view = ReflectedView { direction: Vec3::ZERO, roughness: 0.0, share: 0.0 };
        Self {
            rays: [0; LANES],
            views: [view; LANES],
            directions: Vec3Lanes::default(),
            differentials: [Vec3Lanes::default(); 2],
            roughness: F32Lanes::default(),
            peaks: ActiveLanes::default(),
            count: 0,
        }
    }
}

impl ViewBlock {
    fn push(&mut self, number: usize, ray: &Ray, state: &RayState) {
        let lane = self.count;
        let view = ReflectedView::new(ray, state);
        self.rays[lane] = number;
        self.directions.set(lane, view.direction);
        for (lanes, differential) in self.differentials.iter_mut().zip(state.differential.direction) {
            lanes.set(lane, differential);
        }
        self.roughness[lane] = view.roughness;
        self.views[lane] = view;
        if state.sees_peaks {
            self.peaks = self.peaks.with(lane);
        }
        self.count += 1;
    }
}

impl Tracer<'_, '_> {
    /// Radiance of the environment that a mirror or refraction ray sees.
    pub(in crate::integrator) fn reflected_environment(&self, ray: &Ray, state: &RayState) -> Vec3 {
        let environment = self.context.view.environment;
        let view = ReflectedView::new(ray, state);
        let ReflectedView { direction, roughness, .. } = view;
        let differentials = state.differential.direction;
        let sharp = || {
            if state.sees_peaks {
                environment.radiance_over(direction, differentials)
            } else {
                environment.open_radiance_over(direction, differentials)
            }
        };
        let blurred =
            || self.with_peaks(environment.prefiltered(direction, roughness), &view, state.sees_peaks);
        view.radiance(sharp, blurred)
    }

    /// The prefiltered radiance of a view, and the peaks of the environment where it sees them.
    fn with_peaks(&self, open: Vec3, view: &ReflectedView, sees_peaks: bool) -> Vec3 {
        if !sees_peaks {
            return open;
        }
        open + self.peaks_in_lobe(PrefilteredLobe { direction: view.direction, roughness: view.roughness })
    }

    /// Finds the radiance of the environment for the rays of a wavefront that hit nothing. `first` returns the first hit of a ray.
    pub(in crate::integrator) fn find_escaped_radiances(
        &mut self,
        wavefront: &Wavefront,
        first: impl Fn(&Self, RaySlot, &RayState) -> Option<Hit>,
    ) {
        self.escaped_radiances.clear();
        let settings = &self.context.settings;
        // The ground may hide the environment. Without an image, lookups of blocks are no faster.
        let are_looked_up = settings.integrator == Integrator::Whitted
            && settings.ground.is_none()
            && self.context.view.environment.is_image();
        if !are_looked_up {
            return;
        }
        let mut radiances = std::mem::take(&mut self.escaped_radiances);
        radiances.resize(wavefront.in_order().len(), None);
        let mut block = ViewBlock::default();
        for (number, &slot) in wavefront.in_order().iter().enumerate() {
            let (ray, state) = wavefront.ray(slot);
            let sees_environment = matches!(state.kind, RayKind::Reflection | RayKind::Refraction);
            if sees_environment && first(self, slot, state).is_none() {
                block.push(number, ray, state);
                if block.count == LANES {
                    self.look_up_views(&mut block, &mut radiances);
                }
            }
        }
        self.look_up_views(&mut block, &mut radiances);
        self.escaped_radiances = radiances;
    }

    /// Sets the radiances of the rays of a block, and removes them from it: [`Tracer::reflected_environment`] of each.
    fn look_up_views(&self, block: &mut ViewBlock, radiances: &mut [Option<Vec3>]) {
        let environment = self.context.view.environment;
        let level = self.context.view.bvh.simd_level();
        let ViewBlock { rays, views, directions, differentials, roughness, peaks, count } = block;
        let lookups = |lanes| LookupLanes { level, directions, lanes };
        let lanes = ActiveLanes::first(*count);
        let sees_peaks = |lane| peaks.contains(lane);
        let mut blurred = Vec3Lanes::default();
        let blurred_lanes = lanes.filtered(|lane| views[lane].share > 0.0);
        if !blurred_lanes.is_empty() {
            environment.prefiltered_lanes(&lookups(blurred_lanes), roughness, &mut blurred);
        }
        let mut sharp = [Vec3Lanes::default(); 2];
        let sharp_lanes = lanes.filtered(|lane| views[lane].share < 1.0);
        let with_peaks = sharp_lanes.filtered(sees_peaks);
        if !with_peaks.is_empty() {
            environment.radiances_over(&lookups(with_peaks), differentials, &mut sharp[1]);
        }
        let open = sharp_lanes.filtered(|lane| !sees_peaks(lane));
        if !open.is_empty() {
            environment.open_radiances_over(&lookups(open), differentials, &mut sharp[0]);
        }
        for lane in lanes {
            let blurred = || self.with_peaks(blurred.get(lane), &views[lane], sees_peaks(lane));
            let sharp = || sharp[usize::from(sees_peaks(lane))].get(lane);
            radiances[rays[lane]] = Some(views[lane].radiance(sharp, blurred));
        }
        (*count, *peaks) = (0, ActiveLanes::default());
    }

    /// Adds the radiance of the environment that a ray sees which hits nothing.
    pub(in crate::integrator) fn add_escaped(&mut self, state: &RayState, radiance: Vec3) {
        let weight = state.weight * state.media.transmittance(f32::INFINITY);
        self.add(state.sample, state.light_pass.unwrap_or(LightPass::Environment), weight * radiance);
    }
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;
    use crate::integrator::tracing::tests::with_context;
    use crate::integrator::wavefront::RaySignature;
    use crate::integrator::{MediaStack, Seed};
    use crate::interaction::RayDifferential;
    use crate::scene::{Environment, EnvironmentImage, EnvironmentMap};

    #[test]
    fn blocks_of_rays_see_what_single_rays_see() {
        // Texels that differ and a sun, so that no two lookups are the same
        let mut pixels: Vec<[f32; 3]> =
            (0..64 * 32).map(|i| [(i * 37 % 101) as f32, (i * 53 % 97) as f32, 1.0]).collect();
        pixels[9 * 64 + 20] = [90_000.0; 3];
        let image = EnvironmentImage { width: 64, height: 32, pixels, content_hash: [0; 32] };
        let map = EnvironmentMap::new(std::path::Path::new("sky.hdr"), image, 20.0).unwrap();
        with_context("demo/whitted_1980", &Environment::Map(map), |context, _| {
            let mut tracer = Tracer::new(context);
            let mut wavefront = Wavefront::default();
            for index in 0..50_u8 {
                let turned =
                    Quat::from_rotation_y(f32::from(index)) * Quat::from_rotation_x(f32::from(index) * 0.3);
                let step = f32::from(index % 7) * 0.1;
                let differential = RayDifferential {
                    direction: [turned * Vec3::X * step, turned * Vec3::Y * 0.02],
                    ..RayDifferential::ZERO
                };
                let mut state = RayState::primary(differential, MediaStack::default(), 0, Seed::default());
                let kinds = [RayKind::Reflection, RayKind::Refraction, RayKind::GroundReflection];
                state.kind = kinds[usize::from(index) % 3];
                state.blur = [0.0, 1e-5, 1e-3, 0.3][usize::from(index) % 4];
                state.sees_peaks = index % 5 < 2;
                if index % 11 == 0 {
                    state.environment_lobe =
                        Some(PrefilteredLobe { direction: turned * Vec3::NEG_Y, roughness: 0.4 });
                }
                wavefront.push(RaySignature::CAMERA, Ray::new(Vec3::ZERO, turned * Vec3::NEG_Z), state);
            }
            tracer.find_escaped_radiances(&wavefront, |_, _, _| None);
            let mut seen = Vec::new();
            for (&slot, found) in wavefront.in_order().iter().zip(&tracer.escaped_radiances) {
                let (ray, state) = wavefront.ray(slot);
                let sees_environment = state.kind != RayKind::GroundReflection;
                assert_eq!(*found, sees_environment.then(|| tracer.reflected_environment(ray, state)));
                seen.extend(*found);
            }
            assert_eq!(seen.len(), 34);
        });
    }
}
