//! Builds of obvhs with reused buffers: the steps of its `build_bvh2_from_tris` and `build_cwbvh_from_tris`, which allocate.

use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::ploc::PlocBuilder;
use obvhs::rt_triangle::RtTriangle;
use obvhs::splits::split_aabbs_preset;
use obvhs::triangle::Triangle;
use rayon::ThreadPool;
use rayon::prelude::*;

use crate::clock::wall_seconds;
use crate::obvhs_preset::{Layout, Preset};

/// Rebuilds with reused memory; the best counts.
const REBUILDS: usize = 6;

/// Finished hierarchy.
pub struct Tree {
    /// Nodes of the hierarchy.
    pub nodes: Nodes,
    /// Triangles in the order of leaves.
    pub triangles: Vec<RtTriangle>,
}

/// Nodes of either layout.
pub enum Nodes {
    /// Two children per node.
    Binary(Bvh2),
    /// Eight quantized children per node.
    Compressed(CwBvh),
}

/// Scratch memory kept between builds.
#[derive(Default)]
struct Builder {
    ploc: PlocBuilder,
    reinsertion: ReinsertionOptimizer,
    boxes: Vec<Aabb>,
    binary: Bvh2,
    triangles: Vec<RtTriangle>,
}

/// Converts triangles to those of obvhs.
pub fn triangles(triangles: &[rayframe::geometry::Triangle]) -> Vec<Triangle> {
    let convert = |triangle: &rayframe::geometry::Triangle| {
        let [v0, v1, v2] = triangle.vertices.map(|vertex| glam_simd::Vec3A::from(vertex.to_array()));
        Triangle { v0, v1, v2 }
    };
    triangles.iter().map(convert).collect()
}

/// Builds on the threads of `pool`. Returns the hierarchy, the seconds of the first build, and those of the best rebuild with memory
/// reused where obvhs offers that.
pub fn measure(triangles: &[Triangle], preset: &Preset, pool: &ThreadPool) -> (Tree, [f64; 2]) {
    pool.install(|| {
        let mut builder = Builder::default();
        let (mut tree, build_seconds) = wall_seconds(|| builder.build(triangles, preset));
        let mut rebuild_seconds = f64::INFINITY;
        for _ in 0..REBUILDS {
            builder.recycle(tree);
            let seconds;
            (tree, seconds) = wall_seconds(|| builder.build(triangles, preset));
            rebuild_seconds = rebuild_seconds.min(seconds);
        }
        (tree, [build_seconds, rebuild_seconds])
    })
}

impl Builder {
    fn recycle(&mut self, tree: Tree) {
        self.triangles = tree.triangles;
        if let Nodes::Binary(binary) = tree.nodes {
            self.binary = binary;
        }
    }

    fn build(&mut self, triangles: &[Triangle], preset: &Preset) -> Tree {
        let BvhBuildParams { reinsertion_batch_ratio: ratio, max_prims_per_leaf, .. } = preset.params;
        self.cluster(triangles, &preset.params);
        self.reinsertion.run(&mut self.binary, ratio, None);
        let nodes = match preset.layout {
            Layout::Binary => {
                let mut binary = std::mem::take(&mut self.binary);
                let again = ratio * preset.params.post_collapse_reinsertion_batch_ratio_multiplier;
                collapse(
                    &mut binary,
                    max_prims_per_leaf.clamp(1, 255),
                    preset.params.collapse_traversal_cost,
                );
                self.reinsertion.run(&mut binary, again, None);
                Nodes::Binary(binary)
            }
            Layout::Compressed => {
                Nodes::Compressed(bvh2_to_cwbvh(&self.binary, max_prims_per_leaf.clamp(1, 3), true, false))
            }
        };
        let mut ordered = std::mem::take(&mut self.triangles);
        let order = match &nodes {
            Nodes::Binary(binary) => &binary.primitive_indices,
            Nodes::Compressed(compressed) => &compressed.primitive_indices,
        };
        order
            .par_iter()
            .with_min_len(4096)
            .map(|&i| RtTriangle::from(&triangles[i as usize]))
            .collect_into_vec(&mut ordered);
        Tree { nodes, triangles: ordered }
    }

    /// Builds the first binary tree, over split boxes where the preset splits.
    fn cluster(&mut self, triangles: &[Triangle], params: &BvhBuildParams) {
        let mut indices = std::mem::take(&mut self.binary.primitive_indices);
        indices.clear();
        indices.extend(0..triangles.len() as u32);
        let (distance, precision) = (params.ploc_search_distance, params.sort_precision);
        let threshold = params.search_depth_threshold;
        if params.pre_split {
            self.boxes.clear();
            self.boxes.extend(triangles.iter().map(Triangle::aabb));
            let areas = self.boxes.iter().map(Aabb::half_area);
            let (sum, largest) =
                areas.fold((0.0, 0.0_f32), |(sum, largest), area| (sum + area, largest.max(area)));
            let mean = sum / triangles.len() as f32;
            split_aabbs_preset(&mut self.boxes, &mut indices, triangles, mean, largest);
            self.ploc.build_with_bvh(&mut self.binary, distance, &self.boxes, indices, precision, threshold);
        } else {
            self.ploc.build_with_bvh(&mut self.binary, distance, triangles, indices, precision, threshold);
        }
        self.binary.uses_spatial_splits = params.pre_split;
    }
}
