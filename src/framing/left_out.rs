//! What a scene shows that a camera does not frame: backdrops, and triangles far from the rest.
//!
//! Sizes are those of single times: what moves far is no larger for it, and is framed along its whole path.

use glam::Vec3;
use rayon::prelude::*;

use super::extent::Extent;
use super::posed_triangles::{SAMPLED_TRIANGLES, SampledTriangle};
use super::subject::{Subject, TRIANGLES_PER_TASK};
use crate::bvh::{TriangleFlags, is_traced};
use crate::geometry::{Aabb, Triangle};

/// An instance, or the scene, is too large for its content where its diagonal exceeds that of the rest by this factor.
const TOO_LARGE: f32 = 3.0;
/// The same factor for instances around the rest that may have most of the triangles, but none near the rest.
const AS_LARGE_AS_A_SKY: f32 = 10.0;
/// Largest share of the triangles that grounds have, and smallest share of what skies surround.
const BACKDROP_SHARE: f32 = 0.2;
/// Share of the triangles left out at either end of each axis to find the content.
const OUTLIERS: f32 = 0.01;
/// Margin around the content, as a share of its size, in which triangles are framed.
const CONTENT_MARGIN: f32 = 0.5;

/// A kind of backdrop.
#[derive(Clone, Copy, Debug)]
enum Backdrop {
    /// Most triangles lie beyond the content.
    Ground,
    /// The content lies within, far from all triangles.
    Sky,
}

impl Backdrop {
    /// Whether an instance with this box is one for the content, if `near` of its `count` triangles are near that.
    fn holds(self, bounds: &Aabb, near: usize, count: usize, content: &Aabb) -> bool {
        match self {
            Self::Ground => 2 * near < count,
            Self::Sky => near == 0 && bounds.contains(content),
        }
    }
}

impl Subject<'_> {
    /// Extends the extents of framed instances by those at the next time.
    pub(super) fn extend_extents(
        &self,
        extents: &mut [Extent],
        triangles: &[Triangle],
        flags: &[TriangleFlags],
    ) {
        extents.par_iter_mut().enumerate().for_each(|(instance, extent)| {
            extent.add(self.instance_bounds(instance, triangles, flags));
        });
    }

    /// Bounds of an instance that is framed, posed like this.
    fn instance_bounds(&self, instance: usize, triangles: &[Triangle], flags: &[TriangleFlags]) -> Aabb {
        let triangles = self
            .frame
            .triangle_range(instance)
            .into_par_iter()
            .with_min_len(TRIANGLES_PER_TASK)
            .filter(|&index| self.frames_triangle(index, &triangles[index], flags[index]))
            .map(|index| triangles[index].bounds());
        triangles.reduce(|| Aabb::EMPTY, Aabb::union)
    }

    /// Leaves out the instances that are much larger than all smaller ones together: those with few triangles, most of which lie
    /// beyond those (grounds, stages), and very large ones around them (skies). Then those with few triangles whose paths lead far away.
    pub(super) fn leave_out_backdrops(&mut self, extents: &[Extent]) {
        let framed: Vec<_> = (0..extents.len())
            .filter(|&index| self.is_framed[index] && !extents[index].path.is_empty())
            .collect();
        let (strays, others): (Vec<usize>, Vec<usize>) =
            framed.iter().partition(|&&index| extents[index].is_stray());
        if others.is_empty() {
            self.leave_out_larger(extents, strays);
            return;
        }
        let triangles =
            |of: &[usize]| -> usize { of.iter().map(|&index| self.frame.triangle_range(index).len()).sum() };
        let has_most = triangles(&others) as f32 >= (1.0 - BACKDROP_SHARE) * triangles(&framed) as f32;
        let content = self.leave_out_larger(extents, others);
        let longest = TOO_LARGE * content.extent().length();
        for index in strays.into_iter().filter(|_| has_most) {
            self.is_framed[index] = extents[index].path.extent().length() <= longest;
        }
    }

    /// The backdrops of [`Subject::leave_out_backdrops`] among instances. Returns the box of the others.
    fn leave_out_larger(&mut self, extents: &[Extent], mut by_size: Vec<usize>) -> Aabb {
        let triangles: Vec<usize> =
            (0..extents.len()).map(|index| self.frame.triangle_range(index).len()).collect();
        let diagonal = |index: usize| extents[index].diagonal;
        by_size.sort_by(|&a, &b| diagonal(a).total_cmp(&diagonal(b)).then(a.cmp(&b)));
        let total: usize = by_size.iter().map(|&index| triangles[index]).sum();
        let (mut content, mut content_triangles) = (Aabb::EMPTY, 0);
        for (count, &index) in by_size.iter().enumerate() {
            let size = if count > 0 { diagonal(index) / content.extent().length() } else { 0.0 };
            let (smaller, larger) = by_size.split_at(count);
            let has_most = content_triangles as f32 >= (1.0 - BACKDROP_SHARE) * total as f32;
            let has_some = content_triangles as f32 >= BACKDROP_SHARE * total as f32;
            let are = |kind| self.are_backdrops(kind, extents, smaller, larger);
            let is_ground = size > TOO_LARGE && has_most && are(Backdrop::Ground);
            if is_ground || size > AS_LARGE_AS_A_SKY && has_some && are(Backdrop::Sky) {
                for &index in larger {
                    self.is_framed[index] = false;
                    self.may_be_floor[index] = true;
                }
                return content;
            }
            content = content.union(extents[index].path);
            content_triangles += triangles[index];
        }
        content
    }

    /// Whether all of the `larger` instances are backdrops for the `smaller` ones: those that do not move for their whole paths, others at
    /// every time for what is there then.
    fn are_backdrops(&self, kind: Backdrop, extents: &[Extent], smaller: &[usize], larger: &[usize]) -> bool {
        let (moving, still): (Vec<usize>, Vec<usize>) =
            larger.iter().partition(|&&index| extents[index].moves);
        let paths = smaller.iter().fold(Aabb::EMPTY, |paths, &index| paths.union(extents[index].path));
        let holds = |index: usize, bounds: &Aabb, triangles: &[Triangle], content: &Aabb| {
            let triangles = &triangles[self.frame.triangle_range(index)];
            kind.holds(bounds, triangles_near(triangles, content), triangles.len(), content)
        };
        if !still.iter().all(|&index| holds(index, &extents[index].path, &self.frame.triangles, &paths)) {
            return false;
        }
        let mut are_all = true;
        if !moving.is_empty() {
            self.visit(self.stride(1), |triangles, flags| {
                let bounds = |index: usize| self.instance_bounds(index, triangles, flags);
                if are_all {
                    let content =
                        smaller.iter().fold(Aabb::EMPTY, |content, &index| content.union(bounds(index)));
                    are_all = content.is_empty()
                        || moving.iter().all(|&index| {
                            let bounds = bounds(index);
                            bounds.is_empty() || holds(index, &bounds, triangles, &content)
                        });
                }
            });
        }
        are_all
    }

    /// Leaves out triangles that are far from the content at all times, where they make the bounds much larger. An instance that moves, but is no
    /// stray, and ever comes near is framed as a whole.
    pub(super) fn leave_out_outliers(&mut self, extents: &[Extent]) {
        let Some(content) = self.content() else { return };
        let limit = with_margin(&content);
        if self.bounds.extent().length() <= TOO_LARGE * limit.extent().length() {
            return;
        }
        // The bounds of each triangle over all times, and whether it is ever within the limit.
        let mut paths = vec![(Aabb::EMPTY, false); self.frame.triangles.len()];
        self.visit(1, |triangles, flags| {
            let paths = paths.par_iter_mut().with_min_len(TRIANGLES_PER_TASK).enumerate();
            paths.for_each(|(index, (path, is_near))| {
                if self.frames_triangle(index, &triangles[index], flags[index]) {
                    let bounds = triangles[index].bounds();
                    *path = path.union(bounds);
                    *is_near |= limit.contains(&bounds);
                }
            });
        });
        let largest = TOO_LARGE * limit.extent().length();
        for (instance, extent) in extents.iter().enumerate() {
            let paths = &mut paths[self.frame.triangle_range(instance)];
            if extent.moves
                && !extent.is_stray()
                && extent.diagonal <= largest
                && paths.iter().any(|(_, is_near)| *is_near)
            {
                for (_, is_near) in &mut *paths {
                    *is_near = true;
                }
            }
        }
        let near = paths.iter().filter(|(_, is_near)| *is_near);
        let within = near.fold(Aabb::EMPTY, |bounds, (path, _)| bounds.union(*path));
        if !within.is_empty() {
            self.bounds = within;
            self.is_outlier = Some(paths.iter().map(|(_, is_near)| !is_near).collect());
        }
    }

    /// Some of the traced triangles that are posed like this, evenly over their ids.
    pub(super) fn sampled(
        &self,
        triangles: &[Triangle],
        flags: &[TriangleFlags],
    ) -> impl Iterator<Item = SampledTriangle> {
        let stride = (triangles.len() * self.times.len()).div_ceil(SAMPLED_TRIANGLES).max(1);
        let pairs = triangles.iter().zip(flags).enumerate().step_by(stride);
        let traced = pairs.filter(|(_, (triangle, flags))| is_traced(triangle, **flags));
        traced.map(|(index, (triangle, _))| SampledTriangle { index, bounds: triangle.bounds() })
    }

    /// The box between the percentiles of the triangles' boxes along each axis, over all times.
    fn content(&self) -> Option<Aabb> {
        let mut corners: [Vec<f32>; 6] = Default::default();
        for SampledTriangle { bounds: Aabb { min, max }, .. } in
            self.samples.iter().filter(|sample| self.may_frame_triangle(sample.index))
        {
            let values = min.to_array().into_iter().chain(max.to_array());
            corners.iter_mut().zip(values).for_each(|(all, value)| all.push(value));
        }
        let count = corners[0].len();
        if count == 0 {
            return None;
        }
        let below = (count as f32 * OUTLIERS) as usize;
        let mut ranked =
            |list: usize, rank: usize| *corners[list].select_nth_unstable_by(rank, f32::total_cmp).1;
        let min = Vec3::from_array(std::array::from_fn(|axis| ranked(axis, below)));
        let max = Vec3::from_array(std::array::from_fn(|axis| ranked(axis + 3, count - 1 - below)));
        Some(Aabb { min, max })
    }
}

/// Number of the triangles that lie within the content and the margin around it.
fn triangles_near(triangles: &[Triangle], content: &Aabb) -> usize {
    let near = with_margin(content);
    triangles.iter().filter(|triangle| near.contains(&triangle.bounds())).count()
}

fn with_margin(content: &Aabb) -> Aabb {
    let margin = content.extent() * CONTENT_MARGIN;
    Aabb { min: content.min - margin, max: content.max + margin }
}
