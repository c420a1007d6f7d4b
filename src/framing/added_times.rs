//! Times that are measured besides the even ones: those at which something reaches farther, as periodic motion between equal
//! phases does, or a short one.
//!
//! They are searched by the boxes of meshes under their nodes and joints, which are posed faster than vertices are.

use glam::{Mat4, Vec3};
use rayon::prelude::*;

use super::moving_surfaces::may_move;
use super::posed_triangles::{PosedTriangles, most_added};
use super::subject::Subject;
use crate::frame::{Frame, NodePose};
use crate::geometry::Aabb;
use crate::scene::{MeshIndex, NodeIndex, Scene, Selection};
use crate::uneven::uneven_shares;

/// What reaches farther by at most this share of the diagonal adds no time. The image has a margin of a tenth.
const TOLERANCE: f32 = 0.01;
/// Distance from what the even times show, as a factor on its diagonal, beyond which things are parked far away or fly away. Times at which
/// something framed is there add nothing.
const FARTHEST: f32 = 10.0;
/// Fewest and most times of a selection that are searched.
const SEARCHED: [usize; 2] = [16, 1024];
/// Boxes, nodes and materials that are posed, over all searched times, before fewer times are searched.
const SEARCHED_BOXES: usize = 2_000_000;
/// The same over the even times, beyond which nothing is searched.
const MOST_BOXES: usize = 16_000_000;
/// Share of the searched times that are no key times.
const BETWEEN_KEYS: usize = 4;

impl Subject<'_> {
    /// Measures further times, at which something framed reaches beyond what the even times show, and extends the bounds by them.
    pub(super) fn add_times(&mut self) {
        if self.times.len() == self.selections.len() {
            return;
        }
        let diagonal = if self.bounds.is_empty() { 0.0 } else { self.bounds.extent().length() };
        let boxes = Boxes::new(self, diagonal);
        let groups = boxes.directions.len() / DIRECTIONS;
        let cost = groups + self.scene.nodes.len() + self.scene.materials.len();
        if groups == 0 || cost.saturating_mul(self.times.len()) > MOST_BOXES {
            return;
        }
        let [fewest, most] = SEARCHED;
        let count = (SEARCHED_BOXES / cost / self.selections.len()).clamp(fewest, most);
        let searched: Vec<(usize, f64)> = (0..self.selections.len())
            .flat_map(|index| {
                let times = searched_times(self.scene, &self.selections[index], count);
                times.into_iter().map(move |time| (index, time))
            })
            .collect();
        if searched.is_empty() {
            return;
        }
        let at = |(selection, time): (usize, f64)| boxes.supports_at(&self.selections[selection], time);
        let mut reached = self
            .times
            .par_iter()
            .map(|&time| at(time))
            .reduce(|| vec![f32::NEG_INFINITY; boxes.directions.len()], |a, b| larger(a, &b));
        let farthest = farthest(&searched, reached.len(), at);
        let tolerance = TOLERANCE * diagonal;
        let is_beyond = |reached: &[f32]| {
            let mut pairs = farthest.iter().zip(reached);
            pairs.any(|((farthest, _), reached)| *farthest > reached + tolerance)
        };
        if !is_beyond(&reached) {
            return;
        }
        let directions = directions();
        let mut hull = self.supports(&directions);
        let is_framed = self.framed_blocks();
        for _ in 0..most_added(self.frame.triangles.len(), self.even_times) {
            boxes.raise(&mut reached, &hull);
            let excess = |index: usize| farthest[index].0 - reached[index];
            let open = (0..reached.len()).filter(|&index| excess(index) > tolerance);
            let Some(index) = open.max_by(|&a, &b| excess(a).total_cmp(&excess(b))) else { break };
            let (selection, time) = searched[farthest[index].1];
            reached = larger(reached, &boxes.supports_at(&self.selections[selection], time));
            let mut frame = Frame::of_positions();
            frame.pose_surfaces(self.scene, &self.selections[selection], time);
            let boxes = self.blocks.boxes(&frame.triangles, &frame.flags);
            let posed = (&frame.triangles[..], &frame.flags[..]);
            let supports = self.raised(&hull, posed, (&boxes, &is_framed), &directions);
            if supports.iter().zip(&hull).any(|(support, hull)| *support > hull + tolerance) {
                hull = supports;
                self.blocks.add(boxes);
                self.add_time((selection, time), frame);
            }
        }
    }

    fn add_time(&mut self, time: (usize, f64), frame: Frame) {
        let framed = (0..frame.triangles.len())
            .filter(|&index| self.frames_triangle(index, &frame.triangles[index], frame.flags[index]));
        let bounds = framed.fold(Aabb::EMPTY, |bounds, index| bounds.union(frame.triangles[index].bounds()));
        self.bounds = self.bounds.union(bounds);
        self.times.push(time);
        if let Some(kept) = &mut self.kept {
            kept.push(PosedTriangles { triangles: frame.triangles, flags: frame.flags });
        }
    }
}

/// Number of directions in which boxes are measured.
const DIRECTIONS: usize = 26;

/// Unit vectors towards the faces, edges and corners of a cube, each followed by its opposite.
fn directions() -> Vec<Vec3> {
    let all = (0..27_u8).map(|i| Vec3::new(f32::from(i % 3), f32::from(i / 3 % 3), f32::from(i / 9)) - 1.0);
    let half = all.skip(DIRECTIONS / 2 + 1).map(Vec3::normalize);
    half.flat_map(|direction| [direction, -direction]).collect()
}

/// The larger ones of both, one by one.
fn larger(mut supports: Vec<f32>, others: &[f32]) -> Vec<f32> {
    for (support, other) in supports.iter_mut().zip(others) {
        *support = support.max(*other);
    }
    supports
}

/// The largest of each of the `count` supports over the searched times, with the index of its time.
fn farthest(
    searched: &[(usize, f64)],
    count: usize,
    at: impl Fn((usize, f64)) -> Vec<f32> + Sync,
) -> Vec<(f32, usize)> {
    let nothing = || vec![(f32::NEG_INFINITY, 0); count];
    let larger = |mut a: Vec<(f32, usize)>, b: Vec<(f32, usize)>| {
        for (a, b) in a.iter_mut().zip(b) {
            // The first of equal ones, in whatever order threads are done.
            if b.0 > a.0 || b.0 == a.0 && b.1 < a.1 {
                *a = b;
            }
        }
        a
    };
    let times = searched.par_iter().enumerate();
    let supports = times.map(|(index, &time)| at(time).into_iter().map(|support| (support, index)).collect());
    supports.reduce(nothing, larger)
}

/// Key times of what moves, and uneven times between, up to about `count`; none where nothing moves.
fn searched_times(scene: &Scene, selection: &Selection, count: usize) -> Vec<f64> {
    let duration = f64::from(selection.clip_seconds(scene));
    let clips = selection.clips.iter().filter_map(|clip| scene.animations.get(clip.index()));
    let channels = clips.flat_map(|clip| &clip.channels).filter(|channel| may_move(channel.target));
    let most = count - count / BETWEEN_KEYS;
    let mut keys: Vec<f32> = Vec::new();
    let mut is_moving = false;
    for channel in channels {
        is_moving = true;
        keys.extend(at_most(&channel.keyframes.times_seconds, most));
    }
    if !is_moving || duration <= 0.0 {
        return Vec::new();
    }
    keys.retain(|seconds| *seconds > 0.0);
    keys.sort_by(f32::total_cmp);
    keys.dedup();
    let between = uneven_shares(count / BETWEEN_KEYS).map(|share| share * duration);
    at_most(&keys, most).map(f64::from).chain(between).collect()
}

/// All of the values, or unevenly chosen ones.
fn at_most(values: &[f32], count: usize) -> impl Iterator<Item = f32> {
    let chosen = if values.len() > count { count } else { 0 };
    let all = if chosen == 0 { values } else { &[] };
    let chosen = uneven_shares(chosen).filter_map(|share| values.get((share * values.len() as f64) as usize));
    all.iter().chain(chosen).copied()
}

/// The boxes of the framed meshes under their nodes or joints, and their morph weights.
struct Boxes<'a> {
    scene: &'a Scene,
    axes: Vec<Vec3>,
    nodes: Vec<NodeBox>,
    /// Direction of each support; `None` for morph weights.
    directions: Vec<Option<usize>>,
    /// What a morph weight of one counts as, metres.
    weight: f32,
    /// Where the middles of boxes may be.
    reachable: Aabb,
}

/// The box of a mesh under a node, before both are posed.
struct NodeBox {
    node: NodeIndex,
    mesh: MeshIndex,
    /// In the space of the mesh; where the node has instances, of the node.
    bounds: Aabb,
    /// Index of its first support.
    first: usize,
}

impl<'a> Boxes<'a> {
    fn new(subject: &Subject<'a>, weight: f32) -> Self {
        let scene = subject.scene;
        let mut meshes: Vec<Option<Aabb>> = vec![None; scene.meshes.len()];
        let (mut nodes, mut directions) = (Vec::new(), Vec::new());
        for node in subject.framed_nodes().into_iter().map(NodeIndex) {
            let Some(mesh) = scene.nodes[node.index()].mesh else { continue };
            let bounds = *meshes[mesh.index()].get_or_insert_with(|| mesh_bounds(scene, mesh));
            let skin = scene.nodes[node.index()].skin;
            let bounds = match &scene.nodes[node.index()].instances {
                Some(instances) if skin.is_none() && !bounds.is_empty() => {
                    let boxes = instances.par_iter().map(|instance| posed_box(instance, &bounds));
                    boxes.reduce(|| Aabb::EMPTY, Aabb::union)
                }
                _ => bounds,
            };
            if bounds.is_empty() {
                continue;
            }
            nodes.push(NodeBox { node, mesh, bounds, first: directions.len() });
            let groups = skin.map_or(1, |skin| scene.skins[skin.index()].joints.len());
            directions.extend((0..groups).flat_map(|_| (0..DIRECTIONS).map(Some)));
            directions.extend(scene.meshes[mesh.index()].weights.iter().flat_map(|_| [None; 2]));
        }
        let axes = self::directions().into_iter().step_by(2).collect();
        let margin = Vec3::splat(FARTHEST * subject.bounds.extent().length());
        let Aabb { min, max } = subject.bounds;
        let reachable = Aabb { min: min - margin, max: max + margin };
        Self { scene, axes, nodes, directions, weight, reachable }
    }

    /// How far each box reaches in each direction, and each weight both ways. Negative infinity for what is hidden, and for all where something is
    /// beyond reach.
    fn supports_at(&self, selection: &Selection, time_seconds: f64) -> Vec<f32> {
        let mut supports = vec![f32::NEG_INFINITY; self.directions.len()];
        let pose = NodePose::at(self.scene, selection, time_seconds);
        for posed in self.nodes.iter().filter(|posed| !pose.is_hidden(posed.node)) {
            if !self.measure(posed, &pose, &mut supports[posed.first..]) {
                supports.fill(f32::NEG_INFINITY);
                break;
            }
        }
        supports
    }

    /// The supports of a node. Returns whether it is within reach.
    fn measure(&self, of_node: &NodeBox, pose: &NodePose, supports: &mut [f32]) -> bool {
        let (mut first, mut is_reachable) = (0, true);
        let mut measure = |matrix: &Mat4| {
            let middle = matrix.transform_point3(of_node.bounds.center());
            is_reachable &= self.reachable.contains(&Aabb { min: middle, max: middle });
            self.measure_box(matrix, &of_node.bounds, &mut supports[first..first + DIRECTIONS]);
            first += DIRECTIONS;
        };
        match self.scene.nodes[of_node.node.index()].skin {
            Some(skin) => {
                let skin = &self.scene.skins[skin.index()];
                for (joint, inverse_bind) in skin.joints.iter().zip(&skin.inverse_bind_matrices) {
                    measure(&(pose.world(*joint) * *inverse_bind));
                }
            }
            None => measure(&pose.world(of_node.node)),
        }
        let weights = pose.weights(self.scene, of_node.node, of_node.mesh);
        for (weight, supports) in weights.iter().zip(supports[first..].chunks_exact_mut(2)) {
            supports.copy_from_slice(&[weight * self.weight, -weight * self.weight]);
        }
        is_reachable
    }

    fn measure_box(&self, matrix: &Mat4, bounds: &Aabb, supports: &mut [f32]) {
        let center = matrix.transform_point3(bounds.center());
        let half = bounds.extent() * 0.5;
        let edges = [matrix.x_axis * half.x, matrix.y_axis * half.y, matrix.z_axis * half.z];
        for (axis, supports) in self.axes.iter().zip(supports.chunks_exact_mut(2)) {
            let reach: f32 = edges.iter().map(|edge| edge.truncate().dot(*axis).abs()).sum();
            let middle = center.dot(*axis);
            supports[0] = supports[0].max(middle + reach);
            supports[1] = supports[1].max(reach - middle);
        }
    }

    /// Raises the supports to those of all that is framed.
    fn raise(&self, supports: &mut [f32], hull: &[f32]) {
        for (support, direction) in supports.iter_mut().zip(&self.directions) {
            if let Some(direction) = direction {
                *support = support.max(hull[*direction]);
            }
        }
    }
}

/// The box of the positions of a mesh, in its own space.
fn mesh_bounds(scene: &Scene, mesh: MeshIndex) -> Aabb {
    let primitives = scene.meshes[mesh.index()].primitives.par_iter();
    let boxes = primitives.map(|primitive| Aabb::from_points(&primitive.positions));
    boxes.reduce(|| Aabb::EMPTY, Aabb::union)
}

/// The bounds of a box that is transformed.
fn posed_box(matrix: &Mat4, bounds: &Aabb) -> Aabb {
    let center = matrix.transform_point3(bounds.center());
    let half = bounds.extent() * 0.5;
    let reach =
        (matrix.x_axis * half.x).abs() + (matrix.y_axis * half.y).abs() + (matrix.z_axis * half.z).abs();
    Aabb { min: center - reach.truncate(), max: center + reach.truncate() }
}
