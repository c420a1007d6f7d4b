//! What a camera frames: the visible triangles of the scene, or of a node, over the selected clips.

use std::collections::BTreeSet;

use glam::Vec3;
use rayon::prelude::*;

use crate::bvh::TriangleFlags;
use crate::frame::Frame;
use crate::geometry::{Aabb, Triangle};
use crate::scene::{AnimationIndex, NodeIndex, Scene, Selection};

use super::posed_triangles::{PosedTriangles, TIMES, are_kept};

/// Fewest times of a clip where several are measured one by one.
const FEWEST_CLIP_TIMES: usize = 17;
/// Fewest times where the scene has many triangles.
const FEWEST_TIMES: usize = 9;
/// Products of corners, times and directions that a measurement may take before it uses fewer times.
const PRODUCTS: usize = 400_000_000;
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
/// Triangles of one parallel task.
const TRIANGLES_PER_TASK: usize = 8192;
/// Number of triangles whose positions are ranked.
const SAMPLED_TRIANGLES: usize = 65_536;

/// Visible triangles over the selected clips, without backdrops.
pub(super) struct Subject<'a> {
    scene: &'a Scene,
    /// What is posed: the selected clips together, or each of the measured clips alone.
    selections: Vec<Selection>,
    /// Times at which it is measured, each with the index of its selection.
    times: Vec<(usize, f64)>,
    /// The scene at the first time.
    pub(super) frame: Frame,
    /// The triangles at the other times, where they are few enough to be kept.
    kept: Option<Vec<PosedTriangles>>,
    /// Whether a triangle belongs to the framed node, by its id; `None` where the whole scene is framed.
    follows_node: Option<Vec<bool>>,
    /// Whether an instance is framed, by its index in the frame.
    is_framed: Vec<bool>,
    /// Whether an instance may be a floor under what is framed: it is a shadow catcher or a backdrop.
    may_be_floor: Vec<bool>,
    /// Triangles beyond it are not framed.
    limit: Option<Aabb>,
    /// Bounds over all times; where nothing is visible, two metres around the framed node or the origin.
    pub(super) bounds: Aabb,
    /// Whether nothing is visible.
    pub(super) is_empty: bool,
}

impl<'a> Subject<'a> {
    /// Measures the scene, or the nodes below `node`, while the clips of `selection` play together; where `clips` are given, while
    /// each of these plays alone.
    ///
    /// Of a whole scene, large instances with few triangles around all others (skies, ground planes) are left out, and so are
    /// triangles far from the rest.
    pub(super) fn measure(
        scene: &'a Scene,
        selection: &Selection,
        node: Option<NodeIndex>,
        clips: &[AnimationIndex],
    ) -> Self {
        let mut frame = Frame::default();
        let alone = clips.iter().map(|&clip| Selection { clips: vec![clip], ..selection.clone() });
        let mut selections: Vec<Selection> = alone.collect();
        if selections.is_empty() {
            selections.push(selection.clone());
        }
        let times = sample_times(scene, &selections);
        frame.pose_surfaces(scene, &selections[0], 0.0);
        let follows_node = node.map(|node| frame.triangles_of_node(scene, node));
        let is_framed = frame.instances.iter().enumerate().map(|(index, instance)| {
            let mut triangles = frame.triangle_range(index);
            let is_selected =
                follows_node.as_ref().is_none_or(|follows| triangles.any(|triangle| follows[triangle]));
            is_selected && !frame.materials[instance.material.index()].is_shadow_catcher
        });
        let is_framed = is_framed.collect();
        let catchers = frame
            .instances
            .iter()
            .map(|instance| node.is_none() && frame.materials[instance.material.index()].is_shadow_catcher);
        let may_be_floor = catchers.collect();
        let mut subject = Self {
            scene,
            selections,
            times,
            frame,
            kept: None,
            follows_node,
            is_framed,
            may_be_floor,
            limit: None,
            bounds: Aabb::EMPTY,
            is_empty: false,
        };
        subject.keep_triangles();
        let by_instance = subject.instance_bounds();
        if node.is_none() {
            subject.leave_out_backdrops(&by_instance);
        }
        let framed = by_instance.iter().zip(&subject.is_framed).filter(|(_, is_framed)| **is_framed);
        subject.bounds = framed.fold(Aabb::EMPTY, |bounds, (instance, _)| bounds.union(*instance));
        if node.is_none() {
            subject.leave_out_outliers();
        }
        subject.is_empty = subject.bounds.is_empty();
        if subject.is_empty {
            let center = node.and_then(|node| subject.frame.node_position(node)).unwrap_or(Vec3::ZERO);
            subject.bounds = Aabb { min: center - Vec3::ONE, max: center + Vec3::ONE };
        }
        subject
    }

    /// The largest product of any framed corner with each of `directions`, over the times. Negative infinity without any.
    pub(super) fn supports(&self, directions: &[Vec3]) -> Vec<f32> {
        let products = (self.frame.triangles.len() * 3 * directions.len()).max(1);
        let most = self.times.len().max(FEWEST_TIMES);
        let count = (PRODUCTS / products).clamp(FEWEST_TIMES, most);
        let stride = ((most - 1) / (count - 1)).max(1);
        let mut supports = vec![f32::NEG_INFINITY; directions.len()];
        self.visit(stride, |triangles, flags| {
            let found = (0..triangles.len())
                .into_par_iter()
                .with_min_len(TRIANGLES_PER_TASK)
                .fold(
                    || vec![f32::NEG_INFINITY; directions.len()],
                    |mut largest, index| {
                        let triangle = &triangles[index];
                        if self.frames_triangle(index, triangle, flags[index]) {
                            for (largest, direction) in largest.iter_mut().zip(directions) {
                                let [a, b, c] = triangle.vertices.map(|corner| corner.dot(*direction));
                                *largest = largest.max(a).max(b).max(c);
                            }
                        }
                        largest
                    },
                )
                .reduce_with(|a, b| a.iter().zip(&b).map(|(a, b)| a.max(*b)).collect());
            for (largest, found) in supports.iter_mut().zip(found.unwrap_or_default()) {
                *largest = largest.max(found);
            }
        });
        supports
    }

    /// The bounds of the instances that may be floors over all times, each with its lowest point along the unit vector `up`.
    pub(super) fn floors(&self, up: Vec3) -> Vec<(f32, Aabb)> {
        let mut floors = vec![(f32::INFINITY, Aabb::EMPTY); self.may_be_floor.len()];
        if !self.may_be_floor.contains(&true) {
            return Vec::new();
        }
        self.visit(1, |triangles, flags| {
            for (index, &instance) in self.frame.instance_of_triangle.iter().enumerate() {
                let instance = instance as usize;
                if self.may_be_floor[instance] && !flags[index].has(TriangleFlags::HIDDEN) {
                    let triangle = &triangles[index];
                    let [a, b, c] = triangle.vertices.map(|corner| corner.dot(up));
                    let (lowest, bounds) = floors[instance];
                    floors[instance] = (lowest.min(a).min(b).min(c), bounds.union(triangle.bounds()));
                }
            }
        });
        floors.retain(|(_, bounds)| !bounds.is_empty());
        floors
    }

    /// Indices of the nodes that are framed.
    pub(super) fn framed_nodes(&self) -> BTreeSet<u32> {
        let framed = self.frame.instances.iter().zip(&self.is_framed).filter(|(_, is_framed)| **is_framed);
        framed.map(|(instance, _)| instance.node.0).collect()
    }

    /// Number of framed instances of nodes, each of which may have several mesh instances.
    pub(super) fn framed_node_instances(&self) -> usize {
        let framed = self.frame.instances.iter().zip(&self.is_framed).filter(|(_, is_framed)| **is_framed);
        framed.map(|(instance, _)| (instance.node, instance.node_instance)).collect::<BTreeSet<_>>().len()
    }

    /// Whether the instance with this index is framed.
    pub(super) fn frames_instance(&self, instance: u32) -> bool {
        self.is_framed[instance as usize]
    }

    /// Keeps the triangles at all times, if they are few.
    fn keep_triangles(&mut self) {
        if are_kept(self.frame.triangles.len(), self.times.len()) {
            let mut kept = Vec::new();
            self.visit(1, |triangles, flags| {
                kept.push(PosedTriangles { triangles: triangles.to_vec(), flags: flags.to_vec() });
            });
            self.kept = Some(kept);
        }
    }

    /// Calls `visit` with the triangles and their flags at every `stride`-th time.
    fn visit(&self, stride: usize, mut visit: impl FnMut(&[Triangle], &[TriangleFlags])) {
        if let Some(kept) = &self.kept {
            return kept.iter().step_by(stride).for_each(|posed| visit(&posed.triangles, &posed.flags));
        }
        visit(&self.frame.triangles, &self.frame.flags);
        let mut frame = Frame::default();
        for &(selection, time) in self.times.iter().step_by(stride).skip(1) {
            frame.pose_surfaces(self.scene, &self.selections[selection], time);
            visit(&frame.triangles, &frame.flags);
        }
    }

    /// Whether the triangle `index` is framed where it is posed like `triangle` with these flags.
    fn frames_triangle(&self, index: usize, triangle: &Triangle, flags: TriangleFlags) -> bool {
        let is_visible = !flags.has(TriangleFlags::HIDDEN);
        let is_framed = is_visible
            && self.is_framed[self.frame.instance_of_triangle[index] as usize]
            && self.follows_node.as_ref().is_none_or(|follows| follows[index]);
        is_framed && self.limit.is_none_or(|limit| limit.contains(&triangle.bounds()))
    }

    /// Bounds of each framed instance over all times.
    fn instance_bounds(&self) -> Vec<Aabb> {
        let mut bounds = vec![Aabb::EMPTY; self.is_framed.len()];
        self.visit(1, |triangles, flags| {
            bounds.par_iter_mut().enumerate().for_each(|(instance, bounds)| {
                let triangles = self
                    .frame
                    .triangle_range(instance)
                    .into_par_iter()
                    .with_min_len(TRIANGLES_PER_TASK)
                    .filter(|&index| self.frames_triangle(index, &triangles[index], flags[index]))
                    .map(|index| triangles[index].bounds());
                *bounds = bounds.union(triangles.reduce(|| Aabb::EMPTY, Aabb::union));
            });
        });
        bounds
    }

    /// Leaves out the instances that are much larger than all smaller ones together: those with few triangles, most of which lie
    /// beyond those (grounds, stages), and very large ones around them (skies).
    fn leave_out_backdrops(&mut self, bounds: &[Aabb]) {
        let triangles: Vec<usize> =
            (0..bounds.len()).map(|index| self.frame.triangle_range(index).len()).collect();
        let mut by_size: Vec<_> =
            (0..bounds.len()).filter(|&index| self.is_framed[index] && !bounds[index].is_empty()).collect();
        let diagonal = |index: usize| bounds[index].extent().length();
        by_size.sort_by(|&a, &b| diagonal(a).total_cmp(&diagonal(b)).then(a.cmp(&b)));
        let total: usize = by_size.iter().map(|&index| triangles[index]).sum();
        let (mut content, mut content_triangles) = (Aabb::EMPTY, 0);
        for (count, &index) in by_size.iter().enumerate() {
            let size = if count > 0 { diagonal(index) / content.extent().length() } else { 0.0 };
            let larger = &by_size[count..];
            let has_most = content_triangles as f32 >= (1.0 - BACKDROP_SHARE) * total as f32;
            let has_some = content_triangles as f32 >= BACKDROP_SHARE * total as f32;
            let near = |index: usize| self.triangles_near(index, triangles[index], content);
            let are_grounds = || larger.iter().all(|&index| 2 * near(index) < triangles[index]);
            let are_skies =
                || larger.iter().all(|&index| bounds[index].contains(&content) && near(index) == 0);
            let is_ground = size > TOO_LARGE && has_most && are_grounds();
            if is_ground || size > AS_LARGE_AS_A_SKY && has_some && are_skies() {
                for &index in larger {
                    self.is_framed[index] = false;
                    self.may_be_floor[index] = true;
                }
                return;
            }
            content = content.union(bounds[index]);
            content_triangles += triangles[index];
        }
    }

    /// Number of the instance's `count` triangles that lie within the content and the margin around it, at the first time.
    fn triangles_near(&self, instance: usize, count: usize, content: Aabb) -> usize {
        let margin = content.extent() * CONTENT_MARGIN;
        let near = Aabb { min: content.min - margin, max: content.max + margin };
        let first = self.frame.instances[instance].first_triangle as usize;
        let triangles = &self.frame.triangles[first..first + count];
        triangles.iter().filter(|triangle| near.contains(&triangle.bounds())).count()
    }

    /// Leaves out triangles far from the content, where they make the bounds much larger.
    fn leave_out_outliers(&mut self) {
        let Some(content) = self.content() else { return };
        let margin = content.extent() * CONTENT_MARGIN;
        let limit = Aabb { min: content.min - margin, max: content.max + margin };
        if self.bounds.extent().length() > TOO_LARGE * limit.extent().length() {
            self.limit = Some(limit);
            let within = self.instance_bounds().into_iter().fold(Aabb::EMPTY, Aabb::union);
            if within.is_empty() {
                self.limit = None;
            } else {
                self.bounds = within;
            }
        }
    }

    /// The box between the percentiles of the triangles' boxes along each axis, over all times.
    fn content(&self) -> Option<Aabb> {
        let stride = (self.frame.triangles.len() * self.times.len()).div_ceil(SAMPLED_TRIANGLES).max(1);
        let mut corners: [Vec<f32>; 6] = Default::default();
        self.visit(1, |triangles, flags| {
            for (index, triangle) in triangles.iter().enumerate().step_by(stride) {
                if self.frames_triangle(index, triangle, flags[index]) {
                    let Aabb { min, max } = triangle.bounds();
                    let values = min.to_array().into_iter().chain(max.to_array());
                    corners.iter_mut().zip(values).for_each(|(all, value)| all.push(value));
                }
            }
        });
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

/// Times of every selection: [`TIMES`] of a single one, fewer of each of several, and one where nothing moves.
fn sample_times(scene: &Scene, selections: &[Selection]) -> Vec<(usize, f64)> {
    let count = (4 * TIMES / selections.len()).clamp(FEWEST_CLIP_TIMES, TIMES);
    let mut times = Vec::new();
    for (index, selection) in selections.iter().enumerate() {
        let duration = f64::from(selection.clip_seconds(scene));
        if duration > 0.0 {
            times.extend((0..count).map(|i| (index, duration * i as f64 / (count - 1) as f64)));
        } else {
            times.push((index, 0.0));
        }
    }
    times
}
