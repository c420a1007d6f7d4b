//! Chromaticities of primaries and white points, and conversion of linear light to Rec.709.
//!
//! Sources: ITU-R BT.709-6 (primaries); SMPTE RP 177-1993 (RGB to XYZ); Lam, "Metamerism and Colour Constancy", 1985 (Bradford
//! adaptation, linear here).

use glam::{DMat3, DVec2, DVec3, Vec2};

/// Chromaticities that differ less are the same: files round them.
const TOLERANCE: f32 = 1e-4;
/// Twice the smallest area of the triangle of primaries. That of Rec.709 is 0.22.
const MIN_DOUBLED_AREA: f64 = 1e-6;
/// XYZ to the cone responses of the Bradford transform.
const BRADFORD: DMat3 = DMat3::from_cols(
    DVec3::new(0.8951, -0.7502, 0.0389),
    DVec3::new(0.2664, 1.7135, -0.0685),
    DVec3::new(-0.1614, 0.0367, 1.0296),
);

/// CIE xy chromaticities of three primaries and a white point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Chromaticities {
    /// Red primary.
    pub(crate) red: Vec2,
    /// Green primary.
    pub(crate) green: Vec2,
    /// Blue primary.
    pub(crate) blue: Vec2,
    /// White point.
    pub(crate) white: Vec2,
}

/// Rec.709 primaries with white point D65: the colour space of all radiance.
pub(crate) const REC709: Chromaticities = Chromaticities {
    red: Vec2::new(0.64, 0.33),
    green: Vec2::new(0.30, 0.60),
    blue: Vec2::new(0.15, 0.06),
    white: Vec2::new(0.3127, 0.3290),
};

impl Chromaticities {
    /// Whether these are those of Rec.709, but for rounding.
    pub(crate) fn is_rec709(&self) -> bool {
        let differences = [
            self.red - REC709.red,
            self.green - REC709.green,
            self.blue - REC709.blue,
            self.white - REC709.white,
        ];
        differences.iter().all(|difference| difference.abs().cmple(Vec2::splat(TOLERANCE)).all())
    }

    /// The matrix from linear colours of these primaries to Rec.709, which keeps white. `None` where the primaries span no colours
    /// or the white point is none.
    pub(crate) fn to_rec709(self) -> Option<DMat3> {
        let adapted = bradford(xyz_of_white(self.white)?, xyz_of_white(REC709.white)?);
        let matrix = REC709.to_xyz()?.inverse() * adapted * self.to_xyz()?;
        matrix.is_finite().then_some(matrix)
    }

    /// The matrix from linear colours of these primaries to XYZ, where white has the luminance 1.
    fn to_xyz(self) -> Option<DMat3> {
        let [red, green, blue] = [self.red, self.green, self.blue].map(Vec2::as_dvec2);
        let primaries = DMat3::from_cols(xyz(red), xyz(green), xyz(blue));
        let white = xyz_of_white(self.white)?;
        // The columns have the sum 1, so that the determinant is twice the area of the triangle.
        let are_independent = primaries.determinant().abs() >= MIN_DOUBLED_AREA;
        are_independent.then(|| primaries * DMat3::from_diagonal(primaries.inverse() * white))
    }
}

/// XYZ of a chromaticity, with the sum 1.
fn xyz(xy: DVec2) -> DVec3 {
    DVec3::new(xy.x, xy.y, 1.0 - xy.x - xy.y)
}

/// XYZ of a white point with the luminance 1. `None` without luminance.
fn xyz_of_white(white: Vec2) -> Option<DVec3> {
    let white = white.as_dvec2();
    (white.y > 0.0).then(|| xyz(white) / white.y)
}

/// The matrix of XYZ that takes the white `from` to the white `to`. Not finite where a cone does not respond to `from`.
fn bradford(from: DVec3, to: DVec3) -> DMat3 {
    BRADFORD.inverse() * DMat3::from_diagonal(BRADFORD * to / (BRADFORD * from)) * BRADFORD
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ACES2065-1 (SMPTE ST 2065-1:2012).
    const AP0: Chromaticities = Chromaticities {
        red: Vec2::new(0.7347, 0.2653),
        green: Vec2::new(0.0, 1.0),
        blue: Vec2::new(0.0001, -0.077),
        white: Vec2::new(0.32168, 0.33767),
    };

    fn assert_near(color: DVec3, expected: [f64; 3]) {
        assert!((color - DVec3::from(expected)).abs().max_element() < 1e-5, "{color} is not {expected:?}");
    }

    #[test]
    fn conversions_have_their_published_values() {
        // The columns of the ACES transform from ACES2065-1 to linear Rec.709 with Bradford adaptation
        let matrix = AP0.to_rec709().unwrap();
        assert_near(matrix.x_axis, [2.521_686, -0.276_480, -0.015_378]);
        assert_near(matrix.y_axis, [-1.134_131, 1.372_719, -0.152_975]);
        assert_near(matrix.z_axis, [-0.387_555, -0.096_239, 1.168_353]);
        assert_near(matrix * DVec3::ONE, [1.0; 3]);
        // ITU-R BT.2087-0, annex 2: red of Rec.2020 in Rec.709
        let rec2020 = Chromaticities {
            red: Vec2::new(0.708, 0.292),
            green: Vec2::new(0.170, 0.797),
            blue: Vec2::new(0.131, 0.046),
            ..REC709
        };
        assert_near(rec2020.to_rec709().unwrap().x_axis, [1.660_491, -0.124_550, -0.018_151]);
    }

    #[test]
    fn rounded_rec709_is_rec709() {
        assert!(REC709.is_rec709() && !AP0.is_rec709());
        assert!(Chromaticities { white: Vec2::new(0.31271, 0.32902), ..REC709 }.is_rec709());
        assert!(!Chromaticities { red: Vec2::new(f32::NAN, 0.33), ..REC709 }.is_rec709());
        let matrix = REC709.to_rec709().unwrap();
        assert!(matrix.abs_diff_eq(DMat3::IDENTITY, 1e-12), "{matrix}");
    }

    #[test]
    fn primaries_without_colours_have_no_matrix() {
        for malformed in [
            Chromaticities { red: REC709.blue, ..REC709 },
            Chromaticities { red: Vec2::NAN, ..REC709 },
            Chromaticities { green: Vec2::INFINITY, ..REC709 },
            Chromaticities { white: Vec2::new(0.3127, 0.0), ..REC709 },
            Chromaticities { white: Vec2::NAN, ..REC709 },
            Chromaticities { red: Vec2::ZERO, green: Vec2::ZERO, blue: Vec2::ZERO, white: Vec2::ZERO },
        ] {
            assert_eq!(malformed.to_rec709(), None, "{malformed:?}");
        }
    }
}
