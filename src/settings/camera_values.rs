//! Texts of the camera's settings to values.

use glam::Vec3;

use super::choices::LookAt;
use super::parse::finite;
use crate::scene::{NameOrIndex, Orbit};

/// Height of the sensor of a focal length, millimetres, as for the f-number of an aperture.
const SENSOR_HEIGHT_MM: f32 = 24.0;

/// `AZ,EL` or `AZ,EL,DIST`.
pub(super) fn orbit(text: &str) -> Result<Orbit, String> {
    let (azimuth_degrees, elevation_degrees, distance) = match numbers(text).as_deref() {
        Some(&[azimuth, elevation]) => (azimuth, elevation, 1.0),
        Some(&[azimuth, elevation, distance]) => (azimuth, elevation, distance),
        _ => {
            return Err(
                "write azimuth and elevation in degrees, such as 30,20, or with a distance: 30,20,1.5"
                    .to_owned(),
            );
        }
    };
    if !(-90.0..=90.0).contains(&elevation_degrees) {
        return Err("the elevation lies between -90 and 90 degrees".to_owned());
    }
    if distance <= 0.0 {
        return Err("the distance must be above 0; 1 fits the image, 2 shows it half as large".to_owned());
    }
    Ok(Orbit { azimuth_degrees, elevation_degrees, distance })
}

/// `X,Y,Z`.
pub(super) fn point(text: &str) -> Result<Vec3, String> {
    match numbers(text).as_deref() {
        Some(&[x, y, z]) => Ok(Vec3::new(x, y, z)),
        _ => Err("write three numbers X,Y,Z".to_owned()),
    }
}

/// `X,Y,Z`, not all zero.
pub(super) fn direction(text: &str) -> Result<Vec3, String> {
    match point(text)? {
        Vec3::ZERO => Err("0,0,0 is no direction".to_owned()),
        direction => Ok(direction),
    }
}

/// `X,Y,Z`, or a node.
pub(super) fn look_at(text: &str) -> Result<LookAt, String> {
    match numbers(text) {
        Some(numbers) if numbers.len() > 1 => point(text).map(LookAt::Point),
        _ => Ok(LookAt::Node(NameOrIndex::parse(text))),
    }
}

/// Degrees from -90 to 90.
pub(super) fn elevation(text: &str) -> Result<f32, String> {
    match finite(text) {
        Ok(degrees) if (-90.0..=90.0).contains(&degrees) => Ok(degrees),
        _ => Err("write degrees from -90 to 90".to_owned()),
    }
}

/// Degrees of a vertical field of view.
pub(super) fn field_of_view(text: &str) -> Result<f32, String> {
    match finite(text) {
        Ok(degrees) if (0.1..=175.0).contains(&degrees) => Ok(degrees),
        _ => Err("write degrees from 0.1 to 175".to_owned()),
    }
}

/// Millimetres.
pub(super) fn focal_length(text: &str) -> Result<f32, String> {
    match finite(text) {
        Ok(millimetres) if (1.0..=10000.0).contains(&millimetres) => Ok(millimetres),
        _ => Err("write millimetres from 1 to 10000".to_owned()),
    }
}

/// Vertical field of view of a focal length, degrees.
pub(crate) fn field_of_view_of(focal_length_mm: f32) -> f32 {
    (libm::atanf(SENSOR_HEIGHT_MM * 0.5 / focal_length_mm) * 2.0).to_degrees()
}

fn numbers(text: &str) -> Option<Vec<f32>> {
    text.split(',').map(|number| finite(number.trim()).ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::NameOrIndex;

    #[test]
    fn orbits_are_two_angles_and_a_distance() {
        let is = |azimuth_degrees, elevation_degrees, distance| {
            Ok(Orbit { azimuth_degrees, elevation_degrees, distance })
        };
        assert_eq!(orbit("30,20"), is(30.0, 20.0, 1.0));
        assert_eq!(orbit("-30, 90, 1.5"), is(-30.0, 90.0, 1.5));
        for text in ["", "30", "30,91", "30,20,0", "30,20,-1", "a,b", "1,2,3,4", "30,nan"] {
            assert!(orbit(text).is_err(), "{text}");
        }
    }

    #[test]
    fn targets_are_points_or_nodes() {
        assert_eq!(look_at("1,-2,0.5"), Ok(LookAt::Point(Vec3::new(1.0, -2.0, 0.5))));
        assert_eq!(look_at("Head"), Ok(LookAt::Node(NameOrIndex::Name("Head".to_owned()))));
        assert_eq!(look_at("#3"), Ok(LookAt::Node(NameOrIndex::Index(3))));
        assert!(look_at("1,2").is_err() && point("1,2").is_err() && point("1,2,inf").is_err());
    }

    #[test]
    fn a_focal_length_of_twelve_millimetres_sees_ninety_degrees() {
        assert!((field_of_view_of(12.0) - 90.0).abs() < 1e-4);
        assert!(field_of_view("0").is_err() && focal_length("0").is_err() && elevation("91").is_err());
    }
}
