//! Reference implementation of GGX albedos, in f64 and over slopes of facets, against those of the lobes.
//!
//! ∫ F D V cos θ_l dl over half vectors h with slopes (α_t r cos φ, α_b r sin φ): D spreads r² / (1 + r²) and φ evenly, and
//! dl = 4 (v·h) dh. Light is mirrored from above where r is below the root R(φ) of 2 (v·h) h_z = v_z, and along each φ total
//! reflection ends at the roots of v·h = cos θ_c: between these the integrand is smooth. Nothing here is shared with the lobes'
//! own quadrature.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::specification::{fresnel, v_ggx_anisotropic};
use super::{AlbedoSlice, Bsdf, Coat, MaterialSample, direction, material};
use crate::bsdf::ggx_anisotropic::AnisotropicGgx;
use crate::bsdf::microfacets::Microfacets;
use crate::bsdf::{anisotropic_albedo, internal_albedo};

/// Midpoints of eased steps, whose error is far below the tolerance of the tests.
fn eased(steps: u32) -> impl Iterator<Item = (f64, f64)> {
    (0..steps).map(move |step| {
        let x = (f64::from(step) + 0.5) / f64::from(steps);
        // 6 x⁵ − 15 x⁴ + 10 x³ and its derivative
        (x * x * x * (10.0 + x * (6.0 * x - 15.0)), 30.0 * x * x * (1.0 - x) * (1.0 - x) / f64::from(steps))
    })
}

/// The lobe's albedos with F = 1, with (1 − v·h)⁵, and with Fresnel's F of the relative index.
pub(super) fn albedos(v: DVec3, at: f64, ab: f64, n: f64) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for pair in azimuths(v, at, ab, n).windows(2) {
        for (share, weight) in eased(48) {
            let phi = pair[0] + (pair[1] - pair[0]) * share;
            let (sin, cos) = (libm::sin(phi), libm::cos(phi));
            let radial = Radial { v, x: at * cos, y: ab * sin, at, ab, n };
            for (sum, value) in sums.iter_mut().zip(radial.integrate()) {
                // dξ dφ / 2π
                *sum += value * weight * (pair[1] - pair[0]) / (2.0 * PI);
            }
        }
    }
    sums
}

/// Azimuths between which the integrand is smooth: slopes away from the view, across it and towards it, and those that touch the
/// cone of total reflection, v_xy · slope = ±√(c² − v_z²) |slope|.
fn azimuths(v: DVec3, at: f64, ab: f64, n: f64) -> Vec<f64> {
    let away = libm::atan2(ab * v.y, at * v.x);
    let mut azimuths: Vec<f64> = (0..=4).map(|quarter| away + PI / 2.0 * f64::from(quarter)).collect();
    let (azimuth, sine) = (libm::atan2(v.y, v.x), (v.x * v.x + v.y * v.y).sqrt());
    let beyond = 1.0 - n * n - v.z * v.z;
    if n < 1.0 && beyond > 0.0 {
        let touching = libm::acos(beyond.sqrt() / sine);
        for angle in [touching, -touching, PI - touching, PI + touching] {
            let (sin, cos) = (libm::sin(azimuth + angle), libm::cos(azimuth + angle));
            let turn = libm::atan2(sin / ab, cos / at) - away;
            azimuths.push(away + turn - 2.0 * PI * (turn / (2.0 * PI)).floor());
        }
    }
    azimuths.sort_by(f64::total_cmp);
    azimuths
}

/// The integral over slopes along one azimuth.
struct Radial {
    v: DVec3,
    x: f64,
    y: f64,
    at: f64,
    ab: f64,
    n: f64,
}

impl Radial {
    fn integrate(&self) -> [f64; 3] {
        let b = self.v.x * self.x + self.v.y * self.y;
        let squared = self.x * self.x + self.y * self.y;
        // z s r² + 2 b r − z = 0 for slopes of squared length s r²
        let root = (b * b + squared * self.v.z * self.v.z).sqrt();
        let end = if b > 0.0 { self.v.z / (b + root) } else { (root - b) / (squared * self.v.z) };
        let mut borders = vec![0.0, end];
        if self.n < 1.0 {
            // (z − b r)² = c² (1 + s r²)
            let c = 1.0 - self.n * self.n;
            let (p, q, r) = (b * b - c * squared, -b * self.v.z, self.v.z * self.v.z - c);
            let discriminant = q * q - p * r;
            if discriminant > 0.0 {
                for sign in [-1.0, 1.0] {
                    let at = (sign * discriminant.sqrt() - q) / p;
                    if at > 0.0 && at < end {
                        borders.push(at);
                    }
                }
            }
        }
        borders.sort_by(f64::total_cmp);
        let mut sums = [0.0; 3];
        for pair in borders.windows(2) {
            let [from, to] = [pair[0], pair[1]].map(libm::atan);
            for (share, weight) in eased(48) {
                let r = libm::tan(from + (to - from) * share);
                // dξ = 2 r dr / (1 + r²)², dr = (1 + r²) d(atan r)
                let weight = weight * (to - from) * 2.0 * r / (1.0 + r * r);
                for (sum, value) in sums.iter_mut().zip(self.at(r)) {
                    *sum += value * weight;
                }
            }
        }
        sums
    }

    fn at(&self, r: f64) -> [f64; 3] {
        let h = DVec3::new(-self.x * r, -self.y * r, 1.0).normalize();
        let facet = self.v.dot(h);
        let l = h * (2.0 * facet) - self.v;
        if l.z <= 0.0 {
            return [0.0; 3];
        }
        let value = v_ggx_anisotropic(self.v, l, self.at, self.ab) * l.z * 4.0 * facet / h.z;
        [value, value * (1.0 - facet).powi(5), value * fresnel(facet, self.n)]
    }
}

fn view(cos: f32, azimuth: f64) -> DVec3 {
    let sine = (1.0 - f64::from(cos).powi(2)).sqrt();
    DVec3::new(sine * libm::cos(azimuth), sine * libm::sin(azimuth), f64::from(cos))
}

/// Cosines of views, along the surface and next to the critical angle of a relative index included.
fn cosines(n: f64, roughness: f32) -> Vec<f32> {
    let mut all = vec![1e-5, 0.001, 0.01, 0.03, 0.07, 0.13, 0.25, 0.4, 0.56, 0.7, 0.81, 0.93, 0.99, 1.0];
    if n < 1.0 {
        let critical = (1.0 - n * n).sqrt() as f32;
        let width = roughness * roughness;
        let around = [-2.0, -0.5, -0.1, 0.0, 0.01, 0.1, 0.5, 2.0].map(|share| critical + share * width);
        all.extend(around.into_iter().filter(|cosine| *cosine > 0.0 && *cosine < 1.0));
    }
    all
}

#[test]
fn the_reference_has_the_known_albedo_of_the_roughest_lobe() {
    // α = 1 head on: D = 1 / π, V = 1 / (2 (l_z + 1)), and D V l_z dl = l_z dl_z / (l_z + 1) from 0 to 1 is 1 − ln 2.
    let [total, ..] = albedos(DVec3::Z, 1.0, 1.0, 1.5);
    assert!((total - (1.0 - std::f64::consts::LN_2)).abs() < 1e-6, "{total}");
}

/// Every second of `all`, from the first or the second on: half of a grid, if rows alternate, in which all values of all axes occur.
fn alternate<T>(all: impl IntoIterator<Item = T>, row: usize) -> impl Iterator<Item = T> {
    all.into_iter().skip(row % 2).step_by(2)
}

/// Greatest error of the albedo under the exact Fresnel curve: the edge of total reflection costs accuracy.
fn exact_limit(relative_ior: f32) -> f64 {
    if relative_ior < 1.0 { 2e-3 } else { 1e-3 }
}

#[test]
fn isotropic_lobes_agree_with_quadrature() {
    for (row, roughness) in [0.01_f32, 0.05, 0.13, 0.31, 0.62, 1.0].into_iter().enumerate() {
        let alpha = f64::from(roughness * roughness);
        let indices = [0.5_f32, 1.0 / 1.5, 0.93, 1.01, 1.05, 1.33, 1.5, 2.4, 5.0];
        for (column, n) in indices.into_iter().enumerate() {
            for cosine in alternate(cosines(f64::from(n), roughness), row + column) {
                let expected = albedos(view(cosine, 0.0), alpha, alpha, f64::from(n));
                let terms = AlbedoSlice::new(n).terms(cosine, roughness);
                let found = [terms.total, terms.schlick, terms.exact];
                let limits = [1e-3, 1e-3, exact_limit(n)];
                for ((found, expected), limit) in found.into_iter().zip(expected).zip(limits) {
                    let error = (f64::from(found) - expected).abs();
                    assert!(error < limit, "{roughness} {n} {cosine}: {found} is not {expected}");
                }
            }
        }
    }
}

/// The albedos by the integrals that tables hold.
fn integrated(ggx: AnisotropicGgx, wo: Vec3, relative_ior: f32) -> [f32; 3] {
    use crate::bsdf::fresnel::{exact, schlick_weight};
    let facets = Microfacets::anisotropic(wo, ggx.alpha);
    let [total, schlick, exact] =
        facets.reflected(|cosine| [1.0, schlick_weight(cosine), exact(cosine, relative_ior)]);
    let is_denser = relative_ior < 1.0;
    let exact = if is_denser { total - internal_albedo::by_quadrature(&facets, relative_ior) } else { exact };
    [total, schlick, exact]
}

#[test]
fn anisotropic_lobes_agree_with_quadrature() {
    let lobes = [
        (0.2_f32, 0.5_f32, 1.5e-4),
        (0.4, 0.3, 3e-4),
        (0.4, 1.0, 3e-4),
        (0.7, 0.8, 1e-4),
        (0.1, 0.9, 3e-5),
        (0.3, 0.1, 4e-4),
        (0.15, 0.05, 7e-4),
    ];
    for (lobe, (roughness, strength, limit)) in lobes.into_iter().enumerate() {
        let ggx = AnisotropicGgx::new(roughness * roughness, strength);
        let (at, ab) = (f64::from(ggx.alpha.x), f64::from(ggx.alpha.y));
        let indices = [0.42_f32, 1.0 / 1.5, 1.0 / 1.33, 1.0 / 1.05, 1.05, 1.5, 2.4];
        for (row, n) in indices.into_iter().enumerate() {
            let cosines = [0.002_f32, 0.02, 0.1, 0.25, 0.5, 0.746, 0.9, 1.0];
            for (column, cosine) in cosines.into_iter().enumerate() {
                let azimuths = [0.0_f32, 0.03, 0.05, 0.1, 0.3, 0.7, 1.1, 1.5];
                for azimuth in alternate(azimuths, lobe + row + column) {
                    let v = direction(cosine, azimuth);
                    let expected = albedos(v.as_dvec3().normalize(), at, ab, f64::from(n));
                    let found = integrated(ggx, v, n);
                    for (found, expected) in found.into_iter().zip(expected) {
                        let error = (f64::from(found) - expected).abs();
                        let case = format!("{roughness} {strength} {n} {cosine} {azimuth}");
                        assert!(error < limit, "{case}: {found} is not {expected}");
                    }
                }
            }
        }
    }
}

#[test]
fn nearly_all_anisotropic_lobes_are_within_a_thousandth() {
    const LOBES: u32 = 3000;
    let mut beyond = 0;
    for index in 1..=LOBES {
        // The sequence R5 of Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018
        let [a, b, c, d, e] = [1, 2, 3, 4, 5].map(|power| {
            let position = f64::from(index) / 1.134_724_138_401_519_4_f64.powi(power);
            (position - position.floor()) as f32
        });
        // No lobe is sharper than that of roughness 0.045.
        let (roughness, strength) = (0.045 + 0.955 * a * a, b * b);
        let v = direction(5e-4 + (1.0 - 5e-4) * c * c, std::f32::consts::FRAC_PI_2 * d * d);
        // One of eight is far above the indices of real materials.
        let n = if index % 8 == 0 { 3.0 / (1.0 - 0.99 * e) } else { 0.4 + 2.6 * e };
        let ggx = AnisotropicGgx::new(roughness * roughness, strength);
        let (at, ab) = (f64::from(ggx.alpha.x), f64::from(ggx.alpha.y));
        let expected = albedos(v.as_dvec3().normalize(), at, ab, f64::from(n));
        let terms = anisotropic_albedo::terms(ggx, v, &AlbedoSlice::new(n));
        let found = [terms.total, terms.schlick, terms.exact];
        let error =
            found.into_iter().zip(expected).map(|(found, expected)| (f64::from(found) - expected).abs());
        let error = error.fold(0.0, f64::max);
        assert!(error < 0.02, "{roughness} {strength} {n} {v}: {error}");
        beyond += u32::from(error > 1e-3);
    }
    assert!(beyond <= LOBES / 100, "{beyond}");
}

#[test]
fn materials_and_coats_agree_with_quadrature() {
    for roughness in [0.08_f32, 0.25, 0.55, 0.9] {
        let alpha = f64::from(roughness * roughness);
        for cosine in [0.01_f32, 0.08, 0.3, 0.72, 0.76, 1.0] {
            let v = direction(cosine, 0.0);
            for (outside, inside) in [(1.0_f32, 1.5_f32), (1.5, 1.0), (1.33, 1.5), (1.0, 2.4)] {
                let [total, schlick, exact] =
                    albedos(view(v.z, 0.0), alpha, alpha, f64::from(inside / outside));
                // F0 = ((n − 1) / (n + 1))² and F90 = 1: the exact curve as it is.
                let plastic = MaterialSample { ior: inside, ..material(0.0, roughness, 0.5, false) };
                let albedos = Bsdf::new(&plastic, outside, inside).albedos(v);
                // From the denser side, the lobe's mean F stands for F0.
                let f0 =
                    if inside < outside { exact / total } else { fresnel(1.0, f64::from(inside / outside)) };
                let expected = exact * (1.0 + f0 * (1.0 / total - 1.0));
                let error = (f64::from(albedos.specular.x) - expected).abs();
                assert!(error < exact_limit(inside / outside), "{roughness} {cosine}: {error}");
                let base =
                    MaterialSample { base_color: Vec3::splat(0.3), ..material(1.0, roughness, 0.0, true) };
                let metal = Bsdf::new(&base, 1.0, 1.5).specular_albedo(v).x;
                let expected = (0.3 * total + 0.7 * schlick) * (1.0 + 0.3 * (1.0 / total - 1.0));
                assert!((f64::from(metal) - expected).abs() < 1e-3);
            }
            let expected = 0.7 * fresnel(f64::from(v.z), 1.5);
            assert!((f64::from(Coat::new(0.7, roughness).albedo(v.z)) - expected).abs() < 1e-6);
        }
    }
}

#[test]
fn smooth_lobes_are_exactly_fresnel() {
    for n in [0.4_f32, 1.0 / 1.5, 1.0, 1.33, 1.5, 40.0] {
        for step in 0..=100 {
            let cosine = step as f32 / 100.0;
            let terms = AlbedoSlice::new(n).terms(cosine, 0.0);
            let exact = crate::bsdf::fresnel::exact(cosine, n);
            let weight = crate::bsdf::fresnel::schlick_weight(cosine);
            assert_eq!((terms.total, terms.schlick, terms.exact), (1.0, weight, exact));
        }
    }
}

#[test]
fn albedos_converge_to_those_of_smooth_lobes() {
    // Below the table's roughness, where the difference from a mirror shrinks with α
    for n in [0.4_f32, 1.0 / 1.5, 1.01, 1.5, 5.0] {
        for cosine in [0.0_f32, 1e-4, 0.03, 0.4, 0.9, 1.0] {
            let smooth = AlbedoSlice::new(n).terms(cosine, 0.0);
            let near = AlbedoSlice::new(n).terms(cosine, 1e-4);
            let differences = [near.exact - smooth.exact, near.schlick - smooth.schlick].map(f32::abs);
            assert!(
                differences.into_iter().all(|difference| difference < 1.2e-3),
                "{n} {cosine}: {differences:?}"
            );
        }
    }
}

#[test]
fn albedos_stay_between_zero_and_one() {
    for n in [1e-3_f32, 0.4, 0.75, 1.0, 1.000_1, 1.01, 1.45, 2.4, 40.0, 1e20] {
        for roughness in [0.0, 1e-6, 0.003, 0.01, 0.2, 0.77, 1.0] {
            for cosine in [0.0, 1e-20, 1e-6, 0.001, 0.2, 0.7, 1.0] {
                let terms = AlbedoSlice::new(n).terms(cosine, roughness);
                let case = format!("{n} {roughness} {cosine}: {terms:?}");
                assert!((0.0..=1.0).contains(&terms.total), "{case}");
                assert!(terms.exact > -1e-4 && terms.exact < terms.total + 1e-4, "{case}");
                assert!(terms.schlick > -1e-4 && terms.schlick < terms.total + 1e-4, "{case}");
            }
        }
    }
}
