//! Sampling of a disk.

use glam::Vec2;

use super::sin_cos_of_turn;

/// Concentric map from the unit square to the unit disk. It preserves relative areas and adjacency (Shirley and Chiu, "A Low
/// Distortion Map Between Disk and Square", 1997).
pub(crate) fn concentric_disk_point(u: Vec2) -> Vec2 {
    const QUARTER: f32 = std::f32::consts::FRAC_PI_4;
    let centred = u * 2.0 - Vec2::ONE;
    if centred == Vec2::ZERO {
        return Vec2::ZERO;
    }
    let (radius, angle) = if centred.x.abs() > centred.y.abs() {
        (centred.x, QUARTER * (centred.y / centred.x))
    } else {
        (centred.y, 2.0 * QUARTER - QUARTER * (centred.x / centred.y))
    };
    let (sine, cosine) = sin_cos_of_turn(angle);
    Vec2::new(cosine, sine) * radius
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_areas_are_preserved() {
        // A quarter of evenly spread points lies within half the radius, and their mean is the centre.
        let side = 256;
        let points = (0..side * side).map(|i| {
            let cell = Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5);
            concentric_disk_point(cell / side as f32)
        });
        let (mut inside, mut sum) = (0, Vec2::ZERO);
        for point in points {
            assert!(point.length() <= 1.0 + 1e-6);
            inside += u32::from(point.length() < 0.5);
            sum += point;
        }
        let count = (side * side) as f32;
        assert!((inside as f32 / count - 0.25).abs() < 2e-3);
        assert!((sum / count).length() < 1e-3);
    }

    #[test]
    fn the_centre_and_the_corners_map_exactly() {
        assert_eq!(concentric_disk_point(Vec2::splat(0.5)), Vec2::ZERO);
        let corner = concentric_disk_point(Vec2::ONE);
        assert!((corner - Vec2::splat(std::f32::consts::FRAC_1_SQRT_2)).length() < 1e-6);
    }
}
