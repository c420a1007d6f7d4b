//! The ray with which a path goes on.

use arrayvec::ArrayVec;
use glam::Vec3;

use super::dimensions::Decision;
use super::guided_direction::{ProposedDirection, ScatteredDirection};
use super::path_block::PathBlock;
use super::shaded_point::ShadedPoint;
use crate::bsdf::{ScatterLobe, ScatterSample};
use crate::geometry::{ActiveLanes, Facing, LANES, Ray};
use crate::integrator::last_scatter::LastScatter;
use crate::integrator::tracing::Tracer;
use crate::integrator::{LightPass, RayKind, RayState};
use crate::interaction::RayDifferential;

/// Bounces after which Russian roulette may end a path.
const ROULETTE_DEPTH: u32 = 2;

impl Tracer<'_, '_> {
    /// Samples the rays with which the paths of a block go on.
    pub(super) fn send_paths(&mut self, surfaces: &[ShadedPoint<'_, '_>], block: &mut PathBlock) {
        let mut proposed = ArrayVec::<_, LANES>::new();
        let mut rough = ActiveLanes::default();
        for surface in surfaces {
            let u = surface.samples.point(Decision::Direction);
            let choices = surface.samples.point(Decision::LobeAndRoulette);
            let direction = surface.propose_direction(block, choices.x, u);
            if let Some(wi) = direction.as_ref().and_then(ProposedDirection::rough) {
                block.wi.set(surface.lane, wi);
                rough = rough.with(surface.lane);
            }
            proposed.push(direction.map(|direction| (direction, choices.y)));
        }
        if !rough.is_empty() {
            block.scatter(self.context.view.bvh.simd_level(), rough);
        }
        for (surface, proposed) in surfaces.iter().zip(proposed) {
            let sampled = proposed.and_then(|(direction, u_roulette)| {
                let sampled = surface.sample_in(direction, block.scattered(surface.lane))?;
                Some((sampled, u_roulette))
            });
            let is_smooth = sampled.is_some_and(|(sampled, u)| self.send_path(surface, &sampled, u));
            // Mirrors and clear glass show what guides the denoising.
            if !is_smooth {
                self.add_guide((&surface.state, surface.share), (surface.material, surface.point));
            }
        }
    }

    /// Sends the ray with which a path goes on, unless the path ends. Returns whether a mirror or clear glass ends the path or
    /// sends it on.
    fn send_path(
        &mut self,
        shaded: &ShadedPoint<'_, '_>,
        sampled: &ScatteredDirection,
        u_roulette: f32,
    ) -> bool {
        let depth = shaded.state.depth;
        let ScatteredDirection { sample, direction, unguided_ratio } = *sampled;
        let mut weight = shaded.weight * sample.weight;
        let mut guide_share = if sample.is_smooth { shaded.state.guide_share * shaded.share } else { 0.0 };
        let largest = weight.max_element();
        if !(largest > 0.0 && largest < f32::INFINITY) {
            return false;
        }
        // A guided ray has less weight because it finds more light.
        let unguided_ratio = (shaded.state.unguided_ratio * unguided_ratio).clamp(1.0, 1e6);
        let survival = largest * unguided_ratio;
        // Behind the mirror or clear glass of a path that was guided there most likely is light.
        let is_guided = sample.is_smooth && unguided_ratio > 1.0;
        if depth >= ROULETTE_DEPTH && survival < 1.0 && !is_guided {
            if u_roulette >= survival {
                return sample.is_smooth;
            }
            weight /= survival;
            guide_share /= survival;
        }
        let is_smooth = sample.is_smooth;
        self.push_path(shaded, sample, direction, (weight, guide_share, unguided_ratio));
        is_smooth
    }

    /// Sends a path on through a clear thin wall. Returns its weight.
    pub(super) fn pass_wall(&mut self, wall: &ShadedPoint<'_, '_>, transmittance: Vec3) -> Vec3 {
        let weight = wall.weight * transmittance;
        if weight.max_element() > 0.0 {
            let direction = -wall.point.wo;
            let sample = ScatterSample {
                wi: wall.world_from_local.transpose() * direction,
                weight: transmittance,
                pdf: 0.0,
                lobe: ScatterLobe::Transmission,
                is_smooth: true,
                is_unbent: true,
            };
            self.push_path(wall, sample, direction, (weight, 0.0, wall.state.unguided_ratio));
        }
        weight
    }

    fn push_path(
        &mut self,
        shaded: &ShadedPoint<'_, '_>,
        sample: ScatterSample,
        direction: Vec3,
        (weight, guide_share, unguided_ratio): (Vec3, f32, f32),
    ) {
        let (state, point) = (&*shaded.state, shaded.point);
        let is_reflected = shaded.is_outside(direction);
        let origin = if is_reflected { point.origin_outside() } else { point.origin_inside() };
        let frame = self.context.view.frame;
        let differential = match (sample.is_smooth, is_reflected) {
            (false, _) => RayDifferential::ZERO,
            (true, true) => point.reflected_differential(frame, &state.differential),
            (true, false) => {
                point.refracted_differential(frame, &state.differential, direction, shaded.relative_ior)
            }
        };
        // A clear thin wall neither bends nor scatters: the ray is still that of the last surface.
        let last = if sample.is_unbent && shaded.material.thin {
            shaded.last
        } else {
            let (position, normal) = (point.position, shaded.light_normal());
            // No shadow rays look for lights behind a touching surface.
            let is_covered = !is_reflected && shaded.transmission_side.touching.is_some();
            (sample.pdf > 0.0).then_some(LastScatter {
                pdf: if is_covered { f32::INFINITY } else { sample.pdf },
                position,
                depth: state.depth,
                normal,
                visible: shaded.visible,
            })
        };
        // A mirror outside shows glass as the camera does.
        let is_within =
            point.facing == Facing::Back && self.context.interiors.medium(point.instance).is_some();
        let begins_anew = is_reflected && !is_within;
        let has_lamps = !sample.is_smooth || (state.has_lamps && !begins_anew);
        let own_pass = match sample.lobe {
            ScatterLobe::SpecularReflection | ScatterLobe::Diffuse => LightPass::Reflection,
            ScatterLobe::Transmission | ScatterLobe::DiffuseTransmission => LightPass::Refraction,
        };
        let kind = if is_reflected { RayKind::Reflection } else { RayKind::Refraction };
        let side = &shaded.transmission_side;
        let (media, touching) = if is_reflected {
            (state.media.clone(), None)
        } else {
            (side.media.clone(), side.touching.clone())
        };
        let child = RayState {
            differential,
            media,
            touching,
            weight,
            kind,
            channels: shaded.channels,
            light_pass: shaded.light_pass.or(Some(own_pass)),
            guide_share,
            unguided_ratio,
            has_lamps,
            depth: state.depth + 1,
            ..*state
        };
        self.children.push_scattered(shaded.signature.then(kind), Ray::new(origin, direction), child, last);
    }
}
