//! Decomposition of matrices into translation, rotation and scale.

use glam::{DMat3, DQuat, DVec3, Mat4, Quat, Vec3};

use super::LocalTransform;

/// Largest distance between the unit axes of a matrix and those of its rotation, unless it shears. Exporters print rounded decimals.
const TOLERANCE: f64 = 1e-3;

/// Translation, rotation and scale of an affine matrix. Of a mirroring one the scale along x is negative, as three.js has it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DecomposedMatrix {
    pub(crate) translation: Vec3,
    pub(crate) rotation: Quat,
    pub(crate) scale: Vec3,
    /// Whether the matrix shears, which the three leave out.
    pub(crate) has_shear: bool,
}

impl DecomposedMatrix {
    pub(crate) fn new(matrix: &Mat4) -> Self {
        let linear = DMat3::from_mat4(matrix.as_dmat4());
        let mirror = if linear.determinant() < 0.0 { DVec3::new(-1.0, 1.0, 1.0) } else { DVec3::ONE };
        let columns = [linear.x_axis * mirror.x, linear.y_axis, linear.z_axis];
        let units = columns.map(DVec3::try_normalize);
        let axes = completed(units);
        let rotation = DQuat::from_mat3(&axes).normalize();
        let rotated = DMat3::from_quat(rotation);
        let differs = |i: usize| (rotated.col(i) - axes.col(i)).length() > TOLERANCE;
        Self {
            translation: matrix.w_axis.truncate(),
            rotation: rotation.as_quat(),
            scale: (DVec3::from_array(columns.map(DVec3::length)) * mirror).as_vec3(),
            has_shear: (0..3).any(differs),
        }
    }
}

impl From<DecomposedMatrix> for LocalTransform {
    fn from(DecomposedMatrix { translation, rotation, scale, .. }: DecomposedMatrix) -> Self {
        Self::Trs { translation, rotation, scale }
    }
}

/// The axes with those of columns of length 0: of one, the cross product of the others; of several, those of the smallest rotation to the
/// axis that is left.
fn completed(units: [Option<DVec3>; 3]) -> DMat3 {
    let left = (0..3).find_map(|i| Some(DQuat::from_rotation_arc(DMat3::IDENTITY.col(i), units[i]?)));
    let rotated = DMat3::from_quat(left.unwrap_or_default());
    let axis = |i: usize| match (units[i], units[(i + 1) % 3], units[(i + 2) % 3]) {
        (Some(own), ..) => own,
        (None, Some(next), Some(last)) => next.cross(last).normalize_or(rotated.col(i)),
        _ => rotated.col(i),
    };
    DMat3::from_cols(axis(0), axis(1), axis(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Asserts that `matrix` is what its parts make.
    fn assert_recomposed(matrix: Mat4) -> DecomposedMatrix {
        let parts = DecomposedMatrix::new(&matrix);
        assert!(!parts.has_shear && parts.rotation.is_normalized(), "{parts:?}");
        let DecomposedMatrix { translation, rotation, scale, .. } = parts;
        let joined = Mat4::from_scale_rotation_translation(scale, rotation, translation);
        assert!(joined.abs_diff_eq(matrix, 1e-5), "{joined} {matrix}");
        parts
    }

    #[test]
    fn matrices_without_shear_are_recomposed() {
        let rotation = Quat::from_xyzw(0.5, -0.1, 0.7, 0.5).normalize();
        let translation = Vec3::new(1.0, -2.0, 3.0);
        for scale in [[1.0; 3], [2.0, 0.5, 1e-3], [-2.0, 0.5, 3.0], [1.0, -1.0, -1.0], [-1.0; 3]] {
            let matrix = Mat4::from_scale_rotation_translation(scale.into(), rotation, translation);
            let parts = assert_recomposed(matrix);
            let is_mirrored = scale.iter().product::<f32>() < 0.0;
            assert_eq!(parts.scale.to_array().map(|factor| factor < 0.0), [is_mirrored, false, false]);
        }
    }

    #[test]
    fn scales_of_0_keep_the_other_axes() {
        let rotation = Quat::from_xyzw(0.5, -0.1, 0.7, 0.5).normalize();
        for scale in [[0.0, 2.0, 3.0], [2.0, 0.0, 3.0], [0.0, 0.0, 2.0], [0.0; 3]] {
            assert_recomposed(Mat4::from_scale_rotation_translation(scale.into(), rotation, Vec3::ONE));
        }
    }

    #[test]
    fn shear_is_found() {
        let mut matrix = Mat4::from_scale(Vec3::new(1.0, 1e-3, 1.0));
        assert!(!DecomposedMatrix::new(&matrix).has_shear);
        matrix.y_axis.x = 1e-4;
        let parts = DecomposedMatrix::new(&matrix);
        assert!(parts.has_shear && parts.rotation.is_normalized(), "{parts:?}");
        // Two equal columns.
        matrix.y_axis = matrix.x_axis;
        let parts = DecomposedMatrix::new(&matrix);
        assert!(parts.has_shear && parts.rotation.is_normalized(), "{parts:?}");
    }
}
