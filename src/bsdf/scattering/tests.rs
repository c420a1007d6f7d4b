//! Energy of all lobes, and consistency of value, density and samples.

use glam::{Mat3, Vec2, Vec3};

use super::*;
use crate::bsdf::{Coat, ScatterLobe, ScatterSample};
use crate::interaction::{AnisotropySample, IridescenceSample, MaterialSample, SheenSample};

mod densities;
mod energy;

/// A surface with the media on both sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    name: &'static str,
    material: MaterialSample,
    ior_outside: f32,
    ior_inside: f32,
    coat: Option<f32>,
}

impl Surface {
    fn scattering(&self, wo: Vec3) -> Scattering {
        let bsdf = Bsdf::new(&self.material, self.ior_outside, self.ior_inside);
        let oriented = |roughness| OrientedCoat {
            coat: Coat::new(1.0, roughness),
            coat_from_local: Mat3::IDENTITY,
            geometric_normal: Vec3::Z,
        };
        Scattering::new(bsdf, wo, self.coat.map(oriented))
    }
}

/// Every lobe at one roughness, white.
fn white_surfaces(roughness: f32) -> Vec<Surface> {
    let white = MaterialSample { roughness, ..MaterialSample::default() };
    let glass = MaterialSample { transmission: 1.0, thin: false, ..white };
    let little_specular = MaterialSample { specular: 0.5, is_tinted: true, ..glass };
    let film = IridescenceSample { factor: 1.0, ior: 1.3, thickness_nm: 400.0 };
    let surface = |name, material| Surface { name, material, ior_outside: 1.0, ior_inside: 1.5, coat: None };
    let anisotropy = Some(AnisotropySample { strength: 0.7, direction: Vec3::X });
    let metal = MaterialSample { metallic: 1.0, ..white };
    vec![
        surface("metal", metal),
        surface("dielectric", white),
        surface("half metal", MaterialSample { metallic: 0.5, ..white }),
        surface("sheen", {
            MaterialSample { sheen: Some(SheenSample { color: Vec3::ONE, roughness }), ..white }
        }),
        Surface { coat: Some(roughness), ..surface("coat", MaterialSample { roughness: 0.5, ..white }) },
        surface("thin", MaterialSample { thin: true, ..glass }),
        surface("volume", glass),
        Surface { ior_outside: 1.5, ior_inside: 1.0, ..surface("volume from inside", glass) },
        Surface { ior_inside: 1.1, ..surface("volume of low index", glass) },
        Surface { ior_outside: 2.4, ior_inside: 1.0, ..surface("diamond from inside", glass) },
        surface("volume of little specular", little_specular),
        Surface { ior_outside: 1.5, ior_inside: 1.0, ..surface("the same from inside", little_specular) },
        surface("volume without specular", MaterialSample { specular: 0.0, ..little_specular }),
        surface("diffuse transmission", MaterialSample { diffuse_transmission: 0.6, ..white }),
        surface("iridescent dielectric", MaterialSample { iridescence: Some(film), ..white }),
        surface("anisotropic metal", MaterialSample { anisotropy, ..metal }),
        surface("anisotropic dielectric", MaterialSample { anisotropy, ..white }),
        surface("anisotropic volume", MaterialSample { anisotropy, ..glass }),
        surface("all", {
            let sheen = Some(SheenSample { color: Vec3::ONE, roughness: 0.6 });
            MaterialSample { transmission: 0.5, diffuse_transmission: 0.5, metallic: 0.3, sheen, ..glass }
        }),
    ]
}

fn direction(cosine: f32, azimuth: f32) -> Vec3 {
    let (sine, (sin, cos)) = ((1.0 - cosine * cosine).sqrt(), libm::sincosf(azimuth));
    Vec3::new(sine * cos, sine * sin, cosine)
}

/// Points of the unit cube: a Hammersley set.
fn points(count: u32) -> impl Iterator<Item = (f32, Vec2)> {
    let radical_inverse = |mut index: u32, base: u32| {
        let (mut inverse, mut scale) = (0.0_f64, 1.0 / f64::from(base));
        while index > 0 {
            inverse += f64::from(index % base) * scale;
            index /= base;
            scale /= f64::from(base);
        }
        inverse as f32
    };
    (0..count).map(move |index| {
        let u = Vec2::new(radical_inverse(index, 2), radical_inverse(index, 3));
        ((index as f32 + 0.5) / count as f32, u)
    })
}

/// The mean weight of `count` samples.
fn mean_weight(scattering: &Scattering, count: u32) -> Vec3 {
    let sampled = points(count).filter_map(|(u_lobe, u)| scattering.sample(u_lobe, u));
    let sum: glam::DVec3 = sampled.map(|sample| sample.weight.as_dvec3()).sum();
    (sum / f64::from(count)).as_vec3()
}

/// The sum of all albedos.
fn albedo(scattering: &Scattering) -> Vec3 {
    let Albedos { specular, diffuse, transmission, diffuse_transmission, sheen } = scattering.albedos();
    specular + diffuse + transmission + diffuse_transmission + sheen + scattering.coat_albedo()
}
