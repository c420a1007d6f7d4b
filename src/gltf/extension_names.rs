//! Names of the supported extensions, and of those whose images have a substitute.

pub(super) const ANIMATION_POINTER: &str = "KHR_animation_pointer";
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";
pub(super) const EXT_MESHOPT: &str = "EXT_meshopt_compression";
pub(super) const IMAGE_LIGHTS: &str = "EXT_lights_image_based";
pub(super) const INSTANCING: &str = "EXT_mesh_gpu_instancing";
pub(super) const KHR_MESHOPT: &str = "KHR_meshopt_compression";
pub(super) const LIGHTS: &str = "KHR_lights_punctual";
pub(super) const ANISOTROPY: &str = "KHR_materials_anisotropy";
pub(super) const CLEAR_COAT: &str = "KHR_materials_clearcoat";
pub(super) const DIFFUSE_TRANSMISSION: &str = "KHR_materials_diffuse_transmission";
pub(super) const DISPERSION: &str = "KHR_materials_dispersion";
pub(super) const EMISSIVE_STRENGTH: &str = "KHR_materials_emissive_strength";
pub(super) const IOR: &str = "KHR_materials_ior";
pub(super) const IRIDESCENCE: &str = "KHR_materials_iridescence";
pub(super) const SPECULAR_GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";
pub(super) const SHEEN: &str = "KHR_materials_sheen";
pub(super) const SPECULAR: &str = "KHR_materials_specular";
pub(super) const TRANSMISSION: &str = "KHR_materials_transmission";
pub(super) const UNLIT: &str = "KHR_materials_unlit";
pub(super) const VARIANTS: &str = "KHR_materials_variants";
pub(super) const VOLUME: &str = "KHR_materials_volume";
pub(super) const QUANTIZATION: &str = "KHR_mesh_quantization";
pub(super) const TEXTURE_BASISU: &str = "KHR_texture_basisu";
pub(super) const TEXTURE_TRANSFORM: &str = "KHR_texture_transform";
pub(super) const TEXTURE_WEBP: &str = "EXT_texture_webp";
pub(super) const VISIBILITY: &str = "KHR_node_visibility";

/// Supported extensions of materials.
pub(super) const MATERIAL_EXTENSIONS: [&str; 13] = [
    ANISOTROPY,
    CLEAR_COAT,
    DIFFUSE_TRANSMISSION,
    DISPERSION,
    EMISSIVE_STRENGTH,
    IOR,
    IRIDESCENCE,
    SPECULAR_GLOSSINESS,
    SHEEN,
    SPECULAR,
    TRANSMISSION,
    UNLIT,
    VOLUME,
];

/// Supported extensions of other objects.
const OTHERS: [&str; 13] = [
    ANIMATION_POINTER,
    DRACO,
    EXT_MESHOPT,
    IMAGE_LIGHTS,
    INSTANCING,
    KHR_MESHOPT,
    LIGHTS,
    VARIANTS,
    QUANTIZATION,
    TEXTURE_BASISU,
    TEXTURE_TRANSFORM,
    TEXTURE_WEBP,
    VISIBILITY,
];

/// Unsupported extensions that give a texture an alternative image. Only its plain image can be read.
pub(super) const UNSUPPORTED_IMAGES: [&str; 2] = ["EXT_texture_avif", "MSFT_texture_dds"];

/// Whether the extension `name` is supported.
pub(super) fn is_supported(name: &str) -> bool {
    MATERIAL_EXTENSIONS.contains(&name) || OTHERS.contains(&name)
}
