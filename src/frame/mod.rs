//! The scene at one time: world-space triangles with their attributes, materials, lights and the camera.
//!
//! [`Frame::at`] is a pure function of (scene, selection, time); [`Frame::pose`] is the same into memory that is kept
//! between frames. Animation comes first, then node matrices, then for every drawn primitive morph, skin and the world.
//! Primitive ids are subscripts of [`Frame::triangles`]; they are given once over all drawn nodes and are the same at
//! every time. Acceleration structures are not built here.

mod animation;
mod auto_camera;
mod deform;
mod placed;
mod transform;

use glam::{Mat4, Vec2, Vec3, Vec4};
use rayon::prelude::*;

use crate::bvh::TriangleFlags;
use crate::geometry::Triangle;
use crate::scene::{
    AlphaMode, ImageLightPose, Material, MaterialIndex, MeshIndex, NodeIndex, Primitive, Scene, Selection,
    Skin, VariantIndex,
};

use animation::ScenePose;
use deform::{MorphedAttributes, Placement};

pub use auto_camera::{auto_camera, resolve_auto_camera};
pub use deform::PosedVertex;
pub use placed::{PosedCamera, PosedLight};

/// Triangles handed to one task.
const TRIANGLES_A_TASK: usize = 4096;

/// Everything that is drawn at one time.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Seconds since the start of the animation.
    pub time_seconds: f64,
    /// World-space triangles, re-wound where a mirroring transform turned them; the subscript is the primitive id.
    pub triangles: Vec<Triangle>,
    /// One a triangle.
    pub flags: Vec<TriangleFlags>,
    /// The instance that each triangle belongs to, as a subscript of `instances`.
    pub instance_of_triangle: Vec<u32>,
    /// One mesh primitive under one node each, in primitive id order.
    pub instances: Vec<MeshInstance>,
    /// World-space vertices of all instances.
    pub vertices: Vec<PosedVertex>,
    /// Materials at this time, by [`MaterialIndex`].
    pub materials: Vec<Material>,
    /// Lights at this time.
    pub lights: Vec<PosedLight>,
    /// The image-based light at this time, where clips move it.
    pub image_light: Option<ImageLightPose>,
    /// The camera at this time.
    pub camera: PosedCamera,
    scratch: Scratch,
}

/// One mesh primitive under one node, or under one of its instances.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshInstance {
    /// Where it is drawn.
    pub node: NodeIndex,
    /// Index of the node's instances (`EXT_mesh_gpu_instancing`); 0 for a node without any.
    pub node_instance: u32,
    /// Which mesh.
    pub mesh: MeshIndex,
    /// Subscript of the mesh's primitives.
    pub primitive: usize,
    /// What it looks like.
    pub material: MaterialIndex,
    /// Primitive id of its first triangle.
    pub first_triangle: u32,
    /// Subscript in [`Frame::vertices`] of its first vertex.
    pub first_vertex: usize,
    /// Whether the second and third corner of each triangle changed places.
    pub mirrored: bool,
    morphed: MorphedAttributes,
}

/// Memory that is only used while posing.
#[derive(Clone, Debug, Default)]
struct Scratch {
    pose: ScenePose,
    world: Vec<Mat4>,
    joint_matrices: Vec<Mat4>,
}

impl MeshInstance {
    /// The mesh primitive in its own space.
    pub fn primitive<'s>(&self, scene: &'s Scene) -> &'s Primitive {
        &scene.meshes[self.mesh.index()].primitives[self.primitive]
    }

    /// Texture coordinates of set `set` at three vertices; zero where the primitive has no such set.
    pub fn uvs(&self, scene: &Scene, set: usize, corners: [u32; 3]) -> [Vec2; 3] {
        let sets = self.morphed.uvs.as_ref().unwrap_or(&self.primitive(scene).uvs);
        match sets.get(set) {
            Some(uvs) => corners.map(|corner| uvs[corner as usize]),
            None => [Vec2::ZERO; 3],
        }
    }

    /// Linear vertex colours at three vertices; `None` where the primitive has none.
    pub fn colors(&self, scene: &Scene, corners: [u32; 3]) -> Option<[Vec4; 3]> {
        let colors = self.morphed.colors.as_ref().or(self.primitive(scene).colors.as_ref())?;
        Some(corners.map(|corner| colors[corner as usize]))
    }
}

impl Frame {
    /// The scene at `time_seconds` as a new value.
    pub fn at(scene: &Scene, selection: &Selection, time_seconds: f64) -> Self {
        let mut frame = Self::default();
        frame.pose(scene, selection, time_seconds);
        frame
    }

    /// Poses `scene` at `time_seconds`, using the memory of `self` again.
    ///
    /// A [`crate::scene::SelectedCamera::Auto`] is framed anew for a square picture each time; settle it once with
    /// [`resolve_auto_camera`] when there are several frames.
    pub fn pose(&mut self, scene: &Scene, selection: &Selection, time_seconds: f64) {
        self.pose_surfaces(scene, selection, time_seconds);
        let Scratch { pose, world, .. } = &self.scratch;
        self.camera = placed::camera(scene, selection, &pose.projections, world);
    }

    /// The camera alone at `time_seconds`.
    pub fn camera_at(scene: &Scene, selection: &Selection, time_seconds: f64) -> PosedCamera {
        let Scratch { mut pose, mut world, .. } = Scratch::default();
        pose.play(scene, selection, time_seconds, &mut Vec::new());
        transform::world_matrices(scene, &pose.local, &mut world);
        placed::camera(scene, selection, &pose.projections, &world)
    }

    /// Where the origin of a node is, metres; `None` for a node that the posed scene does not have.
    pub fn node_position(&self, node: NodeIndex) -> Option<Vec3> {
        self.scratch.world.get(node.index()).map(|matrix| matrix.w_axis.truncate())
    }

    /// Everything but the camera.
    fn pose_surfaces(&mut self, scene: &Scene, selection: &Selection, time_seconds: f64) {
        self.time_seconds = time_seconds;
        let Scratch { pose, world, .. } = &mut self.scratch;
        pose.play(scene, selection, time_seconds, &mut self.materials);
        transform::inherit_hidden(scene, &mut pose.hidden);
        transform::world_matrices(scene, &pose.local, world);
        let drawn = transform::drawn_nodes(scene, selection);
        self.lights.clear();
        let shining = drawn.iter().filter(|node| !pose.hidden[node.index()]);
        self.lights.extend(shining.filter_map(|&node| placed::light(scene, &pose.lights, node, world)));
        let moved = selection.image_light.filter(|_| selection.moves_image_light(scene));
        self.image_light = moved.map(|light| pose.image_lights[light.index()]);
        self.list_instances(scene, &drawn, selection.variant);
        self.pose_instances(scene);
    }

    /// Gives every drawn primitive its place among triangles and vertices.
    fn list_instances(&mut self, scene: &Scene, drawn: &[NodeIndex], variant: Option<VariantIndex>) {
        self.instances.clear();
        let (mut triangles, mut vertices) = (0_usize, 0_usize);
        for &node in drawn {
            let Some(mesh) = scene.nodes[node.index()].mesh else {
                continue;
            };
            let instances = scene.nodes[node.index()].instances.as_ref().map_or(1, Vec::len);
            let primitives = &scene.meshes[mesh.index()].primitives;
            let drawn =
                (0..instances).flat_map(|instance| primitives.iter().enumerate().map(move |p| (instance, p)));
            for (node_instance, (index, primitive)) in drawn {
                self.instances.push(MeshInstance {
                    node,
                    node_instance: node_instance as u32,
                    mesh,
                    primitive: index,
                    material: primitive.material_in(variant),
                    first_triangle: triangles as u32,
                    first_vertex: vertices,
                    mirrored: false,
                    morphed: MorphedAttributes::default(),
                });
                triangles += primitive.triangles.len();
                vertices += primitive.positions.len();
            }
        }
        let corner = Triangle { vertices: [Vec3::ZERO; 3] };
        self.triangles.resize(triangles, corner);
        self.flags.resize(triangles, TriangleFlags::default());
        self.instance_of_triangle.resize(triangles, 0);
        self.vertices.resize(vertices, PosedVertex::default());
    }

    fn pose_instances(&mut self, scene: &Scene) {
        let Scratch { pose, world, joint_matrices } = &mut self.scratch;
        for (index, instance) in self.instances.iter_mut().enumerate() {
            let primitive = instance.primitive(scene);
            let node = &scene.nodes[instance.node.index()];
            let node_from_instance =
                node.instances.as_ref().map(|instances| instances[instance.node_instance as usize]);
            let world_from_node = &match node_from_instance {
                Some(node_from_instance) => world[instance.node.index()] * node_from_instance,
                None => world[instance.node.index()],
            };

            // Weights: the node's over the mesh's, animated over those at rest.
            let weights = pose.weights[instance.node.index()]
                .as_ref()
                .or(node.weights.as_ref())
                .or(pose.mesh_weights[instance.mesh.index()].as_ref())
                .unwrap_or(&scene.meshes[instance.mesh.index()].weights);
            instance.morphed = deform::morph_attributes(primitive, weights);

            // Vertices
            let placement = match (node.skin, &primitive.influences) {
                (Some(skin), Some(_)) => {
                    fill_joint_matrices(&scene.skins[skin.index()], world, joint_matrices);
                    Placement::Skinned { joint_matrices, world_from_node }
                }
                _ => Placement::Rigid(world_from_node),
            };
            instance.mirrored = deform::mirrors(placement);
            let vertices = &mut self.vertices[instance.first_vertex..][..primitive.positions.len()];
            deform::pose_vertices(primitive, weights, placement, vertices);

            // Triangles
            let material = &self.materials[instance.material.index()];
            let range = instance.first_triangle as usize
                ..instance.first_triangle as usize + primitive.triangles.len();
            self.instance_of_triangle[range.clone()].fill(index as u32);
            gather_triangles(
                primitive,
                vertices,
                instance.mirrored,
                if pose.hidden[instance.node.index()] {
                    flags_of(material).with(TriangleFlags::HIDDEN)
                } else {
                    flags_of(material)
                },
                (&mut self.triangles[range.clone()], &mut self.flags[range]),
            );
        }
    }

    /// The instance that triangle `primitive` belongs to.
    pub fn instance(&self, primitive: u32) -> &MeshInstance {
        &self.instances[self.instance_of_triangle[primitive as usize] as usize]
    }
}

/// Joint matrix = world from joint · inverse bind matrix.
fn fill_joint_matrices(skin: &Skin, world: &[Mat4], joint_matrices: &mut Vec<Mat4>) {
    let pairs = skin.joints.iter().zip(&skin.inverse_bind_matrices);
    joint_matrices.clear();
    joint_matrices.extend(pairs.map(|(joint, inverse_bind)| world[joint.index()] * *inverse_bind));
}

/// Corners in world space; mirrored instances swap the last two so that counter-clockwise stays the front.
fn gather_triangles(
    primitive: &Primitive,
    vertices: &[PosedVertex],
    mirrored: bool,
    flags: TriangleFlags,
    (triangles, triangle_flags): (&mut [Triangle], &mut [TriangleFlags]),
) {
    let outputs = triangles.par_iter_mut().zip(triangle_flags).zip(&primitive.triangles);
    outputs.with_min_len(TRIANGLES_A_TASK).for_each(|((triangle, triangle_flags), corners)| {
        let [a, b, c] = corners.map(|corner| vertices[corner as usize].position);
        triangle.vertices = if mirrored { [a, c, b] } else { [a, b, c] };
        // Corners that overflowed the number range cannot be hit and must not spoil boxes.
        let finite = triangle.vertices.iter().all(|vertex| vertex.is_finite());
        *triangle_flags = if finite { flags } else { flags.with(TriangleFlags::HIDDEN) };
    });
}

/// What traversal must know of a material: volumes and double-sided surfaces show their back, and whatever lets light
/// through is asked about.
fn flags_of(material: &Material) -> TriangleFlags {
    let mut flags = TriangleFlags::default();
    if !material.double_sided && !is_volume(material) {
        flags = flags.with(TriangleFlags::SINGLE_SIDED);
    }
    if material.alpha_mode != AlphaMode::Opaque || transmits(material) || material.is_shadow_catcher {
        flags = flags.with(TriangleFlags::FILTERED);
    }
    flags
}

/// Whether light can pass through the material.
pub fn transmits(material: &Material) -> bool {
    material.transmission.is_some_and(|transmission| transmission.factor > 0.0) && !material.unlit
}

/// Whether the material bounds a closed volume that light enters and leaves.
pub fn is_volume(material: &Material) -> bool {
    material.volume.is_some_and(|volume| volume.thickness > 0.0) && transmits(material)
}

#[cfg(test)]
mod tests;
