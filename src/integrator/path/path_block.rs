//! What the surfaces of a block of paths scatter, lane by lane.
//!
//! Every value is that of the functions for one surface. Where a block has several surfaces, all in vacuum and without layers and
//! transmission, they are computed for all lanes at once.

use fearless_simd::Level;
use glam::{Vec2, Vec3};

use super::shaded_point::ShadedPoint;
use crate::bsdf::{AlbedoTable, LobeDirection, ScatteredLanes, Scattering, ScatteringLanes};
use crate::color::luminance;
use crate::geometry::{ActiveLanes, F32Lanes, LANES, Vec3Lanes, vectorized};
use crate::integrator::lights::{Incidence, IncidenceLanes};
use crate::interaction::MaterialSample;
use crate::scene::Material;

/// With fewer surfaces, their lobes are evaluated one by one.
const MIN_SURFACES: usize = 3;

/// Lanes of a block. Keeps its memory from block to block.
#[derive(Debug, Default)]
pub(in crate::integrator) struct PathBlock {
    /// Whether lanes are not used: the reference for tests.
    pub(super) is_one_by_one: bool,
    lobes: BlockLobes,
    /// Columns of the matrices from the local frames to world space.
    axes: [Vec3Lanes; 3],
    /// See [`ShadedPoint::weight`].
    weights: Vec3Lanes,
    /// Light of one lamp.
    pub(super) incidences: IncidenceLanes,
    /// Local directions of light.
    pub(super) wi: Vec3Lanes,
    /// What the lobes scatter from there.
    scattered: ScatteredLanes,
    choices: LightChoices,
}

/// The lobes of the surfaces.
#[derive(Debug, Default)]
struct BlockLobes {
    /// Whether they are in lanes.
    in_lanes: bool,
    lanes: ScatteringLanes,
    /// One by one.
    separate: [Option<Scattering>; LANES],
}

/// A lamp for each surface, chosen with a probability proportional to the light that it would send to the viewer without occlusion.
#[derive(Debug, Default)]
struct LightChoices {
    /// Uniform in [0, 1); what one decision leaves decides the next.
    u: F32Lanes,
    /// Sum of the importances so far.
    sum: F32Lanes,
    /// Index of the chosen light.
    light: [u32; LANES],
    contribution: Vec3Lanes,
    /// Zero without a light.
    importance: F32Lanes,
}

impl PathBlock {
    /// Begins a block of hits on one material, whose lobes may be in lanes.
    pub(super) fn begin(&mut self, may_be_in_lanes: bool, hits: usize) {
        self.lobes.in_lanes = may_be_in_lanes && hits >= MIN_SURFACES && !self.is_one_by_one;
    }

    /// Whether the lobes are in lanes, and made from material values.
    pub(super) fn is_in_lanes(&self) -> bool {
        self.lobes.in_lanes
    }

    /// Replaces the material values of a lane.
    pub(super) fn set_material(&mut self, lane: usize, material: &MaterialSample) {
        self.lobes.lanes.set_material(lane, material);
    }

    /// Replaces the lobes of a surface that is not in lanes.
    #[inline(always)]
    pub(super) fn set_lobes(&mut self, lane: usize, scattering: &Scattering) {
        self.lobes.separate[lane] = Some(*scattering);
    }

    /// Gathers the surfaces and computes their lobes, if these are in lanes. The material is in vacuum, and its table that of its index.
    pub(super) fn fill(
        &mut self,
        level: Level,
        (material, table): (&Material, Option<&AlbedoTable>),
        surfaces: &[ShadedPoint<'_, '_>],
        viewers: &Vec3Lanes,
    ) {
        let Some(table) = table.filter(|_| self.lobes.in_lanes) else { return };
        for surface in surfaces {
            let (lane, frame) = (surface.lane, &surface.world_from_local);
            for (axes, axis) in self.axes.iter_mut().zip([frame.x_axis, frame.y_axis, frame.z_axis]) {
                axes.set(lane, axis);
            }
            self.weights.set(lane, surface.weight);
        }
        vectorized!(level, {
            for lane in 0..LANES {
                self.lobes.lanes.wo.set(lane, self.local(lane, viewers.get(lane)));
            }
        });
        let active =
            surfaces.iter().fold(ActiveLanes::default(), |active, surface| active.with(surface.lane));
        self.lobes.lanes.compute((level, active), material.ior, table);
    }

    /// The local direction of a world-space one.
    #[inline(always)]
    fn local(&self, lane: usize, direction: Vec3) -> Vec3 {
        let [x, y, z] = &self.axes;
        Vec3::new(x.get(lane).dot(direction), y.get(lane).dot(direction), z.get(lane).dot(direction))
    }

    /// See [`Scattering::is_smooth`].
    pub(super) fn is_smooth(&self, lane: usize) -> bool {
        let BlockLobes { in_lanes, lanes, separate } = &self.lobes;
        if *in_lanes {
            lanes.is_smooth(lane)
        } else {
            separate[lane].as_ref().is_none_or(Scattering::is_smooth)
        }
    }

    /// See [`Scattering::clear_wall_transmittance`].
    pub(super) fn clear_wall_transmittance(&self, lane: usize) -> Option<Vec3> {
        let BlockLobes { in_lanes, separate, .. } = &self.lobes;
        separate[lane].as_ref().filter(|_| !in_lanes)?.clear_wall_transmittance()
    }

    /// See [`Scattering::diffuse_probability`].
    pub(super) fn diffuse_probability(&self, lane: usize) -> f32 {
        let BlockLobes { in_lanes, lanes, separate } = &self.lobes;
        if *in_lanes {
            lanes.diffuse_probability(lane)
        } else {
            separate[lane].as_ref().map_or(0.0, Scattering::diffuse_probability)
        }
    }

    /// See [`Scattering::sample_direction`].
    pub(super) fn sample_direction(&self, lane: usize, u_lobe: f32, u: Vec2) -> Option<LobeDirection> {
        let BlockLobes { in_lanes, lanes, separate } = &self.lobes;
        if *in_lanes {
            lanes.sample_direction(lane, u_lobe, u)
        } else {
            separate[lane].as_ref()?.sample_direction(u_lobe, u)
        }
    }

    /// Evaluates the lobes of the active lanes in the directions of [`PathBlock::wi`]; see [`Scattering::eval_and_pdf`].
    pub(super) fn scatter(&mut self, level: Level, active: ActiveLanes) {
        let Self { lobes: BlockLobes { in_lanes, lanes, separate }, wi, scattered, .. } = self;
        if *in_lanes {
            vectorized!(level, lanes.eval_and_pdf(wi, scattered));
            return;
        }
        for lane in active {
            let Some(lobes) = &separate[lane] else { continue };
            scattered.set(lane, lobes.eval_and_pdf(wi.get(lane)));
        }
    }

    /// What the lobes of a lane scatter, and the density of the direction.
    pub(super) fn scattered(&self, lane: usize) -> (Vec3, f32) {
        self.scattered.get(lane)
    }

    /// Begins to choose among lamps.
    pub(super) fn begin_choices(&mut self, surface: &ShadedPoint<'_, '_>, u: f32) {
        let LightChoices { u: left, sum, importance, .. } = &mut self.choices;
        (left[surface.lane], sum[surface.lane], importance[surface.lane]) = (u, 0.0, 0.0);
    }

    /// Adds the lamp of [`PathBlock::incidences`] to the choice. `passes_straight` says whether a lamp's light from a world-space direction reached the
    /// last surface straight through this one, where surfaces are not in lanes.
    pub(super) fn choose(
        &mut self,
        (level, light): (Level, u32),
        surfaces: &[ShadedPoint<'_, '_>],
        passes_straight: impl Fn(&ShadedPoint<'_, '_>, Vec3) -> bool,
    ) {
        if self.lobes.in_lanes {
            vectorized!(level, {
                self.orient();
                self.lobes.lanes.eval_with_smooth(&self.wi, &mut self.scattered);
                self.choose_in_lanes(light);
            });
            return;
        }
        for surface in surfaces {
            let lane = surface.lane;
            let Some(lobes) = &self.lobes.separate[lane] else { continue };
            let Incidence { wi, irradiance, .. } = self.incidences.get(lane);
            let local = surface.local_of_lamp(wi).filter(|_| irradiance.max_element() > 0.0);
            let Some(local) = local else { continue };
            let scattered = if passes_straight(surface, wi) {
                lobes.eval_diffuse_transmission(local)
            } else {
                lobes.eval_with_smooth(local)
            };
            self.choices.add(lane, light, surface.weight * scattered * irradiance);
        }
    }

    /// Takes the directions to the lamp to the local frames; zero where no light arrives on the side of the lobes. See
    /// [`ShadedPoint::local_of_lamp`].
    #[inline(always)]
    fn orient(&mut self) {
        for lane in 0..LANES {
            let Incidence { wi, irradiance, .. } = self.incidences.get(lane);
            let local = self.local(lane, wi);
            let is_lit = local.z > 0.0 && irradiance.max_element() > 0.0;
            self.wi.set(lane, if is_lit { local } else { Vec3::ZERO });
        }
    }

    #[inline(always)]
    fn choose_in_lanes(&mut self, light: u32) {
        for lane in 0..LANES {
            let (value, _) = self.scattered.get(lane);
            let irradiance = self.incidences.get(lane).irradiance;
            self.choices.add(lane, light, self.weights.get(lane) * value * irradiance);
        }
    }

    /// The chosen lamp, and its light over the probability of the choice; `None` where no lamp sends light.
    pub(super) fn chosen(&self, lane: usize) -> Option<(usize, Vec3)> {
        let LightChoices { sum, light, contribution, importance, .. } = &self.choices;
        let scale = sum[lane] / importance[lane];
        (importance[lane] > 0.0).then(|| (light[lane] as usize, contribution.get(lane) * scale))
    }
}

impl LightChoices {
    /// Adds a light to a reservoir of one.
    #[inline(always)]
    fn add(&mut self, lane: usize, light: u32, contribution: Vec3) {
        let importance = luminance(contribution);
        let is_candidate = importance > 0.0 && importance < f32::INFINITY;
        let sum = self.sum[lane] + if is_candidate { importance } else { 0.0 };
        let (u, probability) = (self.u[lane], importance / sum);
        let is_chosen = is_candidate && u < probability;
        let left = if is_chosen { u / probability } else { (u - probability) / (1.0 - probability) };
        self.u[lane] = if is_candidate { left } else { u };
        self.sum[lane] = sum;
        self.light[lane] = if is_chosen { light } else { self.light[lane] };
        self.importance[lane] = if is_chosen { importance } else { self.importance[lane] };
        let chosen = self.contribution.get(lane);
        self.contribution.set(lane, if is_chosen { contribution } else { chosen });
    }
}
