//! Shading normals and tangents: interpolated, normal-mapped, and bent towards the viewer.

use glam::{Vec2, Vec3};

use super::surface_point::SurfacePoint;
use super::texture_lookup::Lookups;
use crate::frame::{MeshInstance, PosedVertex};
use crate::geometry::{F32Lanes, LANES, Triangle, Vec3Lanes, unit, unit_or};
use crate::scene::{Encoding, INSIDE_OUT_COSINE, NormalTexture};
use crate::scene_view::SceneView;

/// Bisection steps of [`bent_into_view`]; its angle is exact to about 2⁻²⁰.
const BEND_STEPS: usize = 20;

/// Unit normal of the front face; in f64, so that slivers and huge triangles keep a normal.
pub(super) fn of_triangle(triangle: &Triangle) -> Vec3 {
    of_corners(triangle.vertices)
}

/// [`of_triangle`], for loops over lanes.
#[inline(always)]
pub(super) fn of_corners(corners: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = [corners[0].as_dvec3(), corners[1].as_dvec3(), corners[2].as_dvec3()];
    let normal = (b - a).cross(c - a);
    let length = normal.dot(normal).sqrt();
    let unit = (normal / length).as_vec3();
    if length > 0.0 { unit } else { Vec3::Y }
}

/// The shading normal on the viewer's side: interpolated where vertices have normals, with a normal map applied, bent into view.
pub(super) fn mapped_by(
    textures: &Lookups<'_, '_>,
    point: &SurfacePoint<'_>,
    map: Option<&NormalTexture>,
) -> Vec3 {
    bent_into_view(point.geometric_normal, authored_by(textures, point, map), point.wo)
}

/// The same before it is bent.
pub(super) fn authored_by(
    textures: &Lookups<'_, '_>,
    point: &SurfacePoint<'_>,
    map: Option<&NormalTexture>,
) -> Vec3 {
    let side = point.side();
    let front = (point.geometric_normal * side, &vertices_of(textures.view(), point));
    front_normal_by(textures, point, map, front) * side
}

/// Unit tangent and bitangent of the front face; `None` where neither vertex tangents nor texture coordinate set `uv_set` define
/// them.
pub(super) fn tangent_frame(
    view: SceneView<'_>,
    point: &SurfacePoint<'_>,
    uv_set: u32,
) -> Option<(Vec3, Vec3)> {
    let side = point.side();
    let vertices = vertices_of(view, point);
    let normal = interpolated_normal(point, point.geometric_normal * side, &vertices);
    frame_around(view, point, uv_set, normal, tangent_of_set(view, point, &vertices, uv_set))
}

fn vertices_of<'a>(view: SceneView<'a>, point: &SurfacePoint<'_>) -> [&'a PosedVertex; 3] {
    let vertices = &view.frame.vertices[point.instance.first_vertex..];
    let [a, b, c] = point.corners;
    [&vertices[a as usize], &vertices[b as usize], &vertices[c as usize]]
}

fn front_normal_by(
    textures: &Lookups<'_, '_>,
    point: &SurfacePoint<'_>,
    map: Option<&NormalTexture>,
    (front_normal, vertices): (Vec3, &[&PosedVertex; 3]),
) -> Vec3 {
    let normal = interpolated_normal(point, front_normal, vertices);
    let shading = match map {
        Some(map) => {
            let tangent = tangent_of_set(textures.view(), point, vertices, map.texture.uv_set);
            mapped(textures, point, map, normal, tangent)
        }
        None => normal,
    };
    // The map was made for the frame of the authored normals, so the mapped normal is inverted with them.
    shading
        * authored_side(vertices.map(|vertex| vertex.normal), front_normal, inside_out_cosine(point.instance))
}

/// Whether all vertices have normals, so that these are interpolated.
#[inline(always)]
pub(super) fn is_smooth(normals: [Vec3; 3]) -> bool {
    let [a, b, c] = normals;
    a != Vec3::ZERO && b != Vec3::ZERO && c != Vec3::ZERO
}

/// [`authored_side`]'s `least_cosine` for an instance. Where most of a surface is inside out, all that leans away is, also beside hard edges.
pub(super) fn inside_out_cosine(instance: &MeshInstance) -> f32 {
    if instance.is_inside_out { 0.0 } else { INSIDE_OUT_COSINE }
}

/// −1 where the vertex normals of a triangle were authored inside out, and 1 elsewhere. Inside-out normals tell the curvature of the surface, not the side it
/// faces: the cosine between their mean and the reversed normal of the triangle is above `least_cosine`. Those that lean away less belong to the side that they
/// are stored for, such as the upright normals of grass.
#[inline(always)]
pub(super) fn authored_side([a, b, c]: [Vec3; 3], front_normal: Vec3, least_cosine: f32) -> f32 {
    let sum = a + b + c;
    let cosine = sum.dot(front_normal);
    let is_close = cosine * cosine > least_cosine * least_cosine * sum.dot(sum);
    let is_inside_out = is_close && cosine < 0.0 && is_smooth([a, b, c]);
    if is_inside_out { -1.0 } else { 1.0 }
}

/// Sum of three vertex normals, weighted.
#[inline(always)]
pub(super) fn weighted_sum([a, b, c]: [Vec3; 3], weights: [f32; 3]) -> Vec3 {
    a * weights[0] + b * weights[1] + c * weights[2]
}

fn interpolated(
    point: &SurfacePoint<'_>,
    vertices: &[&PosedVertex; 3],
    of: fn(&PosedVertex) -> Vec3,
) -> Vec3 {
    weighted_sum([of(vertices[0]), of(vertices[1]), of(vertices[2])], point.weights)
}

fn interpolated_normal(point: &SurfacePoint<'_>, front_normal: Vec3, vertices: &[&PosedVertex; 3]) -> Vec3 {
    let smooth = vertices.iter().all(|vertex| vertex.normal != Vec3::ZERO);
    if smooth {
        unit(interpolated(point, vertices, |vertex| vertex.normal)).unwrap_or(front_normal)
    } else {
        front_normal
    }
}

/// The interpolated tangent, and the sign of the bitangent.
fn interpolated_tangent(point: &SurfacePoint<'_>, vertices: &[&PosedVertex; 3]) -> (Vec3, f32) {
    (interpolated(point, vertices, |vertex| vertex.tangent.truncate()), vertices[0].tangent.w)
}

/// The same for a texture coordinate set; zero where the tangents were generated from another one.
fn tangent_of_set(
    view: SceneView<'_>,
    point: &SurfacePoint<'_>,
    vertices: &[&PosedVertex; 3],
    uv_set: u32,
) -> (Vec3, f32) {
    let own = point.instance.primitive(view.scene).tangent_uv_set;
    if own.is_some_and(|own| own != uv_set) {
        (Vec3::ZERO, 1.0)
    } else {
        interpolated_tangent(point, vertices)
    }
}

/// N' = T·x + B·y + N·z with B = (N × T)·w (glTF 2.0, section 3.9.3).
fn mapped(
    textures: &Lookups<'_, '_>,
    point: &SurfacePoint<'_>,
    map: &NormalTexture,
    normal: Vec3,
    (tangent, handedness): (Vec3, f32),
) -> Vec3 {
    let texel = textures.value(point, Some(&map.texture), Encoding::Normal);
    // Without a tangent the map is ignored.
    let Some((tangent, bitangent)) =
        frame_around(textures.view(), point, map.texture.uv_set, normal, (tangent, handedness))
    else {
        return normal;
    };
    let local = Vec2::new(2.0 * texel.x - 1.0, 2.0 * texel.y - 1.0) * map.scale;
    let perturbed = tangent * local.x + bitangent * local.y + normal * (2.0 * texel.z - 1.0);
    unit(perturbed).unwrap_or(normal)
}

/// Unit tangent and bitangent, orthogonal to `normal`.
fn frame_around(
    view: SceneView<'_>,
    point: &SurfacePoint<'_>,
    uv_set: u32,
    normal: Vec3,
    (tangent, handedness): (Vec3, f32),
) -> Option<(Vec3, Vec3)> {
    let (tangent, handedness) =
        if tangent == Vec3::ZERO { tangent_from_uvs(view, point, uv_set) } else { (tangent, handedness) };
    let tangent = unit(tangent - normal * normal.dot(tangent))?;
    Some((tangent, normal.cross(tangent) * handedness))
}

/// The direction in which u grows on this triangle, for primitives without tangents. The bitangent is the direction in which v
/// shrinks, because v grows downwards in the image.
fn tangent_from_uvs(view: SceneView<'_>, point: &SurfacePoint<'_>, uv_set: u32) -> (Vec3, f32) {
    let [ta, tb, tc] = point.instance.uvs(view.scene, uv_set as usize, point.corners);
    let [a, b, c] = view.frame.triangles[point.triangle as usize].vertices;
    let (uv1, uv2) = (tb - ta, tc - ta);
    let determinant = uv1.perp_dot(uv2);
    if determinant == 0.0 {
        return (Vec3::ZERO, 1.0);
    }
    let sign = if determinant < 0.0 { -1.0 } else { 1.0 };
    (((b - a) * uv2.y - (c - a) * uv1.y) * sign, -sign)
}

/// The shading normal, turned towards the geometric normal as little as needed for the viewer to be above it and for the mirror
/// ray to leave the surface.
fn bent_into_view(geometric: Vec3, shading: Vec3, wo: Vec3) -> Vec3 {
    if is_in_view(geometric, shading, wo) {
        return shading;
    }
    let mut shares = BendShares::default();
    for _ in 0..BEND_STEPS {
        shares.bisect(geometric, shading, wo);
    }
    shares.bent(geometric, shading)
}

/// [`bent_into_view`] of all lanes that are not in view; `is_in_view` is 1 for the others.
#[inline(always)]
pub(super) fn bend_into_view(
    geometric: &Vec3Lanes,
    shading: &mut Vec3Lanes,
    wo: &Vec3Lanes,
    is_in_view: &F32Lanes,
) {
    let mut shares = [BendShares::default(); LANES];
    for _ in 0..BEND_STEPS {
        for (lane, shares) in shares.iter_mut().enumerate() {
            shares.bisect(geometric.get(lane), shading.get(lane), wo.get(lane));
        }
    }
    for (lane, shares) in shares.iter().enumerate() {
        let bent = shares.bent(geometric.get(lane), shading.get(lane));
        shading.set(lane, if is_in_view[lane] == 1.0 { shading.get(lane) } else { bent });
    }
}

/// Shares of the geometric normal between which a normal comes into view.
#[derive(Clone, Copy)]
struct BendShares {
    hidden: f32,
    visible: f32,
}

impl Default for BendShares {
    fn default() -> Self {
        Self { hidden: 0.0, visible: 1.0 }
    }
}

impl BendShares {
    #[inline(always)]
    fn bisect(&mut self, geometric: Vec3, shading: Vec3, wo: Vec3) {
        let share = (self.hidden + self.visible) * 0.5;
        let is_visible = is_in_view(geometric, normal_between(geometric, shading, share), wo);
        self.visible = if is_visible { share } else { self.visible };
        self.hidden = if is_visible { self.hidden } else { share };
    }

    #[inline(always)]
    fn bent(self, geometric: Vec3, shading: Vec3) -> Vec3 {
        normal_between(geometric, shading, self.visible)
    }
}

/// The unit normal that has a share of the geometric one.
#[inline(always)]
fn normal_between(geometric: Vec3, shading: Vec3, share: f32) -> Vec3 {
    unit_or(shading * (1.0 - share) + geometric * share, geometric)
}

/// Whether the viewer is above a shading normal and the mirror ray leaves the surface.
#[inline(always)]
pub(super) fn is_in_view(geometric: Vec3, shading: Vec3, wo: Vec3) -> bool {
    let cos_o = wo.dot(geometric);
    // At grazing views even the mirror ray about the geometric normal barely leaves the surface.
    let min_cosine = if cos_o * 0.9 < 0.01 { cos_o * 0.9 } else { 0.01 };
    let cos = wo.dot(shading);
    cos > 0.0 && (shading * (2.0 * cos) - wo).dot(geometric) >= min_cosine
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn visible_normals_are_kept() {
        let shading = Vec3::new(0.1, 0.0, 1.0).normalize();
        assert_eq!(bent_into_view(Vec3::Z, shading, Vec3::new(0.3, 0.0, 1.0).normalize()), shading);
    }

    #[test]
    fn normals_that_face_away_are_bent_into_view() {
        for (shading, wo) in [
            (Vec3::new(-1.0, 0.0, 0.1), Vec3::new(1.0, 0.0, 0.3)),
            (Vec3::new(-0.5, 0.0, 0.5), Vec3::new(0.3, 0.0, 0.2)),
            (Vec3::new(0.9, 0.1, 0.2), Vec3::new(1.0, 0.0, 1e-3)),
        ] {
            let (shading, wo) = (shading.normalize(), wo.normalize());
            let bent = bent_into_view(Vec3::Z, shading, wo);
            let mirrored = bent * (2.0 * wo.dot(bent)) - wo;
            assert!(wo.dot(bent) > 0.0 && mirrored.z >= 0.0, "{bent}");
            assert!(bent.dot(shading) > Vec3::Z.dot(shading), "bent no further than needed: {bent}");
        }
    }

    #[test]
    fn normals_near_the_reversed_one_are_inside_out() {
        let leaning = |degrees: f32| {
            let (sin, cos) = libm::sincosf(degrees.to_radians());
            [Vec3::new(sin, 0.0, cos); 3]
        };
        for (degrees, side) in
            [(0.0, 1.0), (89.0, 1.0), (135.0, 1.0), (143.0, 1.0), (144.0, -1.0), (180.0, -1.0)]
        {
            assert_eq!(authored_side(leaning(degrees), Vec3::Z, INSIDE_OUT_COSINE), side, "{degrees}");
        }
        // A cube whose vertices share reversed normals
        let corner = |x: f32, y: f32| Vec3::new(x, y, -1.0).normalize();
        assert_eq!(
            authored_side(
                [corner(1.0, 1.0), corner(-1.0, 1.0), corner(1.0, -1.0)],
                Vec3::Z,
                INSIDE_OUT_COSINE
            ),
            -1.0
        );
        // Without all normals the triangle has its own.
        assert_eq!(authored_side([Vec3::ZERO, Vec3::NEG_Z, Vec3::NEG_Z], Vec3::Z, INSIDE_OUT_COSINE), 1.0);
        // Of a surface that is inside out, all that leans away is.
        assert_eq!(authored_side(leaning(100.0), Vec3::Z, 0.0), -1.0);
        assert_eq!(authored_side(leaning(80.0), Vec3::Z, 0.0), 1.0);
    }

    #[test]
    fn slivers_keep_their_normal() {
        let sliver = Triangle { vertices: [Vec3::ZERO, Vec3::X, Vec3::new(0.5, 1e-30, 0.0)] };
        assert_eq!(of_triangle(&sliver), Vec3::Z);
    }
}
