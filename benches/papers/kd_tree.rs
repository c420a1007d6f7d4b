//! kd-trees by the surface area heuristic (Ernst and Greiner 2007, Algorithms 1 and 3): candidate planes are the ends of boxes, either
//! those of whole triangles cut to the cell, or those of the parts of triangles inside it ("perfect splits", Havran 2000).

use rayframe::geometry::{Aabb, Ray, Triangle};

use super::clip::Part;
use super::hierarchy::{Closest, Counters, Slabs};
use super::references::{bounds_of, padded, whole};

/// Cost of a step over that of a triangle.
const STEP_COST: f64 = 1.0;
/// Factor of the cost of splits that cut empty space off (Wald and Havran 2006).
const EMPTY_BONUS: f64 = 0.8;
/// Slack of parameters at the border of cells.
const SLACK: f32 = 1.0e-5;

/// Node: `axis` 3 marks a leaf with `count` triangles from `first`; else the children are `first` and `first + 1`.
#[derive(Clone, Copy, Debug)]
struct Node {
    axis: u8,
    plane: f32,
    first: u32,
    count: u32,
}

/// Tree; node 0 is the root.
#[derive(Debug)]
pub(crate) struct KdTree {
    bounds: Aabb,
    nodes: Vec<Node>,
    triangles: Vec<u32>,
    depth: u32,
    sah_cost: f64,
}

/// A triangle in a cell.
struct Item {
    triangle: u32,
    bounds: Aabb,
    /// Its part inside the cell, where triangles are clipped.
    part: Option<Part>,
}

struct Cell {
    node: usize,
    bounds: Aabb,
    items: Vec<Item>,
    depth: u32,
}

impl KdTree {
    /// Builds the tree of `triangles`.
    pub(crate) fn build(triangles: &[Triangle], is_clipped: bool) -> Self {
        let references = whole(triangles);
        let bounds = bounds_of(&references);
        let items = references.iter().map(|reference| Item {
            triangle: reference.triangle,
            bounds: reference.bounds,
            part: is_clipped.then(|| Part::whole(&triangles[reference.triangle as usize])),
        });
        let most_depth = 8 + (1.3 * libm::log2(triangles.len().max(1) as f64)) as u32;
        let leaf = Node { axis: 3, plane: 0.0, first: 0, count: 0 };
        let mut tree = Self { bounds, nodes: vec![leaf], triangles: Vec::new(), depth: 0, sah_cost: 0.0 };
        let mut pending = vec![Cell { node: 0, bounds, items: items.collect(), depth: 0 }];
        while let Some(cell) = pending.pop() {
            tree.depth = tree.depth.max(cell.depth);
            let share = cell.bounds.area() / bounds.area();
            let split = (cell.depth < most_depth).then(|| best_plane(&cell)).flatten();
            let Some((axis, plane)) = split else {
                tree.sah_cost += share * cell.items.len() as f64;
                tree.nodes[cell.node] =
                    Node { first: tree.triangles.len() as u32, count: cell.items.len() as u32, ..leaf };
                tree.triangles.extend(cell.items.iter().map(|item| item.triangle));
                continue;
            };
            tree.sah_cost += share * STEP_COST;
            let first = tree.nodes.len();
            tree.nodes[cell.node] = Node { axis: axis as u8, plane, first: first as u32, count: 0 };
            tree.nodes.extend([leaf; 2]);
            let depth = cell.depth + 1;
            let (mut low, mut high) = (cell.bounds, cell.bounds);
            low.max[axis] = plane;
            high.min[axis] = plane;
            let (below, above) = distribute(cell.items, (axis, plane), triangles);
            pending.push(Cell { node: first + 1, bounds: high, items: above, depth });
            pending.push(Cell { node: first, bounds: low, items: below, depth });
        }
        tree
    }

    /// The closest hit, cell by cell along the ray.
    pub(crate) fn closest(&self, ray: &Ray, triangles: &[Triangle], counters: &mut Counters) -> Closest {
        let slabs = Slabs::new(ray);
        let mut closest: Closest = None;
        let mut stack = Vec::with_capacity(64);
        stack.extend(slabs.span(&self.bounds, ray.t_max).map(|(near, far)| (0_u32, near, far)));
        while let Some((mut index, mut near, mut far)) = stack.pop() {
            if closest.is_some_and(|(t, _)| t < near - SLACK * near.abs()) {
                break;
            }
            loop {
                counters.nodes += 1;
                let node = self.nodes[index as usize];
                if node.axis == 3 {
                    for &id in &self.triangles[node.first as usize..(node.first + node.count) as usize] {
                        slabs.test(id, triangles, &mut closest, counters);
                    }
                    break;
                }
                let axis = usize::from(node.axis);
                let (origin, direction) = (ray.origin[axis], ray.direction[axis]);
                let is_low_first = origin < node.plane || (origin == node.plane && direction <= 0.0);
                let (first, second) =
                    if is_low_first { (node.first, node.first + 1) } else { (node.first + 1, node.first) };
                let t = (node.plane - origin) * slabs.inverse[axis];
                let slack = SLACK * t.abs();
                // Parallel rays, and those on the plane, visit both cells.
                if !(t.abs() > 0.0 && t.is_finite()) {
                    if direction != 0.0 || (node.plane - origin).abs() <= slack.min(f32::MIN_POSITIVE) {
                        stack.push((second, near, far));
                    }
                    index = first;
                } else if t + slack < 0.0 || t > far + slack {
                    index = first;
                } else if t < near - slack {
                    index = second;
                } else {
                    stack.push((second, (t - slack).max(near), far));
                    index = first;
                    far = far.min(t + slack);
                }
                near = near.min(far);
            }
        }
        closest
    }

    pub(crate) fn node_count(&self) -> usize {
        self.nodes.len()
    }

    pub(crate) fn reference_count(&self) -> usize {
        self.triangles.len()
    }

    pub(crate) fn depth(&self) -> u32 {
        self.depth
    }

    pub(crate) fn sah_cost(&self) -> f64 {
        self.sah_cost
    }

    pub(crate) fn bytes(&self) -> usize {
        self.nodes.len() * 8 + self.triangles.len() * size_of::<u32>()
    }
}

/// The triangles of a cell on either side of a plane.
fn distribute(
    items: Vec<Item>,
    (axis, plane): (usize, f32),
    triangles: &[Triangle],
) -> (Vec<Item>, Vec<Item>) {
    let (mut below, mut above) = (Vec::new(), Vec::new());
    for item in items {
        if item.bounds.max[axis] <= plane {
            below.push(item);
        } else if item.bounds.min[axis] >= plane {
            above.push(item);
        } else {
            let Item { triangle, bounds, part } = item;
            let sides = [&mut below, &mut above];
            let halves = match &part {
                Some(part) => part.cut(axis, plane).map(|half| half.map(|half| (*half.bounds(), Some(half)))),
                None => [Some((bounds, None)), Some((bounds, None))],
            };
            for (side, (list, half)) in sides.into_iter().zip(halves).enumerate() {
                let Some((tight, part)) = half else { continue };
                let is_tight = part.is_some();
                let mut cut = if is_tight { padded(tight, &triangles[triangle as usize]) } else { tight };
                if side == 0 {
                    cut.max[axis] = cut.max[axis].min(plane);
                } else {
                    cut.min[axis] = cut.min[axis].max(plane);
                }
                list.push(Item { triangle, bounds: cut, part });
            }
        }
    }
    (below, above)
}

/// The plane of least cost; `None` where a leaf costs less. Sweeps over sorted ends of boxes.
fn best_plane(cell: &Cell) -> Option<(usize, f32)> {
    let count = cell.items.len();
    let area = cell.bounds.area();
    let mut best = (count as f64, None);
    for axis in 0..3 {
        let (low, high) = (cell.bounds.min[axis], cell.bounds.max[axis]);
        // Ends before starts: a box that ends on the plane is below it.
        let mut ends: Vec<(f32, bool)> = Vec::with_capacity(2 * count);
        for item in &cell.items {
            ends.push((item.bounds.min[axis].max(low), true));
            ends.push((item.bounds.max[axis].min(high), false));
        }
        ends.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (mut below, mut above) = (0_usize, count);
        let mut at = 0;
        while at < ends.len() {
            let plane = ends[at].0;
            let (mut starts, mut stops) = (0, 0);
            while at < ends.len() && ends[at].0 == plane {
                if ends[at].1 {
                    starts += 1;
                } else {
                    stops += 1;
                }
                at += 1;
            }
            above -= stops;
            if low < plane && plane < high {
                let (mut left, mut right) = (cell.bounds, cell.bounds);
                left.max[axis] = plane;
                right.min[axis] = plane;
                let hits = left.area() * below as f64 + right.area() * above as f64;
                let bonus = if below == 0 || above == 0 { EMPTY_BONUS } else { 1.0 };
                let cost = bonus * (STEP_COST + hits / area);
                if cost < best.0 {
                    best = (cost, Some((axis, plane)));
                }
            }
            below += starts;
        }
    }
    best.1
}
