//! The surfaces of a frame: world-space triangles, vertices and materials, with the lights.

use glam::{Mat4, Vec3};
use rayon::prelude::*;

use crate::bvh::TriangleFlags;
use crate::geometry::Triangle;
use crate::parallel_resize::resize_with;
use crate::scene::{
    ImageLightPose, Material, Node, NodeIndex, Primitive, Scene, Selection, Skin, VariantIndex,
};

use super::deform::{self, MorphedAttributes, PosedVertex, VertexParts, VertexTransform};
use super::material_flags::material_flags;
use super::mesh_instance::MeshInstance;
use super::posed_nodes::{PosedCamera, PosedLight, posed_light};
use super::surface_pose::{SurfacePose, morph_weights};
use super::transform;
use super::unmoved::Unmoved;

/// Triangles of one parallel task.
const TRIANGLES_PER_TASK: usize = 4096;

/// The scene at one time.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Seconds since the start of the animation.
    pub time_seconds: f64,
    /// World-space triangles, by triangle id. Mirroring transforms keep their winding.
    pub triangles: Vec<Triangle>,
    /// Traversal flags, by triangle id.
    pub flags: Vec<TriangleFlags>,
    /// Index of `instances`, by triangle id.
    pub instance_of_triangle: Vec<u32>,
    /// Mesh instances in the order of their triangle ids.
    pub instances: Vec<MeshInstance>,
    /// World-space vertices of all instances.
    pub vertices: Vec<PosedVertex>,
    /// Materials at this time, by [`crate::scene::MaterialIndex`].
    pub materials: Vec<Material>,
    /// Lights at this time.
    pub lights: Vec<PosedLight>,
    /// The image-based light at this time, if clips animate it.
    pub image_light: Option<ImageLightPose>,
    /// The camera at this time.
    pub camera: PosedCamera,
    pub(super) scratch: Scratch,
}

/// Memory that is only used while posing.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    pub(super) now: SurfacePose,
    /// Of the time that the frame was posed for before.
    before: SurfacePose,
    joint_matrices: Vec<Mat4>,
    /// What is posed of vertices from now on.
    parts: VertexParts,
    /// What the vertices have.
    posed_parts: VertexParts,
}

impl Frame {
    /// A frame that poses positions alone, for what needs no shading: its vertices have no normals and tangents.
    pub(crate) fn of_positions() -> Self {
        let mut frame = Self::default();
        frame.pose_parts(VertexParts::Positions);
        frame
    }

    /// Poses `parts` of vertices from now on.
    pub(crate) fn pose_parts(&mut self, parts: VertexParts) {
        self.scratch.parts = parts;
    }

    /// Whether the vertices have what is posed of them.
    pub(crate) fn has_parts(&self) -> bool {
        let Scratch { parts, posed_parts, .. } = self.scratch;
        posed_parts == VertexParts::All || parts == VertexParts::Positions
    }

    /// World-space origin of a node, metres; `None` for an index that the posed scene does not have.
    pub fn node_position(&self, node: NodeIndex) -> Option<Vec3> {
        self.scratch.now.world.get(node.index()).map(|matrix| matrix.w_axis.truncate())
    }

    /// The instance of a triangle.
    pub fn instance(&self, triangle: u32) -> &MeshInstance {
        &self.instances[self.instance_of_triangle[triangle as usize] as usize]
    }

    /// Poses everything except the camera.
    pub fn pose_surfaces(&mut self, scene: &Scene, selection: &Selection, time_seconds: f64) {
        let nodes = self.play(scene, selection, time_seconds);
        self.list_instances(scene, &nodes, selection.variant);
        self.pose_instances(scene, false);
    }

    /// Poses everything except the camera of a frame that was posed with the same scene and selection. Instances that have not moved since are
    /// kept. Returns whether any has moved.
    pub(crate) fn pose_surfaces_again(
        &mut self,
        scene: &Scene,
        selection: &Selection,
        time_seconds: f64,
    ) -> bool {
        std::mem::swap(&mut self.scratch.now, &mut self.scratch.before);
        self.play(scene, selection, time_seconds);
        self.pose_instances(scene, true)
    }

    /// Plays the clips, and poses what has no vertices. Returns the selected nodes.
    fn play(&mut self, scene: &Scene, selection: &Selection, time_seconds: f64) -> Vec<NodeIndex> {
        self.time_seconds = time_seconds;
        let SurfacePose { pose, world, material_flags: flags } = &mut self.scratch.now;
        pose.play(scene, selection, time_seconds, &mut self.materials);
        transform::inherit_hidden(scene, &mut pose.hidden);
        scene.world_matrices(&pose.local, world);
        flags.clear();
        flags.extend(self.materials.iter().map(material_flags));
        let nodes = transform::selected_nodes(scene, selection);
        self.lights.clear();
        let visible = nodes.iter().filter(|node| !pose.hidden[node.index()]);
        self.lights.extend(visible.filter_map(|&node| posed_light(scene, pose, node, world)));
        let animated = selection.image_light.filter(|_| selection.moves_image_light(scene));
        self.image_light = animated.map(|light| pose.image_lights[light.index()]);
        nodes
    }

    /// Lists the mesh instances and assigns their ranges of triangles and vertices.
    fn list_instances(&mut self, scene: &Scene, nodes: &[NodeIndex], variant: Option<VariantIndex>) {
        self.instances.clear();
        let (mut triangles, mut vertices) = (0_usize, 0_usize);
        for &node in nodes {
            let Some(mesh) = scene.nodes[node.index()].mesh else {
                continue;
            };
            let Node { instances, instance_colors, .. } = &scene.nodes[node.index()];
            let count = instances.as_ref().map_or(1, Vec::len);
            let primitives = &scene.meshes[mesh.index()].primitives;
            let pairs =
                (0..count).flat_map(|instance| primitives.iter().enumerate().map(move |p| (instance, p)));
            for (node_instance, (index, primitive)) in pairs {
                self.instances.push(MeshInstance {
                    node,
                    node_instance: node_instance as u32,
                    mesh,
                    primitive: index,
                    material: primitive.material_in(variant),
                    first_triangle: triangles as u32,
                    first_vertex: vertices,
                    mirrored: false,
                    is_inside_out: primitive.is_inside_out,
                    color: instance_colors.get(node_instance).copied(),
                    morphed: MorphedAttributes::default(),
                });
                triangles += primitive.triangles.len();
                vertices += primitive.positions.len();
            }
        }
        // Fresh memory is written once, by all threads, as every page of it costs.
        emptied(&mut self.triangles, triangles);
        emptied(&mut self.flags, triangles);
        emptied(&mut self.instance_of_triangle, triangles);
        emptied(&mut self.vertices, vertices);
    }

    /// Poses the listed instances, or only those that have moved. Returns whether it posed any.
    fn pose_instances(&mut self, scene: &Scene, keeps_unmoved: bool) -> bool {
        let keeps_unmoved = keeps_unmoved && self.has_parts();
        let mut has_posed = false;
        let Scratch { now, before, joint_matrices: joints, parts, posed_parts } = &mut self.scratch;
        let unmoved = keeps_unmoved.then(|| Unmoved::new(scene, before, now));
        let SurfacePose { pose, world, material_flags } = &*now;
        let mut skin_of_joints = None;
        for (index, instance) in self.instances.iter_mut().enumerate() {
            if unmoved.as_ref().is_some_and(|unmoved| unmoved.holds(instance)) {
                continue;
            }
            has_posed = true;
            *posed_parts = *parts;
            let primitive = instance.primitive(scene);
            let node = &scene.nodes[instance.node.index()];
            let weights = morph_weights(scene, pose, instance.node, instance.mesh);
            instance.morphed = deform::morph_attributes(primitive, weights);

            // Transform the vertices
            let world_from_node = &instance_matrix(node, instance, world);
            let transform = match (node.skin, &primitive.influences) {
                (Some(skin), Some(_)) => {
                    // Primitives of one mesh, and often many meshes in a row, share a skin.
                    if skin_of_joints != Some(skin) {
                        joints.clear();
                        joints.extend(joint_matrices(&scene.skins[skin.index()], world));
                        skin_of_joints = Some(skin);
                    }
                    VertexTransform::Skinned { joint_matrices: joints, world_from_node }
                }
                _ => VertexTransform::Rigid(world_from_node),
            };
            instance.mirrored = deform::mirrors(transform);
            let vertices = deform::posed_vertices(primitive, weights, transform, *parts);
            write_at(&mut self.vertices, instance.first_vertex, vertices);

            // Gather the triangles
            let mut flags = material_flags[instance.material.index()];
            if pose.hidden[instance.node.index()] {
                flags = flags.with(TriangleFlags::HIDDEN);
            }
            let first = instance.first_triangle as usize;
            let end = first + primitive.triangles.len();
            if first == self.flags.len() {
                resize_with(&mut self.instance_of_triangle, end, || index as u32);
                resize_with(&mut self.flags, end, || flags);
            } else {
                self.flags[first..end].fill(flags);
            }
            let vertices = &self.vertices[instance.first_vertex..];
            let flags = &mut self.flags[first..];
            let triangles = posed_triangles(primitive, vertices, instance.mirrored, flags);
            write_at(&mut self.triangles, first, triangles);
        }
        has_posed
    }
}

/// Writes values from `first` on: after the end of a list, whose fresh memory is written once, or over those of the time before.
fn write_at<T: Send>(list: &mut Vec<T>, first: usize, values: impl IndexedParallelIterator<Item = T>) {
    if first == list.len() {
        list.par_extend(values);
    } else {
        list[first..].par_iter_mut().zip(values).for_each(|(old, new)| *old = new);
    }
}

/// World from mesh space, without skinning.
fn instance_matrix(node: &Node, instance: &MeshInstance, world: &[Mat4]) -> Mat4 {
    let world_from_node = world[instance.node.index()];
    match &node.instances {
        Some(node_from_instance) => world_from_node * node_from_instance[instance.node_instance as usize],
        None => world_from_node,
    }
}

/// Joint matrix = world from joint · inverse bind matrix.
pub(super) fn joint_matrices(skin: &Skin, world: &[Mat4]) -> impl Iterator<Item = Mat4> {
    let pairs = skin.joints.iter().zip(&skin.inverse_bind_matrices);
    pairs.map(|(joint, inverse_bind)| world[joint.index()] * *inverse_bind)
}

/// Triangles in world space. Mirrored instances swap the last two corners, so that counter-clockwise remains the front. Taking a
/// triangle from the iterator sets [`TriangleFlags::HIDDEN`] where its corners are not finite.
fn posed_triangles(
    primitive: &Primitive,
    vertices: &[PosedVertex],
    mirrored: bool,
    flags: &mut [TriangleFlags],
) -> impl IndexedParallelIterator<Item = Triangle> {
    let pairs = primitive.triangles.par_iter().zip(flags).with_min_len(TRIANGLES_PER_TASK);
    let position = |corner: u32| vertices[corner as usize].position;
    pairs.map(move |(&[a, b, c], flags)| {
        // Indices are swapped, and positions named one by one: arrays of these go through memory, which takes three times as long.
        let (b, c) = if mirrored { (c, b) } else { (b, c) };
        let [a, b, c] = [position(a), position(b), position(c)];
        // A triangle whose corners overflowed cannot be hit. Hiding it keeps it out of the bounding boxes.
        if !(a.is_finite() && b.is_finite() && c.is_finite()) {
            *flags = flags.with(TriangleFlags::HIDDEN);
        }
        Triangle { vertices: [a, b, c] }
    })
}

/// Empties a list and reserves memory for `count` values.
fn emptied<T>(list: &mut Vec<T>, count: usize) {
    list.clear();
    list.reserve_exact(count);
}
