//! Materials without the lobes of extensions.

use crate::frame::transmits;
use crate::scene::Material;

/// Whether the lobes of a material are those of the metallic-roughness model alone, so that hits can be shaded in blocks.
pub(super) fn is_opaque(material: &Material) -> bool {
    let is_unlayered = material.clear_coat.is_none()
        && material.sheen.is_none()
        && material.iridescence.is_none()
        && material.anisotropy.is_none()
        && material.diffuse_transmission.is_none();
    is_unlayered && !material.unlit && !transmits(material) && material.ior > 0.0
}
