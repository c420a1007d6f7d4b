//! Fibres that stand on a surface, such as those of velvet.
//!
//! Source: Conty Estevez and Kulla, "Production Friendly Microfacet Sheen BRDF", 2017: the distribution "Charlie" (equation 2), its
//! shadowing (equation 3 and table 1), and the scaling of what lies below by the lobe's albedo; `KHR_materials_sheen`. F is 1.

use std::f32::consts::PI;
use std::sync::OnceLock;

use glam::Vec3;

use super::cubic_table::CubicTable;

/// Fibres that stray less than this would all stand upright and show nothing.
const LEAST_ROUGHNESS: f32 = 0.05;

/// The lobe of the fibres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sheen {
    color: Vec3,
    roughness: f32,
}

impl Sheen {
    pub(super) fn new(color: Vec3, roughness: f32) -> Self {
        Self { color, roughness: roughness.clamp(LEAST_ROUGHNESS, 1.0) }
    }

    /// f(wo, wi), both above the surface.
    pub(super) fn evaluate(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        self.color * lobe(wo, wi, self.roughness * self.roughness)
    }

    /// Share of uniform light that the fibres send towards a view.
    pub(super) fn albedo(&self, cos_o: f32) -> Vec3 {
        self.color * albedo(cos_o, self.roughness)
    }

    /// What is left for the layers below, for light along one direction.
    pub(super) fn below(&self, cosine: f32) -> f32 {
        1.0 - self.color.max_element() * albedo(cosine.abs(), self.roughness)
    }
}

/// D V of the fibres.
fn lobe(wo: Vec3, wi: Vec3, alpha: f32) -> f32 {
    let shadowing = 1.0 + masking(wo.z, alpha) + masking(wi.z, alpha);
    distribution(wo, wi, alpha) / (shadowing * (4.0 * wo.z * wi.z))
}

/// (2 + 1/α) sin^(1/α) θ_h / 2π
fn distribution(wo: Vec3, wi: Vec3, alpha: f32) -> f32 {
    let half = (wo + wi).normalize_or(Vec3::Z);
    let sine_squared = half.x * half.x + half.y * half.y;
    let exponent = 1.0 / alpha;
    (2.0 + exponent) * libm::powf(sine_squared, 0.5 * exponent) / (2.0 * PI)
}

/// Λ of the shadowing, which is not the distribution's own but a fit.
fn masking(cosine: f32, alpha: f32) -> f32 {
    let fit = Fit::new(alpha);
    if cosine < 0.5 {
        libm::expf(fit.at(cosine))
    } else {
        libm::expf(2.0 * fit.at(0.5) - fit.at(1.0 - cosine))
    }
}

/// a / (1 + b xᶜ) + d x + e
struct Fit([f32; 5]);

impl Fit {
    fn new(alpha: f32) -> Self {
        const ROUGH: [f32; 5] = [21.5473, 3.829_87, 0.198_23, -1.977_60, -4.320_54];
        const SMOOTH: [f32; 5] = [25.3245, 3.324_35, 0.168_01, -1.273_93, -4.859_67];
        let share = (1.0 - alpha) * (1.0 - alpha);
        let mut terms = ROUGH;
        for (term, smooth) in terms.iter_mut().zip(SMOOTH) {
            *term = *term * (1.0 - share) + smooth * share;
        }
        Self(terms)
    }

    fn at(&self, x: f32) -> f32 {
        let [a, b, c, d, e] = self.0;
        a / (1.0 + b * libm::powf(x, c)) + d * x + e
    }
}

/// Steps of roughness and of the cosine's square root.
const ROUGHNESS_STEPS: usize = 32;
const VIEW_STEPS: usize = 48;
/// Quadrature points along each axis of half a hemisphere.
const HEMISPHERE_STEPS: usize = 72;

/// The lobe's directional albedo; at most 1, which the fit exceeds where both directions graze.
fn albedo(cosine: f32, roughness: f32) -> f32 {
    static TABLE: OnceLock<CubicTable> = OnceLock::new();
    let table = TABLE.get_or_init(|| {
        CubicTable::new(ROUGHNESS_STEPS, VIEW_STEPS, |x, y| {
            // Dense where fibres are upright.
            by_quadrature(y * y, LEAST_ROUGHNESS + (1.0 - LEAST_ROUGHNESS) * x * x, HEMISPHERE_STEPS)
        })
    });
    let place = libm::sqrtf((roughness - LEAST_ROUGHNESS) / (1.0 - LEAST_ROUGHNESS));
    table.at(place, libm::sqrtf(cosine.clamp(0.0, 1.0))).clamp(0.0, 1.0)
}

/// ∫ f cos θ_i dω_i for F = 1, by midpoints over half the hemisphere: it is symmetric about the plane of the view.
fn by_quadrature(cos_o: f32, roughness: f32, steps: usize) -> f32 {
    // Along the surface the limit is close to the value a little above it.
    let cos_o = if cos_o > 1e-4 { cos_o } else { 1e-4 };
    let alpha = roughness * roughness;
    let wo = Vec3::new(libm::sqrtf(1.0 - cos_o * cos_o), 0.0, cos_o);
    let masking_o = masking(cos_o, alpha);
    let mut sum = 0.0_f64;
    for ring in 0..steps {
        // Denser where light grazes, where the lobe is, and about the normal, where it has a cusp.
        let u = (ring as f32 + 0.5) / steps as f32;
        let cosine = u * u * (3.0 - 2.0 * u);
        let sine = libm::sqrtf(1.0 - cosine * cosine);
        let mut around = 0.0;
        for turn in 0..steps {
            let (sin_turn, cos_turn) = libm::sincosf((turn as f32 + 0.5) / steps as f32 * PI);
            around += distribution(wo, Vec3::new(sine * cos_turn, sine * sin_turn, cosine), alpha);
        }
        let shadowing = (1.0 + masking_o + masking(cosine, alpha)) * (4.0 * cos_o);
        sum += f64::from(around * 6.0 * u * (1.0 - u) / shadowing);
    }
    (sum * 2.0 * std::f64::consts::PI / (steps * steps) as f64) as f32
}
