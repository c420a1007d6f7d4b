//! Binary bounding volume hierarchies: the layout that all builders but the kd-tree fill, and its traversal.

use glam::Vec3;

use rayframe::geometry::{Aabb, Ray, Triangle};

use super::references::Reference;

/// Relative error of a distance to a box (Ize 2013), on either side.
const BOX_SLACK: f32 = 1.0 + 4.0 * f32::EPSILON;

/// Node: inner nodes have their children at `first` and `first + 1`, leaves `count` references from `first`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Node {
    pub(crate) bounds: Aabb,
    pub(crate) first: u32,
    pub(crate) count: u32,
}

/// Hierarchy; node 0 is the root.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bvh2 {
    pub(crate) nodes: Vec<Node>,
    pub(crate) references: Vec<Reference>,
}

/// Closest hit: the parameter, and of equal ones the lowest triangle.
pub(crate) type Closest = Option<(f32, u32)>;

/// Work of rays.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counters {
    /// Nodes visited, leaves included.
    pub(crate) nodes: u64,
    pub(crate) triangles: u64,
}

/// A ray with what box tests need of it.
pub(crate) struct Slabs {
    pub(crate) ray: Ray,
    pub(crate) inverse: Vec3,
}

impl Slabs {
    pub(crate) fn new(ray: &Ray) -> Self {
        Self { ray: *ray, inverse: ray.direction.recip() }
    }

    /// Where the ray is inside a box, up to `t_max`; `None` where it passes by.
    pub(crate) fn span(&self, bounds: &Aabb, t_max: f32) -> Option<(f32, f32)> {
        let (mut near, mut far) = (self.ray.t_min, t_max);
        for axis in 0..3 {
            let (low, high) = (bounds.min[axis], bounds.max[axis]);
            let origin = self.ray.origin[axis];
            if self.ray.direction[axis] == 0.0 {
                if origin < low || origin > high {
                    return None;
                }
                continue;
            }
            let (a, b) = ((low - origin) * self.inverse[axis], (high - origin) * self.inverse[axis]);
            let (enter, leave) = if a < b { (a, b) } else { (b, a) };
            near = near.max(enter / BOX_SLACK);
            far = far.min(leave * BOX_SLACK);
        }
        (near <= far).then_some((near, far))
    }

    /// Tests a triangle.
    pub(crate) fn test(
        &self,
        id: u32,
        triangles: &[Triangle],
        closest: &mut Closest,
        counters: &mut Counters,
    ) {
        counters.triangles += 1;
        if let Some(hit) = triangles[id as usize].intersect(&self.ray)
            && closest.is_none_or(|(t, other)| hit.t < t || hit.t == t && id < other)
        {
            *closest = Some((hit.t, id));
        }
    }
}

impl Bvh2 {
    /// The closest hit. The nearer child is visited first.
    pub(crate) fn closest(&self, ray: &Ray, triangles: &[Triangle], counters: &mut Counters) -> Closest {
        let slabs = Slabs::new(ray);
        let mut closest = None;
        let limit = |closest: Closest| closest.map_or(ray.t_max, |(t, _)| t);
        let mut stack = Vec::with_capacity(64);
        if let Some((near, _)) = self.nodes.first().and_then(|root| slabs.span(&root.bounds, ray.t_max)) {
            stack.push((near, 0_u32));
        }
        while let Some((near, index)) = stack.pop() {
            if near > limit(closest) {
                continue;
            }
            counters.nodes += 1;
            let node = &self.nodes[index as usize];
            if node.count > 0 {
                for reference in &self.references[node.first as usize..(node.first + node.count) as usize] {
                    slabs.test(reference.triangle, triangles, &mut closest, counters);
                }
                continue;
            }
            let spans = [node.first, node.first + 1].map(|child| {
                let span = slabs.span(&self.nodes[child as usize].bounds, limit(closest));
                span.map(|(near, _)| (near, child))
            });
            match spans {
                [Some(a), Some(b)] if a.0 <= b.0 => stack.extend([b, a]),
                [a, b] => stack.extend([a, b].into_iter().flatten()),
            }
        }
        closest
    }

    /// Surface area heuristic cost with unit costs.
    pub(crate) fn sah_cost(&self) -> f64 {
        let Some(root) = self.nodes.first() else { return 0.0 };
        let cost = |node: &Node| node.bounds.area() * f64::from(node.count.max(1));
        self.nodes.iter().map(cost).sum::<f64>() / root.bounds.area()
    }

    /// Edges from the root to the deepest leaf.
    pub(crate) fn depth(&self) -> u32 {
        let mut deepest = 0;
        let mut pending = vec![(0_u32, 0_u32)];
        while let Some((index, depth)) = pending.pop() {
            deepest = deepest.max(depth);
            match self.nodes.get(index as usize) {
                Some(node) if node.count == 0 => {
                    pending.extend([(node.first, depth + 1), (node.first + 1, depth + 1)]);
                }
                _ => {}
            }
        }
        deepest
    }

    /// Bytes of nodes and references to triangles.
    pub(crate) fn bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>() + self.references.len() * size_of::<u32>()
    }
}
