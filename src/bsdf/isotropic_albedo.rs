//! Directional albedo of the round GGX lobe: how much of uniform light it reflects, with and without a Fresnel factor.
//!
//! Source: the integrals of [`super::facets`], tabulated. As in the split sum of Karis, "Real Shading in Unreal Engine 4", 2013,
//! equation 8, the lobe without Fresnel and the one with Schlick's weight give the albedo of any of Schlick's curves. For the
//! exact curve, further entries belong to a few indices; between them the albedo is interpolated by a polynomial in
//! ln((n − 1) / (n + 1)), in which the bend at grazing angles keeps its shape. Indices outside of the range, total reflection
//! among them, are integrated when they are asked for.
//!
//! Single scattering only, as in glTF: rough lobes lose a little light.

use std::sync::OnceLock;

use super::cubic_table::CubicTable;
use super::facets::Facets;
use super::fresnel;

/// Albedos of a lobe: with F = 1, with F = (1 − o·h)⁵, and with the exact F of an index.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Terms {
    pub(super) total: f32,
    pub(super) schlick: f32,
    pub(super) exact: f32,
}

/// Rows of roughness and columns of the view's elevation.
const ROUGHNESS_STEPS: usize = 36;
const VIEW_STEPS: usize = 80;
/// Smoother surfaces than this are mirrors: their lobe could not be told apart, and α would leave the number range.
const SMOOTH: f32 = 1e-6;
/// Smoother lobes look like this one, scaled.
const LEAST_ROUGHNESS: f32 = 0.01;

/// Indices in the table, at Chebyshev's nodes.
const INDICES: usize = 10;
/// ln((n − 1) / (n + 1)) for n = 1.06 and n = 3.2.
const LEAST_INDEX: f32 = -3.53;
const MOST_INDEX: f32 = -0.647;

/// `total`, `schlick` and the exact curves.
const ENTRIES: usize = 2 + INDICES;
type Entry = [f32; ENTRIES];

/// The lobe with F = 1 and with F = (1 − o·h)⁵; the exact curve's entry stays 0.
pub(super) fn schlick_terms(cos_o: f32, roughness: f32) -> Terms {
    if roughness < SMOOTH {
        return Terms { total: 1.0, schlick: fresnel::schlick_weight(cos_o), exact: 0.0 };
    }
    Place::new(cos_o, roughness).schlick_terms()
}

/// The lobe with all factors; `relative_ior` is positive. Roughness 0 gives exactly those of the view.
pub(super) fn terms(cos_o: f32, roughness: f32, relative_ior: f32) -> Terms {
    if roughness < SMOOTH {
        let exact = fresnel::exact(cos_o, relative_ior);
        return Terms { exact, ..schlick_terms(cos_o, roughness) };
    }
    let place = Place::new(cos_o, roughness);
    let mut terms = place.schlick_terms();
    let index = index_of(relative_ior);
    terms.exact = if (LEAST_INDEX..=MOST_INDEX).contains(&index) {
        let weights = index_weights(index);
        let exact = weights.iter().zip(&place.entry[2..]).map(|(weight, entry)| weight * entry).sum();
        place.faded(exact, terms.total, |cosine| fresnel::exact(cosine, relative_ior))
    } else {
        untabulated(&Facets::isotropic(place.cos_o, roughness * roughness), terms.total, relative_ior)
    };
    terms
}

/// The lobe with F = 1 alone.
pub(super) fn total(cos_o: f32, roughness: f32) -> f32 {
    schlick_terms(cos_o, roughness).total
}

/// The lobe with the exact F, by integration; `total` is the one with F = 1. Beside total reflection it is what does not pass.
pub(super) fn untabulated(facets: &Facets, total: f32, relative_ior: f32) -> f32 {
    if relative_ior == 1.0 {
        return 0.0;
    }
    if relative_ior > 1.0 {
        let [reflected] = facets.reflected(|cosine| [fresnel::exact(cosine, relative_ior)]);
        return reflected;
    }
    let index = f64::from(relative_ior);
    let passing = |cosine: f32| [1.0 - fresnel::exact(cosine, relative_ior)];
    let [passed] = facets.reflected_within(1.0 - index * index, passing);
    total - passed
}

/// What the table holds for a view of a lobe.
struct Place {
    cos_o: f32,
    /// The view for which the entry is.
    tabulated_cos_o: f32,
    entry: Entry,
    /// Below 1 for smoother lobes than the table has.
    fading: f32,
}

impl Place {
    fn new(cos_o: f32, roughness: f32) -> Self {
        let cos_o = cos_o.clamp(0.0, 1.0);
        // The lobe of a smaller α looks the same at views that graze by as much less.
        let smoother = roughness / LEAST_ROUGHNESS;
        let (tabulated, fading) =
            if smoother < 1.0 { (LEAST_ROUGHNESS, smoother * smoother) } else { (roughness, 1.0) };
        let tabulated_cos_o = if cos_o < fading { cos_o / fading } else { 1.0 };
        let column = column(tabulated_cos_o, tabulated * tabulated);
        let mut entry = table().values.at(row(tabulated), column);
        // The table's error must not make light.
        if entry[0] > 1.0 {
            entry[0] = 1.0;
        }
        Self { cos_o, tabulated_cos_o, entry, fading }
    }

    /// The albedo under a curve of which the entry holds `shaped`; for smoother lobes than the table has what sets them apart
    /// from mirrors shrinks with α.
    fn faded(&self, shaped: f32, total: f32, curve: impl Fn(f32) -> f32) -> f32 {
        if self.fading == 1.0 {
            return shaped;
        }
        total * curve(self.cos_o) + (shaped - total * curve(self.tabulated_cos_o)) * self.fading
    }

    fn schlick_terms(&self) -> Terms {
        let [total, schlick, ..] = self.entry;
        Terms { total, schlick: self.faded(schlick, total, fresnel::schlick_weight), exact: 0.0 }
    }
}

/// Where a roughness stands among the rows, which lie denser towards smooth lobes.
fn row(roughness: f32) -> f32 {
    libm::sqrtf((roughness - LEAST_ROUGHNESS) / (1.0 - LEAST_ROUGHNESS))
}

fn roughness_of(row: f32) -> f32 {
    LEAST_ROUGHNESS + (1.0 - LEAST_ROUGHNESS) * row * row
}

/// Where a view stands among the columns: evenly by the root of its cosine where that is small beside α, by its logarithm above.
fn column(cos_o: f32, alpha: f32) -> f32 {
    arsinh(libm::sqrtf(cos_o / alpha)) / arsinh(1.0 / libm::sqrtf(alpha))
}

/// The inverse of [`column`].
fn cosine_of(column: f32, alpha: f32) -> f32 {
    let root = libm::sinhf(column * arsinh(1.0 / libm::sqrtf(alpha)));
    let cosine = root * root * alpha;
    if cosine < 1.0 { cosine } else { 1.0 }
}

/// For x from 0.
fn arsinh(x: f32) -> f32 {
    libm::log1pf(x + x * x / (1.0 + libm::sqrtf(1.0 + x * x)))
}

/// ln((n − 1) / (n + 1)); NaN below 1.
fn index_of(relative_ior: f32) -> f32 {
    libm::logf((relative_ior - 1.0) / (relative_ior + 1.0))
}

/// One of the table's indices, as [`index_of`] has them.
fn index_at(step: usize) -> f32 {
    let angle = std::f32::consts::PI * (step as f32 + 0.5) / INDICES as f32;
    let (middle, half) = (0.5 * (LEAST_INDEX + MOST_INDEX), 0.5 * (MOST_INDEX - LEAST_INDEX));
    middle - half * libm::cosf(angle)
}

/// Lagrange's polynomials through the table's indices.
fn index_weights(index: f32) -> [f32; INDICES] {
    let Table { indices, scales, .. } = table();
    let mut weights = *scales;
    // The products of all differences before and after each
    let (mut before, mut after) = (1.0, 1.0);
    for step in 0..INDICES {
        weights[step] *= before;
        before *= index - indices[step];
        let back = INDICES - 1 - step;
        weights[back] *= after;
        after *= index - indices[back];
    }
    weights
}

struct Table {
    /// As [`index_of`] has them.
    indices: [f32; INDICES],
    /// One over the product of an index's differences from the others.
    scales: [f32; INDICES],
    values: CubicTable<ENTRIES>,
}

fn table() -> &'static Table {
    static TABLE: OnceLock<Table> = OnceLock::new();
    // On one thread: waiting for a pool while holding the lock could wait for itself.
    TABLE.get_or_init(|| {
        let indices = std::array::from_fn(index_at);
        let iors = indices.map(|index: f32| {
            let root = libm::expf(index);
            (1.0 + root) / (1.0 - root)
        });
        let values = CubicTable::new(ROUGHNESS_STEPS, VIEW_STEPS, |x, y| {
            let roughness = roughness_of(x);
            entry(cosine_of(y, roughness * roughness), roughness, &iors)
        });
        Table { indices, scales: scales(&indices), values }
    })
}

fn scales(indices: &[f32; INDICES]) -> [f32; INDICES] {
    indices.map(|own| {
        let others = indices.iter().filter(|other| **other != own);
        1.0 / others.map(|other| own - other).product::<f32>()
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
    Facets::isotropic(cos_o, roughness * roughness).reflected(factors)
}
