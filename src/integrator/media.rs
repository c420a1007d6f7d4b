//! Closed volumes that a ray is in: a stack that entering pushes and leaving restores.

use std::rc::Rc;

use glam::{DVec3, Vec3};

use super::color_channels::ColorChannels;
use crate::bvh::{Hit, HitOrder, TraversalCounters};
use crate::frame::{Frame, MeshInstance, is_volume};
use crate::geometry::{Aabb, Facing, Ray};
use crate::interaction::alpha_at;
use crate::scene::{Material, MaterialIndex, NodeIndex};
use crate::scene_view::SceneView;

/// Which closed surface a volume belongs to: the primitives of one node or instance that share a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VolumeId {
    /// The node that draws the surface.
    pub node: NodeIndex,
    /// Which of the node's instances.
    pub instance: u32,
    /// Its material.
    pub material: MaterialIndex,
}

/// The inside of a closed surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// Which surface.
    pub volume: VolumeId,
    /// Index of refraction of green light.
    pub ior: f32,
    /// How much less it is for red light, and more for blue (`KHR_materials_dispersion`).
    pub half_spread: f32,
    /// Absorption a metre.
    pub extinction: Vec3,
}

/// What fills the volumes that a frame's materials bound, by [`MaterialIndex`]: found once, asked at every hit.
#[derive(Clone, Debug)]
pub(super) struct Interiors(Vec<Option<Interior>>);

#[derive(Clone, Copy, Debug)]
struct Interior {
    ior: f32,
    half_spread: f32,
    extinction: Vec3,
}

impl Interiors {
    /// The insides of `materials`.
    pub(super) fn of(materials: &[Material]) -> Self {
        let interior = |material: &Material| {
            let volume = material.volume.filter(|_| is_volume(material))?;
            let distance = volume.attenuation_distance;
            let extinction = volume.attenuation_color.map(|color| extinction(color, distance));
            // (n − 1) / V, halved, with dispersion = 20 / V; no colour's index falls below that of empty space.
            let half_spread = (material.ior - 1.0) * (0.025 * material.dispersion);
            let half_spread = half_spread.clamp(0.0, (material.ior - 1.0).abs());
            Some(Interior { ior: material.ior, half_spread, extinction })
        };
        Self(materials.iter().map(interior).collect())
    }

    /// The inside of `instance`, if its material bounds a volume.
    pub(super) fn medium(&self, instance: &MeshInstance) -> Option<Medium> {
        let Interior { ior, half_spread, extinction } = self.0[instance.material.index()]?;
        let volume =
            VolumeId { node: instance.node, instance: instance.node_instance, material: instance.material };
        Some(Medium { volume, ior, half_spread, extinction })
    }

    /// What lies around the surfaces of all volumes; nothing where there is none.
    pub(super) fn bounds(&self, frame: &Frame) -> Aabb {
        let mut bounds = Aabb::EMPTY;
        let ends = frame.instances.iter().skip(1).map(|next| next.first_triangle as usize);
        let ends = ends.chain(std::iter::once(frame.triangles.len()));
        for (instance, end) in frame
            .instances
            .iter()
            .zip(ends)
            .filter(|(instance, _)| self.0[instance.material.index()].is_some())
        {
            let corners =
                frame.triangles[instance.first_triangle as usize..end].iter().flat_map(|t| t.vertices);
            bounds = corners.filter(|corner| corner.is_finite()).fold(bounds, Aabb::union_point);
        }
        bounds
    }

    /// The volumes around `position`: those that a ray from there leaves more often than it enters. The one that it leaves
    /// first was entered last. Where that ray misses the `bounds` of all volumes, nothing is traced.
    pub(super) fn media_around(&self, view: SceneView<'_>, bounds: &Aabb, position: Vec3) -> Vec<Medium> {
        /// A slanted direction, so that axis-aligned edges and vertices are not met.
        const DIRECTION: Vec3 = Vec3::new(0.267_41, 0.801_93, 0.534_27);
        if misses(bounds, position.as_dvec3(), DIRECTION.as_dvec3()) {
            return Vec::new();
        }
        let ray = Ray::new(position, DIRECTION);
        let mut crossings: Vec<Crossing> = Vec::new();
        let mut after = None;
        while let Some(hit) = next_surface(view, &ray, after) {
            after = Some(hit.order());
            if let Some(medium) = self.medium(view.frame.instance(hit.triangle)) {
                count_crossing(&mut crossings, medium, &hit);
            }
        }
        crossings.retain(|crossing| crossing.leaves > crossing.enters);
        crossings.sort_by(|a, b| b.last_left.total_cmp(&a.last_left));
        crossings.into_iter().map(|crossing| crossing.medium).collect()
    }
}

impl Medium {
    /// Index of refraction of one colour; white light follows green.
    pub fn ior_of(&self, channels: ColorChannels) -> f32 {
        match channels {
            ColorChannels::White | ColorChannels::Green => self.ior,
            ColorChannels::Red => self.ior - self.half_spread,
            ColorChannels::Blue => self.ior + self.half_spread,
        }
    }

    /// Beer–Lambert: what is left of light after `distance` metres, which may be infinite.
    pub fn transmittance(&self, distance: f32) -> Vec3 {
        self.extinction
            .map(|extinction| if extinction > 0.0 { libm::expf(-extinction * distance) } else { 1.0 })
    }
}

/// σ with e^(−σ d) = c; black stops light within any distance that floats can tell from zero.
fn extinction(color: f32, distance: f32) -> f32 {
    const BLACK: f32 = 1e30;
    if color <= 0.0 && distance.is_finite() {
        return BLACK;
    }
    let extinction = -libm::logf(color) / distance;
    if extinction > 0.0 { if extinction < BLACK { extinction } else { BLACK } } else { 0.0 }
}

/// The volumes that a point is in; the last entered one fills the space.
///
/// Every ray has one and nearly all are empty, so that empty ones must cost nothing and others are shared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MediaStack(Option<Rc<[Medium]>>);

impl MediaStack {
    /// The last of `volumes` was entered last.
    pub(super) fn new(volumes: Vec<Medium>) -> Self {
        Self((!volumes.is_empty()).then(|| volumes.into()))
    }

    fn volumes(&self) -> &[Medium] {
        self.0.as_deref().unwrap_or_default()
    }

    /// The medium that fills the space; `None` is empty space.
    pub fn current(&self) -> Option<&Medium> {
        self.volumes().last()
    }

    /// Index of refraction of the space.
    pub fn ior(&self, channels: ColorChannels) -> f32 {
        self.current().map_or(1.0, |medium| medium.ior_of(channels))
    }

    /// Whether colours part at the border of the space.
    pub fn disperses(&self) -> bool {
        self.current().is_some_and(|medium| medium.half_spread > 0.0)
    }

    /// Beer–Lambert over `distance` metres of the space.
    pub fn transmittance(&self, distance: f32) -> Vec3 {
        self.current().map_or(Vec3::ONE, |medium| medium.transmittance(distance))
    }

    /// Whether the stack holds this volume.
    pub fn holds(&self, volume: VolumeId) -> bool {
        self.volumes().iter().any(|medium| medium.volume == volume)
    }

    /// Passes through the surface of `medium`: a front face enters, a back face leaves.
    pub fn cross(&mut self, medium: Medium, facing: Facing) {
        let mut volumes = self.volumes().to_vec();
        match facing {
            Facing::Front => volumes.push(medium),
            Facing::Back => {
                if let Some(last) = volumes.iter().rposition(|held| held.volume == medium.volume) {
                    volumes.remove(last);
                }
            }
        }
        *self = Self::new(volumes);
    }
}

/// Whether a ray whose direction is positive along all axes surely misses a box; errs towards no.
fn misses(bounds: &Aabb, origin: DVec3, direction: DVec3) -> bool {
    if bounds.is_empty() {
        return true;
    }
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    // Far more than what a hit in single precision is off by.
    let margin = (min.abs().max(max.abs()).max(origin.abs()).max_element()) * 1e-5;
    let entry = ((min - margin - origin) / direction).max_element();
    let exit = ((max + margin - origin) / direction).min_element();
    exit < 0.0 || entry > exit
}

fn next_surface(view: SceneView<'_>, ray: &Ray, after: Option<HitOrder>) -> Option<Hit> {
    view.bvh.closest_hit_of_any_side(
        ray,
        after,
        |hit| alpha_at(view, hit) > 0.0,
        &mut TraversalCounters::default(),
    )
}

/// How often a ray passes the surface of one volume.
struct Crossing {
    medium: Medium,
    enters: u32,
    leaves: u32,
    last_left: f32,
}

fn count_crossing(crossings: &mut Vec<Crossing>, medium: Medium, hit: &Hit) {
    let known = crossings.iter().position(|crossing| crossing.medium.volume == medium.volume);
    let index = known.unwrap_or_else(|| {
        crossings.push(Crossing { medium, enters: 0, leaves: 0, last_left: 0.0 });
        crossings.len() - 1
    });
    match hit.facing {
        Facing::Front => crossings[index].enters += 1,
        Facing::Back => {
            crossings[index].leaves += 1;
            crossings[index].last_left = hit.t;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn medium(material: u32, ior: f32) -> Medium {
        let volume = VolumeId { node: NodeIndex(0), instance: 0, material: MaterialIndex(material) };
        Medium { volume, ior, half_spread: 0.0, extinction: Vec3::ZERO }
    }

    #[test]
    fn leaving_restores_the_volume_below() {
        let (glass, water) = (medium(0, 1.5), medium(1, 1.33));
        let mut stack = MediaStack::default();
        stack.cross(glass, Facing::Front);
        stack.cross(water, Facing::Front);
        assert_eq!(stack.ior(ColorChannels::White), 1.33);
        // Leaving the outer one first leaves the inner one in place.
        let mut overlapping = stack.clone();
        overlapping.cross(glass, Facing::Back);
        assert_eq!(overlapping.ior(ColorChannels::White), 1.33);
        stack.cross(water, Facing::Back);
        assert_eq!(stack.ior(ColorChannels::White), 1.5);
        stack.cross(glass, Facing::Back);
        assert_eq!(stack, MediaStack::default());
    }

    #[test]
    fn colours_part_by_abbes_number() {
        // Dispersion 1 is V = 20: n_blue − n_red = (1.6 − 1) / 20 = 0.03, half of it on each side.
        let with = |dispersion| {
            let material = Material {
                ior: 1.6,
                dispersion,
                transmission: Some(crate::scene::Transmission { factor: 1.0, texture: None }),
                volume: Some(crate::scene::Volume::CLEAR),
                ..Material::default()
            };
            let interior = Interiors::of(&[material]).0[0].unwrap();
            let medium = Medium { half_spread: interior.half_spread, ..medium(0, interior.ior) };
            [ColorChannels::Red, ColorChannels::Green, ColorChannels::Blue, ColorChannels::White]
                .map(|of| medium.ior_of(of))
        };
        let [red, green, blue, white] = with(1.0);
        assert!((red - 1.585).abs() < 1e-6 && (blue - 1.615).abs() < 1e-6 && green == 1.6 && white == 1.6);
        assert_eq!(with(0.0), [1.6; 4]);
        // Far beyond what there is, red does not fall below empty space.
        assert!((with(1e9)[0] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn the_attenuation_colour_is_reached_at_the_attenuation_distance() {
        let sigma = extinction(0.25, 2.0);
        let at =
            |distance| Medium { extinction: Vec3::splat(sigma), ..medium(0, 1.5) }.transmittance(distance).x;
        assert!((at(2.0) - 0.25).abs() < 1e-6);
        assert!((at(1.0) - 0.5).abs() < 1e-6);
        assert_eq!(at(f32::INFINITY), 0.0);
    }

    #[test]
    fn black_white_and_infinitely_clear_volumes_give_no_nan() {
        let through = |color, distance, length| {
            Medium { extinction: Vec3::splat(extinction(color, distance)), ..medium(0, 1.5) }
                .transmittance(length)
                .x
        };
        assert_eq!(through(0.0, 1.0, 0.0), 1.0);
        assert_eq!(through(0.0, 1.0, 1e-3), 0.0);
        assert_eq!(through(1.0, 1.0, f32::INFINITY), 1.0);
        assert_eq!(through(0.5, f32::INFINITY, f32::INFINITY), 1.0);
        assert_eq!(through(0.0, f32::INFINITY, 5.0), 1.0);
    }

    #[test]
    fn only_rays_that_surely_miss_a_box_are_said_to() {
        let bounds = Aabb { min: Vec3::new(-1.0, 2.0, 3.0), max: Vec3::new(4.0, 5.0, 9.0) };
        let direction = DVec3::new(0.3, 0.8, 0.5);
        // Towards points inside the box from before and within it; never from behind it, nor past its edges.
        for aim in [DVec3::new(0.0, 3.0, 5.0), DVec3::new(-1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 9.0)] {
            for distance in [0.0, 1.0, 100.0] {
                assert!(!misses(&bounds, aim - direction * distance, direction), "{aim} {distance}");
            }
        }
        for origin in [DVec3::new(4.1, 0.0, 0.0), DVec3::new(0.0, 0.0, 9.1), DVec3::new(0.0, 5.1, 5.0)] {
            assert!(misses(&bounds, origin, direction), "behind: {origin}");
        }
        assert!(misses(&bounds, DVec3::new(3.9, 0.0, 3.0), direction), "beside");
        assert!(misses(&Aabb::EMPTY, DVec3::ZERO, direction));
    }
}
