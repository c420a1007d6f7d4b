//! The ground: shadows as on a shadow catcher, and the mirror image of a polished floor.
//!
//! A shadow is black; its opacity is the share of the ground's light that is occluded, by luminance. It counts
//! the light of the environment even where no shadow rays decide about it, unlike that of a shadow catcher, so that shadows are as
//! dark as on a diffuse floor. A catcher above hides it. The mirror image lies over both shadows: it adds F times the premultiplied colour and
//! coverage of the objects that the mirror ray sees, and nothing of the environment. Catchers far above the ground, such as tables, hide it too.

use super::receiver_shadows::ReceivedLight;
use super::receivers::Receiver;
use super::tracer::Tracer;
use crate::bsdf::dielectric_reflectance;
use crate::bvh::Hit;
use crate::geometry::Ray;
use crate::integrator::least_weights::MIN_WEIGHT;
use crate::integrator::light_set::LightSet;
use crate::integrator::occluders::OccluderBox;
use crate::integrator::random::Purpose;
use crate::integrator::wavefront::RaySlot;
use crate::integrator::{LightPass, RayKind, RayState, TRANSPARENCY_LIMIT};
use crate::interaction::{alpha_at, catches_shadows};
use crate::scene::Ground;

/// Index of refraction of the floor's polish, that of varnish and polished stone.
const FLOOR_IOR: f32 = 1.5;

/// Height of a floor above the ground at most, as a share of its distance: its mirror image, twice as far off, is less than half a degree away from
/// its own. Feet that dip into a floor for a moment lower the ground that far.
const FLOOR_HEIGHT: f32 = 1.0 / 256.0;
/// The same as a share of the diagonal of all shadow casters: four times the gap of the ground below its floor, for short rays.
const FLOOR_GAP: f32 = 1.0 / 8192.0;

/// A ray that hits the ground.
#[derive(Clone, Copy)]
pub(super) struct GroundHit<'r> {
    /// The ground, which is no mirror for rays of the last depth.
    pub(super) ground: Ground,
    pub(super) slot: RaySlot,
    pub(super) ray: &'r Ray,
    pub(super) state: &'r RayState,
    pub(super) t: f32,
    /// The share of the ray that surfaces in front leave, shadows on catchers apart.
    pub(super) through: f32,
    /// The share of the ground's shadow that catchers in front leave. They stand for solid surfaces, which hide it.
    pub(super) shadow_share: f32,
    /// The share of the mirror image that catchers in front leave: all of it where they stand for the floor itself.
    pub(super) image_share: f32,
}

impl GroundHit<'_> {
    /// The hit behind a shadow catcher of this coverage that the ray hits at `t`; `None` where nothing is left of it.
    pub(super) fn behind_catcher(
        self,
        (t, alpha): (f32, f32),
        occluders: Option<OccluderBox>,
    ) -> Option<Self> {
        let shadow_share = self.shadow_share * (1.0 - alpha);
        let is_floor = self.ground.is_mirror && self.is_floor_at(t, occluders);
        let image_share = if is_floor { self.image_share } else { self.image_share * (1.0 - alpha) };
        let is_left = shadow_share > 0.0 || (self.ground.is_mirror && image_share > 0.0);
        is_left.then_some(Self { shadow_share, image_share, ..self })
    }

    /// Whether a catcher that the ray hits at `t` lies close enough to the ground to stand for its floor.
    fn is_floor_at(&self, t: f32, occluders: Option<OccluderBox>) -> bool {
        let height = self.ground.up.dot(self.ray.at(t)) - self.ground.height;
        let gap = occluders.map_or(0.0, |occluders| occluders.diagonal() * FLOOR_GAP);
        height <= t * FLOOR_HEIGHT + gap
    }

    /// The share of the ray that is left for the mirror image. It lies over all shadows of the floor, those on catchers as well.
    pub(super) fn mirror_share(&self) -> f32 {
        if self.ground.is_mirror { self.through * self.image_share } else { 0.0 }
    }

    /// An opacity of the ground in the share `through` of the ray, where it is `opacity` without catchers and they leave `left` of it: they and
    /// the ground share the ray by coverage, as parts of one floor do.
    fn beside_catchers(&self, (opacity, left): (f32, f32), through: f32) -> f32 {
        let share = left * self.through / through;
        if share < 1.0 { opacity * share } else { opacity }
    }
}

impl Tracer<'_, '_> {
    /// Where a ray hits the ground, with nothing in front.
    pub(super) fn ground_hit<'r>(
        &self,
        slot: RaySlot,
        ray: &'r Ray,
        state: &'r RayState,
    ) -> Option<GroundHit<'r>> {
        let settings = &self.context.settings;
        let ground = settings.ground?;
        let t = ground.hit(ray)?;
        let is_mirror = ground.is_mirror && state.depth < settings.max_depth;
        let ground = Ground { is_mirror, ..ground };
        Some(GroundHit { ground, slot, ray, state, t, through: 1.0, shadow_share: 1.0, image_share: 1.0 })
    }

    /// The opacity of the ground where a ray hits it, of which the share `through` is left. `received` is the light there, where it is known, and
    /// `number` that of the receiver along the ray. Sends the mirror ray.
    pub(super) fn ground_alpha(
        &mut self,
        hit: &GroundHit<'_>,
        received: Option<ReceivedLight>,
        number: u32,
        (through, light_pass): (f32, Option<LightPass>),
    ) -> f32 {
        // Nothing is left to darken behind full shadows on catchers.
        let is_shown = hit.shadow_share > 0.0 && through > 0.0;
        let shadow = if is_shown {
            let shadow = self.ground_shadow(hit, received, number);
            hit.beside_catchers((shadow, hit.shadow_share), through)
        } else {
            0.0
        };
        let mirrored = if hit.mirror_share() > 0.0 {
            hit.beside_catchers((self.mirror(hit, light_pass), hit.image_share), through)
        } else {
            0.0
        };
        1.0 - (1.0 - shadow) * (1.0 - mirrored)
    }

    /// The opacity of the ground's shadow without catchers in front.
    fn ground_shadow(&mut self, hit: &GroundHit<'_>, received: Option<ReceivedLight>, number: u32) -> f32 {
        let ReceivedLight { unoccluded, arriving } = received.unwrap_or_else(|| {
            let position = hit.ray.at(hit.t);
            let points = self.receiver_points(hit.state, number);
            let receiver = Receiver { position, normal: hit.ground.up, seed: hit.state.seed, points };
            self.direct_light_on(&receiver, |_| position)
        });
        let light = unoccluded + self.context.ground_irradiance;
        if light > 0.0 { ((unoccluded - arriving) / light).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// Sends the mirror ray of the ground and returns the coverage of what it sees, times its reflectance.
    fn mirror(&mut self, hit: &GroundHit<'_>, light_pass: Option<LightPass>) -> f32 {
        let GroundHit { ground, slot, ray, state, t, .. } = *hit;
        let cosine = -ground.up.dot(ray.direction);
        let reflectance = dielectric_reflectance(cosine, FLOOR_IOR);
        let weight = state.weight * state.media.transmittance(t) * (hit.mirror_share() * reflectance);
        if weight.max_element() < MIN_WEIGHT {
            return 0.0;
        }
        let mirrored = Ray::new(ray.at(t), (ray.direction + ground.up * (2.0 * cosine)).normalize());
        let coverage = self.coverage_along(&mirrored);
        if coverage == 0.0 {
            return 0.0;
        }
        let child = RayState {
            differential: state.differential.mirrored(ray.direction, t, ground.up),
            touching: None,
            shown_lamps: LightSet::default(),
            weight,
            kind: RayKind::GroundReflection,
            light_pass: light_pass.or(Some(LightPass::Reflection)),
            depth: state.depth + 1,
            seed: state.seed.child(Purpose::Reflection, 0, 1),
            ..state.clone()
        };
        self.children.push(slot.signature.then(child.kind), mirrored, child);
        reflectance * coverage
    }

    /// The share of a ray that surfaces cover. It must be known before the ray that hit the ground goes on, so it is found at once.
    fn coverage_along(&mut self, ray: &Ray) -> f32 {
        let view = self.context.view;
        let mut through = 1.0;
        let mut after = None;
        for _ in 0..TRANSPARENCY_LIMIT {
            let is_visible = |hit: &Hit| alpha_at(view, hit) > 0.0 && !catches_shadows(view, hit);
            let Some(hit) = view.bvh.closest_hit(ray, after, is_visible, &mut self.counters) else {
                return 1.0 - through;
            };
            through *= 1.0 - alpha_at(view, &hit);
            if through < MIN_WEIGHT {
                return 1.0;
            }
            after = Some(hit.order());
        }
        1.0
    }
}
