//! The scene at one time: world-space triangles with their attributes, materials, lights and the camera.

use glam::{Mat4, Vec3};

use crate::bvh::PrimitiveFlags;
use crate::geometry::Triangle;
use crate::scene::{Light, Material, Projection, Scene, Selection};

/// Everything that is drawn at one time; a pure function of (scene, selection, time).
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// World-space triangles; the subscript is the primitive id, the same in every frame.
    pub triangles: Vec<Triangle>,
    /// One a triangle.
    pub flags: Vec<PrimitiveFlags>,
    /// Materials at this time, by [`crate::scene::MaterialIndex`].
    pub materials: Vec<Material>,
    /// Lights at this time.
    pub lights: Vec<PosedLight>,
    /// The camera at this time.
    pub camera: PosedCamera,
}

/// A light in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct PosedLight {
    /// Metres.
    pub position: Vec3,
    /// Unit vector in which the light shines.
    pub direction: Vec3,
    /// Its colour, intensity and shape.
    pub light: Light,
}

/// A camera in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PosedCamera {
    /// Rotation and translation; columns are right, up, backward, position.
    pub world_from_camera: Mat4,
    /// Its projection.
    pub projection: Projection,
}

impl Default for PosedCamera {
    fn default() -> Self {
        Self {
            world_from_camera: Mat4::IDENTITY,
            projection: Projection::Perspective {
                fov_y_radians: std::f32::consts::FRAC_PI_4,
                aspect_ratio: None,
                z_near: 0.0,
                z_far: None,
            },
        }
    }
}

impl Frame {
    /// Poses `scene` at `time_seconds`, reusing the memory of `self`.
    pub fn pose(&mut self, scene: &Scene, selection: &Selection, time_seconds: f64) {
        let _ = (scene, selection, time_seconds);
    }

    /// The scene at `time_seconds` as a new value.
    pub fn at(scene: &Scene, selection: &Selection, time_seconds: f64) -> Self {
        let mut frame = Self::default();
        frame.pose(scene, selection, time_seconds);
        frame
    }
}
