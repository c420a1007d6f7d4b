//! The camera of a job in words.

use glam::{Mat4, Vec3};

use rayframe::framing::{CameraRule, ResolvedCamera, resolve_camera};
use rayframe::scene::{Projection, Scene, SelectedCamera, Selection, ViewRequest, look_along};

/// `camera "name"`, or what decided the camera, with the options that keep an automatic one. A camera with a name is called `known_as`, if anything.
pub(super) fn camera_text(
    scene: &Scene,
    selection: &Selection,
    rule: CameraRule,
    known_as: Option<&str>,
) -> String {
    let label = || match known_as.filter(|_| selection.camera_name(scene).is_some()) {
        Some(name) => format!("camera \"{name}\""),
        None => selection.camera_label(scene),
    };
    let options = match &selection.camera {
        &SelectedCamera::Fixed { world_from_camera, projection } => {
            placing_options(world_from_camera, &projection)
        }
        _ => String::new(),
    };
    match rule {
        CameraRule::Changed => format!("{} changed", label()),
        CameraRule::Requested => "camera as requested".to_owned(),
        CameraRule::Turntable => "camera on a turntable".to_owned(),
        CameraRule::Outside => format!("camera auto outside ({options})"),
        CameraRule::Inside => format!("camera auto inside ({options})"),
        _ => label(),
    }
}

/// The camera that `selection` gives an image of the default aspect ratio.
pub(super) fn default_camera_text(scene: &Scene, selection: &Selection) -> String {
    let view = ViewRequest::default();
    let ResolvedCamera { selection, rule } = resolve_camera(scene, selection.clone(), &view, 16.0 / 9.0);
    camera_text(scene, &selection, rule, None)
}

/// Options that place the camera alike.
fn placing_options(camera: Mat4, projection: &Projection) -> String {
    let position = camera.w_axis.truncate();
    let (distance, lens) = match *projection {
        Projection::Perspective { fov_y_radians, .. } => {
            (position.length().max(1.0), format!(" --fov {}", rounded(fov_y_radians.to_degrees())))
        }
        // A parallel view is as high as one of 45 degrees at the point looked at.
        Projection::Orthographic { y_mag, .. } => {
            (y_mag / libm::tanf(std::f32::consts::FRAC_PI_8), " --ortho".to_owned())
        }
    };
    let ahead = position - camera.z_axis.truncate() * distance;
    let [position, ahead] = [position, ahead].map(|point| point_text(point, distance));
    let roll = rounded(roll_degrees(camera));
    let roll = if roll == "0" { String::new() } else { format!(" --roll {roll}") };
    format!("--camera-position {position} --look-at {ahead}{lens}{roll}")
}

/// The roll of a camera against one that looks there with +Y up, to a thousandth of a degree.
fn roll_degrees(camera: Mat4) -> f32 {
    let unrolled = look_along(Vec3::ZERO, camera.z_axis.truncate(), Vec3::Y);
    let (sine, cosine) = (-camera.y_axis.dot(unrolled.x_axis), camera.y_axis.dot(unrolled.y_axis));
    let degrees = (libm::atan2f(sine, cosine).to_degrees() * 1000.0).round() / 1000.0;
    if degrees == -180.0 { 180.0 } else { degrees }
}

/// Coordinates with digits that tell a ten-thousandth of `distance`, and six significant ones at least.
fn point_text(point: Vec3, distance: f32) -> String {
    let decimals = (4 - libm::log10f(distance.max(1e-9)).floor() as i32).clamp(0, 12) as usize;
    let text = |number: f32| {
        let (rounded, fine) = (rounded(number), trimmed(&format!("{number:.decimals$}")));
        if fine.len() > rounded.len() { fine } else { rounded }
    };
    point.to_array().map(text).join(",")
}

/// Six significant digits.
fn rounded(number: f32) -> String {
    let digits = 5 - (libm::log10f(number.abs().max(1e-9)).floor() as i32);
    trimmed(&format!("{number:.*}", digits.clamp(0, 12) as usize))
}

/// The decimal number without zeros at its end, and without the sign of zero.
fn trimmed(text: &str) -> String {
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use rayframe::scene::rolled;

    use super::*;

    #[test]
    fn numbers_have_six_digits() {
        assert_eq!(rounded(1.234_567_8), "1.23457");
        assert_eq!(rounded(-0.0), "0");
        assert_eq!(rounded(12345.678), "12345.7");
        assert_eq!(rounded(45.0), "45");
        assert_eq!(rounded(2_000_000.0), "2000000");
    }

    #[test]
    fn the_options_place_the_camera_alike() {
        let projection = Projection::Perspective {
            fov_y_radians: std::f32::consts::FRAC_PI_4,
            aspect_ratio: None,
            z_near: 0.0,
            z_far: None,
        };
        let camera = Mat4::from_translation(Vec3::new(0.0, 0.0, 4.0));
        let expected = "--camera-position 0,0,4 --look-at 0,0,0 --fov 45";
        assert_eq!(placing_options(camera, &projection), expected);
        let sideways = rolled(camera, 0.5);
        let expected = "--camera-position 0,0,4 --look-at 0,0,0 --fov 45 --roll 28.648";
        assert_eq!(placing_options(sideways, &projection), expected);
        let half = 3.0 * libm::tanf(std::f32::consts::FRAC_PI_8);
        let parallel = Projection::Orthographic { x_mag: half, y_mag: half, z_near: 0.0, z_far: f32::MAX };
        let expected = "--camera-position 0,0,4 --look-at 0,0,1 --ortho";
        assert_eq!(placing_options(camera, &parallel), expected);
        // Far from the origin, the two points differ in their last digits.
        let half = 0.02 * libm::tanf(std::f32::consts::FRAC_PI_8);
        let parallel = Projection::Orthographic { x_mag: half, y_mag: half, z_near: 0.0, z_far: f32::MAX };
        let far = Mat4::from_translation(Vec3::new(0.0, 0.0, 128.5));
        let expected = "--camera-position 0,0,128.5 --look-at 0,0,128.479996 --ortho";
        assert_eq!(placing_options(far, &parallel), expected);
    }
}
