//! Hashes of the parts of a scene at the time of a frame, from which a comparison tells what changed.
//!
//! They say which of geometry, materials and lights differ between two images, whatever it does to pixels. The order of nodes, names
//! and content that nothing uses do not count. Vertices and texels enter by checksums, so that the hashes take little of a frame's time.

use crc32fast::Hasher as Checksum;
use glam::{Mat4, Vec2, Vec3, Vec4};
use rayon::prelude::*;
use sha2::{Digest as _, Sha256};

use super::{SequenceJob, hex};
use crate::frame::{Frame, PosedContent, PosedLight, PosedMesh};
use crate::image::{CameraOrigin, PartHashes};
use crate::scene::{
    Image, ImageLight, Light, Material, MaterialIndex, Mesh, MorphTarget, Primitive, Scene, SelectedCamera,
    SkinInfluences, Texels, Texture,
};

/// Bytes of a hash that are kept.
const KEPT: usize = 8;
/// Values of one parallel task.
const BLOCK: usize = 32_768;

type Hash = [u8; 32];

/// Hashes of what no clip moves: vertices and texels.
pub(super) struct StaticHashes {
    /// By [`crate::scene::MeshIndex`].
    meshes: Vec<MeshHashes>,
    textures: Hash,
    /// By [`crate::scene::ImageLightIndex`].
    image_lights: Vec<u32>,
}

impl StaticHashes {
    pub(super) fn of(scene: &Scene) -> Self {
        let meshes = scene.meshes.par_iter().map(MeshHashes::of);
        let images: Vec<_> = scene.images.par_iter().map(checksum_of_image).collect();
        let textures = scene.textures.iter().map(|Texture { image, sampler, name: _ }| {
            let image = images.get(image.index());
            Sha256::digest(format!("{image:?} {sampler:?}"))
        });
        let image_lights = scene.image_lights.iter().map(checksum_of_image_light).collect();
        Self { textures: joined(textures), meshes: meshes.collect(), image_lights }
    }
}

/// Hashes of the vertices of a mesh.
struct MeshHashes {
    /// Of all that vertices and morph targets have.
    whole: Hash,
    /// The same without vertex colours; equal to `whole` where there are none.
    shape: Hash,
}

impl MeshHashes {
    fn of(mesh: &Mesh) -> Self {
        let primitives: Vec<_> = mesh.primitives.par_iter().map(PrimitiveChecksums::of).collect();
        let hash = |sum: fn(&PrimitiveChecksums) -> &Checksum| {
            joined(primitives.iter().map(|sums| sum(sums).clone().finalize().to_le_bytes()))
        };
        Self { whole: hash(|sums| &sums.whole), shape: hash(|sums| &sums.shape) }
    }
}

/// The hashes at the time of `frame`.
pub(super) fn part_hashes(job: &SequenceJob, statics: &StaticHashes, frame: i64) -> PartHashes {
    let scene = &job.scene;
    let content = Frame::content_at(scene, &job.selection, job.rate.time_seconds(frame));
    let meshes = &content.meshes;
    let statics_of = |posed: &PosedMesh| &statics.meshes[posed.mesh.index()];
    let geometry: Vec<Hash> =
        meshes.par_iter().map(|posed| geometry_of_mesh(&statics_of(posed).whole, posed)).collect();
    let shapes: Vec<Hash> = (meshes.par_iter().zip(&geometry))
        .map(|(posed, geometry)| match statics_of(posed) {
            MeshHashes { whole, shape } if whole == shape => *geometry,
            MeshHashes { shape, .. } => geometry_of_mesh(shape, posed),
        })
        .collect();
    let of_material = MaterialHashes::of(&content);
    let materials_of = |posed: &PosedMesh| {
        let primitives = &scene.meshes[posed.mesh.index()].primitives;
        primitives.iter().map(|primitive| of_material.get(primitive.material_in(job.selection.variant)))
    };

    // The material of every visible primitive, by mesh and number, and the colours of instances
    let colors: Vec<Option<Hash>> = meshes.iter().map(|posed| instance_colors(scene, posed)).collect();
    let assignments: Vec<Hash> = (meshes.par_iter().zip(&geometry).zip(&colors))
        .map(|((posed, geometry), colors)| {
            joined(std::iter::once(geometry).chain(materials_of(posed)).chain(colors.as_ref()))
        })
        .collect();

    // Materials and colours of instances once each, since an object that vanishes changes none, and all textures
    let mut materials = sorted(meshes.iter().flat_map(materials_of).chain(colors.iter().flatten()).collect());
    materials.dedup();
    materials.push(&statics.textures);

    let [geometry, shape, materials, assignments, lights] = [
        joined(sorted(geometry.iter().collect())),
        joined(sorted(shapes.iter().collect())),
        joined(materials),
        joined(sorted(assignments.iter().collect())),
        lights(job, statics, &content),
    ]
    .map(|hash| hex(&hash[..KEPT]));
    let background = Some(hex(&background(job, frame)[..KEPT]));
    PartHashes {
        geometry,
        materials,
        assignments,
        lights,
        shape: Some(shape),
        background,
        camera: Some(match job.selection.camera {
            SelectedCamera::Node(_) => CameraOrigin::File,
            SelectedCamera::Fixed { .. } if job.camera_follows_clips => CameraOrigin::Framed,
            _ => CameraOrigin::Other,
        }),
        rules: Some(PartHashes::RULES),
    }
}

/// The order of nodes does not count.
fn sorted(mut hashes: Vec<&Hash>) -> Vec<&Hash> {
    hashes.sort_unstable();
    hashes
}

/// The colours of instances, where they have any.
fn instance_colors(scene: &Scene, posed: &PosedMesh) -> Option<Hash> {
    let colors = &scene.nodes[posed.node.index()].instance_colors;
    if colors.is_empty() {
        return None;
    }
    let mut hash = Sha256::new();
    add(&mut |bytes: &[u8]| hash.update(bytes), colors.iter().flat_map(Vec4::to_array));
    Some(hash.finalize().into())
}

/// A mesh with its matrices and weights.
fn geometry_of_mesh(mesh: &Hash, posed: &PosedMesh) -> Hash {
    let mut hash = Sha256::new_with_prefix(mesh);
    let mut update = |bytes: &[u8]| hash.update(bytes);
    add(&mut update, posed.matrices.iter().chain(&*posed.joint_matrices).flat_map(Mat4::to_cols_array));
    add(&mut update, posed.weights.iter().copied());
    hash.finalize().into()
}

/// Hashes of materials without their names. Many primitives share one.
struct MaterialHashes {
    /// By [`MaterialIndex`].
    materials: Vec<Hash>,
    /// Of primitives without material.
    absent: Hash,
}

impl MaterialHashes {
    fn of(content: &PosedContent) -> Self {
        let hash = |material: Option<Material>| Sha256::digest(format!("{material:?}")).into();
        let nameless = |material: &Material| hash(Some(Material { name: None, ..material.clone() }));
        Self { materials: content.materials.par_iter().map(nameless).collect(), absent: hash(None) }
    }

    fn get(&self, material: MaterialIndex) -> &Hash {
        self.materials.get(material.index()).unwrap_or(&self.absent)
    }
}

fn lights(job: &SequenceJob, statics: &StaticHashes, content: &PosedContent) -> Hash {
    let nameless = |light: &PosedLight| {
        let light = PosedLight { light: Light { name: None, ..light.light.clone() }, ..light.clone() };
        format!("{light:?}")
    };
    let mut lights: Vec<_> = content.lights.iter().map(nameless).collect();
    lights.sort_unstable();
    let image_light = job.selection.image_light.map(|light| statics.image_lights[light.index()]);
    let of_job = format!(
        "{} {:?} {image_light:?} {} {:?}",
        job.environment.content_key(),
        content.image_light,
        job.render.light_scale,
        job.render.light_size
    );
    Sha256::digest(lights.join(" ") + &of_job).into()
}

/// The plate of a frame, and whether camera rays see the environment.
fn background(job: &SequenceJob, frame: i64) -> Hash {
    let plate = job.plates.as_ref().map(|plates| plates.content_key(frame));
    Sha256::digest(format!("{plate:?} {}", job.render.show_background)).into()
}

/// Checksums of a primitive, as of texels.
#[derive(Default)]
struct PrimitiveChecksums {
    whole: Checksum,
    /// Without colours, as if it had none.
    shape: Checksum,
}

impl PrimitiveChecksums {
    fn of(primitive: &Primitive) -> Self {
        // The material belongs to another part.
        let Primitive {
            positions,
            normals,
            tangents,
            tangent_uv_set: _,
            is_inside_out: _,
            uvs,
            colors,
            influences,
            triangles,
            material: _,
            variants: _,
            targets,
        } = primitive;
        let mut sums = Self::default();
        sums.add_shape(|sum| {
            add_lists(sum, [positions.as_slice()], bits_of_vec3);
            add_lists(sum, normals.as_deref(), bits_of_vec3);
            add_lists(sum, tangents.as_deref(), bits_of_vec4);
            add_lists(sum, uvs.iter().map(Vec::as_slice), bits_of_vec2);
        });
        sums.add_colors(colors.as_deref());
        sums.add_shape(|sum| {
            if let Some(SkinInfluences { per_vertex, joints, weights }) = influences {
                sum.update(&per_vertex.to_le_bytes());
                add_lists(sum, [joints.as_slice()], |joint| [joint]);
                add_lists(sum, [weights.as_slice()], |weight| [weight.to_bits()]);
            }
            add_lists(sum, [triangles.as_slice()], |corners| corners);
        });
        for MorphTarget { positions, normals, tangents, uvs, colors } in targets {
            sums.add_shape(|sum| {
                for differences in [positions, normals, tangents] {
                    add_lists(sum, differences.as_deref(), bits_of_vec3);
                }
                add_lists(sum, uvs.iter().map(|(_, uvs)| uvs.as_slice()), bits_of_vec2);
            });
            sums.add_colors(colors.as_deref());
        }
        sums
    }

    fn add_shape(&mut self, add: impl FnOnce(&mut Checksum)) {
        let mut part = Checksum::new();
        add(&mut part);
        self.whole.combine(&part);
        self.shape.combine(&part);
    }

    fn add_colors(&mut self, colors: Option<&[Vec4]>) {
        let [mut part, mut absent] = [Checksum::new(), Checksum::new()];
        add_lists(&mut part, colors, bits_of_vec4);
        add_lists(&mut absent, None, bits_of_vec4);
        self.whole.combine(&part);
        self.shape.combine(&absent);
    }
}

fn bits_of_vec2(vector: Vec2) -> [u32; 2] {
    vector.to_array().map(f32::to_bits)
}

fn bits_of_vec3(vector: Vec3) -> [u32; 3] {
    vector.to_array().map(f32::to_bits)
}

fn bits_of_vec4(vector: Vec4) -> [u32; 4] {
    vector.to_array().map(f32::to_bits)
}

/// A checksum: there are many texels, and a hash of them all would delay the first frame.
fn checksum_of_image(image: &Image) -> u32 {
    let mut checksum = Checksum::new();
    checksum.update(&image.width.to_le_bytes());
    match &image.texels {
        Texels::Rgba8(texels) => checksum.update(texels.as_flattened()),
        Texels::Rgba16(texels) => add_values(&mut checksum, texels, |texel| texel.map(u16::to_le_bytes)),
    }
    checksum.finalize()
}

/// A checksum, as of texels. Intensity and rotation may be animated and are not part of it.
fn checksum_of_image_light(light: &ImageLight) -> u32 {
    let mut checksum = Checksum::new();
    add_lists(&mut checksum, [light.irradiance.as_slice()], bits_of_vec3);
    for face in light.levels.iter().flat_map(|level| &level.faces) {
        add_lists(&mut checksum, [face.as_slice()], |texel| texel.map(f32::to_bits));
    }
    checksum.finalize()
}

/// Hands the bits of numbers to `update`, then their count.
fn add(update: &mut impl FnMut(&[u8]), numbers: impl Iterator<Item = f32>) {
    let bytes: Vec<[u8; 4]> = numbers.map(|number| number.to_bits().to_le_bytes()).collect();
    update(bytes.as_flattened());
    update(&(bytes.len() as u64).to_le_bytes());
}

/// Adds the bits of all values of lists to a checksum, then the count of their numbers.
fn add_lists<'l, T: Copy + Sync + 'l, const N: usize>(
    checksum: &mut Checksum,
    lists: impl IntoIterator<Item = &'l [T]>,
    bits: impl Fn(T) -> [u32; N] + Sync,
) {
    let mut count = 0_u64;
    for list in lists {
        add_values(checksum, list, |value| bits(value).map(u32::to_le_bytes));
        count += (list.len() * N) as u64;
    }
    checksum.update(&count.to_le_bytes());
}

/// Adds the bytes of values to a checksum. All threads take part, since lists may be long.
fn add_values<T: Copy + Sync, const N: usize, const B: usize>(
    checksum: &mut Checksum,
    values: &[T],
    bytes: impl Fn(T) -> [[u8; B]; N] + Sync,
) {
    let of_block = |block: &[T]| {
        let bytes: Vec<[[u8; B]; N]> = block.iter().map(|&value| bytes(value)).collect();
        let mut checksum = Checksum::new();
        checksum.update(bytes.as_flattened().as_flattened());
        checksum
    };
    let blocks: Vec<Checksum> = values.par_chunks(BLOCK).map(of_block).collect();
    for block in &blocks {
        checksum.combine(block);
    }
}

fn joined(hashes: impl IntoIterator<Item = impl AsRef<[u8]>>) -> Hash {
    let mut joined = Sha256::new();
    for hash in hashes {
        joined.update(hash);
    }
    joined.finalize().into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{MeshIndex, NodeIndex};

    #[test]
    fn vertex_colors_are_no_shape() {
        let with = |colors: Option<Vec4>| Primitive {
            positions: vec![Vec3::X],
            colors: colors.map(|color| vec![color]),
            ..Primitive::default()
        };
        let hashes = [None, Some(Vec4::ONE), Some(Vec4::ZERO)]
            .map(|colors| MeshHashes::of(&Mesh { primitives: vec![with(colors)], ..Mesh::default() }));
        let [bare, white, black] = hashes;
        assert!(bare.whole == bare.shape);
        assert!(white.shape == bare.shape && black.shape == bare.shape);
        assert!(white.whole != bare.whole && white.whole != black.whole && bare.whole != black.whole);
        // Two nodes that exchange their meshes
        let posed = |x: f32| PosedMesh {
            mesh: MeshIndex(0),
            node: NodeIndex(0),
            matrices: vec![Mat4::from_translation(Vec3::X * x)],
            joint_matrices: [].into(),
            weights: Vec::new(),
        };
        let both = |meshes: [&Hash; 2]| {
            let hashes = [geometry_of_mesh(meshes[0], &posed(0.0)), geometry_of_mesh(meshes[1], &posed(1.0))];
            joined(sorted(hashes.iter().collect()))
        };
        assert_ne!(both([&white.whole, &black.whole]), both([&black.whole, &white.whole]));
        assert_eq!(both([&white.shape, &black.shape]), both([&black.shape, &white.shape]));
    }

    #[test]
    fn checksums_of_blocks_are_those_of_the_whole() {
        for count in [0, 1, BLOCK, 2 * BLOCK + 5] {
            let values: Vec<Vec3> = (0..count).map(|index| Vec3::new(index as f32, 0.5, -1.5)).collect();
            let texels: Vec<[u16; 4]> = (0..count).map(|index| [index as u16, 7, 0, u16::MAX]).collect();
            let [mut expected, mut checksum] = [Checksum::new(), Checksum::new()];
            expected.update(b"before");
            // Two lists are as one.
            let numbers = values.iter().chain(&values).flat_map(Vec3::to_array);
            add(&mut |bytes| expected.update(bytes), numbers);
            texels.as_flattened().iter().for_each(|number| expected.update(&number.to_le_bytes()));
            checksum.update(b"before");
            add_lists(&mut checksum, [values.as_slice(); 2], bits_of_vec3);
            add_values(&mut checksum, &texels, |texel| texel.map(u16::to_le_bytes));
            assert_eq!(checksum.finalize(), expected.finalize(), "{count} values");
        }
    }
}
