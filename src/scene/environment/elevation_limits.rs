//! Limits of an environment's luminance by elevation.

use glam::Vec3;

/// Steps of the sine of the elevation.
const STEPS: usize = 32;

/// The largest luminances up to elevations above a plane.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ElevationLimits {
    normal: Vec3,
    /// Up to the end of each step.
    up_to: [f32; STEPS],
}

impl ElevationLimits {
    /// The limits above a plane of a unit normal of what is interpolated between samples: unit vectors with their luminances, of which the farthest
    /// that counts is `spacing` radians away.
    pub(super) fn new(normal: Vec3, spacing: f32, samples: impl Iterator<Item = (Vec3, f32)>) -> Self {
        let mut up_to = [0.0_f32; STEPS];
        for (direction, luminance) in samples {
            // A sine changes by less than its angle.
            let sine = direction.dot(normal);
            if sine < -spacing {
                continue;
            }
            let first = ((sine - spacing).max(0.0) * STEPS as f32) as usize;
            if let Some(limit) = up_to.get_mut(first) {
                *limit = limit.max(luminance);
            }
        }
        let mut largest = 0.0_f32;
        for limit in &mut up_to {
            largest = largest.max(*limit);
            *limit = largest;
        }
        Self { normal, up_to }
    }

    /// The normal of the plane.
    pub(crate) fn normal(&self) -> Vec3 {
        self.normal
    }

    /// No luminance above the plane up to this sine of the elevation is larger.
    pub(crate) fn up_to(&self, sine: f32) -> f32 {
        self.up_to[((sine * STEPS as f32) as usize).min(STEPS - 1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::spiral_direction;

    #[test]
    fn limits_are_the_largest_luminances_up_to_an_elevation() {
        let normal = Vec3::new(0.48, 0.6, -0.64);
        let luminance = |direction: Vec3| 1.0 + 3.0 * (direction.x + direction.y * direction.z).max(0.0);
        let samples: Vec<_> =
            (0..2000).map(|i| spiral_direction(i, 2000)).map(|wi| (wi, luminance(wi))).collect();
        let limits = ElevationLimits::new(normal, 0.05, samples.iter().copied());
        for step in 0..=40 {
            let sine = step as f32 / 40.0;
            let largest = |margin: f32| {
                let near = samples.iter().filter(|(wi, _)| {
                    let height = wi.dot(normal);
                    (-margin..=sine + margin).contains(&height)
                });
                near.map(|(_, luminance)| *luminance).fold(0.0, f32::max)
            };
            let limit = limits.up_to(sine);
            assert!((largest(0.05)..=largest(0.05 + 1.0 / 32.0)).contains(&limit), "{sine}: {limit}");
        }
        // What is below the plane does not count.
        let below = ElevationLimits::new(Vec3::Y, 0.05, [(Vec3::NEG_Y, 5.0), (Vec3::X, 2.0)].into_iter());
        assert_eq!((below.up_to(0.0), below.up_to(1.0), below.normal()), (2.0, 2.0, Vec3::Y));
    }
}
