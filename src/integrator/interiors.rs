//! Media of a frame's volumes, and the volumes that contain a point.

use glam::{DVec3, Vec3};

use super::media::{Medium, VolumeId};
use crate::bvh::{Hit, HitOrder, TraversalCounters};
use crate::frame::{Frame, MeshInstance};
use crate::geometry::{Aabb, Facing, Ray};
use crate::interaction::alpha_at;
use crate::scene::Material;
use crate::scene_view::SceneView;

/// The media of a frame's materials, by material index; `None` for materials that bound no volume, and empty where none does. Computed once a frame.
#[derive(Clone, Debug)]
pub(super) struct Interiors(Vec<Option<Interior>>);

#[derive(Clone, Copy, Debug)]
struct Interior {
    ior: f32,
    half_spread: f32,
    extinction: Vec3,
}

impl Interiors {
    /// The media of `materials`.
    pub(super) fn of(materials: &[Material]) -> Self {
        let interior = |material: &Material| {
            let volume = material.volume.filter(|_| material.is_volume())?;
            let distance = volume.attenuation_distance;
            let extinction = volume.attenuation_color.map(|color| extinction(color, distance));
            // (n − 1) / V, halved, with dispersion = 20 / V. No channel's index falls below 1.
            let half_spread = (material.ior - 1.0) * (0.025 * material.dispersion);
            let half_spread = half_spread.clamp(0.0, (material.ior - 1.0).abs());
            Some(Interior { ior: material.ior, half_spread, extinction })
        };
        let interiors: Vec<_> = materials.iter().map(interior).collect();
        Self(if interiors.iter().any(Option::is_some) { interiors } else { Vec::new() })
    }

    /// Whether no material bounds a volume.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn of_instance(&self, instance: &MeshInstance) -> Option<Interior> {
        *self.0.get(instance.material.index())?
    }

    /// The medium inside `instance`, if its material bounds a volume.
    pub(super) fn medium(&self, instance: &MeshInstance) -> Option<Medium> {
        let Interior { ior, half_spread, extinction } = self.of_instance(instance)?;
        let volume =
            VolumeId { node: instance.node, instance: instance.node_instance, material: instance.material };
        Some(Medium { volume, ior, half_spread, extinction })
    }

    /// Bounds of the surfaces of all volumes; empty where there are none.
    pub(super) fn bounds(&self, frame: &Frame) -> Aabb {
        let mut bounds = Aabb::EMPTY;
        let ends = frame.instances.iter().skip(1).map(|next| next.first_triangle as usize);
        let ends = ends.chain(std::iter::once(frame.triangles.len()));
        for (instance, end) in
            frame.instances.iter().zip(ends).filter(|(instance, _)| self.of_instance(instance).is_some())
        {
            let corners =
                frame.triangles[instance.first_triangle as usize..end].iter().flat_map(|t| t.vertices);
            bounds = corners.filter(|corner| corner.is_finite()).fold(bounds, Aabb::union_point);
        }
        bounds
    }

    /// The volumes that contain `position`, outermost first: those that a ray from there leaves more often than it enters. The
    /// volume that the ray leaves first is the innermost. No ray is traced where it misses the `bounds` of all volumes.
    pub(super) fn media_around(&self, view: SceneView<'_>, bounds: &Aabb, position: Vec3) -> Vec<Medium> {
        /// A slanted direction, which avoids axis-aligned edges and vertices.
        const DIRECTION: Vec3 = Vec3::new(0.267_41, 0.801_93, 0.534_27);
        if misses(bounds, position.as_dvec3(), DIRECTION.as_dvec3()) {
            return Vec::new();
        }
        let ray = Ray::new(position, DIRECTION);
        let mut counts: Vec<FaceCount> = Vec::new();
        let mut after = None;
        while let Some(hit) = next_surface(view, &ray, after) {
            after = Some(hit.order());
            if let Some(medium) = self.medium(view.frame.instance(hit.triangle)) {
                count_face(&mut counts, medium, &hit);
            }
        }
        counts.retain(|count| count.leaves > count.enters);
        counts.sort_by(|a, b| b.last_left.total_cmp(&a.last_left));
        counts.into_iter().map(|count| count.medium).collect()
    }
}

/// σ with e^(−σ d) = c. Black stops light within any distance that floats distinguish from zero.
fn extinction(color: f32, distance: f32) -> f32 {
    const BLACK: f32 = 1e30;
    if color <= 0.0 && distance.is_finite() {
        return BLACK;
    }
    let extinction = -libm::logf(color) / distance;
    if extinction > 0.0 { if extinction < BLACK { extinction } else { BLACK } } else { 0.0 }
}

/// Whether a ray whose direction is positive along all axes misses a box for certain; errs towards `false`.
fn misses(bounds: &Aabb, origin: DVec3, direction: DVec3) -> bool {
    if bounds.is_empty() {
        return true;
    }
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    // Far above the error of a hit in single precision.
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

/// Faces of one volume along a ray.
struct FaceCount {
    medium: Medium,
    /// Number of front faces.
    enters: u32,
    /// Number of back faces.
    leaves: u32,
    /// `t` of the last back face.
    last_left: f32,
}

fn count_face(counts: &mut Vec<FaceCount>, medium: Medium, hit: &Hit) {
    let known = counts.iter().position(|count| count.medium.volume == medium.volume);
    let index = known.unwrap_or_else(|| {
        counts.push(FaceCount { medium, enters: 0, leaves: 0, last_left: 0.0 });
        counts.len() - 1
    });
    match hit.facing {
        Facing::Front => counts[index].enters += 1,
        Facing::Back => {
            counts[index].leaves += 1;
            counts[index].last_left = hit.t;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::ColorChannels;
    use crate::scene::{MaterialIndex, NodeIndex};

    fn medium(material: u32, ior: f32) -> Medium {
        let volume = VolumeId { node: NodeIndex(0), instance: 0, material: MaterialIndex(material) };
        Medium { volume, ior, half_spread: 0.0, extinction: Vec3::ZERO }
    }

    #[test]
    fn dispersion_follows_abbe_numbers() {
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
        // Beyond all real media, the index of red does not fall below 1.
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
    fn only_rays_that_certainly_miss_a_box_are_reported() {
        let bounds = Aabb { min: Vec3::new(-1.0, 2.0, 3.0), max: Vec3::new(4.0, 5.0, 9.0) };
        let direction = DVec3::new(0.3, 0.8, 0.5);
        // Rays towards points in the box, from in front of it and from within, do not miss it.
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
