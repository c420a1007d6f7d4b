//! The AOVs that an EXR file can hold, by name.

use crate::film::{AovFlags, LightPass};

/// One AOV: a few channels that belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Aov {
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
    Light(LightPass),
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

impl Aov {
    /// All of them, in the order in which they are listed.
    pub const ALL: [Self; 19] = [
        Self::Beauty,
        Self::Depth,
        Self::Position,
        Self::Normal,
        Self::GeometricNormal,
        Self::Albedo,
        Self::Light(LightPass::Emission),
        Self::Light(LightPass::Direct),
        Self::Light(LightPass::Environment),
        Self::Light(LightPass::Reflection),
        Self::Light(LightPass::Refraction),
        Self::Light(LightPass::Transparency),
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
    pub(super) fn needs_instances(self) -> bool {
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

/// The AOVs of a file: the picture, and any others, each once and in the order of [`Aov::ALL`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AovSet(Vec<Aov>);

impl Default for AovSet {
    fn default() -> Self {
        Self::new(&[])
    }
}

impl AovSet {
    /// The picture and `aovs`.
    pub fn new(aovs: &[Aov]) -> Self {
        let is_in = |aov: &Aov| *aov == Aov::Beauty || aovs.contains(aov);
        Self(Aov::ALL.into_iter().filter(is_in).collect())
    }

    /// The AOVs, the picture first.
    pub fn as_slice(&self) -> &[Aov] {
        &self.0
    }

    /// What the film has to record for them.
    pub fn flags(&self) -> AovFlags {
        let mut flags = AovFlags::NONE;
        for aov in &self.0 {
            match aov {
                Aov::Beauty => {}
                Aov::Light(_) => flags.light = true,
                Aov::CryptoObject | Aov::CryptoMaterial => flags.coverage = true,
                _ => flags.centers = true,
            }
        }
        flags
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_sorted_and_hold_the_picture() {
        let set = AovSet::new(&[Aov::NodeId, Aov::Depth, Aov::NodeId]);
        assert_eq!(set.as_slice(), [Aov::Beauty, Aov::Depth, Aov::NodeId]);
        assert_eq!(AovSet::default().as_slice(), [Aov::Beauty]);
    }

    #[test]
    fn only_what_is_needed_is_recorded() {
        let request = |aov| AovSet::new(&[aov]).flags();
        assert_eq!(AovSet::default().flags(), AovFlags::NONE);
        assert_eq!(request(Aov::Light(LightPass::Direct)), AovFlags { light: true, ..AovFlags::NONE });
        assert_eq!(request(Aov::Uv), AovFlags { centers: true, ..AovFlags::NONE });
        assert_eq!(request(Aov::CryptoMaterial), AovFlags { coverage: true, ..AovFlags::NONE });
    }

    #[test]
    fn all_parts_of_light_are_layers() {
        for part in LightPass::ALL {
            assert!(Aov::ALL.contains(&Aov::Light(part)));
        }
        let names: std::collections::BTreeSet<_> = Aov::ALL.map(Aov::name).into();
        assert_eq!(names.len(), Aov::ALL.len());
    }
}
