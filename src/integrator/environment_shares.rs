//! Shares of the light of the environment that Whitted's tree traces. They fade out as the camera enters a closed space, which would be black without more
//! bounces.

use glam::Vec3;

use super::walls::is_wall;
use crate::bvh::{Hit, TraversalCounters};
use crate::geometry::{Ray, smoothstep, spiral_direction};
use crate::scene_view::SceneView;

/// Shadows of the environment begin where a camera sees it in this share of all directions, and are full at the second share.
const OPEN_SHARES: [f32; 2] = [0.05, 0.15];
/// Their occluders reflect light from the first of these shares on, and all of it at the second.
const BOUNCE_SHARES: [f32; 2] = [0.15, EnvironmentShares::OPEN];
/// Rays that find how much of the environment a camera sees.
const OPENNESS_RAYS: u32 = 2048;

/// What is traced of the light of the environment, each from 0 to 1. The rest arrives as if nothing were in between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvironmentShares {
    /// Share of its light that shadow rays decide about.
    pub occluded: f32,
    /// Share of what their occluders reflect of it.
    pub bounced: f32,
}

impl EnvironmentShares {
    /// The share of all directions from which on all is traced, where a camera sees the environment in them.
    pub const OPEN: f32 = 0.25;
    /// All is traced, as in front of a convex object.
    pub const ALL: Self = Self { occluded: 1.0, bounced: 1.0 };
    /// Nothing is.
    pub const NONE: Self = Self { occluded: 0.0, bounced: 0.0 };

    /// Those of a camera at `position`, metres: by the share of all directions in which it sees the environment, past glass and surfaces that are more than
    /// half transparent.
    pub fn seen_from(view: SceneView<'_>, position: Vec3) -> Self {
        let open_share = open_share(view, position);
        let [occluded, bounced] =
            [OPEN_SHARES, BOUNCE_SHARES].map(|closed_and_open| smoothstep(closed_and_open, open_share));
        Self { occluded, bounced }
    }

    /// Those of an animation with `shares` at several times; all of the light where there are none. The mean decides about shadows, and the least about
    /// reflections: in closed spaces few rays find much light, which a small share of it would leave as white dots.
    pub fn of_animation(shares: &[Self]) -> Self {
        if shares.is_empty() {
            return Self::ALL;
        }
        let sum: f64 = shares.iter().map(|shares| f64::from(shares.occluded)).sum();
        let bounced = shares.iter().map(|shares| shares.bounced);
        Self {
            occluded: (sum / shares.len() as f64) as f32,
            bounced: bounced.reduce(|a, b| if b < a { b } else { a }).unwrap_or(1.0),
        }
    }
}

fn open_share(view: SceneView<'_>, position: Vec3) -> f32 {
    let mut counters = TraversalCounters::default();
    let directions = (0..OPENNESS_RAYS).map(|index| spiral_direction(index, OPENNESS_RAYS));
    let hides = |hit: &Hit| is_wall(view, hit, |_| true);
    let is_open = |direction| !view.bvh.occluded(&Ray::new(position, direction), hides, &mut counters);
    directions.map(is_open).filter(|is_open| *is_open).count() as f32 / OPENNESS_RAYS as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_shares_are_those_of_the_animation_to_the_bit() {
        let shares = EnvironmentShares { occluded: 0.1, bounced: 0.7 };
        assert_eq!(EnvironmentShares::of_animation(&[shares; 7]), shares);
        let with_closed = EnvironmentShares::of_animation(&[EnvironmentShares::NONE, shares]);
        assert_eq!(with_closed, EnvironmentShares { occluded: 0.05, bounced: 0.0 });
        assert_eq!(EnvironmentShares::of_animation(&[]), EnvironmentShares::ALL);
    }
}
