//! Shares of the light of the environment that Whitted's tree traces. They fade out as the camera enters a closed space, where few shadow rays would find any
//! light: the light that such a space has on average stands for the rest.

use glam::Vec3;

use super::closed_space::{ClosedSpace, EnclosedLight, open_share};
use crate::geometry::smoothstep;
use crate::scene_view::SceneView;

/// Shadows of the environment begin where a camera sees it in this share of all directions, and are full at the second share.
const OPEN_SHARES: [f32; 2] = [0.05, 0.15];
/// Their occluders reflect light from the first of these shares on, and all of it at the second.
const BOUNCE_SHARES: [f32; 2] = [0.15, 0.25];
/// What walls see of it counts where a camera sees less of it than the second of these shares, and alone where that is less than the first.
const WALL_SHARES: [f32; 2] = [0.25, EnvironmentShares::OPEN];

/// What is traced of the light of the environment, each from 0 to 1, and what stands for the rest.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentShares {
    /// Share of the light of surfaces by it that shadow rays decide about.
    pub occluded: f32,
    /// Share of what their occluders reflect of it.
    pub bounced: f32,
    /// The light of surfaces for the share that is not occluded; `None` for that of the environment, as if nothing were in between.
    pub enclosed: Option<EnclosedLight>,
}

/// The shares of one time.
#[derive(Clone, Debug)]
pub struct SharesOfTime {
    occluded: f32,
    bounced: f32,
    /// `None` where all is occluded.
    space: Option<ClosedSpace>,
    /// The same without the environment, where its intensity is animated.
    dark_space: Option<ClosedSpace>,
}

impl SharesOfTime {
    /// All is traced, as in front of a convex object.
    pub const ALL: Self = Self { occluded: 1.0, bounced: 1.0, space: None, dark_space: None };

    /// Those of a camera at `position`, metres: by the share of all directions in which it sees the environment, past glass and surfaces that are more than
    /// half transparent, and by that of the walls around it.
    pub fn seen_from(view: SceneView<'_>, position: Vec3) -> Self {
        let seen = open_share(view, position);
        if seen >= EnvironmentShares::OPEN {
            return Self::ALL;
        }
        let space = ClosedSpace::around(view, position);
        let of_walls = space.open_share();
        let open_share = of_camera_and_walls(seen, of_walls);
        let [occluded, bounced] =
            [OPEN_SHARES, BOUNCE_SHARES].map(|closed_and_open| smoothstep(closed_and_open, open_share));
        let openings = if of_walls > seen { of_walls } else { seen };
        let space = (occluded < 1.0).then(|| space.with_openings(view, openings));
        Self { occluded, bounced, space, dark_space: None }
    }

    /// Those of an environment whose intensity is animated: `self` is that of one, `dark` is the same view and position at an intensity of zero.
    #[must_use]
    pub fn with_dark(self, dark: Self) -> Self {
        Self { dark_space: dark.space, ..self }
    }
}

/// The share of directions that decides. A camera at a window sees much of the environment from a closed space: as much as its walls do counts.
fn of_camera_and_walls(of_camera: f32, of_walls: f32) -> f32 {
    let least = if of_walls < of_camera { of_walls } else { of_camera };
    least + (of_camera - least) * smoothstep(WALL_SHARES, of_camera)
}

impl EnvironmentShares {
    /// The share of all directions from which on all is traced, where a camera sees the environment in them.
    pub const OPEN: f32 = 0.4;
    /// All is traced, as in front of a convex object.
    pub const ALL: Self = Self { occluded: 1.0, bounced: 1.0, enclosed: None };
    /// Nothing is.
    pub const NONE: Self = Self { occluded: 0.0, bounced: 0.0, enclosed: None };

    /// Those of an animation with shares at several times; all of the light where there are none. The mean decides about shadows, and the least about
    /// reflections: in closed spaces few rays find much light, which a small share of it would leave as white dots.
    pub fn of_times(times: &[SharesOfTime]) -> Self {
        if times.is_empty() {
            return Self::ALL;
        }
        let sum: f64 = times.iter().map(|time| f64::from(time.occluded)).sum();
        let bounced = times.iter().map(|time| time.bounced);
        let light_of = |space: fn(&SharesOfTime) -> Option<&ClosedSpace>| {
            let spaces = times.iter().filter_map(|time| Some((space(time)?, 1.0 - time.occluded)));
            EnclosedLight::new(&spaces.collect::<Vec<_>>())
        };
        let dark = light_of(|time| time.dark_space.as_ref());
        let enclosed = light_of(|time| time.space.as_ref()).map(|light| match dark {
            Some(dark) => light.with_dark(dark),
            None => light,
        });
        Self {
            occluded: (sum / times.len() as f64) as f32,
            bounced: bounced.reduce(|a, b| if b < a { b } else { a }).unwrap_or(1.0),
            enclosed,
        }
    }

    /// Those of a frame whose environment has this intensity.
    #[must_use]
    pub(super) fn at_intensity(&self, intensity: f32) -> Self {
        let enclosed = self.enclosed.as_ref().map(|light| light.at_intensity(intensity));
        Self { enclosed, ..*self }
    }

    /// Numbers that tell them from any others.
    pub fn bits(&self) -> Vec<u32> {
        let Self { occluded, bounced, enclosed } = self;
        let light = enclosed.iter().flat_map(EnclosedLight::bits);
        [occluded.to_bits(), bounced.to_bits()].into_iter().chain(light).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use std::f32::consts::PI;

    fn time(occluded: f32, bounced: f32, space: Option<(f32, bool)>) -> SharesOfTime {
        let space = space.map(|(radiance, is_lit)| ClosedSpace::uniform(radiance * PI, is_lit));
        SharesOfTime { occluded, bounced, space, dark_space: None }
    }

    fn mean_light(times: &[SharesOfTime]) -> Option<f32> {
        EnvironmentShares::of_times(times).enclosed.map(|light| light.mean_radiance().x)
    }

    #[test]
    fn equal_shares_are_those_of_the_animation_to_the_bit() {
        let shares = EnvironmentShares { occluded: 0.1, bounced: 0.7, enclosed: None };
        assert_eq!(EnvironmentShares::of_times(&vec![time(0.1, 0.7, None); 7]), shares);
        let with_closed = EnvironmentShares::of_times(&[time(0.0, 0.0, None), time(0.1, 0.7, None)]);
        assert_eq!(with_closed, EnvironmentShares { occluded: 0.05, bounced: 0.0, enclosed: None });
        assert_eq!(EnvironmentShares::of_times(&[]), EnvironmentShares::ALL);
    }

    #[test]
    fn the_light_of_closed_spaces_counts_by_what_is_not_occluded() {
        // Open times have no part in it.
        let times = [time(0.0, 0.0, Some((3.0, true))), SharesOfTime::ALL, time(0.5, 0.0, Some((6.0, true)))];
        assert_eq!(EnvironmentShares::of_times(&times).occluded, 0.5);
        assert!(mean_light(&times).is_some_and(|mean| (mean - 4.0).abs() < 1e-3), "{:?}", mean_light(&times));
        // Those without any opening have.
        let times = [time(0.0, 0.0, Some((0.0, true))), time(0.0, 0.0, Some((1.0, false)))];
        assert!(mean_light(&times).is_some_and(|mean| (mean - 0.5).abs() < 1e-3), "{:?}", mean_light(&times));
        assert_eq!(mean_light(&times[1..]), None);
    }

    #[test]
    fn a_camera_at_a_window_is_in_the_space_behind_it() {
        let found = [(0.1, 0.03), (0.1, 0.3), (0.03, 0.3), (0.325, 0.04), (0.4, 0.04)]
            .map(|(of_camera, of_walls)| of_camera_and_walls(of_camera, of_walls));
        for (found, expected) in found.into_iter().zip([0.03, 0.1, 0.03, 0.1825, 0.4]) {
            assert!((found - expected).abs() < 1e-6, "{found}, expected {expected}");
        }
    }

    #[test]
    fn the_enclosed_light_tells_shares_apart() {
        let bits = |radiance| EnvironmentShares::of_times(&[time(0.0, 0.0, Some((radiance, true)))]).bits();
        assert_ne!(bits(1.0), bits(1.5));
        assert_ne!(bits(1.0), EnvironmentShares::NONE.bits());
        assert_eq!(bits(1.0), bits(1.0));
    }
}
