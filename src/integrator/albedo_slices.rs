//! The tables of albedos of the boundaries that were shaded last.

use crate::bsdf::AlbedoSlice;

/// Slices of two boundaries: those of one material are mostly seen from both sides in turn.
#[derive(Debug, Default)]
pub(super) struct AlbedoSlices {
    /// Indices of refraction on both sides, and their slice.
    known: [Option<([f32; 2], AlbedoSlice)>; 2],
}

impl AlbedoSlices {
    /// [`AlbedoSlice::between`] two media.
    pub(super) fn between(&mut self, ior_outside: f32, ior_inside: f32) -> AlbedoSlice {
        let iors = [ior_outside, ior_inside];
        if let Some((_, slice)) = self.known.iter().flatten().find(|(known, _)| *known == iors) {
            return *slice;
        }
        let slice = AlbedoSlice::between(ior_outside, ior_inside);
        self.known = [Some((iors, slice)), self.known[0]];
        slice
    }
}
