//! Albedos of GGX lobes under the exact Fresnel curve of one relative index of refraction.
//!
//! Source: the integrals of [`super::microfacets`], tabulated over roughness, view and index. The tables hold the difference from a
//! mirror's reflectance, whose share fades out with the roughness: for smooth lobes that difference is small although the curve is
//! steep. [`external_albedo`] is the table for views from the thinner side, [`internal_albedo`] for those from the denser side.
//!
//! Indices closer to 1 than those of the tables reuse the first one: there the curve and the lobe keep their shape when cosine, α and
//! √(n² − 1) shrink together. Beyond the last index, the transmitted share shrinks with the index.

use super::albedo_grid::Cell;
use super::fresnel;
use super::index_planes::{FIRST_IOR, IndexPosition, LAST_IOR};
use super::isotropic_albedo::{AlbedoTerms, SMOOTH, mirror_share, schlick_terms, schlick_terms_in, total_in};
use super::{external_albedo, internal_albedo};

/// The side from which a boundary is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    /// The same medium is on both sides.
    None,
    Thinner,
    Denser,
}

/// The tables of albedos at one relative index of refraction: prepared once, looked up at every hit.
///
/// Albedos from a slice are within 1e-3 of the integrals for views from the thinner side and indices of 1.01 to 25, and within 2e-3 from
/// the denser side and 1.01 to 6. From there to 25 the edge of total reflection, a cone of a few degrees, is coarser. Indices above 28 are
/// extrapolated: errors at views close to the surface reach some hundredths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlbedoSlice {
    side: Side,
    relative_ior: f32,
    /// The index whose tables are used; that of the boundary unless it is too close to 1.
    tabulated_ior: f32,
    position: IndexPosition,
    /// Scale of cosine and α to the first index of the tables; at least 1.
    zoom: f32,
    /// Scale of the transmitted share beyond the last index; at most 1.
    beyond: f32,
}

impl AlbedoSlice {
    /// The slice of the boundary between two media, one of which may have glTF's index of 0.
    pub fn between(ior_outside: f32, ior_inside: f32) -> Self {
        Self::new(if ior_outside > 0.0 && ior_inside > 0.0 { ior_inside / ior_outside } else { 1.0 })
    }

    /// The slice of an index beyond the boundary over the one before it.
    pub fn new(relative_ior: f32) -> Self {
        let larger = if relative_ior < 1.0 { 1.0 / relative_ior } else { relative_ior };
        let side = match relative_ior {
            1.0 => Side::None,
            ior if ior < 1.0 => Side::Denser,
            _ => Side::Thinner,
        };
        // Sine or tangent of the critical angle, by side
        let width = |larger: f32| {
            let root = ((larger - 1.0) * (larger + 1.0)).sqrt();
            if side == Side::Denser { root / larger } else { root }
        };
        let transmitted = |larger: f32| larger / ((larger + 1.0) * (larger + 1.0));
        let is_close = larger < FIRST_IOR;
        let larger_in_table = if is_close { FIRST_IOR } else { larger };
        Self {
            side,
            relative_ior,
            tabulated_ior: if side == Side::Denser { 1.0 / larger_in_table } else { larger_in_table },
            position: IndexPosition::new(larger),
            zoom: if is_close && side != Side::None { width(FIRST_IOR) / width(larger) } else { 1.0 },
            beyond: if larger > LAST_IOR { transmitted(larger) / transmitted(LAST_IOR) } else { 1.0 },
        }
    }

    /// The albedos of an isotropic lobe. Roughness 0 gives exactly the factors of the view.
    pub(super) fn terms(&self, cos_o: f32, roughness: f32) -> AlbedoTerms {
        let cos_o = cos_o.clamp(0.0, 1.0);
        if self.side == Side::None {
            return schlick_terms(cos_o, roughness);
        }
        let reflectance = fresnel::exact(cos_o, self.relative_ior);
        if roughness < SMOOTH {
            return AlbedoTerms { exact: reflectance, ..schlick_terms(cos_o, roughness) };
        }
        let cell = Cell::of_view(cos_o, roughness);
        let terms = schlick_terms_in(&cell, cos_o, roughness);
        let exact = if self.zoom > 1.0 {
            let (cos_o, roughness) = (self.zoomed(cos_o), self.zoomed_roughness(roughness));
            let cell = Cell::of_view(cos_o, roughness);
            self.exact(cos_o, roughness, &cell, total_in(&cell), reflectance)
        } else {
            self.exact(cos_o, roughness, &cell, terms.total, reflectance)
        };
        // Interpolation must not create light.
        AlbedoTerms { exact: exact.clamp(0.0, terms.total), ..terms }
    }

    /// The albedo with the exact F, for a view and a lobe in the scale of the tables. `total` is the one with F = 1, and
    /// `reflectance` that of a mirror.
    fn exact(&self, cos_o: f32, roughness: f32, cell: &Cell, total: f32, reflectance: f32) -> f32 {
        let mirrored = mirror_share(roughness) * total;
        if self.side == Side::Denser {
            let rough = internal_albedo::transmitted(cos_o, roughness, self.tabulated_ior, &self.position);
            return total - (rough * self.beyond + mirrored * (1.0 - reflectance));
        }
        let rough = self.position.interpolate(external_albedo::STORED, cell);
        self.exact_beyond(rough, mirrored, total) + mirrored * reflectance
    }

    /// The position between the planes of the index, for views from the thinner side and an index that the tables reach.
    pub(super) fn thinner_side(&self) -> Option<&IndexPosition> {
        (self.side == Side::Thinner && self.zoom == 1.0).then_some(&self.position)
    }

    /// Index beyond the boundary over the one before it.
    pub(super) fn relative_ior(&self) -> f32 {
        self.relative_ior
    }

    /// F of a mirror.
    #[inline(always)]
    pub(super) fn reflectance(&self, cos_o: f32) -> f32 {
        fresnel::exact(cos_o, self.relative_ior)
    }

    /// The albedo with the exact F from the thinner side, without the mirror's part: `rough` in the tables, whose last index may be below
    /// that of the slice. `mirrored` is the part of `total` that a mirror reflects.
    #[inline(always)]
    pub(super) fn exact_beyond(&self, rough: f32, mirrored: f32, total: f32) -> f32 {
        let all = total - mirrored;
        all + (rough - all) * self.beyond
    }

    fn zoomed(&self, cosine: f32) -> f32 {
        let zoomed = cosine * self.zoom;
        if zoomed < 1.0 { zoomed } else { 1.0 }
    }

    fn zoomed_roughness(&self, roughness: f32) -> f32 {
        self.zoomed(roughness * roughness).sqrt()
    }
}
