//! Words of the formats, for edits and for dictionaries.

/// Names and values of glTF and of the reports.
#[rustfmt::skip]
pub(crate) const WORDS: [&str; 136] = [
    "accessors", "alphaCutoff", "alphaMode", "animations", "asset", "aspectRatio", "attributes", "attenuationColor",
    "attenuationDistance", "anisotropyStrength", "anisotropyTexture", "baseColorFactor", "baseColorTexture", "BLEND", "buffer",
    "bufferView", "bufferViews", "buffers", "byteLength", "byteOffset", "byteStride", "camera", "cameras", "channels", "children",
    "clearcoatFactor", "clearcoatNormalTexture", "color", "COLOR_0", "componentType", "count", "CUBICSPLINE",
    "data:application/octet-stream;base64,AAAA", "diffuseFactor", "diffuseTransmissionFactor", "dispersion", "doubleSided",
    "emissiveFactor", "emissiveStrength", "emissiveTexture", "EXT_lights_image_based", "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression", "EXT_texture_webp", "extensions", "extensionsRequired", "extensionsUsed", "extras", "images", "index",
    "indices", "input", "intensity", "interpolation", "inverseBindMatrices", "ior", "iridescenceFactor", "joints", "JOINTS_0",
    "JOINTS_1", "KHR_animation_pointer", "KHR_draco_mesh_compression", "KHR_lights_punctual", "KHR_materials_anisotropy",
    "KHR_materials_clearcoat", "KHR_materials_diffuse_transmission", "KHR_materials_dispersion", "KHR_materials_emissive_strength",
    "KHR_materials_ior", "KHR_materials_iridescence", "KHR_materials_pbrSpecularGlossiness", "KHR_materials_sheen",
    "KHR_materials_specular", "KHR_materials_transmission", "KHR_materials_unlit", "KHR_materials_variants",
    "KHR_materials_volume", "KHR_mesh_quantization", "KHR_meshopt_compression", "KHR_node_visibility", "KHR_texture_basisu",
    "KHR_texture_transform", "light", "lights", "MASK", "MAT4", "material", "materials", "matrix", "max", "mesh", "meshes",
    "metallicFactor", "mimeType", "min", "mode", "name", "NORMAL", "normalized", "nodes", "normalTexture", "orthographic", "perspective",
    "pointer", "POSITION", "primitives", "range", "ROTATION", "rotation", "roughnessFactor", "sampler", "samplers", "SCALAR", "scale",
    "scenes", "skeleton", "skin", "source", "sparse", "specularFactor", "spot", "STEP", "TANGENT", "targets", "TEXCOORD_1",
    "thicknessFactor", "TRANSLATION", "transmissionFactor", "translation", "type", "uri", "values", "VEC2", "VEC3", "weights",
    "zfar",
];

/// Values of shot files, suite files and definitions, beside the names of the settings.
#[rustfmt::skip]
pub(crate) const SETTING_WORDS: [&str; 45] = [
    "[test]", "[shot]", "[[shot]]", "[limits]", "references", "report", "scenes", "preset", "max_reference_kib", "exclude", "cache",
    "####", "%04d", "{frame:04}", "{scene}", "{clip}", "{camera}", "{variant}", "{layer}", "{shot}", ".exr", ".png", ".mp4", "auto", "all", "none",
    "each", "#0", "1-10x2", "10-1:-1", "-3--2", "every", "180deg", "f/2.8", "24000/1001", "studio", "0.5,0.25,1", "path", "whitted",
    "half,zip", "64M", "50%", "1080p", "true", "plate:",
];
