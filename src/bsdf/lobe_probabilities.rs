//! How a sample chooses among the lobes of a surface.

/// Probabilities of the lobes; they sum to 1, or are all 0.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LobeProbabilities {
    pub(super) coat: f32,
    /// With transmission where facets refract: then the facet decides.
    pub(super) specular: f32,
    pub(super) transmission: f32,
    pub(super) diffuse: f32,
    pub(super) sheen: f32,
    pub(super) diffuse_transmission: f32,
}

impl LobeProbabilities {
    /// The same in proportion, with a sum of 1; all 0 if they are.
    #[inline(always)]
    pub(super) fn normalized(self) -> Self {
        let Self { coat, specular, transmission, diffuse, sheen, diffuse_transmission } = self;
        let total = coat + specular + transmission + diffuse + sheen + diffuse_transmission;
        let share = |of: f32| if total > 0.0 { of / total } else { 0.0 };
        Self {
            coat: share(coat),
            specular: share(specular),
            transmission: share(transmission),
            diffuse: share(diffuse),
            sheen: share(sheen),
            diffuse_transmission: share(diffuse_transmission),
        }
    }
}
