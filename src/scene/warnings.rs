//! Which of a scene's warnings hold for what is rendered of it.

use super::{Scene, VariantIndex, VariantWarning};
use crate::error::Warning;

impl Scene {
    /// The warnings that hold where these variants are rendered; `None` stands for the primitives' own materials.
    pub fn warnings_of(&self, variants: &[Option<VariantIndex>]) -> Vec<Warning> {
        let depends = |warning: &&Warning| {
            self.variant_warnings.iter().any(|of_variants| of_variants.warning.message == warning.message)
        };
        let mut warnings: Vec<_> =
            self.warnings.iter().filter(|warning| !depends(warning)).cloned().collect();
        for VariantWarning { warning, variants: affected } in &self.variant_warnings {
            let is_told = warnings.iter().any(|told| told.message == warning.message);
            if !is_told && affected.iter().any(|variant| variants.contains(variant)) {
                warnings.push(warning.clone());
            }
        }
        warnings
    }
}
