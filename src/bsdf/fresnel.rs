//! Fresnel reflectance of smooth boundaries.
//!
//! Sources: Fresnel's equations for unpolarised light (Born and Wolf, "Principles of Optics", 7th edition, section 1.5);
//! Schlick, "An Inexpensive BRDF Model for Physically-based Rendering", 1994, equation 24.
//!
//! Departure from glTF 2.0, appendix B: dielectrics follow the exact curve, scaled so that it runs from the material's F0 to its F90.
//! Metals, materials without an index, and opaque tinted ones of an index beyond [`LARGEST_SCALED_IOR`] keep Schlick's curve.

use glam::Vec3;

/// 2 + √3: beyond this index the exact curve falls below its value along the normal before it rises. Scaled to another one it could be negative. Converters
/// write an index of 1000, for one that is left to the specular colour.
pub(crate) const LARGEST_SCALED_IOR: f32 = 3.732_051;

/// The reflectance of one dielectric boundary, seen from one side: `offset + scale ·` the curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Dielectric {
    /// Index of refraction beyond the boundary over the one before it; always positive.
    pub(super) relative_ior: f32,
    pub(super) offset: Vec3,
    pub(super) scale: Vec3,
    pub(super) curve: FresnelCurve,
}

/// A curve from about 0 along the normal to 1 at grazing angles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FresnelCurve {
    /// Fresnel's equations for the relative index.
    Exact,
    /// Schlick's curve, for glTF's index of 0, which leaves the reflectance to the specular colour, and for [`Dielectric::tinted`].
    Schlick,
}

/// Scale of a boundary's reflectance (`KHR_materials_specular`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tint {
    /// At every angle.
    pub(super) factor: f32,
    /// Along the normal.
    pub(super) color: Vec3,
}

impl Tint {
    /// No scale.
    pub(super) const NONE: Self = Self { factor: 1.0, color: Vec3::ONE };

    /// A reflectance along the normal with the tint, at most the factor.
    #[inline(always)]
    fn scaled(self, along_normal: f32) -> Vec3 {
        let at_most_1 = |f0: f32| if f0 < 1.0 { f0 } else { 1.0 };
        self.color.map(|color| at_most_1(along_normal * color)) * self.factor
    }
}

impl Dielectric {
    /// The boundary between two media: F0 = min(((n − 1) / (n + 1))² · colour, 1) · factor, F90 = factor. An index of 0 means
    /// ((n − 1) / (n + 1))² = 1.
    ///
    /// From the denser side F90 is 1 whatever the factor: the curve ends where total reflection starts, which no factor weakens.
    #[inline(always)]
    pub(super) fn between(ior_outside: f32, ior_inside: f32, tint: Tint) -> Self {
        let f0 = |along_normal: f32| tint.scaled(along_normal);
        if ior_outside > 0.0 && ior_inside > 0.0 {
            let relative_ior = ior_inside / ior_outside;
            let f90 = if relative_ior < 1.0 { 1.0 } else { tint.factor };
            return Self::with_ends(relative_ior, f0(reflectance_along_normal(relative_ior)), f90);
        }
        Self::by_schlick(1.0, f0(1.0), tint.factor)
    }

    /// [`Dielectric::between`] for a material with `KHR_materials_specular`. Beyond [`LARGEST_SCALED_IOR`] its curve is Schlick's. Where the surface transmits light,
    /// and from the denser side, it is the exact one without a tint: Schlick's has no total reflection, and what is transmitted is known for the exact curve alone.
    pub(super) fn tinted(ior_outside: f32, ior_inside: f32, tint: Tint, transmits: bool) -> Self {
        let relative_ior = ior_inside / ior_outside;
        let is_scaled = (1.0 / LARGEST_SCALED_IOR..=LARGEST_SCALED_IOR).contains(&relative_ior);
        if is_scaled || ior_outside <= 0.0 || ior_inside <= 0.0 {
            Self::between(ior_outside, ior_inside, tint)
        } else if transmits || relative_ior < 1.0 {
            Self::between(ior_outside, ior_inside, Tint::NONE)
        } else {
            Self::by_schlick(relative_ior, tint.scaled(reflectance_along_normal(relative_ior)), tint.factor)
        }
    }

    /// Schlick's curve from `f0` to `f90`.
    #[inline(always)]
    fn by_schlick(relative_ior: f32, f0: Vec3, f90: f32) -> Self {
        Self { relative_ior, offset: f0, scale: f90 - f0, curve: FresnelCurve::Schlick }
    }

    /// The exact curve of `relative_ior`, scaled so that it runs from `f0` along the normal to `f90` at grazing angles.
    #[inline(always)]
    fn with_ends(relative_ior: f32, f0: Vec3, f90: f32) -> Self {
        let exact_f0 = reflectance_along_normal(relative_ior);
        let curve = FresnelCurve::Exact;
        if exact_f0 >= 1.0 {
            return Self { relative_ior, offset: f0, scale: Vec3::ZERO, curve };
        }
        let scale = (f90 - f0) / (1.0 - exact_f0);
        Self { relative_ior, offset: f0 - scale * exact_f0, scale, curve }
    }

    /// Whether F is the exact curve but for a fraction that no image shows.
    pub(super) fn is_nearly_exact(&self) -> bool {
        let most = (self.scale - Vec3::ONE).abs().max(self.offset.abs()).max_element();
        self.curve == FresnelCurve::Exact && most < 0.1
    }

    /// F at an angle to the normal, or to the half vector of a rough lobe.
    #[inline(always)]
    pub(super) fn reflectance(&self, cosine: f32) -> Vec3 {
        self.reflectance_by(self.curve_at(cosine))
    }

    /// F by the value of the unscaled curve.
    #[inline(always)]
    pub(super) fn reflectance_by(&self, curve: f32) -> Vec3 {
        self.offset + self.scale * curve
    }

    /// F along the normal.
    #[inline(always)]
    pub(super) fn along_normal(&self) -> Vec3 {
        self.reflectance(1.0)
    }

    /// The curve before scaling.
    #[inline(always)]
    pub(super) fn curve_at(&self, cosine: f32) -> f32 {
        match self.curve {
            FresnelCurve::Exact => exact(cosine, self.relative_ior),
            FresnelCurve::Schlick => schlick_weight(cosine),
        }
    }

    /// The albedo of a lobe whose albedo is `total` with F = 1 and `shaped` with F = the unscaled curve.
    #[inline(always)]
    pub(super) fn albedo(&self, total: f32, shaped: f32) -> Vec3 {
        (self.offset * total + self.scale * shaped).map(|albedo| albedo.clamp(0.0, 1.0))
    }
}

/// ((n − 1) / (n + 1))².
#[inline(always)]
fn reflectance_along_normal(relative_ior: f32) -> f32 {
    let root = (relative_ior - 1.0) / (relative_ior + 1.0);
    root * root
}

/// Fresnel reflectance of unpolarised light; 1 beyond the critical angle. `cosine` is on the near side.
#[inline(always)]
pub(crate) fn exact(cosine: f32, relative_ior: f32) -> f32 {
    if relative_ior == 1.0 {
        return 0.0;
    }
    let cosine = cosine.clamp(0.0, 1.0);
    let g_squared = relative_ior * relative_ior - 1.0 + cosine * cosine;
    // Beyond the critical angle, or the square of the index is out of range
    if g_squared <= 0.0 || g_squared == f32::INFINITY {
        return 1.0;
    }
    // n cos θ_t
    let g = g_squared.sqrt();
    let across = (cosine - g) / (cosine + g);
    let n_squared = relative_ior * relative_ior;
    let along = (n_squared * cosine - g) / (n_squared * cosine + g);
    0.5 * (across * across + along * along)
}

/// F0 + (1 − F0)(1 − cos θ)⁵ for each channel.
#[inline(always)]
pub(super) fn schlick(cosine: f32, f0: Vec3) -> Vec3 {
    f0 + (Vec3::ONE - f0) * schlick_weight(cosine)
}

/// (1 − cos θ)⁵.
#[inline(always)]
pub(super) fn schlick_weight(cosine: f32) -> f32 {
    let rest = 1.0 - cosine.clamp(0.0, 1.0);
    let square = rest * rest;
    square * square * rest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn between(ior_outside: f32, ior_inside: f32) -> Dielectric {
        Dielectric::between(ior_outside, ior_inside, Tint::NONE)
    }

    #[test]
    fn glass_has_the_known_reflectances() {
        let glass = between(1.0, 1.5);
        // ((1.5 − 1) / (1.5 + 1))² = 0.04, the same from both sides.
        assert!((glass.reflectance(1.0).x - 0.04).abs() < 1e-6);
        assert!((between(1.5, 1.0).reflectance(1.0).x - 0.04).abs() < 1e-6);
        assert!((glass.reflectance(0.0).x - 1.0).abs() < 1e-6);
        // Brewster: tan θ = 1.5, cos θ = 1/√3.25. There the part along the plane of incidence vanishes and the other is
        // ((1 − n²) / (1 + n²))² = (1.25 / 3.25)² = 0.14793; half of it is unpolarised.
        let brewster = 1.0 / 3.25_f32.sqrt();
        assert!((glass.reflectance(brewster).x - 0.073_964_5).abs() < 1e-6);
    }

    #[test]
    fn total_internal_reflection_starts_at_the_critical_angle() {
        let inside = between(1.5, 1.0);
        // sin θ_c = 1 / 1.5, cos θ_c = √(1 − 4/9) = 0.745356.
        let critical = (1.0_f32 - 4.0 / 9.0).sqrt();
        assert_eq!(inside.reflectance(critical - 1e-4), Vec3::ONE);
        assert_eq!(inside.reflectance(0.0), Vec3::ONE);
        let just_before = inside.reflectance(critical + 1e-4).x;
        assert!(just_before < 0.95 && just_before > 0.8, "{just_before}");
    }

    #[test]
    fn both_sides_agree_along_one_refracted_path() {
        // Stokes: the reflectance is the same for a ray and its reversed refracted ray.
        for step in 1..=50 {
            let cosine = step as f32 / 50.0;
            let sine_beyond = (1.0 - cosine * cosine).sqrt() / 1.33;
            let cosine_beyond = (1.0 - sine_beyond * sine_beyond).sqrt();
            let difference = exact(cosine, 1.33) - exact(cosine_beyond, 1.0 / 1.33);
            assert!(difference.abs() < 1e-4, "{cosine}: {difference}");
        }
    }

    #[test]
    fn equal_media_reflect_nothing_and_index_zero_everything() {
        for cosine in [0.0, 0.3, 1.0] {
            // The same medium on both sides is no boundary.
            assert_eq!(between(1.33, 1.33).reflectance(cosine), Vec3::ZERO);
            // glTF: ior 0 reflects everything.
            assert_eq!(between(1.0, 0.0).reflectance(cosine), Vec3::ONE);
        }
    }

    #[test]
    fn the_curve_runs_from_f0_to_f90() {
        let curve = Dielectric::with_ends(1.5, Vec3::new(0.02, 0.1, 0.5), 0.5);
        assert!((curve.along_normal() - Vec3::new(0.02, 0.1, 0.5)).abs().max_element() < 1e-6);
        assert!((curve.reflectance(0.0) - 0.5).abs().max_element() < 1e-6);
        // Schlick at 60°: (1 − 0.5)⁵ = 1/32.
        let metal = schlick(0.5, Vec3::new(0.0, 0.5, 1.0));
        assert!((metal - Vec3::new(0.031_25, 0.515_625, 1.0)).abs().max_element() < 1e-6);
    }

    #[test]
    fn an_index_of_1000_with_a_colour_is_one_of_0() {
        let tint = Tint { factor: 1.0, color: Vec3::new(0.04, 0.2, 0.9) };
        let [large, none] = [1000.0, 0.0].map(|ior| Dielectric::tinted(1.0, ior, tint, false));
        for step in 0..=90 {
            let cosine = libm::cosf((step as f32).to_radians());
            let difference = large.reflectance(cosine) - none.reflectance(cosine);
            assert!(difference.abs().max_element() < 0.005, "{step} degrees: {difference}");
        }
    }

    #[test]
    fn no_tint_makes_a_reflectance_negative() {
        for ior in [1.01, 1.5, 2.4, 3.7, 3.74, 5.0, 10.0, 1000.0] {
            for color in [0.0, 0.05, 0.5, 1.0, 30.0] {
                for factor in [0.0, 0.3, 1.0] {
                    let tint = Tint { factor, color: Vec3::splat(color) };
                    for boundary in [
                        Dielectric::tinted(1.0, ior, tint, false),
                        Dielectric::tinted(1.0, ior, tint, true),
                        Dielectric::tinted(ior, 1.0, tint, true),
                    ] {
                        for step in 0..=100 {
                            let value = boundary.reflectance(step as f32 / 100.0).x;
                            assert!((-1e-6..=1.000_001).contains(&value), "{ior} {tint:?} {step}: {value}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn the_curve_depends_on_the_material_and_not_on_the_values_of_its_tint() {
        let almost_none = Tint { factor: 0.999, ..Tint::NONE };
        for (outside, inside, transmits) in [(1.0, 5.0, false), (1.0, 5.0, true), (5.0, 1.0, true)] {
            for step in 0..=20 {
                let cosine = step as f32 / 20.0;
                let [none, tinted] = [Tint::NONE, almost_none]
                    .map(|tint| Dielectric::tinted(outside, inside, tint, transmits).reflectance(cosine).x);
                assert!((none - tinted).abs() < 0.002, "{outside} {inside} {cosine}: {none} {tinted}");
            }
        }
    }

    #[test]
    fn tints_scale_the_reflectance_of_the_index() {
        let tint = Tint { factor: 0.5, color: Vec3::new(0.5, 1.0, 40.0) };
        // F0 = min(0.04 · colour, 1) · 0.5, F90 = 0.5.
        let outside = Dielectric::between(1.0, 1.5, tint);
        assert!((outside.along_normal() - Vec3::new(0.01, 0.02, 0.5)).abs().max_element() < 1e-6);
        assert!((outside.reflectance(0.0) - 0.5).abs().max_element() < 1e-6);
        // From inside, total reflection stays total.
        let inside = Dielectric::between(1.5, 1.0, tint);
        assert!((inside.along_normal() - Vec3::new(0.01, 0.02, 0.5)).abs().max_element() < 1e-6);
        assert!((inside.reflectance(0.3) - 1.0).abs().max_element() < 1e-6);
        // An index of 0 takes the colour as it is, up to 1, and Schlick's curve: (1 − 0.5)⁵ = 1/32.
        let free = Dielectric::between(1.0, 0.0, Tint { factor: 1.0, color: Vec3::new(0.0, 0.5, 2.0) });
        assert!((free.reflectance(0.5) - Vec3::new(0.031_25, 0.515_625, 1.0)).abs().max_element() < 1e-6);
    }
}
