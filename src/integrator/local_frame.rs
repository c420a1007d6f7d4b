//! Local shading frames and mirror directions.

use glam::{Mat3, Vec3};

use crate::geometry::unit;
use crate::interaction::AnisotropySample;

/// Direction of the mirror ray. It leaves the surface because the shading normal is bent towards the viewer.
#[inline(always)]
pub(super) fn mirror_direction(wo: Vec3, normal: Vec3) -> Vec3 {
    let mirrored = normal * (2.0 * wo.dot(normal)) - wo;
    mirrored * (1.0 / mirrored.dot(mirrored).sqrt())
}

/// Orthonormal frame around a unit normal (Duff et al. 2017, "Building an Orthonormal Basis, Revisited"). Its columns are
/// tangent, bitangent and normal.
#[inline(always)]
pub(super) fn local_frame(normal: Vec3) -> Mat3 {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    Mat3::from_cols(tangent, bitangent, normal)
}

/// The frame in which the lobes of a surface are evaluated: along its anisotropy, where it has any.
#[inline(always)]
pub(super) fn shading_frame(normal: Vec3, anisotropy: Option<&AnisotropySample>) -> Mat3 {
    anisotropy.map_or_else(|| local_frame(normal), |anisotropy| frame_along(normal, anisotropy.direction))
}

/// Orthonormal frame around a unit normal whose tangent is the projection of `direction` onto the tangent plane.
fn frame_along(normal: Vec3, direction: Vec3) -> Mat3 {
    match unit(direction - normal * normal.dot(direction)) {
        Some(tangent) => Mat3::from_cols(tangent, normal.cross(tangent), normal),
        None => local_frame(normal),
    }
}
