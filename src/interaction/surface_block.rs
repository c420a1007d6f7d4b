//! Surface points of a block of hits, computed lane by lane.
//!
//! The values are those of [`SurfacePoint::new`], by the same functions. Loops over lanes are vectorised; only normal maps are left to each point.

use std::cell::RefCell;

use glam::Vec3;

use super::material::material_at;
use super::normal;
use super::normal::is_smooth;
use super::ray_differential::{RayDifferential, weight_steps};
use super::surface::{corner_indices, offset_distance, position_of, terminator_free_point};
use super::surface_differentials::normal_steps;
use super::texture_lookup::{Lookups, TextureProbes};
use super::{MaterialSample, SurfacePoint};
use crate::bvh::Hit;
use crate::geometry::{F32Lanes, Facing, LANES, Ray, Vec2Lanes, Vec3Lanes, unit_or, vectorized};
use crate::scene::Material;
use crate::scene_view::SceneView;

/// A hit with the ray that found it.
#[derive(Clone, Copy, Debug)]
pub struct RayHit<'r> {
    /// The ray.
    pub ray: &'r Ray,
    /// Change of the ray to its neighbours.
    pub differential: &'r RayDifferential,
    /// The hit.
    pub hit: &'r Hit,
}

/// Surface points of up to sixteen hits on one material. Keeps its memory from block to block.
#[derive(Debug, Default)]
pub struct SurfaceBlock<'a> {
    /// The points, in the order of the hits.
    pub points: Vec<SurfacePoint<'a>>,
    hits: HitLanes,
    surfaces: SurfaceLanes,
    probes: RefCell<TextureProbes>,
}

/// Hits and the triangles that they lie on.
#[derive(Debug, Default)]
struct HitLanes {
    /// Directions of the rays.
    direction: Vec3Lanes,
    t: F32Lanes,
    /// Weights of the second and third corner.
    u: F32Lanes,
    v: F32Lanes,
    /// 1 for front faces, −1 for back faces.
    side: F32Lanes,
    corners: [Vec3Lanes; 3],
    normals: [Vec3Lanes; 3],
    /// See [`normal::inside_out_cosine`].
    inside_out_cosine: F32Lanes,
    /// Differentials of the rays.
    origin_steps: [Vec3Lanes; 2],
    direction_steps: [Vec3Lanes; 2],
    /// 1 for rays with an extent, 0 for others.
    has_extent: F32Lanes,
}

/// See the fields of the same names of [`SurfacePoint`].
#[derive(Debug, Default)]
struct SurfaceLanes {
    position: Vec3Lanes,
    front_normal: Vec3Lanes,
    wo: Vec3Lanes,
    geometric_normal: Vec3Lanes,
    offset_distance: F32Lanes,
    shadow_position: Vec3Lanes,
    /// The interpolated normal on the viewer's side; mapped and bent into view in the end.
    shading_normal: Vec3Lanes,
    /// 1 where that normal needs no bending.
    is_in_view: F32Lanes,
    position_steps: [Vec3Lanes; 2],
    /// Not zero for rays without an extent on degenerate triangles.
    weight_steps: [Vec2Lanes; 2],
    normal_steps: [Vec3Lanes; 2],
}

impl<'a> SurfaceBlock<'a> {
    /// Replaces the points by those of `hits`, at most sixteen on `material`.
    pub fn fill<'r>(
        &mut self,
        view: SceneView<'a>,
        material: &Material,
        hits: impl ExactSizeIterator<Item = RayHit<'r>>,
    ) {
        self.points.clear();
        for (lane, hit) in hits.enumerate() {
            self.gather(view, lane, hit);
        }
        let is_textured = material.texture_refs().next().is_some();
        let Self { surfaces, hits, .. } = self;
        vectorized!(view.bvh.simd_level(), surfaces.compute(hits, is_textured));
        self.finish(view, material, is_textured);
    }

    /// Computes the derivatives of normals that child rays need. `material` is that of [`SurfaceBlock::fill`].
    pub fn compute_normal_steps(&mut self, view: SceneView<'a>, material: &Material) {
        let is_textured = material.texture_refs().next().is_some();
        let Self { points, surfaces, hits, .. } = self;
        vectorized!(view.bvh.simd_level(), {
            if !is_textured {
                surfaces.extend_weights(hits);
            }
            surfaces.extend_normals(hits);
        });
        for (lane, point) in points.iter_mut().enumerate() {
            point.normal_steps = Some(pair(&surfaces.normal_steps, lane));
        }
    }

    /// Material values at a point.
    pub fn material(&self, view: SceneView<'a>, lane: usize) -> MaterialSample {
        material_at(&Lookups::new(view, &self.probes), &self.points[lane])
    }

    /// Whether the instance of a point has vertex colours.
    pub fn has_vertex_colors(&self, view: SceneView<'a>, lane: usize) -> bool {
        self.points[lane].instance.has_colors(view.scene)
    }

    /// Positions of the points.
    pub(crate) fn positions(&self) -> &Vec3Lanes {
        &self.surfaces.position
    }

    /// Shading normals of the points.
    pub(crate) fn normals(&self) -> &Vec3Lanes {
        &self.surfaces.shading_normal
    }

    /// Unit vectors towards the viewer.
    pub(crate) fn viewers(&self) -> &Vec3Lanes {
        &self.surfaces.wo
    }

    /// Copies a hit and its triangle into a lane, and adds its point.
    #[inline(always)]
    fn gather(&mut self, view: SceneView<'a>, lane: usize, RayHit { ray, differential, hit }: RayHit<'_>) {
        let frame = view.frame;
        let instance = frame.instance(hit.triangle);
        let corners = corner_indices(view, instance, hit.triangle);
        let triangle = &frame.triangles[hit.triangle as usize];
        let lanes = &mut self.hits;
        lanes.direction.set(lane, ray.direction);
        (lanes.t[lane], lanes.u[lane], lanes.v[lane]) = (hit.t, hit.u, hit.v);
        lanes.side[lane] = if hit.facing == Facing::Front { 1.0 } else { -1.0 };
        for (corner, index) in corners.into_iter().enumerate() {
            let vertex = &frame.vertices[instance.first_vertex + index as usize];
            lanes.corners[corner].set(lane, triangle.vertices[corner]);
            lanes.normals[corner].set(lane, vertex.normal);
        }
        for axis in 0..2 {
            lanes.origin_steps[axis].set(lane, differential.origin[axis]);
            lanes.direction_steps[axis].set(lane, differential.direction[axis]);
        }
        lanes.inside_out_cosine[lane] = normal::inside_out_cosine(instance);
        lanes.has_extent[lane] = if *differential == RayDifferential::ZERO { 0.0 } else { 1.0 };
        self.points.push(SurfacePoint {
            instance,
            triangle: hit.triangle,
            facing: hit.facing,
            corners,
            weights: [1.0 - hit.u - hit.v, hit.u, hit.v],
            ..SurfacePoint::unplaced(instance)
        });
    }

    /// Completes the points.
    fn finish(&mut self, view: SceneView<'a>, material: &Material, is_textured: bool) {
        let lanes = &mut self.surfaces;
        for (lane, point) in self.points.iter_mut().enumerate() {
            point.position = lanes.position.get(lane);
            point.wo = lanes.wo.get(lane);
            point.geometric_normal = lanes.geometric_normal.get(lane);
            point.offset_distance = lanes.offset_distance[lane];
            point.shadow_position = lanes.shadow_position.get(lane);
            point.position_steps = pair(&lanes.position_steps, lane);
            let has_extent = self.hits.has_extent[lane] == 1.0;
            if is_textured && has_extent && !point.instance.primitive(view.scene).uvs.is_empty() {
                let [row, column] = &lanes.weight_steps;
                point.weight_steps = [row.get(lane), column.get(lane)];
            }
            if material.normal_texture.is_some() {
                point.shading_normal = point.geometric_normal;
                let textures = Lookups::new(view, &self.probes);
                let mapped = normal::authored_by(&textures, point, material.normal_texture.as_ref());
                lanes.shading_normal.set(lane, mapped);
            }
        }

        // Bend normals into view.
        let level = view.bvh.simd_level();
        if material.normal_texture.is_some() {
            vectorized!(level, lanes.find_normals_in_view());
        }
        if lanes.is_in_view.iter().take(self.points.len()).any(|&is_in_view| is_in_view != 1.0) {
            let SurfaceLanes { geometric_normal, shading_normal, wo, is_in_view, .. } = lanes;
            vectorized!(level, normal::bend_into_view(geometric_normal, shading_normal, wo, is_in_view));
        }
        for (lane, point) in self.points.iter_mut().enumerate() {
            point.shading_normal = lanes.shading_normal.get(lane);
        }
    }
}

#[inline(always)]
fn pair([first, second]: &[Vec3Lanes; 2], lane: usize) -> [Vec3; 2] {
    [first.get(lane), second.get(lane)]
}

#[inline(always)]
fn triple([first, second, third]: &[Vec3Lanes; 3], lane: usize) -> [Vec3; 3] {
    [first.get(lane), second.get(lane), third.get(lane)]
}

impl HitLanes {
    #[inline(always)]
    fn corners(&self, lane: usize) -> [Vec3; 3] {
        triple(&self.corners, lane)
    }

    #[inline(always)]
    fn weights(&self, lane: usize) -> [f32; 3] {
        [1.0 - self.u[lane] - self.v[lane], self.u[lane], self.v[lane]]
    }
}

impl SurfaceLanes {
    #[inline(always)]
    fn compute(&mut self, hits: &HitLanes, is_textured: bool) {
        self.place(hits);
        self.orient(hits);
        self.extend(hits);
        if is_textured {
            self.extend_weights(hits);
        }
    }

    /// Positions and normals of the triangles; in doubles.
    #[inline(always)]
    fn place(&mut self, hits: &HitLanes) {
        for lane in 0..LANES {
            let corners = hits.corners(lane);
            self.position.set(lane, position_of(corners, [hits.u[lane], hits.v[lane]]));
            self.front_normal.set(lane, normal::of_corners(corners));
        }
    }

    /// Directions to the viewer, normals on his side, and offsets.
    #[inline(always)]
    fn orient(&mut self, hits: &HitLanes) {
        for lane in 0..LANES {
            let (position, front_normal) = (self.position.get(lane), self.front_normal.get(lane));
            let (corners, weights) = (hits.corners(lane), hits.weights(lane));
            let side = hits.side[lane];
            let geometric_normal = front_normal * side;
            let wo = -unit_or(hits.direction.get(lane), Vec3::Y);
            self.wo.set(lane, wo);
            self.geometric_normal.set(lane, geometric_normal);
            self.offset_distance[lane] = offset_distance(front_normal, position, corners);

            // Interpolated normals
            let normals = triple(&hits.normals, lane);
            let is_smooth = is_smooth(normals);
            let authored_side = normal::authored_side(normals, front_normal, hits.inside_out_cosine[lane]);
            let outward = normals.map(|normal| normal * (side * authored_side));
            let lifted = terminator_free_point(position, geometric_normal, corners, outward, weights);
            self.shadow_position.set(lane, if is_smooth { lifted } else { position });
            let smooth = unit_or(normal::weighted_sum(normals, weights), front_normal);
            let normal = if is_smooth { smooth } else { front_normal };
            self.shading_normal.set(lane, normal * (side * authored_side));
        }
        self.find_normals_in_view();
    }

    /// Finds the normals that need no bending.
    #[inline(always)]
    fn find_normals_in_view(&mut self) {
        for lane in 0..LANES {
            let (geometric, shading) = (self.geometric_normal.get(lane), self.shading_normal.get(lane));
            let is_in_view = normal::is_in_view(geometric, shading, self.wo.get(lane));
            self.is_in_view[lane] = if is_in_view { 1.0 } else { 0.0 };
        }
    }

    /// Steps on the surfaces to the hits of the neighbouring rays.
    #[inline(always)]
    fn extend(&mut self, hits: &HitLanes) {
        for lane in 0..LANES {
            let differential = RayDifferential {
                origin: pair(&hits.origin_steps, lane),
                direction: pair(&hits.direction_steps, lane),
            };
            let normal = self.front_normal.get(lane);
            let steps = differential.on_surface(hits.direction.get(lane), hits.t[lane], normal);
            let has_extent = hits.has_extent[lane] == 1.0;
            let [row, column] = &mut self.position_steps;
            row.set(lane, if has_extent { steps[0] } else { Vec3::ZERO });
            column.set(lane, if has_extent { steps[1] } else { Vec3::ZERO });
        }
    }

    /// Changes of the barycentric weights over these steps; in doubles.
    #[inline(always)]
    fn extend_weights(&mut self, hits: &HitLanes) {
        for lane in 0..LANES {
            let steps = weight_steps(hits.corners(lane), pair(&self.position_steps, lane));
            let [row, column] = &mut self.weight_steps;
            row.set(lane, steps[0]);
            column.set(lane, steps[1]);
        }
    }

    /// Derivatives of the interpolated normals.
    #[inline(always)]
    fn extend_normals(&mut self, hits: &HitLanes) {
        for lane in 0..LANES {
            let [row, column] = &self.weight_steps;
            let weight_steps = [row.get(lane), column.get(lane)];
            let normals = triple(&hits.normals, lane);
            let front_normal = self.front_normal.get(lane);
            let authored_side = normal::authored_side(normals, front_normal, hits.inside_out_cosine[lane]);
            let side = hits.side[lane] * authored_side;
            let steps = normal_steps(normals, hits.weights(lane), weight_steps, side);
            let [row, column] = &mut self.normal_steps;
            row.set(lane, steps[0]);
            column.set(lane, steps[1]);
        }
    }
}
