//! Attributes of a frame's EXR file.

use glam::{Mat4, Vec4};

use crate::frame::PosedCamera;
use crate::image_file::FrameAttributes;
use crate::scene::Projection;

/// Program and version, as stored in files.
pub const SOFTWARE: &str = concat!("rayframe ", env!("CARGO_PKG_VERSION"));

/// Near plane of the matrix for cameras without one, metres. It only scales the depth, which nothing uses.
const DEFAULT_NEAR: f32 = 0.01;

/// Attributes of one frame; `resolution` is that of the whole image.
pub fn frame_attributes(
    frame: i64,
    time_seconds: f64,
    frames_per_second: (i32, u32),
    render_hash: &str,
    (camera, resolution): (&PosedCamera, (u32, u32)),
) -> FrameAttributes {
    let camera_from_world = camera.world_from_camera.inverse();
    let ndc_from_world = ndc_from_camera(&camera.projection, resolution) * camera_from_world;
    FrameAttributes {
        software: SOFTWARE.to_owned(),
        render_hash: render_hash.to_owned(),
        frame: frame as i32,
        time_seconds,
        frames_per_second,
        // Adding zero turns −0 into 0.
        world_to_camera: camera_from_world.to_cols_array().map(|value| value + 0.0),
        world_to_ndc: ndc_from_world.to_cols_array().map(|value| value + 0.0),
        time_code: time_code(frame, frames_per_second),
        texts: Vec::new(),
        stamp: None,
    }
}

/// SMPTE time code without dropped frames: hours, minutes, seconds and frames.
///
/// `None` for rates that are not an integer or above 30, before frame 0, and after a day.
fn time_code(frame: i64, (numerator, denominator): (i32, u32)) -> Option<[u8; 4]> {
    let rate = u64::try_from(numerator).ok().filter(|rate| denominator == 1 && (1..=30).contains(rate))?;
    let frame = u64::try_from(frame).ok()?;
    let seconds = frame / rate;
    (seconds < 24 * 3600).then_some([
        (seconds / 3600) as u8,
        (seconds / 60 % 60) as u8,
        (seconds % 60) as u8,
        (frame % rate) as u8,
    ])
}

/// Projection from camera space to normalised device coordinates: x is 0 to 1 from left to right, y 0 to 1 from top to bottom,
/// and depth 0 at the near plane to 1 at the far plane.
pub fn ndc_from_camera(projection: &Projection, resolution: (u32, u32)) -> Mat4 {
    let half_size = projection.half_size(resolution.0 as f32 / resolution.1 as f32);
    let (scale_x, scale_y) = (1.0 / half_size.x, 1.0 / half_size.y);
    let clip_from_camera = match *projection {
        Projection::Perspective { z_near, z_far, .. } => {
            let near = if z_near > 0.0 { z_near } else { DEFAULT_NEAR };
            // Depth (a·z + b) / −z is 0 at −near and 1 at −far.
            let (a, b) = match z_far {
                Some(far) if far > near => (-far / (far - near), -far * near / (far - near)),
                _ => (-1.0, -near),
            };
            Mat4::from_cols(
                Vec4::new(scale_x, 0.0, 0.0, 0.0),
                Vec4::new(0.0, scale_y, 0.0, 0.0),
                Vec4::new(0.0, 0.0, a, -1.0),
                Vec4::new(0.0, 0.0, b, 0.0),
            )
        }
        Projection::Orthographic { z_near, z_far, .. } => {
            // The inverse is finite without a far plane, too.
            let depth = if z_far > z_near && z_far < f32::MAX { z_far - z_near } else { 1.0 };
            Mat4::from_cols(
                Vec4::new(scale_x, 0.0, 0.0, 0.0),
                Vec4::new(0.0, scale_y, 0.0, 0.0),
                Vec4::new(0.0, 0.0, -1.0 / depth, 0.0),
                Vec4::new(0.0, 0.0, -z_near / depth, 1.0),
            )
        }
    };
    let ndc_from_clip = Mat4::from_cols(
        Vec4::new(0.5, 0.0, 0.0, 0.0),
        Vec4::new(0.0, -0.5, 0.0, 0.0),
        Vec4::new(0.0, 0.0, 1.0, 0.0),
        Vec4::new(0.5, 0.5, 0.0, 1.0),
    );
    ndc_from_clip * clip_from_camera
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn assert_near(actual: Vec3, expected: Vec3) {
        assert!((actual - expected).length() < 1e-5, "{actual} is not {expected}");
    }

    #[test]
    fn a_quarter_turn_wide_pinhole_has_corners_at_45_degrees() {
        let projection = Projection::Perspective {
            fov_y_radians: std::f32::consts::FRAC_PI_2,
            aspect_ratio: None,
            z_near: 1.0,
            z_far: Some(3.0),
        };
        let ndc = ndc_from_camera(&projection, (200, 100));
        // At distance d the image is 2·d high and, twice as wide as high, 4·d wide.
        assert_near(ndc.project_point3(Vec3::new(-2.0, 1.0, -1.0)), Vec3::new(0.0, 0.0, 0.0));
        assert_near(ndc.project_point3(Vec3::new(6.0, -3.0, -3.0)), Vec3::new(1.0, 1.0, 1.0));
        assert_near(ndc.project_point3(Vec3::new(0.0, 0.0, -2.0)), Vec3::new(0.5, 0.5, 0.75));
    }

    #[test]
    fn parallel_rays_keep_sizes() {
        let projection = Projection::Orthographic { x_mag: 2.0, y_mag: 2.0, z_near: 1.0, z_far: 5.0 };
        let ndc = ndc_from_camera(&projection, (64, 64));
        assert_near(ndc.project_point3(Vec3::new(-2.0, 2.0, -1.0)), Vec3::ZERO);
        assert_near(ndc.project_point3(Vec3::new(2.0, -2.0, -5.0)), Vec3::ONE);
    }

    #[test]
    fn time_codes_count_frames_up_to_a_day() {
        let film = (24, 1);
        assert_eq!(time_code(0, film), Some([0; 4]));
        // 1 h 2 min 3 s and 4 frames at 24 a second.
        assert_eq!(time_code((3600 + 2 * 60 + 3) * 24 + 4, film), Some([1, 2, 3, 4]));
        assert_eq!(time_code(24 * 3600 * 24 - 1, film), Some([23, 59, 59, 23]));
        assert_eq!(time_code(24 * 3600 * 24, film), None);
        assert_eq!(time_code(-1, film), None);
        assert_eq!(time_code(29, (30, 1)), Some([0, 0, 0, 29]));
        for rate in [(30000, 1001), (48, 1), (25, 2)] {
            assert_eq!(time_code(10, rate), None, "{rate:?}");
        }
    }

    #[test]
    fn narrow_images_keep_the_authored_width() {
        // Authored 2 wide and 1 high (halves); a square image shows 2 each way.
        let projection = Projection::Orthographic { x_mag: 2.0, y_mag: 1.0, z_near: 0.0, z_far: 1.0 };
        let ndc = ndc_from_camera(&projection, (8, 8));
        assert_near(ndc.project_point3(Vec3::new(2.0, 2.0, -1.0)), Vec3::new(1.0, 0.0, 1.0));
    }

    #[test]
    fn matrices_are_stored_for_row_vectors() {
        // A camera at (1, 2, 3) without rotation: the world origin is at (−1, −2, −3) for it. OpenEXR keeps the
        // translation in the last row, elements 12 to 14.
        let camera = PosedCamera {
            world_from_camera: Mat4::from_translation(Vec3::new(1.0, 2.0, 3.0)),
            ..PosedCamera::default()
        };
        let attributes = frame_attributes(5, 0.5, (24, 1), "ab", (&camera, (16, 9)));
        assert_eq!(attributes.world_to_camera[12..], [-1.0, -2.0, -3.0, 1.0]);
        assert_eq!((attributes.frame, attributes.time_seconds), (5, 0.5));
    }
}
