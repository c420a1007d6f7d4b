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

use crate::geometry::smoothstep_f64;
use crate::interaction::IridescenceSample;

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
    factor: f32,
    ior: f32,
    thickness_nm: f32,
    /// Index of refraction on the film's outer side.
    ior_outside: f32,
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
    /// The film of a material; `None` where it has no thickness. The thinnest films cover less, since the reflectances of films do not become
    /// those of the bare surface: Schlick's curve reflects at both boundaries, however near they are, and the series of orders ends.
    pub(super) fn new(film: &IridescenceSample, ior_outside: f32) -> Option<Self> {
        let &IridescenceSample { factor, ior, thickness_nm } = film;
        let factor = factor * smoothstep_f64([0.0, FADE_NM], f64::from(thickness_nm)) as f32;
        (factor > 0.0).then_some(Self { factor, ior, thickness_nm, ior_outside })
    }

    /// The reflectances over a dielectric and over a metal, by their F0. `cosine` is that of the view on the film's outer side; `None`
    /// where light is totally reflected from within.
    pub(super) fn reflectances(&self, cosine: Option<f32>, base_f0: [Vec3; 2]) -> FilmReflectances {
        let path = cosine.and_then(|cosine| self.path(cosine));
        let [dielectric, metal] =
            base_f0.map(|f0| path.as_ref().map_or(Vec3::ONE, |path| path.reflectance(f0)));
        FilmReflectances { factor: self.factor, dielectric, metal }
    }

    /// The refracted path of a view through the film; `None` where it is totally reflected outside.
    fn path(&self, cosine: f32) -> Option<FilmPath> {
        let outside = f64::from(self.ior_outside);
        let thickness = f64::from(self.thickness_nm);
        let film = f64::from(self.ior);
        let cos1 = f64::from(cosine.clamp(0.0, 1.0));
        let cos2_squared = 1.0 - (outside / film) * (outside / film) * (1.0 - cos1 * cos1);
        if cos2_squared < 0.0 {
            return None;
        }
        let cos2 = cos2_squared.sqrt();
        Some(FilmPath {
            film,
            cos2,
            r12: schlick(f0_between(film, outside), cos1),
            phi21_is_pi: film >= outside,
            sensitivities: sensitivities(2.0 * film * thickness * cos2),
        })
    }
}

/// The refracted path of one view through a film, which no base below changes.
struct FilmPath {
    /// Index of refraction of the film.
    film: f64,
    /// Cosine of the path within the film.
    cos2: f64,
    /// Reflectance of the outer boundary.
    r12: f64,
    /// Whether φ21 of the source, the phase shift of the outer boundary, is π.
    phi21_is_pi: bool,
    /// The eye's response to the first and the second order of interference.
    sensitivities: [Sensitivity; 2],
}

impl FilmPath {
    /// Reflectance over a base whose own is `base_f0` along the normal.
    fn reflectance(&self, base_f0: Vec3) -> Vec3 {
        // Second boundary
        let base_ior = base_f0.as_dvec3().map(|f0| ior_of_f0(f0.clamp(0.0, 0.9999)));
        let r23 = base_ior.map(|base| schlick(f0_between(base, self.film), self.cos2));
        // Either boundary shifts the phase by half a wave or not at all.
        let sign = base_ior.map(|base| if self.phi21_is_pi == (base < self.film) { 1.0 } else { -1.0 });

        // Orders of interference
        let t121 = 1.0 - self.r12;
        let r123 = (r23 * self.r12).map(|product| product.clamp(1e-5, 0.9999));
        let root = r123.map(f64::sqrt);
        let leaving = r23 * (t121 * t121) / (DVec3::ONE - r123);
        let [first, second] = &self.sensitivities;
        let first_amplitude = (leaving - t121) * root;
        let second_amplitude = first_amplitude * root;
        // Twice the shift is a multiple of the wave.
        let sum = leaving
            + self.r12
            + first_amplitude * first.shifted(sign) * 2.0
            + second_amplitude * second.shifted(DVec3::ONE) * 2.0;
        // Colours outside of the gamut; the truncated series may exceed 1.
        sum.map(|value| if value > 0.0 { value.min(1.0) } else { 0.0 }).as_vec3()
    }
}

/// The eye's response to a phase that depends on the wavelength, in CIE XYZ, without shifts by half a wave.
struct Sensitivity(DVec3);

impl Sensitivity {
    /// The response to phases that are shifted by half a wave where `sign` is -1, in linear Rec. 709.
    fn shifted(&self, sign: DVec3) -> DVec3 {
        RGB_FROM_XYZ * (self.0 * sign)
    }
}

/// The responses to a path difference and to twice as much, as sums of Gaussians in the frequency domain.
fn sensitivities(path_difference_nm: f64) -> [Sensitivity; 2] {
    let phase = 2.0 * PI * path_difference_nm * 1e-9;
    let gaussians = |value: f64, position: f64, variance: f64| {
        let scale = value * (2.0 * PI * variance).sqrt();
        let cosine = libm::cos(position * phase);
        let gaussian = libm::exp(-phase * phase * variance);
        // cos 2x = 2 cos² x - 1, and a Gaussian at 2x is its fourth power at x.
        let square = gaussian * gaussian;
        [scale * cosine * gaussian, scale * (2.0 * cosine * cosine - 1.0) * (square * square)]
    };
    let [x0, x0_second] = gaussians(5.4856e-13, 1.6810e6, 4.3278e9);
    let [x1, x1_second] = gaussians(9.7470e-14, 2.2399e6, 4.5282e9);
    let [y, y_second] = gaussians(4.4201e-13, 1.7953e6, 9.3046e9);
    let [z, z_second] = gaussians(5.2481e-13, 2.2084e6, 6.6121e9);
    [[x0 + x1, y, z], [x0_second + x1_second, y_second, z_second]]
        .map(|xyz| Sensitivity(DVec3::from_array(xyz) / 1.0685e-7))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Bsdf;
    use crate::interaction::MaterialSample;

    /// The lobes below a film, seen from both sides of a surface of index 1.5.
    fn filmed(material: &MaterialSample, thickness_nm: f32) -> [Bsdf; 2] {
        let film = IridescenceSample { factor: 1.0, ior: 1.3, thickness_nm };
        let material = MaterialSample { iridescence: Some(film), ..*material };
        [[1.0, 1.5], [1.5, 1.0]].map(|[outside, inside]| Bsdf::new(&material, outside, inside))
    }

    #[test]
    fn a_film_without_thickness_is_none_and_the_thinnest_fade() {
        const STEPS: u16 = 32;
        let base_color = Vec3::new(0.7, 0.3, 0.2);
        for (metallic, transmission) in [(0.0, 0.0), (1.0, 0.0), (0.5, 0.8)] {
            let bare = MaterialSample {
                base_color,
                metallic,
                transmission,
                roughness: 0.4,
                thin: false,
                ..MaterialSample::default()
            };
            let sides = [[1.0, 1.5], [1.5, 1.0]].map(|[outside, inside]| Bsdf::new(&bare, outside, inside));
            let light = Vec3::new(-0.6, 0.0, 0.8);
            for (x, z) in [(0.0, 1.0), (0.6, 0.8), (0.8, 0.6), (0.995, 0.1)] {
                let view = Vec3::new(x, 0.0, z).normalize();
                let without = filmed(&bare, 0.0);
                let mut last = sides.map(|bsdf| bsdf.albedos(view).specular);
                assert_eq!(
                    without.map(|bsdf| bsdf.eval(view, light)),
                    sides.map(|bsdf| bsdf.eval(view, light))
                );
                assert_eq!(without.map(|bsdf| bsdf.albedos(view).specular), last);
                for step in 1..=STEPS {
                    let thickness_nm = FADE_NM as f32 * f32::from(step) / f32::from(STEPS);
                    let next = filmed(&bare, thickness_nm).map(|bsdf| bsdf.albedos(view).specular);
                    // Steps of a smoothstep between reflectances that differ by 0.8 at most
                    let most = if step == 1 { 0.0025 } else { 0.04 };
                    for (last, next) in last.into_iter().zip(next) {
                        assert!((next - last).abs().max_element() < most, "{step} at {z}: {last} {next}");
                    }
                    last = next;
                }
            }
        }
    }
}
