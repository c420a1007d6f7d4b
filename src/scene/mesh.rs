//! Geometry in its own space.

use glam::{Vec2, Vec3, Vec4};

use super::{MaterialIndex, VariantIndex};

/// A list of primitives drawn together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Name, when the file gives one.
    pub name: Option<String>,
    /// Parts, each with one material.
    pub primitives: Vec<Primitive>,
    /// Morph weights while no node or animation gives others; one a morph target.
    pub weights: Vec<f32>,
}

/// Indexed triangles with one material. All attribute lists have one entry a vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Primitive {
    /// Metres.
    pub positions: Vec<Vec3>,
    /// Unit normals; `None` shades every triangle flat.
    pub normals: Option<Vec<Vec3>>,
    /// Unit tangents, with the sign of the bitangent in `w`.
    pub tangents: Option<Vec<Vec4>>,
    /// Texture coordinate sets, `TEXCOORD_0` first; origin at the image's top left.
    pub uvs: Vec<Vec<Vec2>>,
    /// Linear vertex colour and alpha.
    pub colors: Option<Vec<Vec4>>,
    /// Joints and weights.
    pub influences: Option<SkinInfluences>,
    /// Corners of each triangle, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// What the surface looks like.
    pub material: MaterialIndex,
    /// What it looks like in variants that change it; each at most once.
    pub variants: Vec<(VariantIndex, MaterialIndex)>,
    /// Morph targets.
    pub targets: Vec<MorphTarget>,
}

/// Joints that move each vertex; `per_vertex` consecutive entries a vertex, any number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SkinInfluences {
    /// Influences a vertex.
    pub per_vertex: usize,
    /// Subscripts of [`super::Skin::joints`].
    pub joints: Vec<u32>,
    /// Weights; they sum to one a vertex, or are all zero where no joint holds the vertex.
    pub weights: Vec<f32>,
}

/// Differences that a morph weight adds; `None` adds nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphTarget {
    /// Metres, one a vertex.
    pub positions: Option<Vec<Vec3>>,
    /// One a vertex.
    pub normals: Option<Vec<Vec3>>,
    /// One a vertex; the bitangent sign never changes.
    pub tangents: Option<Vec<Vec3>>,
    /// Texture coordinate sets that change, each with its set number.
    pub uvs: Vec<(usize, Vec<Vec2>)>,
    /// One a vertex.
    pub colors: Option<Vec<Vec4>>,
}
