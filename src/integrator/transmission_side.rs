//! The transmission side of a surface: the volumes there, and the surfaces that touch it.

use super::glass_passage::GlassPassage;
use super::ray_state::Touching;
use super::shadow::stops_light;
use super::{ColorChannels, IntegratorContext, MediaStack, Medium, RayState};
use crate::geometry::Facing;
use crate::interaction::MaterialSample;

/// The transmission side of a surface.
pub(super) struct TransmissionSide {
    /// The volumes there.
    pub(super) media: MediaStack,
    /// A surface that bounds no volume and touches this one.
    pub(super) touching: Option<Box<Touching>>,
}

impl TransmissionSide {
    /// Whether the touching surface stops the light of lamps that rays cannot hit.
    pub(super) fn stops_lamps(&self, context: &IntegratorContext<'_>) -> bool {
        let touching = self.touching.as_deref();
        touching.is_some_and(|touching| stops_light(context, &touching.hit, GlassPassage::Straight))
    }

    /// Whether light of different colours is bent differently between the viewer's side of a surface, whose own medium is `own_medium`, and this
    /// one.
    pub(super) fn disperses(
        &self,
        state: &RayState,
        own_medium: Option<Medium>,
        material: &MaterialSample,
    ) -> bool {
        state.channels == ColorChannels::White
            && !material.thin
            && (own_medium.is_some_and(|medium| medium.half_spread > 0.0)
                || state.media.disperses()
                || self.media.disperses())
    }
}

/// Index of refraction on the viewer's side. The back face of a volume is seen from within, even where the surface is not
/// closed and the ray never entered it.
pub(super) fn ior_outside(
    state: &RayState,
    own_medium: Option<Medium>,
    facing: Facing,
    channels: ColorChannels,
) -> f32 {
    match own_medium {
        Some(medium) if facing == Facing::Back && !state.media.holds(medium.volume) => {
            medium.ior_of(channels)
        }
        _ => state.media.ior(channels),
    }
}

/// Index of refraction on the transmission side: that of the medium there, or the material's own for thin walls and opaque
/// surfaces.
pub(super) fn ior_transmission_side(
    material: &MaterialSample,
    media: &MediaStack,
    channels: ColorChannels,
) -> f32 {
    if material.thin { material.ior } else { media.ior(channels) }
}
