//! Directional albedo of the isotropic GGX lobe, with and without a Fresnel factor.
//!
//! Source: the integrals of [`super::facets`], tabulated. As in the split sum of Karis, "Real Shading in Unreal Engine 4", 2013,
//! equation 8, the lobe without Fresnel and the one with Schlick's weight give the albedo of every Schlick curve. For the exact
//! curve the table holds a few indices of refraction. Between them the albedo is interpolated by a polynomial in
//! ln((n − 1) / (n + 1)), over which the bend at grazing angles keeps its shape. [`super::internal_albedo`] is the table for views
//! from the denser side. Indices beyond both ranges are integrated for each view.
//!
//! Single scattering only, as in glTF: rough lobes lose a little light.

use std::sync::OnceLock;

use super::albedo_grid::{
    AlbedoTable, MAX_INDEX, MIN_INDEX, MIN_ROUGHNESS, arsinh, index_nodes, roughness_of, row,
};
use super::cubic_table::grid_values;
use super::microfacets::Microfacets;
use super::{fresnel, internal_albedo};

/// Albedos of a lobe: with F = 1, with F = (1 − o·h)⁵, and with the exact F of an index.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct AlbedoTerms {
    pub(crate) total: f32,
    pub(crate) schlick: f32,
    pub(crate) exact: f32,
}

/// Rows of roughness and columns of the view's elevation.
const ROUGHNESS_STEPS: usize = 36;
const VIEW_STEPS: usize = 80;
/// Surfaces of a lower roughness are mirrors: their lobes look the same, and α would leave the range of floats.
const SMOOTH: f32 = 1e-6;

/// Number of indices of refraction in the table, at Chebyshev nodes.
const INDICES: usize = 10;

/// `total`, `schlick` and the exact curves.
const ENTRIES: usize = 2 + INDICES;
type Entry = [f32; ENTRIES];
/// The values of the table; [`super::albedo_tables`] says how they are made.
pub(super) const STORED: &[u8] = include_bytes!("isotropic_albedo.bin");

/// The albedos with F = 1 and with F = (1 − o·h)⁵; `exact` stays 0.
pub(super) fn schlick_terms(cos_o: f32, roughness: f32) -> AlbedoTerms {
    if roughness < SMOOTH {
        return AlbedoTerms { total: 1.0, schlick: fresnel::schlick_weight(cos_o), exact: 0.0 };
    }
    TableEntry::new(cos_o, roughness).schlick_terms()
}

/// The albedos with all Fresnel factors; `relative_ior` is positive. Roughness 0 gives exactly the factors of the view.
pub(super) fn terms(cos_o: f32, roughness: f32, relative_ior: f32) -> AlbedoTerms {
    if roughness < SMOOTH {
        let exact = fresnel::exact(cos_o, relative_ior);
        return AlbedoTerms { exact, ..schlick_terms(cos_o, roughness) };
    }
    let entry = TableEntry::new(cos_o, roughness);
    let mut terms = entry.schlick_terms();
    let index = index_of(relative_ior);
    terms.exact = if (MIN_INDEX..=MAX_INDEX).contains(&index) {
        let weights = index_weights(index);
        let exact = weights.iter().zip(&entry.values[2..]).map(|(weight, entry)| weight * entry).sum();
        entry.faded(exact, terms.total, |cosine| fresnel::exact(cosine, relative_ior))
    } else if internal_albedo::covers(relative_ior) {
        // Interpolation errors must not create light.
        let transmitted = internal_albedo::transmitted(entry.cos_o, roughness, terms.total, relative_ior);
        terms.total - transmitted.clamp(0.0, terms.total)
    } else {
        integrated(&Microfacets::isotropic(entry.cos_o, roughness * roughness), terms.total, relative_ior)
    };
    terms
}

/// The albedo with F = 1.
pub(super) fn total(cos_o: f32, roughness: f32) -> f32 {
    schlick_terms(cos_o, roughness).total
}

/// The albedo with the exact F, by integration; `total` is the one with F = 1. Below the critical angle, the transmitted share is
/// subtracted from `total`.
pub(super) fn integrated(facets: &Microfacets, total: f32, relative_ior: f32) -> f32 {
    if relative_ior == 1.0 {
        return 0.0;
    }
    if relative_ior > 1.0 {
        let [reflected] = facets.reflected(|cosine| [fresnel::exact(cosine, relative_ior)]);
        return reflected;
    }
    total - internal_albedo::integrated(facets, relative_ior)
}

/// The table's entry for one view of a lobe.
struct TableEntry {
    cos_o: f32,
    /// Cosine of the tabulated view.
    tabulated_cos_o: f32,
    values: Entry,
    /// Below 1 for smoother lobes than the table holds.
    fading: f32,
}

impl TableEntry {
    fn new(cos_o: f32, roughness: f32) -> Self {
        let cos_o = cos_o.clamp(0.0, 1.0);
        // The lobe of a smaller α looks the same at views that are closer to the surface by the same factor.
        let smoother = roughness / MIN_ROUGHNESS;
        let (tabulated, fading) =
            if smoother < 1.0 { (MIN_ROUGHNESS, smoother * smoother) } else { (roughness, 1.0) };
        let tabulated_cos_o = if cos_o < fading { cos_o / fading } else { 1.0 };
        let column = column(tabulated_cos_o, tabulated * tabulated);
        let mut values = table().values.at(row(tabulated), column);
        // Interpolation errors must not create light.
        if values[0] > 1.0 {
            values[0] = 1.0;
        }
        Self { cos_o, tabulated_cos_o, values, fading }
    }

    /// The albedo under a Fresnel curve whose tabulated value is `shaped`. For smoother lobes than the table holds, the difference from
    /// a mirror shrinks with α.
    fn faded(&self, shaped: f32, total: f32, curve: impl Fn(f32) -> f32) -> f32 {
        if self.fading == 1.0 {
            return shaped;
        }
        total * curve(self.cos_o) + (shaped - total * curve(self.tabulated_cos_o)) * self.fading
    }

    fn schlick_terms(&self) -> AlbedoTerms {
        let [total, schlick, ..] = self.values;
        AlbedoTerms { total, schlick: self.faded(schlick, total, fresnel::schlick_weight), exact: 0.0 }
    }
}

/// Column of a view, 0 to 1: proportional to the root of the cosine where it is small compared to α, to its logarithm above.
fn column(cos_o: f32, alpha: f32) -> f32 {
    arsinh(libm::sqrtf(cos_o / alpha)) / arsinh(1.0 / libm::sqrtf(alpha))
}

/// The inverse of [`column`].
fn cosine_of(column: f32, alpha: f32) -> f32 {
    let root = libm::sinhf(column * arsinh(1.0 / libm::sqrtf(alpha)));
    let cosine = root * root * alpha;
    if cosine < 1.0 { cosine } else { 1.0 }
}

/// ln((n − 1) / (n + 1)); NaN below 1.
fn index_of(relative_ior: f32) -> f32 {
    libm::logf((relative_ior - 1.0) / (relative_ior + 1.0))
}

/// Lagrange weights of the table's indices.
fn index_weights(index: f32) -> [f32; INDICES] {
    table().nodes.weights(index)
}

fn table() -> &'static AlbedoTable<ENTRIES, INDICES> {
    static TABLE: OnceLock<AlbedoTable<ENTRIES, INDICES>> = OnceLock::new();
    TABLE.get_or_init(|| AlbedoTable::stored(STORED, ROUGHNESS_STEPS))
}

/// The table's values, by integration.
pub(super) fn integrated_grid() -> Vec<Entry> {
    let iors = index_nodes::<INDICES>().positions.map(|index: f32| {
        let root = libm::expf(index);
        (1.0 + root) / (1.0 - root)
    });
    grid_values(ROUGHNESS_STEPS, VIEW_STEPS, |x, y| {
        let roughness = roughness_of(x);
        entry(cosine_of(y, roughness * roughness), roughness, &iors)
    })
}

fn entry(cos_o: f32, roughness: f32, iors: &[f32; INDICES]) -> Entry {
    let factors = |cosine: f32| {
        std::array::from_fn(|at| match at {
            0 => 1.0,
            1 => fresnel::schlick_weight(cosine),
            _ => fresnel::exact(cosine, iors[at - 2]),
        })
    };
    Microfacets::isotropic(cos_o, roughness * roughness).reflected(factors)
}
