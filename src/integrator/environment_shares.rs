//! Shares of the light of the environment that Whitted's tree traces. They fade out as the camera enters a closed space, where few shadow rays would find any
//! light: the light that such a space has on average stands for the rest.

use glam::Vec3;

use super::closed_space::{enclosed_light, open_share, unenclosed_light};
use super::enclosed_light::EnclosedLight;
use crate::geometry::smoothstep;
use crate::scene::Environment;
use crate::scene_view::SceneView;

/// Shadows of the environment begin where a camera sees it in this share of all directions, and are full at the second share.
const OPEN_SHARES: [f32; 2] = [0.05, 0.15];
/// Their occluders reflect light from the first of these shares on, and all of it at the second.
const BOUNCE_SHARES: [f32; 2] = [0.15, EnvironmentShares::OPEN];

/// What is traced of the light of the environment, each from 0 to 1, and what stands for the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvironmentShares {
    /// Share of the light of surfaces by it that shadow rays decide about.
    pub occluded: f32,
    /// Share of what their occluders reflect of it.
    pub bounced: f32,
    /// The light of surfaces for the share that is not occluded; `None` for that of the environment, as if nothing were in between.
    pub enclosed: Option<EnclosedLight>,
}

impl EnvironmentShares {
    /// The share of all directions from which on all is traced, where a camera sees the environment in them.
    pub const OPEN: f32 = 0.25;
    /// All is traced, as in front of a convex object.
    pub const ALL: Self = Self { occluded: 1.0, bounced: 1.0, enclosed: None };
    /// Nothing is.
    pub const NONE: Self = Self { occluded: 0.0, bounced: 0.0, enclosed: None };

    /// Those of a camera at `position`, metres: by the share of all directions in which it sees the environment, past glass and surfaces that are more than
    /// half transparent.
    pub fn seen_from(view: SceneView<'_>, position: Vec3) -> Self {
        let open_share = open_share(view, position);
        let [occluded, bounced] =
            [OPEN_SHARES, BOUNCE_SHARES].map(|closed_and_open| smoothstep(closed_and_open, open_share));
        let enclosed = if occluded < 1.0 && view.environment.is_lit() {
            enclosed_light(view, position, open_share)
        } else {
            None
        };
        Self { occluded, bounced, enclosed }
    }

    /// Those of an animation with shares and environments at several times; all of the light where there are none. The mean decides about shadows, and the least about
    /// reflections: in closed spaces few rays find much light, which a small share of it would leave as white dots.
    pub fn of_animation(times: &[(Self, Environment)]) -> Self {
        if times.is_empty() {
            return Self::ALL;
        }
        let sum: f64 = times.iter().map(|(shares, _)| f64::from(shares.occluded)).sum();
        let bounced = times.iter().map(|(shares, _)| shares.bounced);
        Self {
            occluded: (sum / times.len() as f64) as f32,
            bounced: bounced.reduce(|a, b| if b < a { b } else { a }).unwrap_or(1.0),
            enclosed: Self::mean_enclosed(times),
        }
    }

    /// Numbers that tell them from any others.
    pub fn bits(&self) -> Vec<u32> {
        let Self { occluded, bounced, enclosed } = self;
        let light = enclosed.iter().flat_map(EnclosedLight::bits);
        [occluded.to_bits(), bounced.to_bits()].into_iter().chain(light).collect()
    }

    /// The mean of what is not occluded.
    fn mean_enclosed(times: &[(Self, Environment)]) -> Option<EnclosedLight> {
        times.iter().find(|(shares, _)| shares.enclosed.is_some())?;
        let closed = times.iter().filter(|(shares, _)| shares.occluded < 1.0);
        let lights = closed.map(|(shares, environment)| {
            (shares.enclosed.unwrap_or_else(|| unenclosed_light(environment)), 1.0 - shares.occluded)
        });
        Some(EnclosedLight::mean(&lights.collect::<Vec<_>>()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_animation(shares: &[EnvironmentShares]) -> EnvironmentShares {
        let times: Vec<_> = shares.iter().map(|shares| (*shares, Environment::Constant(Vec3::ONE))).collect();
        EnvironmentShares::of_animation(&times)
    }

    #[test]
    fn equal_shares_are_those_of_the_animation_to_the_bit() {
        let shares = EnvironmentShares { occluded: 0.1, bounced: 0.7, enclosed: None };
        assert_eq!(of_animation(&[shares; 7]), shares);
        let with_closed = of_animation(&[EnvironmentShares::NONE, shares]);
        assert_eq!(with_closed, EnvironmentShares { occluded: 0.05, bounced: 0.0, enclosed: None });
        assert_eq!(of_animation(&[]), EnvironmentShares::ALL);
    }

    #[test]
    fn the_light_of_closed_spaces_counts_by_what_is_not_occluded() {
        let dim = EnclosedLight::new([(Vec3::X, Vec3::ZERO, 1.0)]);
        let closed = EnvironmentShares { enclosed: Some(dim), ..EnvironmentShares::NONE };
        // Open times have no part in it, and those without any opening have the whole environment.
        let found =
            of_animation(&[closed, EnvironmentShares::ALL, EnvironmentShares { occluded: 0.5, ..closed }]);
        assert_eq!((found.occluded, found.enclosed), (0.5, Some(dim)));
        let found = of_animation(&[closed, EnvironmentShares::NONE]);
        let mean = found.enclosed.map(|light| light.mean_radiance().x);
        assert!(mean.is_some_and(|mean| (mean - 0.5).abs() < 1e-3), "{mean:?}");
    }

    #[test]
    fn times_without_openings_have_their_own_environment() {
        let dim = EnclosedLight::new([(Vec3::X, Vec3::ZERO, 1.0)]);
        let closed = EnvironmentShares { enclosed: Some(dim), ..EnvironmentShares::NONE };
        let [none, two, six] = [0.0, 2.0, 6.0].map(|radiance| Environment::Constant(Vec3::splat(radiance)));
        let times = [(closed, none), (EnvironmentShares::NONE, two), (EnvironmentShares::NONE, six)];
        // (0 + 2 + 6) / 3
        let mean = EnvironmentShares::of_animation(&times).enclosed.map(|light| light.mean_radiance().x);
        assert!(mean.is_some_and(|mean| (mean - 8.0 / 3.0).abs() < 1e-2), "{mean:?}");
    }
}
