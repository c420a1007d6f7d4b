//! Material variants (`KHR_materials_variants`).

use super::{MaterialIndex, Primitive, VariantIndex};

/// Material variant. Primitives map it to their materials.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Variant {
    /// Name that users select it by.
    pub name: String,
}

impl Primitive {
    /// The material in `variant`; the primitive's own material if the variant does not replace it.
    pub fn material_in(&self, variant: Option<VariantIndex>) -> MaterialIndex {
        let other = self.variants.iter().find(|(of, _)| Some(*of) == variant);
        other.map_or(self.material, |(_, material)| *material)
    }
}
