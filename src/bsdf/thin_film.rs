//! Reflectance of a thin film by interference.
//!
//! Source: Belcour and Barla, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence", 2017, section 4,
//! with the simplifications of `KHR_materials_iridescence`: Schlick's curve at both boundaries, no polarisation, three orders of
//! interference. In f64, because the terms cancel.
//!
//! Departure: also in rough lobes, the factor is that of the angle between view and normal, so that the albedo is exactly the lobe's
//! times the factor.

use std::f64::consts::PI;

use glam::{DMat3, DVec3, Vec3};

/// Rec. 709 from CIE XYZ; columns.
const RGB_FROM_XYZ: DMat3 = DMat3::from_cols(
    DVec3::new(3.240_454_2, -0.969_266_0, 0.055_643_4),
    DVec3::new(-1.537_138_5, 1.876_010_8, -0.204_025_9),
    DVec3::new(-0.498_531_4, 0.041_556_0, 1.057_225_2),
);

/// Films thinner than this fade out, nanometres.
const FADE_NM: f64 = 0.03;

/// A thin film on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ThinFilm {
    /// Share of the surface that it covers.
    pub(super) factor: f32,
    pub(super) ior: f32,
    pub(super) thickness_nm: f32,
    /// Index of refraction on the film's outer side.
    pub(super) ior_outside: f32,
}

/// Reflectances of a thin film towards one view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FilmReflectances {
    /// Share of the surface that the film covers.
    pub(super) factor: f32,
    pub(super) dielectric: Vec3,
    pub(super) metal: Vec3,
}

impl FilmReflectances {
    /// Reflectance of a partially covered surface: `bare` where it is bare and `own` where it is covered.
    #[inline(always)]
    pub(super) fn over(&self, bare: Vec3, own: Vec3) -> Vec3 {
        bare + (own - bare) * self.factor
    }
}

impl ThinFilm {
    /// The reflectances over a dielectric and over a metal, by their F0. `cosine` is that of the view on the film's outer side; `None`
    /// where light is totally reflected from within.
    pub(super) fn reflectances(&self, cosine: Option<f32>, base_f0: [Vec3; 2]) -> FilmReflectances {
        let [dielectric, metal] =
            base_f0.map(|f0| cosine.map_or(Vec3::ONE, |cosine| self.reflectance(cosine, f0)));
        FilmReflectances { factor: self.factor, dielectric, metal }
    }

    fn reflectance(&self, cosine: f32, base_f0: Vec3) -> Vec3 {
        let outside = f64::from(self.ior_outside);
        let thickness = f64::from(self.thickness_nm);
        let presence = smoothstep(thickness / FADE_NM);
        let film = outside + (f64::from(self.ior) - outside) * presence;
        let cos1 = f64::from(cosine.clamp(0.0, 1.0));
        let cos2_squared = 1.0 - (outside / film) * (outside / film) * (1.0 - cos1 * cos1);
        if cos2_squared < 0.0 {
            return Vec3::ONE;
        }
        let cos2 = cos2_squared.sqrt();

        // First boundary
        let r12 = schlick(f0_between(film, outside), cos1);
        let t121 = 1.0 - r12;
        let phi21 = if film < outside { 0.0 } else { PI };

        // Second boundary
        let base_ior = base_f0.as_dvec3().map(|f0| ior_of_f0(f0.clamp(0.0, 0.9999)));
        let r23 = base_ior.map(|base| schlick(f0_between(base, film), cos2));
        let phi = base_ior.map(|base| phi21 + if base < film { PI } else { 0.0 });

        // Orders of interference
        let path_difference = 2.0 * film * thickness * cos2;
        let r123 = (r23 * r12).map(|product| product.clamp(1e-5, 0.9999));
        let root = r123.map(f64::sqrt);
        let leaving = r23 * (t121 * t121) / (DVec3::ONE - r123);
        let mut sum = leaving + r12;
        let mut amplitude = leaving - t121;
        for order in [1.0, 2.0] {
            amplitude *= root;
            sum += amplitude * sensitivity(order * path_difference, phi * order) * 2.0;
        }
        // Colours outside of the gamut; the truncated series may exceed 1.
        sum.map(|value| if value > 0.0 { value.min(1.0) } else { 0.0 }).as_vec3()
    }
}

/// The eye's response to a phase that depends on the wavelength, as a sum of Gaussians in the frequency domain.
fn sensitivity(path_difference_nm: f64, shift: DVec3) -> DVec3 {
    let phase = 2.0 * PI * path_difference_nm * 1e-9;
    let gaussian = |value: f64, position: f64, variance: f64, shift: f64| {
        value
            * (2.0 * PI * variance).sqrt()
            * libm::cos(position * phase + shift)
            * libm::exp(-phase * phase * variance)
    };
    let xyz = DVec3::new(
        gaussian(5.4856e-13, 1.6810e6, 4.3278e9, shift.x) + gaussian(9.7470e-14, 2.2399e6, 4.5282e9, shift.x),
        gaussian(4.4201e-13, 1.7953e6, 9.3046e9, shift.y),
        gaussian(5.2481e-13, 2.2084e6, 6.6121e9, shift.z),
    );
    RGB_FROM_XYZ * (xyz / 1.0685e-7)
}

fn schlick(f0: f64, cosine: f64) -> f64 {
    let rest = 1.0 - cosine;
    let square = rest * rest;
    f0 + (1.0 - f0) * (square * square * rest)
}

fn f0_between(beyond: f64, before: f64) -> f64 {
    let root = (beyond - before) / (beyond + before);
    root * root
}

/// The index of refraction of a medium whose reflectance along the normal is `f0`.
fn ior_of_f0(f0: f64) -> f64 {
    let root = f0.sqrt();
    (1.0 + root) / (1.0 - root)
}

fn smoothstep(x: f64) -> f64 {
    let s = x.clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}
