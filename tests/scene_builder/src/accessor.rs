//! Accessors: typed arrays in a buffer, and the conversion of vectors to them.

use glam::Vec3;

/// Component types of accessors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    I8 = 5120,
    U8 = 5121,
    I16 = 5122,
    U16 = 5123,
    U32 = 5125,
    F32 = 5126,
}

/// Target of a buffer view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    Vertices,
    Indices,
    Other,
}

/// An accessor to be written. A `data` of `None` is an accessor of zeros without a buffer view.
#[derive(Clone, Debug)]
pub struct Accessor {
    pub component: Component,
    pub normalized: bool,
    pub kind: &'static str,
    pub count: usize,
    pub data: Option<Vec<u8>>,
    pub byte_stride: Option<usize>,
    pub used_as: Use,
    pub bounds: Option<(Vec<f32>, Vec<f32>)>,
    /// Sparse elements that replace those of `data`: their indices in rising order, and their bytes.
    pub sparse: Option<(Vec<u16>, Vec<u8>)>,
}

impl Accessor {
    /// `count` elements of `kind`, tightly packed in `data`.
    pub fn new(component: Component, kind: &'static str, count: usize, data: Vec<u8>) -> Self {
        Self {
            component,
            normalized: false,
            kind,
            count,
            data: Some(data),
            byte_stride: None,
            used_as: Use::Vertices,
            bounds: None,
            sparse: None,
        }
    }
}

/// An accessor of positions with its bounds.
pub fn position_accessor(values: &[Vec3]) -> Accessor {
    let floats: Vec<f32> = values.iter().flat_map(Vec3::to_array).collect();
    let mut accessor =
        Accessor::new(Component::F32, "VEC3", values.len(), float_bytes(floats.iter().copied()));
    accessor.bounds = Some(bounds_of(&floats, 3));
    accessor
}

/// The little-endian bytes of `values`.
pub fn float_bytes(values: impl IntoIterator<Item = f32>) -> Vec<u8> {
    values.into_iter().flat_map(f32::to_le_bytes).collect()
}

/// The minimum and maximum of each of `width` interleaved components.
pub fn bounds_of(values: &[f32], width: usize) -> (Vec<f32>, Vec<f32>) {
    let mut least = vec![f32::INFINITY; width];
    let mut greatest = vec![f32::NEG_INFINITY; width];
    for element in values.chunks_exact(width) {
        for (component, &value) in element.iter().enumerate() {
            if value < least[component] {
                least[component] = value;
            }
            if value > greatest[component] {
                greatest[component] = value;
            }
        }
    }
    (least, greatest)
}
