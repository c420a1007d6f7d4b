//! What a surface looks up of the environment, lobe by lobe, and how faint lookups join brighter ones to share their shadow rays.

use arrayvec::ArrayVec;
use glam::{Vec2, Vec3};

use crate::color::luminance;
use crate::integrator::environment_directions::EnvironmentDirections;
use crate::integrator::prefiltered_lobe::PrefilteredLobe;

/// Lookups of one surface: two lobes of each side, three of dispersed glass, and a coat.
pub(super) const MAX_LOOKUPS: usize = 8;

/// A lookup shares the rays of the brightest one on its side unless it has more than this share of its luminance.
const MIN_SHARE: f32 = 0.125;

/// Light of the environment that one lobe scatters towards the camera, without occlusion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct EnvironmentLookup {
    pub(super) radiance: Vec3,
    /// The same where light of radiance 1 comes from everywhere.
    pub(super) albedo: Vec3,
    pub(super) lobe: LookupLobe,
    /// Whether the light comes from the side of the viewer.
    pub(super) is_outside: bool,
}

impl EnvironmentLookup {
    /// Whether it looks anything up.
    #[inline(always)]
    pub(super) fn looks_up(&self) -> bool {
        self.albedo.max_element() > 0.0
    }
}

/// Directions that a lookup averages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum LookupLobe {
    /// The cosine lobe around a normal.
    Diffuse { normal: Vec3 },
    /// A lobe around a direction.
    Glossy(PrefilteredLobe),
}

/// The lookups of one surface.
pub(super) type EnvironmentLookups = ArrayVec<EnvironmentLookup, MAX_LOOKUPS>;

impl LookupLobe {
    /// A direction of the lobe, by a sample point and a random number.
    pub(super) fn sample(&self, directions: &EnvironmentDirections, sampled: (Vec2, f32)) -> Vec3 {
        match *self {
            Self::Diffuse { normal } => directions.diffuse(normal, sampled),
            Self::Glossy(PrefilteredLobe { direction, roughness }) => {
                directions.glossy(direction, roughness, sampled)
            }
        }
    }

    /// The direction around which it averages.
    pub(super) fn middle(self) -> Vec3 {
        match self {
            Self::Diffuse { normal } => normal,
            Self::Glossy(PrefilteredLobe { direction, .. }) => direction,
        }
    }
}

/// Adds faint lookups to the brightest one of their side, and returns the index of the brightest of those that have shadow rays. How bright they are counts
/// what hides the environment, too, of `mean_radiance`.
pub(super) fn join_faint(
    lookups: &mut [EnvironmentLookup],
    mean_radiance: Vec3,
    has_rays: impl Fn(&EnvironmentLookup) -> bool,
) -> Option<usize> {
    let mut luminances = [0.0; MAX_LOOKUPS];
    for (luminance_of, lookup) in luminances.iter_mut().zip(&*lookups) {
        *luminance_of = luminance(lookup.radiance + lookup.albedo * mean_radiance);
    }
    for side in [true, false] {
        let Some(index) = brightest_of(lookups, &luminances, |lookup| lookup.is_outside == side) else {
            continue;
        };
        let limit = luminances[index] * MIN_SHARE;
        let (mut joined, mut joined_albedo) = (Vec3::ZERO, Vec3::ZERO);
        for (other, (lookup, &luminance)) in lookups.iter_mut().zip(&luminances).enumerate() {
            if other != index && lookup.is_outside == side && luminance <= limit {
                joined += std::mem::take(&mut lookup.radiance);
                joined_albedo += std::mem::take(&mut lookup.albedo);
            }
        }
        lookups[index].radiance += joined;
        lookups[index].albedo += joined_albedo;
    }
    brightest_of(lookups, &luminances, has_rays)
}

/// [`join_faint`] for two lookups of the side of the viewer, by their radiances and albedos. Returns whether the second is the brighter one.
#[inline(always)]
pub(super) fn join_faint_pair(lights: &mut [[Vec3; 2]; 2], mean_radiance: Vec3) -> bool {
    let [first, second] = *lights;
    let luminance_of = |[radiance, albedo]: [Vec3; 2]| luminance(radiance + albedo * mean_radiance);
    let (of_first, of_second) = (luminance_of(first), luminance_of(second));
    let is_second = of_second >= of_first;
    let joins_second = is_second && of_first <= of_second * MIN_SHARE;
    let joins_first = !is_second && of_second <= of_first * MIN_SHARE;
    let select = |condition: bool, light: Vec3, other: Vec3| if condition { light } else { other };
    for part in 0..2 {
        let sum = first[part] + second[part];
        let without_first = select(joins_second, Vec3::ZERO, first[part]);
        lights[0][part] = select(joins_first, sum, without_first);
        let without_second = select(joins_first, Vec3::ZERO, second[part]);
        lights[1][part] = select(joins_second, sum, without_second);
    }
    is_second
}

/// The index of the brightest of some lookups, the last one of several.
#[inline(always)]
fn brightest_of(
    lookups: &[EnvironmentLookup],
    luminances: &[f32; MAX_LOOKUPS],
    is_one: impl Fn(&EnvironmentLookup) -> bool,
) -> Option<usize> {
    let mut brightest = None;
    let mut most = f32::NEG_INFINITY;
    for (index, (lookup, &luminance)) in lookups.iter().zip(luminances).enumerate() {
        if is_one(lookup) && luminance >= most {
            (brightest, most) = (Some(index), luminance);
        }
    }
    brightest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faint_lookups_join_the_brightest_of_their_side() {
        let lookup = |radiance: f32, normal: Vec3| EnvironmentLookup {
            radiance: Vec3::splat(radiance),
            albedo: Vec3::ONE,
            lobe: LookupLobe::Diffuse { normal },
            is_outside: normal == Vec3::Y,
        };
        let mut lookups: EnvironmentLookups =
            [lookup(0.1, Vec3::Y), lookup(1.0, Vec3::Y), lookup(0.5, Vec3::Y), lookup(0.05, Vec3::NEG_Y)]
                .into_iter()
                .collect();
        let brightest = join_faint(&mut lookups, Vec3::ZERO, |_| true);
        assert_eq!(brightest, Some(1));
        let left: Vec<[f32; 2]> = lookups.iter().map(|lookup| [lookup.radiance.x, lookup.albedo.x]).collect();
        assert_eq!(left, [[0.0, 0.0], [1.1, 2.0], [0.5, 1.0], [0.05, 1.0]]);
        assert_eq!(join_faint(&mut lookups, Vec3::ZERO, |lookup| !lookup.is_outside), Some(3));
        // In the dark, what hides the environment decides.
        let dark = |albedo: f32| EnvironmentLookup { albedo: Vec3::splat(albedo), ..lookup(0.0, Vec3::Y) };
        let mut lookups = [dark(0.8), dark(0.0)];
        assert_eq!(join_faint(&mut lookups, Vec3::ONE, |_| true), Some(0));
        assert_eq!(lookups.map(|lookup| lookup.albedo.x), [0.8, 0.0]);
    }

    #[test]
    fn pairs_join_as_all_lookups_do() {
        let mean_radiance = Vec3::new(0.3, 0.2, 0.4);
        for [first, second] in [[1.0, 1.0], [1.0, 0.1], [0.1, 1.0], [0.3, 0.2], [0.0, 0.0], [1.0, 0.0]] {
            let light =
                |radiance: f32| [Vec3::new(radiance, 0.7 * radiance, 0.2), Vec3::splat(radiance * 0.9)];
            let lookup = |[radiance, albedo]: [Vec3; 2]| EnvironmentLookup {
                radiance,
                albedo,
                lobe: LookupLobe::Diffuse { normal: Vec3::Y },
                is_outside: true,
            };
            let mut pair = [light(first), light(second)];
            let mut lookups = pair.map(lookup);
            let is_second = join_faint_pair(&mut pair, mean_radiance);
            assert_eq!(join_faint(&mut lookups, mean_radiance, |_| true), Some(usize::from(is_second)));
            assert_eq!(pair.map(lookup), lookups, "{first} {second}");
        }
    }
}
