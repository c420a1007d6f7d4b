//! Materials and texture references as glTF writes them.

use crate::document::Gltf;
use crate::json::{Json, list, object};

/// Alpha mode of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Alpha {
    Opaque,
    Mask(f32),
    Blend,
}

/// Reference of a material to a texture.
#[derive(Clone, Copy, Debug)]
pub struct TextureUse {
    pub texture: usize,
    pub uv_set: usize,
    pub transform: Option<TextureTransform>,
    /// `scale` of a normal texture, `strength` of an occlusion texture.
    pub amount: Option<f32>,
}

/// `KHR_texture_transform`.
#[derive(Clone, Copy, Debug)]
pub struct TextureTransform {
    pub offset: [f32; 2],
    pub rotation_radians: f32,
    pub scale: [f32; 2],
}

/// `KHR_materials_volume`: the medium inside a closed surface.
#[derive(Clone, Copy, Debug)]
pub struct Volume {
    pub thickness: f32,
    /// Attenuation distance in metres and colour; `None` absorbs nothing.
    pub attenuation: Option<(f32, [f32; 3])>,
}

/// `KHR_materials_specular`.
#[derive(Clone, Copy, Debug)]
pub struct Specular {
    pub factor: f32,
    pub color: [f32; 3],
}

/// `KHR_materials_clearcoat`.
#[derive(Clone, Copy, Debug)]
pub struct ClearCoat {
    pub factor: f32,
    pub roughness: f32,
    pub normal_texture: Option<TextureUse>,
}

/// `KHR_materials_sheen`.
#[derive(Clone, Copy, Debug)]
pub struct Sheen {
    pub color: [f32; 3],
    pub roughness: f32,
}

/// `KHR_materials_iridescence`; the texture sets the thickness.
#[derive(Clone, Copy, Debug)]
pub struct Iridescence {
    pub ior: f32,
    pub thickness_nm: [f32; 2],
    pub thickness_texture: Option<TextureUse>,
}

/// `KHR_materials_anisotropy`.
#[derive(Clone, Copy, Debug)]
pub struct Anisotropy {
    pub strength: f32,
    pub rotation_radians: f32,
    pub texture: Option<TextureUse>,
}

/// `KHR_materials_diffuse_transmission`.
#[derive(Clone, Copy, Debug)]
pub struct DiffuseTransmission {
    pub factor: f32,
    pub color: [f32; 3],
}

/// `KHR_materials_pbrSpecularGlossiness`; the colour is the base colour.
#[derive(Clone, Copy, Debug)]
pub struct SpecularGlossiness {
    pub specular: [f32; 3],
    pub glossiness: f32,
    pub texture: Option<TextureUse>,
}

/// A material. Values at their glTF default are not written.
#[derive(Clone, Copy, Debug)]
pub struct Material {
    pub name: &'static str,
    pub base_color: [f32; 4],
    pub base_color_texture: Option<TextureUse>,
    pub metallic: f32,
    pub roughness: f32,
    pub metallic_roughness_texture: Option<TextureUse>,
    pub normal_texture: Option<TextureUse>,
    pub occlusion_texture: Option<TextureUse>,
    pub emissive: [f32; 3],
    pub emissive_texture: Option<TextureUse>,
    pub emissive_strength: Option<f32>,
    pub alpha: Alpha,
    pub double_sided: bool,
    pub unlit: bool,
    pub ior: Option<f32>,
    pub transmission: Option<f32>,
    pub volume: Option<Volume>,
    pub dispersion: Option<f32>,
    pub specular: Option<Specular>,
    pub clear_coat: Option<ClearCoat>,
    pub sheen: Option<Sheen>,
    pub iridescence: Option<Iridescence>,
    pub anisotropy: Option<Anisotropy>,
    pub diffuse_transmission: Option<DiffuseTransmission>,
    pub specular_glossiness: Option<SpecularGlossiness>,
}

impl TextureUse {
    /// `texture` over the first set of texture coordinates.
    pub fn of(texture: usize) -> Self {
        Self { texture, uv_set: 0, transform: None, amount: None }
    }
}

impl Material {
    /// A rough dielectric.
    pub fn matte(name: &'static str, color: [f32; 3]) -> Self {
        Self {
            name,
            base_color: [color[0], color[1], color[2], 1.0],
            base_color_texture: None,
            metallic: 0.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            occlusion_texture: None,
            emissive: [0.0; 3],
            emissive_texture: None,
            emissive_strength: None,
            alpha: Alpha::Opaque,
            double_sided: false,
            unlit: false,
            ior: None,
            transmission: None,
            volume: None,
            dispersion: None,
            specular: None,
            clear_coat: None,
            sheen: None,
            iridescence: None,
            anisotropy: None,
            diffuse_transmission: None,
            specular_glossiness: None,
        }
    }

    /// A metal.
    pub fn metal(name: &'static str, color: [f32; 3], roughness: f32) -> Self {
        Self { metallic: 1.0, roughness, ..Self::matte(name, color) }
    }

    /// Smooth solid glass of the index of refraction `ior`.
    pub fn glass(name: &'static str, ior: f32) -> Self {
        Self {
            roughness: 0.0,
            ior: Some(ior),
            transmission: Some(1.0),
            volume: Some(Volume { thickness: 1.0, attenuation: None }),
            ..Self::matte(name, [1.0; 3])
        }
    }

    /// A material of `KHR_materials_unlit`.
    pub fn unlit(name: &'static str, color: [f32; 3]) -> Self {
        Self { unlit: true, ..Self::matte(name, color) }
    }

    /// The same material, double-sided.
    #[must_use]
    pub fn two_sided(self) -> Self {
        Self { double_sided: true, ..self }
    }

    /// Adds the material and registers the extensions it uses; returns its index.
    pub fn add_to(&self, gltf: &mut Gltf) -> usize {
        let mut json = object([
            ("name", self.name.into()),
            ("pbrMetallicRoughness", self.metallic_roughness_json(gltf)),
        ]);
        let textures = [
            ("normalTexture", self.normal_texture, "scale"),
            ("occlusionTexture", self.occlusion_texture, "strength"),
            ("emissiveTexture", self.emissive_texture, ""),
        ];
        for (key, texture, amount_key) in textures {
            if let Some(texture) = texture {
                json.set(key, texture_json(gltf, texture, amount_key));
            }
        }
        if self.emissive != [0.0; 3] {
            json.set("emissiveFactor", list(self.emissive));
        }
        match self.alpha {
            Alpha::Opaque => {}
            Alpha::Mask(cutoff) => {
                json.set("alphaMode", "MASK");
                json.set("alphaCutoff", cutoff);
            }
            Alpha::Blend => json.set("alphaMode", "BLEND"),
        }
        if self.double_sided {
            json.set("doubleSided", true);
        }
        let extensions = self.extensions_json(gltf);
        if !extensions.is_empty() {
            json.set("extensions", extensions);
        }
        gltf.add("materials", json)
    }

    fn metallic_roughness_json(&self, gltf: &mut Gltf) -> Json {
        let mut json = object([]);
        if self.base_color != [1.0; 4] {
            json.set("baseColorFactor", list(self.base_color));
        }
        if let Some(texture) = self.base_color_texture {
            json.set("baseColorTexture", texture_json(gltf, texture, ""));
        }
        json.set("metallicFactor", self.metallic);
        json.set("roughnessFactor", self.roughness);
        if let Some(texture) = self.metallic_roughness_texture {
            json.set("metallicRoughnessTexture", texture_json(gltf, texture, ""));
        }
        json
    }

    fn extensions_json(&self, gltf: &mut Gltf) -> Json {
        let mut extensions = object([]);
        let mut set = |name: &'static str, value: Json| {
            gltf.uses_extension(name);
            extensions.set(name, value);
        };
        if self.unlit {
            set("KHR_materials_unlit", object([]));
        }
        if let Some(strength) = self.emissive_strength {
            set("KHR_materials_emissive_strength", object([("emissiveStrength", strength.into())]));
        }
        if let Some(ior) = self.ior {
            set("KHR_materials_ior", object([("ior", ior.into())]));
        }
        if let Some(factor) = self.transmission {
            set("KHR_materials_transmission", object([("transmissionFactor", factor.into())]));
        }
        if let Some(volume) = self.volume {
            let mut json = object([("thicknessFactor", volume.thickness.into())]);
            if let Some((distance, color)) = volume.attenuation {
                json.set("attenuationDistance", distance);
                json.set("attenuationColor", list(color));
            }
            set("KHR_materials_volume", json);
        }
        if let Some(dispersion) = self.dispersion {
            set("KHR_materials_dispersion", object([("dispersion", dispersion.into())]));
        }
        if let Some(specular) = self.specular {
            let json = object([
                ("specularFactor", specular.factor.into()),
                ("specularColorFactor", list(specular.color)),
            ]);
            set("KHR_materials_specular", json);
        }
        if let Some(layer) = self.diffuse_transmission {
            let json = object([
                ("diffuseTransmissionFactor", layer.factor.into()),
                ("diffuseTransmissionColorFactor", list(layer.color)),
            ]);
            set("KHR_materials_diffuse_transmission", json);
        }
        if let Some(sheen) = self.sheen {
            let json = object([
                ("sheenColorFactor", list(sheen.color)),
                ("sheenRoughnessFactor", sheen.roughness.into()),
            ]);
            set("KHR_materials_sheen", json);
        }
        for (name, json) in self.textured_extensions(gltf) {
            gltf.uses_extension(name);
            extensions.set(name, json);
        }
        extensions
    }

    /// Extensions that may have textures.
    fn textured_extensions(&self, gltf: &mut Gltf) -> Vec<(&'static str, Json)> {
        let mut extensions = Vec::new();
        if let Some(coat) = self.clear_coat {
            let mut json = object([
                ("clearcoatFactor", coat.factor.into()),
                ("clearcoatRoughnessFactor", coat.roughness.into()),
            ]);
            if let Some(texture) = coat.normal_texture {
                json.set("clearcoatNormalTexture", texture_json(gltf, texture, "scale"));
            }
            extensions.push(("KHR_materials_clearcoat", json));
        }
        if let Some(film) = self.iridescence {
            let mut json = object([
                ("iridescenceFactor", 1.0.into()),
                ("iridescenceIor", film.ior.into()),
                ("iridescenceThicknessMinimum", film.thickness_nm[0].into()),
                ("iridescenceThicknessMaximum", film.thickness_nm[1].into()),
            ]);
            if let Some(texture) = film.thickness_texture {
                json.set("iridescenceThicknessTexture", texture_json(gltf, texture, ""));
            }
            extensions.push(("KHR_materials_iridescence", json));
        }
        if let Some(anisotropy) = self.anisotropy {
            let mut json = object([
                ("anisotropyStrength", anisotropy.strength.into()),
                ("anisotropyRotation", anisotropy.rotation_radians.into()),
            ]);
            if let Some(texture) = anisotropy.texture {
                json.set("anisotropyTexture", texture_json(gltf, texture, ""));
            }
            extensions.push(("KHR_materials_anisotropy", json));
        }
        if let Some(older) = self.specular_glossiness {
            let mut json = object([
                ("diffuseFactor", list(self.base_color)),
                ("specularFactor", list(older.specular)),
                ("glossinessFactor", older.glossiness.into()),
            ]);
            if let Some(texture) = older.texture {
                json.set("specularGlossinessTexture", texture_json(gltf, texture, ""));
            }
            extensions.push(("KHR_materials_pbrSpecularGlossiness", json));
        }
        extensions
    }
}

fn texture_json(gltf: &mut Gltf, texture: TextureUse, amount_key: &str) -> Json {
    let mut json = object([("index", texture.texture.into())]);
    if texture.uv_set != 0 {
        json.set("texCoord", texture.uv_set);
    }
    if let Some(amount) = texture.amount {
        json.set(amount_key, amount);
    }
    if let Some(transform) = texture.transform {
        gltf.uses_extension("KHR_texture_transform");
        let value = object([
            ("offset", list(transform.offset)),
            ("rotation", transform.rotation_radians.into()),
            ("scale", list(transform.scale)),
        ]);
        json.set("extensions", object([("KHR_texture_transform", value)]));
    }
    json
}
