//! Compensation of the light that facets reflect more than once.
//!
//! Source: Turquin, "Practical Multiple Scattering Compensation for Microfacet Models", 2019: a lobe of single scattering, times
//! 1 + F0 (1/E − 1) with its albedo E for F = 1. A white lobe then reflects everything. From the denser side of a boundary the lobe's
//! mean F takes the place of F0, so that total reflection loses nothing, either.
//!
//! The factor depends on the view alone: a compensated lobe is not reciprocal.

use glam::Vec3;

use super::isotropic_albedo::AlbedoTerms;
use super::{Bsdf, FilmReflectances};

/// Factors of a specular lobe; at least 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Compensation {
    pub(super) dielectric: Vec3,
    pub(super) metal: Vec3,
}

impl Bsdf {
    /// The factors for one view.
    #[inline(always)]
    pub(super) fn compensation(&self, film: Option<&FilmReflectances>, terms: AlbedoTerms) -> Compensation {
        let dielectric = if self.dielectric.relative_ior < 1.0 {
            self.dielectric.reflectance_by(terms.exact / terms.total)
        } else {
            self.dielectric.along_normal()
        };
        let mut mean = (dielectric, self.base_color);
        if let Some(film) = film {
            mean = (film.over(dielectric, film.dielectric), film.over(self.base_color, film.metal));
        }
        // A table's value may be 0 only for lobes that nothing sees.
        let lost = if terms.total > 0.0 { 1.0 / terms.total - 1.0 } else { 0.0 };
        let factor = |f0: Vec3| f0.map(|f0| 1.0 + lost * if f0 < 1.0 { f0 } else { 1.0 });
        Compensation { dielectric: factor(mean.0), metal: factor(mean.1) }
    }
}
