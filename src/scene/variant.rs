//! Sets of materials that a file offers to choose from (`KHR_materials_variants`).

use super::{MaterialIndex, Primitive, VariantIndex};

/// One set of materials; primitives say what they look like in it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Variant {
    /// What users choose it by.
    pub name: String,
}

impl Primitive {
    /// What the primitive looks like in `variant`; its own material where it has no other for it.
    pub fn material_in(&self, variant: Option<VariantIndex>) -> MaterialIndex {
        let other = self.variants.iter().find(|(of, _)| Some(*of) == variant);
        other.map_or(self.material, |(_, material)| *material)
    }
}
