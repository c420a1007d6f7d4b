//! Where shadow rays can be blocked: in a box around all surfaces that cast shadows.

use std::f32::consts::TAU;

use glam::{Mat3, Vec2, Vec3};
use rayon::prelude::*;

use super::local_frame::local_frame;
use crate::bvh::TriangleFlags;
use crate::frame::Frame;
use crate::geometry::{Aabb, Ray, sin_cos_of_turn};

/// Margin of the box for the rounding of rays, as a share of its diagonal.
const MARGIN: f32 = 0.0005;
/// The same for the rounding of coordinates and distances, as a share of these.
const ROUNDING: f32 = 8.0 * f32::EPSILON;
/// Triangles of one parallel task.
const TRIANGLES_PER_TASK: usize = 16_384;

/// A box around all surfaces that cast shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OccluderBox {
    center: Vec3,
    half_extent: Vec3,
}

/// Directions above a surface in a range of azimuths and elevations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DirectionRange {
    /// Tangent, bitangent and normal of the surface.
    frame: Mat3,
    /// Unit vector in the tangent plane from which azimuths count, towards the bitangent.
    start: Vec2,
    /// Azimuths, radians: at most half a turn, or a whole one.
    span: f32,
    /// Squared sines of the lowest and the highest elevation.
    sines_squared: [f32; 2],
}

impl OccluderBox {
    /// The box around the visible triangles of a frame but those of shadow catchers.
    pub(super) fn of(frame: &Frame) -> Self {
        let casts_shadows = |instance: u32| {
            let material = frame.instances[instance as usize].material;
            !frame.materials[material.index()].is_shadow_catcher
        };
        let casts_shadows: Vec<bool> = (0..frame.instances.len() as u32).map(casts_shadows).collect();
        let triangles = frame.triangles.par_iter().zip(&frame.flags).zip(&frame.instance_of_triangle);
        let bounds = triangles
            .with_min_len(TRIANGLES_PER_TASK)
            .filter(|((_, flags), instance)| {
                !flags.has(TriangleFlags::HIDDEN) && casts_shadows[**instance as usize]
            })
            .map(|((triangle, _), _)| triangle.bounds())
            .reduce(|| Aabb::EMPTY, Aabb::union);
        Self::new(bounds)
    }

    /// Length of its diagonal; 0 if nothing casts shadows.
    pub(super) fn diagonal(&self) -> f32 {
        if self.is_empty() { 0.0 } else { 2.0 * self.half_extent.length() }
    }

    pub(super) fn new(bounds: Aabb) -> Self {
        if bounds.is_empty() {
            return Self { center: Vec3::ZERO, half_extent: Vec3::NEG_INFINITY };
        }
        let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
        let margin = bounds.extent().length() * MARGIN + farthest * ROUNDING;
        Self { center: bounds.center(), half_extent: bounds.extent() * 0.5 + margin }
    }

    /// Whether nothing casts shadows.
    fn is_empty(&self) -> bool {
        self.half_extent.x < 0.0
    }

    /// Whether a ray misses the box.
    pub(super) fn is_missed_by(&self, ray: &Ray) -> bool {
        let (to_center, inverse) = (self.center - ray.origin, ray.direction.recip());
        let [low, high] = [-self.half_extent, self.half_extent].map(|offset| (to_center + offset) * inverse);
        let near = low.min(high).max_element().max(ray.t_min);
        let far = low.max(high).min_element().min(ray.t_max);
        self.is_empty() || near * (1.0 - ROUNDING) > far * (1.0 + ROUNDING)
    }

    /// The directions from a point of a surface towards the box; `None` if they may have any azimuth. They are those to a box that lies along the
    /// surface's tangents.
    pub(super) fn range_from(&self, point: Vec3, normal: Vec3) -> Option<DirectionRange> {
        let frame = local_frame(normal);
        let nothing = DirectionRange { frame, start: Vec2::X, span: 0.0, sines_squared: [0.0; 2] };
        let span = self.center - point;
        let along = |axis: Vec3| (span.dot(axis), self.half_extent.dot(axis.abs()));
        let [(x, half_x), (y, half_y), (height, half_height)] =
            [frame.x_axis, frame.y_axis, frame.z_axis].map(along);
        let (lowest, highest) = (height - half_height, height + half_height);
        if self.is_empty() || highest <= 0.0 {
            return Some(nothing);
        }

        // Elevations: the top at the nearest distance, the base at the farthest.
        let nearest = Vec2::new((x.abs() - half_x).max(0.0), (y.abs() - half_y).max(0.0)).length_squared();
        let is_below = nearest <= 0.0;
        if is_below && lowest <= 0.0 {
            return None;
        }
        let farthest = Vec2::new(x.abs() + half_x, y.abs() + half_y).length_squared();
        let sine_squared =
            |height: f32, distance_squared: f32| height * height / (height * height + distance_squared);
        let sines_squared = [sine_squared(lowest.max(0.0), farthest), sine_squared(highest, nearest)];
        if is_below {
            return Some(DirectionRange { span: TAU, sines_squared, ..nothing });
        }

        // Azimuths: the two corners between which all others are seen
        let center = Vec2::new(x, y);
        let corners = [(-half_x, -half_y), (half_x, -half_y), (-half_x, half_y), (half_x, half_y)]
            .map(|(x, y)| center + Vec2::new(x, y));
        let (mut first, mut last) = ((f32::INFINITY, center), (f32::NEG_INFINITY, center));
        for corner in corners {
            let order = angle_order(center, corner);
            if order < first.0 {
                first = (order, corner);
            }
            if order > last.0 {
                last = (order, corner);
            }
        }
        let (first, last) = (first.1, last.1);
        let span = libm::atan2f(first.perp_dot(last), first.dot(last)).max(0.0);
        Some(DirectionRange { start: first.normalize_or(Vec2::X), span, sines_squared, ..nothing })
    }
}

/// A number that grows with the angle from one vector to another, from -2 at minus half a turn to 2 at half a turn.
fn angle_order(from: Vec2, to: Vec2) -> f32 {
    let (sine, cosine) = (from.perp_dot(to), from.dot(to));
    let share = cosine / (sine.abs() + cosine.abs());
    if sine >= 0.0 { 1.0 - share } else { share - 1.0 }
}

impl DirectionRange {
    /// Unit normal of the surface.
    pub(super) fn normal(&self) -> Vec3 {
        self.frame.z_axis
    }

    /// The first azimuth from the tangent of [`local_frame`], from 0 to a whole turn, radians.
    pub(super) fn start_azimuth(&self) -> f32 {
        let azimuth = libm::atan2f(self.start.y, self.start.x);
        if azimuth < 0.0 { azimuth + TAU } else { azimuth }
    }

    /// Azimuths, radians.
    pub(super) fn span(&self) -> f32 {
        self.span
    }

    /// Squared sines of the lowest and the highest elevation.
    pub(super) fn sines_squared(&self) -> [f32; 2] {
        self.sines_squared
    }

    /// The irradiance of the surface by a radiance of 1 from all directions of the range: its projected solid angle, steradians.
    pub(super) fn projected_solid_angle(&self) -> f32 {
        let [lowest, highest] = self.sines_squared;
        0.5 * self.span * (highest - lowest)
    }

    /// A direction, by its cosine to the normal.
    pub(super) fn direction(&self, u: Vec2) -> Vec3 {
        let (sine, cosine) = sin_cos_of_turn(u.x * self.span);
        let azimuth = self.start.rotate(Vec2::new(cosine, sine));
        let [lowest, highest] = self.sines_squared;
        let sine_squared = lowest + (highest - lowest) * u.y;
        self.frame * local_direction((azimuth.y, azimuth.x), sine_squared)
    }
}

/// The unit vector of an azimuth, by its sine and cosine, and a squared sine of the elevation, above a surface along z.
#[inline(always)]
pub(super) fn local_direction((sine, cosine): (f32, f32), sine_squared: f32) -> Vec3 {
    let level = (1.0 - sine_squared).max(0.0).sqrt();
    Vec3::new(cosine * level, sine * level, sine_squared.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::spiral_direction;
    use crate::scene::{Selection, SelectionRequest, mark_shadow_catchers};

    fn around(center: Vec3, half_extent: Vec3) -> OccluderBox {
        OccluderBox::new(Aabb { min: center - half_extent, max: center + half_extent })
    }

    /// The azimuth of a direction from the range's first one, radians, and its squared sine of elevation.
    fn coordinates(range: &DirectionRange, direction: Vec3) -> (f32, f32) {
        let local = range.frame.transpose() * direction.normalize();
        let (sine, cosine) = (range.start.perp_dot(local.truncate()), range.start.dot(local.truncate()));
        (libm::atan2f(sine, cosine), local.z * local.z)
    }

    #[test]
    fn the_box_holds_what_casts_shadows_and_nothing_else() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/environment/shadow_catcher.gltf");
        let mut scene = crate::gltf::import(path.as_ref(), &crate::gltf::ImportOptions::default()).unwrap();
        let (selection, _) = Selection::resolve(&SelectionRequest::default(), &scene).unwrap();
        let with_floor = OccluderBox::of(&Frame::at(&scene, &selection, 0.0));
        assert!(mark_shadow_catchers(&mut scene, "floor") > 0);
        let mut frame = Frame::at(&scene, &selection, 0.0);
        let without_floor = OccluderBox::of(&frame);
        assert!(without_floor.half_extent.length() < 0.5 * with_floor.half_extent.length());
        let casts = |frame: &Frame, index: usize| {
            let material = frame.instances[frame.instance_of_triangle[index] as usize].material;
            !frame.materials[material.index()].is_shadow_catcher
        };
        for (index, triangle) in frame.triangles.iter().enumerate().filter(|(index, _)| casts(&frame, *index))
        {
            let is_inside =
                |corner: &Vec3| (*corner - without_floor.center).abs().cmple(without_floor.half_extent).all();
            assert!(triangle.vertices.iter().all(is_inside), "{index}");
        }

        // Hidden triangles are not there.
        let last = (0..frame.triangles.len()).rev().find(|&index| casts(&frame, index)).unwrap();
        for index in 0..frame.triangles.len() {
            if index != last {
                frame.flags[index] = frame.flags[index].with(TriangleFlags::HIDDEN);
            }
        }
        let of_last = OccluderBox::of(&frame);
        assert_eq!(of_last, OccluderBox::new(frame.triangles[last].bounds()));
        assert_eq!(OccluderBox::of(&Frame::default()), OccluderBox::new(Aabb::EMPTY));
    }

    #[test]
    fn ranges_hold_the_directions_to_the_box() {
        let (center, half_extent) = (Vec3::new(1.0, 0.5, -2.0), Vec3::new(0.3, 0.8, 1.5));
        let occluders = around(center, half_extent);
        let mut ranges = 0;
        for i in 0..200 {
            let normal = if i % 2 == 0 { Vec3::Y } else { spiral_direction(i, 200) };
            let point = center + spiral_direction(i * 7 % 200, 200) * (0.4 + 0.02 * i as f32);
            let Some(range) = occluders.range_from(point, normal) else { continue };
            ranges += 1;
            assert!((0.0..=std::f32::consts::PI).contains(&range.span) || range.span == TAU);
            for j in 0..500 {
                let j = j as f32;
                let share = Vec3::new(j * 0.8191725, j * 0.6710436, j * 0.5497004).fract() * 2.0 - 1.0;
                let to_box = center + half_extent * share - point;
                if to_box.dot(normal) <= 0.0 {
                    continue;
                }
                let (azimuth, sine_squared) = coordinates(&range, to_box);
                let azimuth = if range.span == TAU { azimuth.rem_euclid(TAU) } else { azimuth };
                let [lowest, highest] = range.sines_squared;
                assert!((-1e-4..range.span + 1e-4).contains(&azimuth), "{i}: {azimuth} {}", range.span);
                assert!((lowest..=highest).contains(&sine_squared), "{i}: {sine_squared}");
            }
        }
        assert!(ranges > 100, "{ranges}");
    }

    #[test]
    fn rays_miss_the_box_where_no_part_of_them_is_inside() {
        for offset in [0.0, 1e4, -1e5] {
            assert_misses(Vec3::new(1.0, 0.5, -2.0) + offset);
        }
    }

    fn assert_misses(center: Vec3) {
        let half_extent = Vec3::new(0.3, 0.8, 1.5);
        let occluders = around(center, half_extent);
        let mut missed = 0;
        for i in 0..2000 {
            let (origin, direction) =
                (center + spiral_direction(i * 7 % 2000, 2000) * 2.5, spiral_direction(i, 2000));
            let direction = (center + direction - origin).normalize();
            let t_max = if i % 2 == 0 { f32::INFINITY } else { 2.0 };
            let ray = Ray { t_max, ..Ray::new(origin, direction) };
            let is_inside = |step: u32| {
                let distance = (ray.at(step as f32 * 0.002) - center).abs();
                distance.cmple(half_extent).all()
            };
            let ends = if i % 2 == 0 { 3000 } else { 1000 };
            let enters = (0..ends).any(is_inside);
            let is_missed = occluders.is_missed_by(&ray);
            missed += u32::from(is_missed);
            assert!(!(enters && is_missed), "{i}");
        }
        assert!((600..1900).contains(&missed), "{missed}");
        // Rays along an axis, and what is no box
        assert!(!occluders.is_missed_by(&Ray::new(center - Vec3::X * 9.0, Vec3::X)));
        assert!(occluders.is_missed_by(&Ray::new(center - Vec3::X * 9.0 + Vec3::Y, Vec3::X)));
        assert!(OccluderBox::new(Aabb::EMPTY).is_missed_by(&Ray::new(Vec3::ZERO, Vec3::X)));
        let flat = OccluderBox::new(Aabb { min: -Vec3::X - Vec3::Z, max: Vec3::X + Vec3::Z });
        assert!(!flat.is_missed_by(&Ray::new(Vec3::NEG_Y, Vec3::Y)));
    }

    #[test]
    fn directions_of_a_range_are_spread_by_their_cosine() {
        let point = Vec3::new(-3.0, 0.0, 0.5);
        let range = around(Vec3::new(0.0, 1.5, 0.0), Vec3::ONE).range_from(point, Vec3::Y).unwrap();
        let inside = |wi: Vec3| {
            let (azimuth, sine_squared) = coordinates(&range, wi);
            let [lowest, highest] = range.sines_squared;
            wi.y > 0.0
                && (-1e-5..range.span + 1e-5).contains(&azimuth)
                && (lowest - 1e-5..highest + 1e-5).contains(&sine_squared)
        };
        // The integral of the cosine over the directions within, and their mean by the cosine
        let count = 400_000;
        let (mut irradiance, mut mean) = (0.0, Vec3::ZERO);
        for wi in (0..count).map(|i| spiral_direction(i, count)).filter(|wi| inside(*wi)) {
            irradiance += f64::from(wi.y);
            mean += wi * wi.y;
        }
        mean /= irradiance as f32;
        irradiance *= 4.0 * std::f64::consts::PI / f64::from(count);
        assert!((f64::from(range.projected_solid_angle()) / irradiance - 1.0).abs() < 5e-3);

        let samples = 10_000;
        let mut of_samples = Vec3::ZERO;
        for i in 0..samples {
            let wi = range.direction(Vec2::new(i as f32 * 0.754_877_7, i as f32 * 0.569_840_3).fract());
            assert!((wi.length() - 1.0).abs() < 1e-5 && inside(wi));
            of_samples += wi / samples as f32;
        }
        assert!(of_samples.distance(mean) < 5e-3, "{of_samples} {mean}");
    }

    #[test]
    fn points_inside_a_box_have_no_range_and_points_above_an_empty_one() {
        let occluders = around(Vec3::Y * 3.0, Vec3::ONE);
        assert_eq!(occluders.range_from(Vec3::Y * 2.0, Vec3::Y), None);
        assert_eq!(occluders.range_from(Vec3::Y * 3.0, Vec3::Y), None);
        let solid_angle = |occluders: OccluderBox, point: Vec3| {
            occluders.range_from(point, Vec3::Y).map(|range| range.projected_solid_angle())
        };
        assert_eq!(solid_angle(occluders, Vec3::Y * 5.0), Some(0.0));
        assert_eq!(solid_angle(OccluderBox::new(Aabb::EMPTY), Vec3::ZERO), Some(0.0));
        assert!(solid_angle(occluders, Vec3::X * 1.5).unwrap() > 0.5);
        // Below, those around the zenith: within 45° here
        let below = around(Vec3::Y * 3.0, Vec3::new(1.0, 1.585_786, 1.0));
        let half = solid_angle(below, Vec3::ZERO).unwrap() / std::f32::consts::PI;
        assert!((half - 0.5).abs() < 5e-3, "{half}");
    }
}
