//! Lobes of a block of surfaces towards their views: those of one material of the metallic-roughness model, without layers and transmission.
//!
//! Every value is that of [`Scattering`], by the same functions, but computed for all lanes of a block at once.

use fearless_simd::Level;
use glam::{Vec2, Vec3};

use super::fresnel::{Dielectric, FresnelCurve};
use super::lobe_probabilities::LobeProbabilities;
use super::multiple_scattering::Compensation;
use super::scattering::TransmissionLobe;
use super::smooth_lobes::SmoothLobes;
use super::specular_lobe::SpecularLobe;
use super::{AlbedoSlice, AlbedoTable, AlbedoTermLanes, Albedos, Bsdf, LobeDirection, Scattering};
use crate::geometry::{ActiveLanes, F32Lanes, LANES, Vec3Lanes, vectorized};
use crate::interaction::{BaseMaterialLanes, MaterialSample};

/// The lobes of each lane.
#[derive(Debug)]
pub(crate) struct ScatteringLanes {
    /// Directions to the viewers, in local frames.
    pub(crate) wo: Vec3Lanes,
    cos_o: F32Lanes,
    material: BaseMaterialLanes,
    terms: AlbedoTermLanes,
    /// Not used by the values of lobes, whose terms are known.
    albedo_slice: AlbedoSlice,
    metallic: F32Lanes,
    alpha: F32Lanes,
    reflectance: ReflectanceLanes,
    dielectric_compensation: Vec3Lanes,
    metal_compensation: Vec3Lanes,
    specular_albedo: Vec3Lanes,
    diffuse_albedo: Vec3Lanes,
    specular_probability: F32Lanes,
    diffuse_probability: F32Lanes,
}

/// Reflectances of the dielectric, by its exact curve.
#[derive(Debug, Default)]
struct ReflectanceLanes {
    relative_ior: F32Lanes,
    offset: Vec3Lanes,
    scale: Vec3Lanes,
}

/// Values of lobes in one direction for each lane, and the densities of these directions.
#[derive(Debug, Default)]
pub(crate) struct ScatteredLanes {
    value: Vec3Lanes,
    pdf: F32Lanes,
}

impl Default for ScatteringLanes {
    fn default() -> Self {
        Self {
            wo: Vec3Lanes::default(),
            cos_o: F32Lanes::default(),
            material: BaseMaterialLanes::default(),
            terms: AlbedoTermLanes::default(),
            albedo_slice: AlbedoSlice::new(1.0),
            metallic: F32Lanes::default(),
            alpha: F32Lanes::default(),
            reflectance: ReflectanceLanes::default(),
            dielectric_compensation: Vec3Lanes::default(),
            metal_compensation: Vec3Lanes::default(),
            specular_albedo: Vec3Lanes::default(),
            diffuse_albedo: Vec3Lanes::default(),
            specular_probability: F32Lanes::default(),
            diffuse_probability: F32Lanes::default(),
        }
    }
}

impl ScatteredLanes {
    /// The value and the density of a lane.
    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> (Vec3, f32) {
        (self.value.get(lane), self.pdf[lane])
    }

    /// Replaces them.
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, (value, pdf): (Vec3, f32)) {
        self.value.set(lane, value);
        self.pdf[lane] = pdf;
    }
}

impl ScatteringLanes {
    /// Replaces the material values of a lane.
    pub(crate) fn set_material(&mut self, lane: usize, sample: &MaterialSample) {
        self.material.set(lane, sample);
    }

    /// Computes the lobes of the active lanes, seen through vacuum, from the material values and the directions to the viewers. The table is that of
    /// the material's index.
    pub(crate) fn compute(&mut self, (level, active): (Level, ActiveLanes), ior: f32, table: &AlbedoTable) {
        let Self { wo, cos_o, material, terms, .. } = self;
        for (lane, cosine) in cos_o.iter_mut().enumerate() {
            *cosine = wo.get(lane).z;
        }
        table.terms((level, active), cos_o, material.roughness(), terms);
        self.albedo_slice = table.slice();
        vectorized!(level, self.compute_lobes(ior));
    }

    #[inline(always)]
    fn compute_lobes(&mut self, ior: f32) {
        for lane in 0..LANES {
            let bsdf = Bsdf::in_lane(&self.material.get(lane, ior), 1.0, ior, self.albedo_slice);
            let (wo, terms) = (self.wo.get(lane), self.terms.get(lane));
            let terms = bsdf.scattering_terms(wo, || terms);
            let Scattering { bsdf, compensation, albedos, probabilities, .. } =
                Scattering::opaque(bsdf, wo, terms);
            self.metallic[lane] = bsdf.metallic;
            self.alpha[lane] = bsdf.lobe.alpha;
            self.reflectance.relative_ior[lane] = bsdf.dielectric.relative_ior;
            self.reflectance.offset.set(lane, bsdf.dielectric.offset);
            self.reflectance.scale.set(lane, bsdf.dielectric.scale);
            self.dielectric_compensation.set(lane, compensation.dielectric);
            self.metal_compensation.set(lane, compensation.metal);
            self.specular_albedo.set(lane, albedos.specular);
            self.diffuse_albedo.set(lane, albedos.diffuse);
            self.specular_probability[lane] = probabilities.specular;
            self.diffuse_probability[lane] = probabilities.diffuse;
        }
    }

    /// [`Scattering::is_smooth`] of a lane.
    pub(crate) fn is_smooth(&self, lane: usize) -> bool {
        self.get(lane).is_smooth()
    }

    /// [`Scattering::diffuse_probability`] of a lane.
    pub(crate) fn diffuse_probability(&self, lane: usize) -> f32 {
        self.diffuse_probability[lane]
    }

    /// [`Scattering::sample_direction`] of a lane.
    pub(crate) fn sample_direction(&self, lane: usize, u_lobe: f32, u: Vec2) -> Option<LobeDirection> {
        self.get(lane).direction_by(u_lobe, u)
    }

    /// [`Scattering::eval_and_pdf`] of all lanes, for the directions `wi`.
    #[inline(always)]
    pub(crate) fn eval_and_pdf(&self, wi: &Vec3Lanes, out: &mut ScatteredLanes) {
        for lane in 0..LANES {
            out.set(lane, self.values(lane, wi.get(lane), SmoothLobes::Without));
        }
    }

    /// [`Scattering::eval_with_smooth`] of all lanes, for the directions `wi`; the densities are those of rough lobes.
    #[inline(always)]
    pub(crate) fn eval_with_smooth(&self, wi: &Vec3Lanes, out: &mut ScatteredLanes) {
        for lane in 0..LANES {
            out.set(lane, self.values(lane, wi.get(lane), SmoothLobes::Sharpest));
        }
    }

    /// f · |cos θ_i| and the density.
    #[inline(always)]
    fn values(&self, lane: usize, wi: Vec3, smooth: SmoothLobes) -> (Vec3, f32) {
        let scattering = self.get(lane);
        let (value, pdf) = scattering.reflected(wi, smooth);
        let is_lit = scattering.wo.z > 0.0 && wi.z > 0.0;
        (if is_lit { value } else { Vec3::ZERO }, if is_lit { pdf } else { 0.0 })
    }

    /// The lobes of a lane.
    #[inline(always)]
    fn get(&self, lane: usize) -> Scattering {
        // Roughness is for albedos, which are known.
        let lobe = SpecularLobe { roughness: 0.0, alpha: self.alpha[lane], anisotropic: None };
        let dielectric = Dielectric {
            relative_ior: self.reflectance.relative_ior[lane],
            offset: self.reflectance.offset.get(lane),
            scale: self.reflectance.scale.get(lane),
            curve: FresnelCurve::Exact,
        };
        Scattering {
            bsdf: Bsdf {
                base_color: self.material.base_color(lane),
                metallic: self.metallic[lane],
                transmission: 0.0,
                thin: true,
                diffuse_transmission: 0.0,
                diffuse_transmission_color: Vec3::ZERO,
                dielectric,
                albedo_slice: self.albedo_slice,
                lobe,
                transmission_lobe: lobe,
                thin_film: None,
                sheen: None,
            },
            wo: self.wo.get(lane),
            film: None,
            compensation: Compensation {
                dielectric: self.dielectric_compensation.get(lane),
                metal: self.metal_compensation.get(lane),
            },
            albedos: Albedos {
                specular: self.specular_albedo.get(lane),
                diffuse: self.diffuse_albedo.get(lane),
                ..Albedos::default()
            },
            below: 1.0,
            coat: None,
            transmission: TransmissionLobe::None,
            probabilities: LobeProbabilities {
                specular: self.specular_probability[lane],
                diffuse: self.diffuse_probability[lane],
                ..LobeProbabilities::default()
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::LARGEST_SCALED_IOR;

    /// A number in [0, 1) of a quasirandom set.
    fn number(index: u32, dimension: usize) -> f32 {
        const BASES: [u32; 16] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53];
        let (mut digits, mut scale, mut number) = (index + 1, 1.0, 0.0);
        while digits > 0 {
            scale /= BASES[dimension] as f32;
            number += (digits % BASES[dimension]) as f32 * scale;
            digits /= BASES[dimension];
        }
        number.min(1.0 - f32::EPSILON)
    }

    fn color(index: u32, dimension: usize) -> Vec3 {
        Vec3::new(number(index, dimension), number(index, dimension + 1), number(index, dimension + 2))
    }

    /// Materials with smooth lobes, black and white ones, pure metals and dielectrics among them.
    fn material(index: u32, ior: f32) -> MaterialSample {
        let ends = |value: f32| (1.4 * value - 0.2).clamp(0.0, 1.0);
        // Blocks hold no tinted surfaces of larger ones.
        let is_tinted = ior <= LARGEST_SCALED_IOR;
        MaterialSample {
            base_color: color(index, 0).map(ends),
            metallic: ends(number(index, 3)),
            roughness: ends(number(index, 4)),
            specular: if is_tinted { ends(number(index, 5)) } else { 1.0 },
            specular_color: if is_tinted { color(index, 6).map(ends) } else { Vec3::ONE },
            ior,
            ..MaterialSample::default()
        }
    }

    /// A unit vector with `z` between −0.3 and 1.
    fn direction(index: u32, dimension: usize) -> Vec3 {
        let z = 1.3 * number(index, dimension) - 0.3;
        let (sine, cosine) = libm::sincosf(std::f32::consts::TAU * number(index, dimension + 1));
        let radius = (1.0 - z * z).sqrt();
        Vec3::new(radius * cosine, radius * sine, z)
    }

    #[test]
    fn lanes_scatter_as_their_surfaces_do() {
        let active = ActiveLanes::first(LANES);
        let mut lit = 0;
        for (ior, level) in [1.0, 1.02, 1.33, 1.5, 2.4, 30.0]
            .into_iter()
            .flat_map(|ior| [Level::fallback(), Level::new()].map(|level| (ior, level)))
        {
            let table = AlbedoTable::between(1.0, ior);
            for block in 0..40 {
                let index = |lane: usize| block * LANES as u32 + lane as u32;
                let mut lanes = ScatteringLanes::default();
                let mut wi = Vec3Lanes::default();
                for lane in 0..LANES {
                    lanes.set_material(lane, &material(index(lane), ior));
                    lanes.wo.set(lane, direction(index(lane), 9));
                    wi.set(lane, direction(index(lane), 11));
                }
                lanes.compute((level, active), ior, &table);
                let (mut rough, mut with_smooth) = (ScatteredLanes::default(), ScatteredLanes::default());
                vectorized!(level, {
                    lanes.eval_and_pdf(&wi, &mut rough);
                    lanes.eval_with_smooth(&wi, &mut with_smooth);
                });
                for lane in 0..LANES {
                    let material = material(index(lane), ior);
                    let scattering =
                        Scattering::new(Bsdf::new(&material, 1.0, ior), direction(index(lane), 9), None);
                    let wi = wi.get(lane);
                    assert_eq!(rough.get(lane), scattering.eval_and_pdf(wi), "{material:?}");
                    assert_eq!(with_smooth.get(lane).0, scattering.eval_with_smooth(wi), "{material:?}");
                    assert_eq!(lanes.is_smooth(lane), scattering.is_smooth(), "{material:?}");
                    assert_eq!(lanes.diffuse_probability(lane), scattering.diffuse_probability());
                    let (u_lobe, u) = (number(index(lane), 13), Vec2::new(number(index(lane), 14), 0.3));
                    let sampled = lanes.sample_direction(lane, u_lobe, u);
                    assert_eq!(sampled, scattering.sample_direction(u_lobe, u), "{material:?}");
                    lit += u32::from(rough.get(lane).1 > 0.0 && sampled.is_some());
                }
            }
        }
        assert!(lit > 2000, "{lit}");
    }
}
