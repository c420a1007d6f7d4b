//! The layers that an EXR file can hold, by name.

use crate::film::{LayerRequest, LightPart};

/// One layer: a few channels that belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Layer {
    /// The picture: `R`, `G`, `B`, `A`.
    Beauty,
    /// Distance along the camera's axis, metres: `Z`; [`super::DEPTH_OF_NOTHING`] where nothing is met.
    Depth,
    /// World space, metres: `position.X`, `.Y`, `.Z`.
    Position,
    /// World-space shading normal: `normal.X`, `.Y`, `.Z`.
    Normal,
    /// World-space normal of the triangle: `geometric_normal.X`, `.Y`, `.Z`.
    GeometricNormal,
    /// Linear base colour: `albedo.R`, `.G`, `.B`.
    Albedo,
    /// One part of the picture's light: `direct.R`, `.G`, `.B` and so on.
    Light(LightPart),
    /// Texture coordinates with v growing upwards: `uv.U`, `.V`.
    Uv,
    /// Subscript of the mesh plus one: `object_id`.
    ObjectId,
    /// Subscript of the material plus one: `material_id`.
    MaterialId,
    /// Subscript of the node plus one: `node_id`.
    NodeId,
    /// Pixels to where the same point is in the next and in the previous frame: `forward.u`, `.v`, `backward.u`, `.v`; v
    /// grows upwards.
    Motion,
    /// Cryptomatte by names of nodes: `crypto_object00.R` and so on.
    CryptoObject,
    /// Cryptomatte by names of materials: `crypto_material00.R` and so on.
    CryptoMaterial,
}

impl Layer {
    /// All of them, in the order in which they are listed.
    pub const ALL: [Self; 19] = [
        Self::Beauty,
        Self::Depth,
        Self::Position,
        Self::Normal,
        Self::GeometricNormal,
        Self::Albedo,
        Self::Light(LightPart::Emission),
        Self::Light(LightPart::Direct),
        Self::Light(LightPart::Environment),
        Self::Light(LightPart::Reflection),
        Self::Light(LightPart::Refraction),
        Self::Light(LightPart::PassThrough),
        Self::Uv,
        Self::ObjectId,
        Self::MaterialId,
        Self::NodeId,
        Self::Motion,
        Self::CryptoObject,
        Self::CryptoMaterial,
    ];

    /// As it is typed, and as files of its own are called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Beauty => "beauty",
            Self::Depth => "depth",
            Self::Position => "position",
            Self::Normal => "normal",
            Self::GeometricNormal => "geometric_normal",
            Self::Albedo => "albedo",
            Self::Light(part) => part.name(),
            Self::Uv => "uv",
            Self::ObjectId => "object_id",
            Self::MaterialId => "material_id",
            Self::NodeId => "node_id",
            Self::Motion => "motion",
            Self::CryptoObject => "crypto_object",
            Self::CryptoMaterial => "crypto_material",
        }
    }

    /// Whether it is a picture to look at, which may lose a little; data may not.
    pub fn is_light(self) -> bool {
        matches!(self, Self::Beauty | Self::Light(_))
    }

    /// Whether it tells surfaces apart by name or number.
    pub(super) fn needs_shapes(self) -> bool {
        matches!(
            self,
            Self::ObjectId | Self::MaterialId | Self::NodeId | Self::CryptoObject | Self::CryptoMaterial
        )
    }

    /// Most bytes of its channels for one pixel.
    pub(super) fn bytes_a_pixel(self) -> u64 {
        match self {
            Self::Depth | Self::ObjectId | Self::MaterialId | Self::NodeId => 4,
            Self::Uv => 8,
            Self::Position | Self::Normal | Self::GeometricNormal | Self::Albedo | Self::Light(_) => 12,
            Self::Beauty | Self::Motion => 16,
            Self::CryptoObject | Self::CryptoMaterial => 48,
        }
    }
}

/// The layers of a file: the picture, and any others, each once and in the order of [`Layer::ALL`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LayerSet(Vec<Layer>);

impl Default for LayerSet {
    fn default() -> Self {
        Self::new(&[])
    }
}

impl LayerSet {
    /// The picture and `layers`.
    pub fn new(layers: &[Layer]) -> Self {
        let is_in = |layer: &Layer| *layer == Layer::Beauty || layers.contains(layer);
        Self(Layer::ALL.into_iter().filter(is_in).collect())
    }

    /// The layers, the picture first.
    pub fn layers(&self) -> &[Layer] {
        &self.0
    }

    /// What the film has to record for them.
    pub fn request(&self) -> LayerRequest {
        let mut request = LayerRequest::NONE;
        for layer in &self.0 {
            match layer {
                Layer::Beauty => {}
                Layer::Light(_) => request.light = true,
                Layer::CryptoObject | Layer::CryptoMaterial => request.coverage = true,
                _ => request.centres = true,
            }
        }
        request
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_sorted_and_hold_the_picture() {
        let set = LayerSet::new(&[Layer::NodeId, Layer::Depth, Layer::NodeId]);
        assert_eq!(set.layers(), [Layer::Beauty, Layer::Depth, Layer::NodeId]);
        assert_eq!(LayerSet::default().layers(), [Layer::Beauty]);
    }

    #[test]
    fn only_what_is_needed_is_recorded() {
        let request = |layer| LayerSet::new(&[layer]).request();
        assert_eq!(LayerSet::default().request(), LayerRequest::NONE);
        assert_eq!(
            request(Layer::Light(LightPart::Direct)),
            LayerRequest { light: true, ..LayerRequest::NONE }
        );
        assert_eq!(request(Layer::Uv), LayerRequest { centres: true, ..LayerRequest::NONE });
        assert_eq!(request(Layer::CryptoMaterial), LayerRequest { coverage: true, ..LayerRequest::NONE });
    }

    #[test]
    fn all_parts_of_light_are_layers() {
        for part in LightPart::ALL {
            assert!(Layer::ALL.contains(&Layer::Light(part)));
        }
        let names: std::collections::BTreeSet<_> = Layer::ALL.map(Layer::name).into();
        assert_eq!(names.len(), Layer::ALL.len());
    }
}
