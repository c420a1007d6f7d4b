//! Cameras.
//!
//! Source: glTF 2.0 specification, section 3.10 (cameras).

use gltf::json;
use gltf::json::camera::Type;
use gltf::json::validation::Checked;

use super::context::Context;
use super::document::Document;
use super::raw::{ANY, check_range};
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
    let z_far = match perspective.zfar {
        Some(far) => Some(positive(context, far, pointer, "zfar")?),
        None => None,
    };
    if let Some(far) = z_far {
        check_order(context, z_near, far, pointer)?;
    }
    Ok(Projection::Perspective { fov_y_radians, aspect_ratio, z_near, z_far })
}

fn orthographic(
    context: &mut Context,
    orthographic: &json::camera::Orthographic,
    pointer: &str,
) -> Result<Projection> {
    if orthographic.xmag < 0.0 || orthographic.ymag < 0.0 {
        let message = "negative magnifications of orthographic cameras are taken as positive";
        context.warn(pointer, message);
    }
    let z_near = check_range(context, orthographic.znear, &(0.0..=f32::MAX), &format!("{pointer}/znear"))?;
    let z_far = positive(context, orthographic.zfar, pointer, "zfar")?;
    check_order(context, z_near, z_far, pointer)?;
    Ok(Projection::Orthographic {
        x_mag: positive(context, orthographic.xmag.abs(), pointer, "xmag")?,
        y_mag: positive(context, orthographic.ymag.abs(), pointer, "ymag")?,
        z_near,
        z_far,
    })
}

fn positive(context: &Context, value: f32, pointer: &str, key: &str) -> Result<f32> {
    let pointer = format!("{pointer}/{key}");
    if value <= 0.0 {
        return Err(context.invalid(pointer, format!("is {value}, but must be greater than 0")));
    }
    check_range(context, value, &ANY, &pointer)
}

fn check_order(context: &Context, near: f32, far: f32, pointer: &str) -> Result<()> {
    if far > near {
        return Ok(());
    }
    let message = format!("is {far}, but must be greater than znear, {near}");
    Err(context.invalid(format!("{pointer}/zfar"), message))
}
