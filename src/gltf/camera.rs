//! Cameras.
//!
//! Source: glTF 2.0 specification, section 3.10 (cameras).

use gltf::json;
use gltf::json::camera::Type;
use gltf::json::validation::Checked;

use super::context::Context;
use super::document::Document;
use super::raw::{NOT_NEGATIVE, POSITIVE, check_range};
use crate::error::Result;
use crate::scene::{Camera, Projection};

/// Imports all cameras.
pub(super) fn import(context: &mut Context, document: &Document) -> Result<Vec<Camera>> {
    let mut cameras = Vec::new();
    for (i, camera) in document.root.cameras.iter().enumerate() {
        cameras.push(Camera {
            name: camera.name.clone(),
            projection: projection(context, camera, &format!("/cameras/{i}"))?,
        });
    }
    Ok(cameras)
}

fn projection(context: &mut Context, camera: &json::Camera, pointer: &str) -> Result<Projection> {
    match (&camera.type_, &camera.perspective, &camera.orthographic) {
        (Checked::Valid(Type::Perspective), Some(perspective), _) => {
            self::perspective(context, perspective, &format!("{pointer}/perspective"))
        }
        (Checked::Valid(Type::Orthographic), _, Some(orthographic)) => {
            self::orthographic(context, orthographic, &format!("{pointer}/orthographic"))
        }
        (Checked::Valid(_), _, _) => Err(context.invalid(pointer, "lacks the object that its type names")),
        (Checked::Invalid, _, _) => {
            Err(context.invalid(format!("{pointer}/type"), "must be perspective or orthographic"))
        }
    }
}

fn perspective(
    context: &mut Context,
    perspective: &json::camera::Perspective,
    pointer: &str,
) -> Result<Projection> {
    let fov_y_radians = positive(context, perspective.yfov, pointer, "yfov")?;
    if fov_y_radians >= std::f32::consts::PI {
        let message = format!("is {fov_y_radians}, but must be less than π");
        return Err(context.invalid(format!("{pointer}/yfov"), message));
    }
    let aspect_ratio = match perspective.aspect_ratio {
        Some(ratio) => Some(positive(context, ratio, pointer, "aspectRatio")?),
        None => None,
    };
    let z_near = positive(context, perspective.znear, pointer, "znear")?;
    // Some programs write the largest 64-bit float for none.
    let z_far = match perspective.zfar.filter(|far| *far != f32::INFINITY) {
        Some(far) => Some(positive(context, far, pointer, "zfar")?),
        None => None,
    };
    if let Some(far) = z_far {
        check_planes(context, z_near, far, pointer)?;
    }
    Ok(Projection::Perspective { fov_y_radians, aspect_ratio, z_near, z_far })
}

fn orthographic(
    context: &mut Context,
    orthographic: &json::camera::Orthographic,
    pointer: &str,
) -> Result<Projection> {
    if orthographic.xmag < 0.0 || orthographic.ymag < 0.0 {
        warn_of_negative_magnification(context, pointer);
    }
    let z_near = check_range(context, orthographic.znear, &NOT_NEGATIVE, &format!("{pointer}/znear"))?;
    let z_far = positive(context, orthographic.zfar.min(f32::MAX), pointer, "zfar")?;
    check_planes(context, z_near, z_far, pointer)?;
    Ok(Projection::Orthographic {
        x_mag: positive(context, orthographic.xmag.abs(), pointer, "xmag")?,
        y_mag: positive(context, orthographic.ymag.abs(), pointer, "ymag")?,
        z_near,
        z_far,
    })
}

fn positive(context: &Context, value: f32, pointer: &str, key: &str) -> Result<f32> {
    check_range(context, value, &POSITIVE, &format!("{pointer}/{key}"))
}

/// Warns of a negative magnification, whose sign has no effect. `pointer` names the camera or the values of an animation.
pub(super) fn warn_of_negative_magnification(context: &mut Context, pointer: &str) {
    context.warn(pointer, "negative magnifications of orthographic cameras are taken as positive");
}

/// Errors unless the far plane is beyond the near one. `pointer` names the camera or the values of an animation.
pub(super) fn check_planes(context: &Context, near: f32, far: f32, pointer: &str) -> Result<()> {
    if far > near {
        return Ok(());
    }
    Err(context.invalid(pointer, format!("zfar is {far}, but must be greater than znear, {near}")))
}
