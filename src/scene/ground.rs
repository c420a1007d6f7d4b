//! The ground: an invisible plane below the scene that shows shadows, and mirror images if asked.

use glam::Vec3;

use crate::geometry::Ray;

/// An unbounded plane that is visible from above only. It is no geometry of the scene: it is not in the hierarchy, occludes
/// nothing, and no AOV but colour and alpha knows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Unit normal.
    pub up: Vec3,
    /// Distance from the origin along the normal, metres.
    pub height: f32,
    /// Whether it also shows mirror images.
    pub is_mirror: bool,
}

impl Ground {
    /// The parameter at which a ray hits the upper side.
    pub fn hit(&self, ray: &Ray) -> Option<f32> {
        let (above, descent) = (self.up.dot(ray.origin) - self.height, -self.up.dot(ray.direction));
        if above <= 0.0 || descent <= 0.0 {
            return None;
        }
        let t = above / descent;
        (t > ray.t_min && t < ray.t_max).then_some(t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_rays_from_above_hit_the_ground() {
        let ground = Ground { up: Vec3::Y, height: -1.0, is_mirror: false };
        let from = |height: f32, direction: Vec3| ground.hit(&Ray::new(Vec3::Y * height, direction));
        assert_eq!(from(2.0, Vec3::NEG_Y), Some(3.0));
        assert_eq!(from(1.0, Vec3::new(0.6, -0.8, 0.0)), Some(2.5));
        assert_eq!((from(2.0, Vec3::Y), from(2.0, Vec3::X)), (None, None));
        assert_eq!(
            (from(-2.0, Vec3::Y), from(-2.0, Vec3::NEG_Y), from(-1.0, Vec3::NEG_Y)),
            (None, None, None)
        );
        let near = Ray { t_max: 3.0, ..Ray::new(Vec3::Y * 2.0, Vec3::NEG_Y) };
        assert_eq!(ground.hit(&near), None);
    }
}
