//! AOVs (arbitrary output variables) of EXR files, by name.

use crate::film::{AovFlags, LightPass};

/// An AOV: a few channels that belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Aov {
    /// Colour and coverage: `R`, `G`, `B`, `A`.
    Beauty,
    /// Distance along the camera's axis, metres: `Z`; [`super::DEPTH_WITHOUT_HIT`] where nothing is hit.
    Depth,
    /// World space, metres: `position.X`, `.Y`, `.Z`.
    Position,
    /// World-space shading normal: `normal.X`, `.Y`, `.Z`.
    Normal,
    /// World-space normal of the triangle: `geometric_normal.X`, `.Y`, `.Z`.
    GeometricNormal,
    /// Linear base colour: `albedo.R`, `.G`, `.B`.
    Albedo,
    /// A light pass: `direct.R`, `.G`, `.B` and so on.
    Light(LightPass),
    /// Texture coordinates with v growing upwards: `uv.U`, `.V`.
    Uv,
    /// Index of the mesh plus one: `object_id`.
    ObjectId,
    /// Index of the material plus one: `material_id`.
    MaterialId,
    /// Index of the node plus one: `node_id`.
    NodeId,
    /// Motion vectors to the next and to the previous frame, pixels: `forward.u`, `.v`, `backward.u`, `.v`; v grows upwards.
    Motion,
    /// Cryptomatte by names of nodes: `crypto_object00.R` and so on.
    CryptoObject,
    /// Cryptomatte by names of materials: `crypto_material00.R` and so on.
    CryptoMaterial,
    /// Variance of the pixel's mean, of the path integrator: `variance.R`, `.G`, `.B`.
    Variance,
    /// Number of samples of the pixel, of the path integrator: `sample_count`.
    SampleCount,
    /// Albedo that guides denoising, of the path integrator: `denoising_albedo.R`, `.G`, `.B`.
    DenoisingAlbedo,
    /// Normal that guides denoising, of the path integrator: `denoising_normal.X`, `.Y`, `.Z`.
    DenoisingNormal,
}

impl Aov {
    /// All AOVs, in the order of listings.
    pub const ALL: [Self; 23] = [
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
        Self::Variance,
        Self::SampleCount,
        Self::DenoisingAlbedo,
        Self::DenoisingNormal,
    ];

    /// Name on the command line and in names of split files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Beauty => "beauty",
            Self::Depth => "depth",
            Self::Position => "position",
            Self::Normal => "normal",
            Self::GeometricNormal => "geometric_normal",
            Self::Albedo => "albedo",
            Self::Light(pass) => pass.name(),
            Self::Uv => "uv",
            Self::ObjectId => "object_id",
            Self::MaterialId => "material_id",
            Self::NodeId => "node_id",
            Self::Motion => "motion",
            Self::CryptoObject => "crypto_object",
            Self::CryptoMaterial => "crypto_material",
            Self::Variance => "variance",
            Self::SampleCount => "sample_count",
            Self::DenoisingAlbedo => "denoising_albedo",
            Self::DenoisingNormal => "denoising_normal",
        }
    }

    /// Whether it holds light, which lossy compression may change; data must stay exact.
    pub fn is_light(self) -> bool {
        matches!(self, Self::Beauty | Self::Light(_))
    }

    /// Whether only the path integrator records it.
    pub fn is_of_paths(self) -> bool {
        self.is_noise() || self.is_guide()
    }

    /// Whether it guides denoising.
    pub fn is_guide(self) -> bool {
        matches!(self, Self::DenoisingAlbedo | Self::DenoisingNormal)
    }

    /// Whether it tells about the samples of a pixel.
    pub fn is_noise(self) -> bool {
        matches!(self, Self::Variance | Self::SampleCount)
    }

    /// Whether it identifies surfaces by name or number.
    pub(super) fn needs_instances(self) -> bool {
        matches!(
            self,
            Self::ObjectId | Self::MaterialId | Self::NodeId | Self::CryptoObject | Self::CryptoMaterial
        )
    }

    /// Most bytes a pixel over its channels.
    pub(super) fn bytes_a_pixel(self) -> u64 {
        match self {
            Self::Depth | Self::ObjectId | Self::MaterialId | Self::NodeId | Self::SampleCount => 4,
            Self::Uv => 8,
            Self::Position
            | Self::Normal
            | Self::GeometricNormal
            | Self::Albedo
            | Self::Light(_)
            | Self::Variance
            | Self::DenoisingAlbedo
            | Self::DenoisingNormal => 12,
            Self::Beauty | Self::Motion => 16,
            Self::CryptoObject | Self::CryptoMaterial => 48,
        }
    }
}

/// AOVs of a frame: [`Aov::Beauty`] and any others, each once and in the order of [`Aov::ALL`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AovSet(Vec<Aov>);

impl Default for AovSet {
    fn default() -> Self {
        Self::new(&[])
    }
}

impl AovSet {
    /// [`Aov::Beauty`] and `aovs`.
    pub fn new(aovs: &[Aov]) -> Self {
        let is_in = |aov: &Aov| *aov == Aov::Beauty || aovs.contains(aov);
        Self(Aov::ALL.into_iter().filter(is_in).collect())
    }

    /// The AOVs, [`Aov::Beauty`] first.
    pub fn as_slice(&self) -> &[Aov] {
        &self.0
    }

    /// AOVs that the film records for them.
    pub fn flags(&self) -> AovFlags {
        let mut flags = AovFlags::NONE;
        for aov in &self.0 {
            match aov {
                Aov::Beauty => {}
                Aov::Light(_) => flags.light = true,
                Aov::CryptoObject | Aov::CryptoMaterial => flags.coverage = true,
                Aov::Variance | Aov::SampleCount => flags.noise = true,
                Aov::DenoisingAlbedo | Aov::DenoisingNormal => flags.guides = true,
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
    fn sets_are_sorted_and_hold_the_beauty() {
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
        assert_eq!(request(Aov::SampleCount), AovFlags { noise: true, ..AovFlags::NONE });
        assert_eq!(request(Aov::CryptoMaterial), AovFlags { coverage: true, ..AovFlags::NONE });
    }

    #[test]
    fn all_light_passes_are_aovs() {
        for pass in LightPass::ALL {
            assert!(Aov::ALL.contains(&Aov::Light(pass)));
        }
        let names: std::collections::BTreeSet<_> = Aov::ALL.map(Aov::name).into();
        assert_eq!(names.len(), Aov::ALL.len());
    }
}
