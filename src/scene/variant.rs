//! Material variants (`KHR_materials_variants`).

use super::{MaterialIndex, Primitive, VariantIndex};
use crate::error::Warning;

/// Material variant. Primitives map it to their materials.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Variant {
    /// Name that users select it by.
    pub name: String,
}

/// A warning about what a material of a primitive needs. Variants with other materials do not have it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct VariantWarning {
    /// The warning.
    pub warning: Warning,
    /// The variants that have it; `None` stands for the primitives' own materials.
    pub variants: Vec<Option<VariantIndex>>,
}

impl Primitive {
    /// The material in `variant`; the primitive's own material if the variant does not replace it.
    pub fn material_in(&self, variant: Option<VariantIndex>) -> MaterialIndex {
        let other = self.variants.iter().find(|(of, _)| Some(*of) == variant);
        other.map_or(self.material, |(_, material)| *material)
    }
}
