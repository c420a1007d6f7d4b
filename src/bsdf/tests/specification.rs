//! Reference implementation of the extensions' formulas, in f64 and in the notation of their texts, against the lobes.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Mutex;

use glam::{DVec3, Vec3};

use super::quadrature::albedos;
use super::{Bsdf, direction, single_scattering};
use crate::bsdf::Coat;
use crate::interaction::{AnisotropySample, IridescenceSample, MaterialSample, SheenSample};

/// Unpolarised Fresnel by the cosines on both sides; n is the relative index.
pub(super) fn fresnel(cos_i: f64, n: f64) -> f64 {
    let sin_t_squared = (1.0 - cos_i * cos_i) / (n * n);
    if sin_t_squared >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin_t_squared).sqrt();
    let s = (cos_i - n * cos_t) / (cos_i + n * cos_t);
    let p = (n * cos_i - cos_t) / (n * cos_i + cos_t);
    f64::midpoint(s * s, p * p)
}

fn schlick(f0: DVec3, f90: f64, v_dot_h: f64) -> DVec3 {
    f0 + (f90 - f0) * (1.0 - v_dot_h).powi(5)
}

/// F0 and F90 of `KHR_materials_specular`.
fn ends(m: &MaterialSample) -> (DVec3, f64) {
    let n = f64::from(m.ior);
    let specular = f64::from(m.specular);
    let f0 = ((n - 1.0) / (n + 1.0)).powi(2) * m.specular_color.as_dvec3();
    (f0.min(DVec3::ONE) * specular, specular)
}

/// The dielectric's F: this project's rule, or Schlick where the index is 0.
fn dielectric_fresnel(m: &MaterialSample, v_dot_h: f64) -> DVec3 {
    let (f0, f90) = ends(m);
    if m.ior == 0.0 {
        return schlick(f0, f90, v_dot_h);
    }
    let n = f64::from(m.ior);
    let exact0 = fresnel(1.0, n);
    f0 + (f90 - f0) * ((fresnel(v_dot_h, n) - exact0) / (1.0 - exact0))
}

/// α along the direction of anisotropy and across it.
fn alphas(m: &MaterialSample) -> (f64, f64) {
    let alpha = f64::from(m.roughness).powi(2);
    let strength = m.anisotropy.map_or(0.0, |a| f64::from(a.strength));
    (alpha + (1.0 - alpha) * strength * strength, alpha)
}

pub(super) fn d_ggx_anisotropic(h: DVec3, at: f64, ab: f64) -> f64 {
    let a2 = at * ab;
    let f = DVec3::new(ab * h.x, at * h.y, a2 * h.z);
    let w2 = a2 / f.dot(f);
    a2 * w2 * w2 / PI
}

pub(super) fn v_ggx_anisotropic(v: DVec3, l: DVec3, at: f64, ab: f64) -> f64 {
    let ggx_v = l.z * DVec3::new(at * v.x, ab * v.y, v.z).length();
    let ggx_l = v.z * DVec3::new(at * l.x, ab * l.y, l.z).length();
    0.5 / (ggx_v + ggx_l)
}

fn l_sheen(x: f64, alpha: f64) -> f64 {
    let mix = |a: f64, b: f64| a + (b - a) * (1.0 - alpha).powi(2);
    let (a, b) = (mix(21.5473, 25.3245), mix(3.82987, 3.32435));
    let (c, d, e) = (mix(0.19823, 0.16801), mix(-1.97760, -1.27393), mix(-4.32054, -4.85967));
    a / (1.0 + b * libm::pow(x, c)) + d * x + e
}

fn lambda_sheen(cos: f64, alpha: f64) -> f64 {
    if cos < 0.5 {
        libm::exp(l_sheen(cos, alpha))
    } else {
        libm::exp(2.0 * l_sheen(0.5, alpha) - l_sheen(1.0 - cos, alpha))
    }
}

/// D V of the sheen.
fn sheen_lobe(v: DVec3, l: DVec3, roughness: f64) -> f64 {
    let alpha = roughness * roughness;
    let h = (v + l).normalize();
    let sin_h = (1.0 - h.z * h.z).sqrt();
    let d = (2.0 + 1.0 / alpha) * libm::pow(sin_h, 1.0 / alpha) / (2.0 * PI);
    d / ((1.0 + lambda_sheen(v.z, alpha) + lambda_sheen(l.z, alpha)) * 4.0 * v.z * l.z)
}

/// E(cos θ) of the sheen by quadrature. Few cosines come back often.
fn sheen_albedo(cos: f64, roughness: f64) -> f64 {
    static KNOWN: Mutex<BTreeMap<[u64; 2], f64>> = Mutex::new(BTreeMap::new());
    let key = [cos, roughness].map(f64::to_bits);
    let known = KNOWN.lock().unwrap().get(&key).copied();
    known.unwrap_or_else(|| {
        let albedo = sheen_quadrature(cos, roughness);
        KNOWN.lock().unwrap().insert(key, albedo);
        albedo
    })
}

fn sheen_quadrature(cos: f64, roughness: f64) -> f64 {
    let v = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let steps = 300;
    let mut sum = 0.0;
    for ring in 0..steps {
        let u = (f64::from(ring) + 0.5) / f64::from(steps);
        let z = u * u;
        for turn in 0..steps {
            let phi = (f64::from(turn) + 0.5) / f64::from(steps) * PI;
            let r = (1.0 - z * z).sqrt();
            let l = DVec3::new(r * libm::cos(phi), r * libm::sin(phi), z);
            sum += sheen_lobe(v, l, roughness) * z * 2.0 * u;
        }
    }
    sum * 2.0 * PI / f64::from(steps * steps)
}

/// `KHR_materials_iridescence`, channel by channel; all lengths in metres.
fn iridescent(film: &IridescenceSample, f0: DVec3, cos1: f64) -> DVec3 {
    let (eta2, thickness) = (f64::from(film.ior), f64::from(film.thickness_nm) * 1e-9);
    let sin2_squared = (1.0 - cos1 * cos1) / (eta2 * eta2);
    let cos2 = (1.0 - sin2_squared).sqrt();
    let schlick = |r0: f64, cos: f64| r0 + (1.0 - r0) * (1.0 - cos).powi(5);
    let r12 = schlick(((eta2 - 1.0) / (eta2 + 1.0)).powi(2), cos1);
    let optical_path = 2.0 * eta2 * thickness * cos2;
    let channel = |f0: f64, row: [f64; 3]| {
        let root = f0.min(0.9999).sqrt();
        let eta3 = (1.0 + root) / (1.0 - root);
        let r23 = schlick(((eta3 - eta2) / (eta3 + eta2)).powi(2), cos2);
        let shift = PI + if eta3 < eta2 { PI } else { 0.0 };
        (r23, shift, row)
    };
    let rows = [
        [3.2404542, -1.5371385, -0.4985314],
        [-0.9692660, 1.8760108, 0.0415560],
        [0.0556434, -0.2040259, 1.0572252],
    ];
    let channels: Vec<_> = (0..3).map(|c| channel(f0[c], rows[c])).collect();
    // The text shifts X, Y and Z by the phases of red, green and blue.
    let sensitivity = |order: f64| {
        let k = 2.0 * PI * order * optical_path;
        let term = |val: f64, pos: f64, var: f64, shift: f64| {
            val * (2.0 * PI * var).sqrt() * libm::cos(pos * k + order * shift) * libm::exp(-k * k * var)
        };
        let x = term(5.4856e-13, 1.6810e6, 4.3278e9, channels[0].1)
            + term(9.7470e-14, 2.2399e6, 4.5282e9, channels[0].1);
        let y = term(4.4201e-13, 1.7953e6, 9.3046e9, channels[1].1);
        let z = term(5.2481e-13, 2.2084e6, 6.6121e9, channels[2].1);
        [x / 1.0685e-7, y / 1.0685e-7, z / 1.0685e-7]
    };
    let (first, second) = (sensitivity(1.0), sensitivity(2.0));
    let mut f = DVec3::ZERO;
    for (c, (r23, _, row)) in channels.iter().enumerate() {
        let t = 1.0 - r12;
        let r123 = (r12 * r23).clamp(1e-5, 0.9999);
        let rs = t * t * r23 / (1.0 - r123);
        let rgb = |xyz: [f64; 3]| row[0] * xyz[0] + row[1] * xyz[1] + row[2] * xyz[2];
        let cm = (rs - t) * r123.sqrt();
        let sum = r12 + rs + cm * 2.0 * rgb(first) + cm * r123.sqrt() * 2.0 * rgb(second);
        f[c] = sum.clamp(0.0, 1.0);
    }
    f
}

/// The whole material on the side of the view, and through it, without a coat.
fn material(m: &MaterialSample, v: DVec3, l: DVec3) -> DVec3 {
    let through = l.z < 0.0;
    let above = DVec3::new(l.x, l.y, l.z.abs());
    let h = (v + above).normalize();
    let (at, ab) = alphas(m);
    let specular_brdf = d_ggx_anisotropic(h, at, ab) * v_ggx_anisotropic(v, above, at, ab);
    let base_color = m.base_color.as_dvec3();
    let mut dielectric_f = dielectric_fresnel(m, v.dot(h));
    let mut metal_f = schlick(base_color, 1.0, v.dot(h));
    if let Some(film) = &m.iridescence {
        let mix = |f: DVec3, own: DVec3| f + (own - f) * f64::from(film.factor);
        dielectric_f = mix(dielectric_f, iridescent(film, ends(m).0, v.z));
        metal_f = mix(metal_f, iridescent(film, base_color, v.z));
    }
    let (t, d) = (f64::from(m.transmission), f64::from(m.diffuse_transmission));
    let base = if through {
        m.diffuse_transmission_color.as_dvec3() / PI * d * (1.0 - t) + base_color * specular_brdf * t
    } else {
        base_color / PI * (1.0 - d) * (1.0 - t)
    };
    let reflection = if through { 0.0 } else { specular_brdf };
    let dielectric = base * (1.0 - dielectric_f.max_element()) + dielectric_f * reflection;
    let metallic = f64::from(m.metallic);
    let below = dielectric * (1.0 - metallic) + metal_f * reflection * metallic;
    let Some(sheen) = &m.sheen else { return below };
    let (color, roughness) = (sheen.color.as_dvec3(), f64::from(sheen.roughness));
    let scaling = |cos: f64| 1.0 - color.max_element() * sheen_albedo(cos, roughness);
    let below = below * scaling(v.z).min(scaling(above.z));
    if through { below } else { below + color * sheen_lobe(v, l, roughness) }
}

/// Views and lights over both hemispheres, with cosines of at least 0.1.
fn directions() -> Vec<(Vec3, Vec3)> {
    let mut pairs = Vec::new();
    for v in 0..6 {
        for l in 0..12 {
            let cos = |index: i32, steps: i32| 0.1 + 0.89 * index as f32 / (steps - 1) as f32;
            let view = direction(cos(v, 6), 0.7 * v as f32);
            let light = direction(cos(l % 6, 6), 1.3 * l as f32);
            pairs.push((view, light));
            pairs.push((view, Vec3::new(light.x, light.y, -light.z)));
        }
    }
    pairs
}

/// Compares at all directions, by a relative tolerance and an absolute one (`floor`).
fn assert_agrees(m: &MaterialSample, relative: f64, floor: f64) {
    let bsdf = Bsdf::new(m, 1.0, m.ior);
    for (v, l) in directions() {
        let found = single_scattering(&bsdf, v, l).as_dvec3();
        let expected = material(m, v.as_dvec3(), l.as_dvec3());
        let difference = (found - expected).abs();
        let allowed = expected.abs() * relative + floor;
        assert!(difference.cmple(allowed).all(), "{m:?}\n{v} {l}: {found} is not {expected}");
    }
}

fn plain(metallic: f32, roughness: f32) -> MaterialSample {
    MaterialSample { base_color: Vec3::new(0.9, 0.5, 0.1), metallic, roughness, ..MaterialSample::default() }
}

#[test]
fn specular_strength_and_colour() {
    for (specular, color, ior) in [
        (1.0, Vec3::ONE, 1.5),
        (0.5, Vec3::ONE, 1.5),
        (0.0, Vec3::ONE, 1.5),
        (1.0, Vec3::new(1.0, 0.2, 0.0), 1.33),
        (0.7, Vec3::new(3.0, 40.0, 0.5), 2.0),
        (1.0, Vec3::new(0.04, 0.5, 1.0), 0.0),
    ] {
        for roughness in [0.4, 0.7, 1.0] {
            let m = MaterialSample { specular, specular_color: color, ior, ..plain(0.0, roughness) };
            assert_agrees(&m, 1e-5, 1e-7);
            assert_agrees(&MaterialSample { metallic: 0.4, ..m }, 1e-5, 1e-7);
        }
    }
}

#[test]
fn anisotropy_of_metal_plastic_and_thin_glass() {
    for strength in [0.0, 0.3, 0.8, 1.0] {
        for roughness in [0.3, 0.6, 1.0] {
            let anisotropy = Some(AnisotropySample { strength, direction: Vec3::X });
            for metallic in [0.0, 1.0] {
                let m = MaterialSample { anisotropy, transmission: 0.5, ..plain(metallic, roughness) };
                assert_agrees(&m, 1e-5, 1e-7);
            }
        }
    }
}

#[test]
fn thin_films_on_plastic_and_metal() {
    for ior in [1.0, 1.3, 1.8, 2.4] {
        for thickness_nm in [100.0, 287.0, 400.0, 1200.0] {
            for (factor, metallic) in [(1.0, 0.0), (0.5, 0.0), (1.0, 1.0), (0.8, 0.5)] {
                let film = IridescenceSample { factor, ior, thickness_nm };
                let m = MaterialSample { iridescence: Some(film), ..plain(metallic, 0.6) };
                assert_agrees(&m, 1e-5, 1e-6);
            }
        }
    }
}

#[test]
fn a_film_of_zero_thickness_has_no_effect() {
    for metallic in [0.0, 1.0] {
        let bare = plain(metallic, 0.5);
        let film = IridescenceSample { factor: 1.0, ior: 1.8, thickness_nm: 0.0 };
        let filmed = MaterialSample { iridescence: Some(film), ..bare };
        let [bare, filmed] = [bare, filmed].map(|m| Bsdf::new(&m, 1.0, 1.5).specular_albedo(Vec3::Z));
        assert_eq!(bare, filmed);
    }
}

#[test]
fn diffuse_transmission() {
    for (factor, transmission) in [(1.0, 0.0), (0.4, 0.0), (0.4, 0.5)] {
        let m = MaterialSample {
            diffuse_transmission: factor,
            diffuse_transmission_color: Vec3::new(0.2, 0.9, 1.0),
            transmission,
            ..plain(0.2, 0.5)
        };
        assert_agrees(&m, 1e-5, 1e-7);
    }
}

#[test]
fn sheen_lobe_alone() {
    for roughness in [0.05_f32, 0.1, 0.3, 0.6, 1.0] {
        let lobe = crate::bsdf::sheen::Sheen::new(Vec3::new(1.0, 0.5, 0.0), roughness);
        for (v, l) in directions().into_iter().filter(|(_, l)| l.z > 0.0) {
            let found = lobe.eval(v, l).as_dvec3();
            let expected = sheen_lobe(v.as_dvec3(), l.as_dvec3(), f64::from(roughness));
            let allowed = expected * 1e-5 + 1e-12;
            assert!((found.x - expected).abs() <= allowed, "{roughness} {v} {l}: {} {expected}", found.x);
            assert!((found.y - 0.5 * expected).abs() <= allowed && found.z == 0.0);
        }
    }
}

#[test]
fn sheen_over_a_material() {
    for roughness in [0.3, 0.8] {
        let sheen = Some(SheenSample { color: Vec3::new(0.9, 0.4, 0.1), roughness });
        // The lobes below are scaled by the albedo, which is within 1e-3.
        assert_agrees(&MaterialSample { sheen, ..plain(0.3, 0.6) }, 1e-3, 1e-6);
    }
}

#[test]
fn sheen_albedo_by_quadrature() {
    for roughness in [0.1_f32, 0.17, 0.3, 0.55, 0.82, 1.0] {
        let lobe = crate::bsdf::sheen::Sheen::new(Vec3::ONE, roughness);
        for cos in [0.06_f32, 0.1, 0.25, 0.5, 0.77, 1.0] {
            let expected = sheen_albedo(f64::from(cos), f64::from(roughness)).min(1.0);
            let found = f64::from(lobe.albedo(cos).x);
            assert!((found - expected).abs() < 1e-3, "{roughness} {cos}: {found} {expected}");
        }
    }
}

#[test]
fn coats() {
    for roughness in [0.15_f32, 0.33, 0.6, 1.0] {
        let coat = Coat::new(0.7, roughness);
        let alpha = f64::from(roughness).powi(2);
        for (v, l) in directions() {
            let (vd, ld) = (v.as_dvec3(), l.as_dvec3());
            let h = (vd + ld).normalize();
            let blend = 0.7 * fresnel(vd.z, 1.5);
            let lobe = d_ggx_anisotropic(h, alpha, alpha) * v_ggx_anisotropic(vd, ld, alpha, alpha);
            // Divided by the albedo, which is within 1e-3
            let [total, ..] = albedos(vd, alpha, alpha, 1.5);
            let expected = if l.z > 0.0 { blend * lobe / total } else { 0.0 };
            let found = f64::from(coat.eval(v, l));
            assert!((found - expected).abs() <= 3e-3 * expected + 1e-9, "{roughness} {v} {l}");
            assert!((f64::from(coat.transmittance(v.z)) - (1.0 - blend)).abs() < 1e-6);
        }
    }
}

#[test]
fn thin_films_scale_the_lobes_albedo() {
    let film = IridescenceSample { factor: 1.0, ior: 1.5, thickness_nm: 350.0 };
    for (roughness, cos) in [(0.2_f32, 0.9_f32), (0.5, 0.3), (0.8, 0.6)] {
        let m = MaterialSample { iridescence: Some(film), ..plain(1.0, roughness) };
        let v = direction(cos, 0.4);
        let alpha = f64::from(roughness).powi(2);
        let total = albedos(v.as_dvec3().normalize(), alpha, alpha, 1.5)[0];
        let reflectance = iridescent(&film, m.base_color.as_dvec3(), f64::from(v.z));
        let expected = reflectance * total * (1.0 + reflectance * (1.0 / total - 1.0));
        let found = Bsdf::new(&m, 1.0, 1.5).specular_albedo(v).as_dvec3();
        assert!((found - expected).abs().max_element() < 1e-3, "{found} {expected}");
    }
}
