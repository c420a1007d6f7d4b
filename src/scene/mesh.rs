//! Meshes: triangles and vertex attributes in mesh space.

use glam::{Vec2, Vec3, Vec4};

use super::{MaterialIndex, VariantIndex};

/// Mesh: a list of primitives under one node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// Primitives, each with one material.
    pub primitives: Vec<Primitive>,
    /// Default morph weights, one for each morph target. Nodes and animations override them.
    pub weights: Vec<f32>,
}

impl Mesh {
    /// Vertices of all primitives.
    pub fn vertex_count(&self) -> usize {
        self.primitives.iter().map(|part| part.positions.len()).sum()
    }

    /// Triangles of all primitives.
    pub fn triangle_count(&self) -> usize {
        self.primitives.iter().map(|part| part.triangles.len()).sum()
    }

    /// Morph targets, which all primitives share.
    pub fn morph_target_count(&self) -> usize {
        self.primitives.iter().map(|part| part.targets.len()).max().unwrap_or(0)
    }
}

/// Cosine between the mean vertex normal of a triangle and its reversed normal above which the vertex normals are inside out: 37°.
pub const INSIDE_OUT_COSINE: f32 = 0.8;

/// Indexed triangles with one material. All attribute lists have one entry for each vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Primitive {
    /// Positions, metres.
    pub positions: Vec<Vec3>,
    /// Unit normals; `None` gives flat shading.
    pub normals: Option<Vec<Vec3>>,
    /// Unit tangents, with the sign of the bitangent in `w`.
    pub tangents: Option<Vec<Vec4>>,
    /// The texture coordinate set that the tangents were generated from; `None` for those of the file, which hold for every set.
    pub tangent_uv_set: Option<u32>,
    /// Whether the normals of most of the surface are inside out, by [`INSIDE_OUT_COSINE`].
    pub is_inside_out: bool,
    /// Texture coordinate sets, `TEXCOORD_0` first; origin at the image's top left.
    pub uvs: Vec<Vec<Vec2>>,
    /// Linear vertex colours with alpha.
    pub colors: Option<Vec<Vec4>>,
    /// Skinning joints and weights.
    pub influences: Option<SkinInfluences>,
    /// Corners of each triangle, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Material without a variant.
    pub material: MaterialIndex,
    /// Materials in the variants that replace it; each variant at most once.
    pub variants: Vec<(VariantIndex, MaterialIndex)>,
    /// Morph targets.
    pub targets: Vec<MorphTarget>,
}

/// Skinning influences: `per_vertex` consecutive entries for each vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SkinInfluences {
    /// Number of influences of a vertex.
    pub per_vertex: usize,
    /// Indices of [`super::Skin::joints`].
    pub joints: Vec<u32>,
    /// Weights. Those of a vertex sum to one, or are all zero if no joint influences it.
    pub weights: Vec<f32>,
}

/// Morph target: differences that are added in proportion to its weight; `None` adds nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphTarget {
    /// Differences of positions, metres.
    pub positions: Option<Vec<Vec3>>,
    /// Differences of normals.
    pub normals: Option<Vec<Vec3>>,
    /// Differences of tangents; the bitangent sign never changes.
    pub tangents: Option<Vec<Vec3>>,
    /// Differences of texture coordinates, with the number of the set.
    pub uvs: Vec<(usize, Vec<Vec2>)>,
    /// Differences of colours.
    pub colors: Option<Vec<Vec4>>,
}
