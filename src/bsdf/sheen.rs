//! The sheen lobe: fibres that stand on a surface, such as velvet.
//!
//! Source: Conty Estevez and Kulla, "Production Friendly Microfacet Sheen BRDF", 2017: the distribution "Charlie" (equation 2), its
//! shadowing (equation 3 and table 1), and the scaling of lower lobes by the sheen's albedo; `KHR_materials_sheen`. F is 1.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::albedo_grid::{COLUMNS, Cell, ROWS, grid_points};
use super::cubic_table::CubicTable;

/// Unlimited albedos; [`super::albedo_tables`] says how they are made.
pub(super) const STORED: &[u8] = include_bytes!("sheen_albedo.bin");
/// Lowest roughness; smoother sheen would be invisible.
const MIN_ROUGHNESS: f32 = 0.05;

/// Lowest cosine of a view; the lobe diverges along the surface.
const MIN_COSINE: f64 = 1e-4;

/// The sheen lobe of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sheen {
    color: Vec3,
    roughness: f32,
    fit: MaskingFit,
}

impl Sheen {
    pub(super) fn new(color: Vec3, roughness: f32) -> Self {
        let roughness = roughness.clamp(MIN_ROUGHNESS, 1.0);
        let alpha = f64::from(roughness) * f64::from(roughness);
        Self { color, roughness, fit: MaskingFit::new(alpha as f32) }
    }

    /// f(wo, wi), both above the surface.
    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        let roughness = f64::from(self.roughness);
        let alpha = roughness * roughness;
        let value = lobe(wo.as_dvec3(), wi.as_dvec3(), (alpha, &self.fit)) as f32;
        let unlimited = unlimited_albedo(wo.z, self.roughness);
        self.color * if unlimited > 1.0 { value / unlimited } else { value }
    }

    /// Share of uniform light that the sheen reflects towards a view.
    pub(super) fn albedo(&self, cos_o: f32) -> Vec3 {
        self.color * albedo(cos_o, self.roughness)
    }

    /// Share of light that the lobes below receive, for one direction.
    pub(super) fn below(&self, cosine: f32) -> f32 {
        1.0 - self.color.max_element() * albedo(cosine.abs(), self.roughness)
    }
}

/// D V of the sheen; in f64, because the exponent, up to 400, multiplies the rounding of the sine.
fn lobe(wo: DVec3, wi: DVec3, (alpha, fit): (f64, &MaskingFit)) -> f64 {
    let shadowing = 1.0 + fit.masking(wo.z) + fit.masking(wi.z);
    distribution(wo, wi, alpha) / (shadowing * (4.0 * wo.z.max(MIN_COSINE) * wi.z))
}

/// (2 + 1/α) sin^(1/α) θ_h / 2π
fn distribution(wo: DVec3, wi: DVec3, alpha: f64) -> f64 {
    let half = (wo + wi).normalize_or(DVec3::Z);
    let sine_squared = half.x * half.x + half.y * half.y;
    let exponent = 1.0 / alpha;
    (2.0 + exponent) * libm::pow(sine_squared, 0.5 * exponent) / (2.0 * PI)
}

/// Λ of the shadowing, which is a fit and not derived from the distribution; f32 is exact enough for it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct MaskingFit {
    /// a to e of the fit ln Λ = a / (1 + b xᶜ) + d x + e, for cosines x up to 1/2.
    terms: [f32; 5],
    /// The fit at 1/2, about which the other half is symmetric.
    at_half: f32,
}

impl MaskingFit {
    fn new(alpha: f32) -> Self {
        const ROUGH: [f32; 5] = [21.5473, 3.829_87, 0.198_23, -1.977_60, -4.320_54];
        const SMOOTH: [f32; 5] = [25.3245, 3.324_35, 0.168_01, -1.273_93, -4.859_67];
        let share = (1.0 - alpha) * (1.0 - alpha);
        let mut terms = ROUGH;
        for (term, smooth) in terms.iter_mut().zip(SMOOTH) {
            *term = *term * (1.0 - share) + smooth * share;
        }
        let fit = Self { terms, at_half: 0.0 };
        Self { at_half: fit.at(0.5), ..fit }
    }

    fn at(&self, x: f32) -> f32 {
        let [a, b, c, d, e] = self.terms;
        a / (1.0 + b * libm::powf(x, c)) + d * x + e
    }

    /// Λ of a direction.
    fn masking(&self, cosine: f64) -> f64 {
        // The cosine of a unit vector may be rounded to above 1.
        let cosine = (cosine as f32).min(1.0);
        f64::from(libm::expf(if cosine < 0.5 {
            self.at(cosine)
        } else {
            2.0 * self.at_half - self.at(1.0 - cosine)
        }))
    }
}

/// Steps of the roughness and of the cosine's square root whose albedos are integrated; those between come from cubics.
const ROUGHNESS_STEPS: usize = 32;
const VIEW_STEPS: usize = 48;
/// Number of quadrature points along each axis of half the hemisphere.
const HEMISPHERE_STEPS: usize = 72;

/// The lobe's directional albedo, at most 1.
fn albedo(cosine: f32, roughness: f32) -> f32 {
    unlimited_albedo(cosine, roughness).clamp(0.0, 1.0)
}

/// The albedo that the fit has, which may exceed 1 where both directions graze.
fn unlimited_albedo(cosine: f32, roughness: f32) -> f32 {
    let (points, _) = STORED.as_chunks::<4>();
    let row = (roughness - MIN_ROUGHNESS) / (1.0 - MIN_ROUGHNESS);
    let cell = Cell::at(row, cosine.clamp(0.0, 1.0).sqrt());
    let [albedo] = cell.interpolate(points, |bytes| [f32::from_le_bytes(*bytes)]);
    albedo
}

/// The bytes of every `step`th grid point, by integration: little-endian `f32`.
pub(super) fn integrated(step: usize) -> Vec<u8> {
    let cubic = CubicTable::new(ROUGHNESS_STEPS, VIEW_STEPS, |x, y| {
        // Denser towards smooth sheen
        [by_quadrature(y * y, MIN_ROUGHNESS + (1.0 - MIN_ROUGHNESS) * x * x, HEMISPHERE_STEPS)]
    });
    let even = |index: usize, steps: usize| index as f32 / (steps - 1) as f32;
    let points = grid_points(step, |row, column| cubic.at(even(row, ROWS), even(column, COLUMNS))[0]);
    points.into_iter().flat_map(f32::to_le_bytes).collect()
}

/// ∫ f cos θ_i dω_i for F = 1, by midpoints over half the hemisphere: it is symmetric about the plane of the view.
fn by_quadrature(cos_o: f32, roughness: f32, steps: usize) -> f32 {
    // Along the surface the limit is close to the value a little above it.
    let cos_o = f64::from(cos_o).max(MIN_COSINE);
    let alpha = f64::from(roughness) * f64::from(roughness);
    let wo = DVec3::new((1.0 - cos_o * cos_o).sqrt(), 0.0, cos_o);
    let fit = MaskingFit::new(alpha as f32);
    let masking_o = fit.masking(cos_o);
    let step = 1.0 / steps as f64;
    let azimuths: Vec<_> =
        (0..steps).map(|azimuth| libm::sincos((azimuth as f64 + 0.5) * step * PI)).collect();
    let mut sum = 0.0;
    for ring in 0..steps {
        // Denser at grazing angles, where the lobe is, and about the normal, where it has a cusp
        let u = (ring as f64 + 0.5) * step;
        let cosine = u * u * (3.0 - 2.0 * u);
        let sine = (1.0 - cosine * cosine).sqrt();
        let mut ring_sum = 0.0;
        for (sin, cos) in &azimuths {
            ring_sum += distribution(wo, DVec3::new(sine * cos, sine * sin, cosine), alpha);
        }
        let shadowing = (1.0 + masking_o + fit.masking(cosine)) * (4.0 * cos_o);
        sum += ring_sum * 6.0 * u * (1.0 - u) / shadowing;
    }
    (sum * 2.0 * PI * step * step) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cosines_that_are_rounded_to_above_one_count_as_one() {
        let sheen = Sheen::new(Vec3::ONE, 0.5);
        let [slanted, above] = [Vec3::new(0.6, 0.0, 0.8), Vec3::Z * 1.000_000_1];
        assert!((sheen.eval(above, slanted) - sheen.eval(Vec3::Z, slanted)).abs().max_element() < 1e-6);
        assert!((sheen.eval(slanted, above) - sheen.eval(slanted, Vec3::Z)).abs().max_element() < 1e-6);
    }
}
