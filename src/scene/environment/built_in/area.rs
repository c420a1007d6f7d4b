//! Rectangular areas of light or shade on the sphere of directions.
//!
//! An area is a flat rectangle that faces the scene at a distance of one. Its edges are soft: across an edge the share of the
//! area rises by a smoothstep. A mean over a parallelogram of directions widens the edges to the parallelogram's extents, which
//! keeps the energy.

use glam::Vec3;

use crate::geometry::smoothstep;

/// A rectangle as it is stated: angles in degrees, azimuth and elevation as of `orbit` (0, 0 is +Z; azimuth 90 is +X).
pub(super) struct AreaDesign {
    pub(super) azimuth: f32,
    pub(super) elevation: f32,
    /// Width and height between the middles of opposite edges, seen from the scene.
    pub(super) size: [f32; 2],
    /// Width of an edge.
    pub(super) edge: f32,
    pub(super) radiance: Vec3,
}

/// A rectangle, prepared for lookups.
#[derive(Debug)]
pub(super) struct Area {
    /// Unit vector towards the centre.
    center: Vec3,
    right: Vec3,
    up: Vec3,
    /// Half of the width and height on the plane at a distance of one.
    half: [f32; 2],
    /// Width of an edge on that plane.
    edge: f32,
    radiance: Vec3,
    /// Least cosine between the centre and a direction that the area covers.
    least_cosine: f32,
}

/// Least cosine at which a mean looks at an area.
const LEAST_COSINE: f32 = 0.05;

/// Limit of the squared extents of a parallelogram on the plane, far beyond any area.
const MAX_EXTENT_SQUARED: f32 = 1e4;

impl Area {
    pub(super) fn new(design: &AreaDesign) -> Self {
        let AreaDesign { azimuth, elevation, size, edge, radiance } = *design;
        let center = direction(azimuth, elevation);
        let (sin_azimuth, cos_azimuth) = libm::sincosf(azimuth.to_radians());
        let right = Vec3::new(cos_azimuth, 0.0, -sin_azimuth);
        let half = size.map(|degrees| libm::tanf((0.5 * degrees).to_radians()));
        let edge = 2.0 * libm::tanf((0.5 * edge).to_radians());
        let corner = half.map(|half| half + 0.5 * edge);
        let least_cosine = 1.0 / (1.0 + corner[0] * corner[0] + corner[1] * corner[1]).sqrt();
        Self { center, right, up: center.cross(right), half, edge, radiance, least_cosine }
    }

    /// `behind`, covered by the area in a direction.
    #[inline]
    pub(super) fn over(&self, behind: Vec3, direction: Vec3) -> Vec3 {
        let cosine = self.center.dot(direction);
        if cosine <= self.least_cosine {
            return behind;
        }
        let share = cover(self.right.dot(direction) / cosine, self.half[0], self.edge)
            * cover(self.up.dot(direction) / cosine, self.half[1], self.edge);
        behind + (self.radiance - behind) * share
    }

    /// [`Area::over`] for the mean over a parallelogram of directions.
    #[inline]
    pub(super) fn mean_over(&self, behind: Vec3, directions: &Parallelogram) -> Vec3 {
        let &Parallelogram { direction, differentials: [a, b], size_squared } = directions;
        let Some((cosine, x, y)) = self.position(direction, size_squared) else {
            return behind;
        };
        let (along_a, along_b) = (self.center.dot(a), self.center.dot(b));
        let extent_squared = |axis: Vec3, position: f32| {
            let step_a = (axis.dot(a) - position * along_a) / cosine;
            let step_b = (axis.dot(b) - position * along_b) / cosine;
            step_a * step_a + step_b * step_b
        };
        self.blend(behind, (x, extent_squared(self.right, x)), (y, extent_squared(self.up, y)))
    }

    /// [`Area::over`] for the mean over a square of directions of the given width.
    #[inline]
    pub(super) fn mean_over_square(&self, behind: Vec3, direction: Vec3, width: f32) -> Vec3 {
        let width_squared = width * width;
        let Some((cosine, x, y)) = self.position(direction, 2.0 * width_squared) else {
            return behind;
        };
        let scale = width_squared / (cosine * cosine);
        self.blend(behind, (x, scale * (1.0 + x * x)), (y, scale * (1.0 + y * y)))
    }

    /// Cosine and position on the plane of a direction, from which a parallelogram of a size may reach the area.
    #[inline]
    fn position(&self, direction: Vec3, size_squared: f32) -> Option<(f32, f32, f32)> {
        let cosine = self.center.dot(direction);
        let missing = self.least_cosine - cosine;
        // A comparison with not a number is false, so that it reaches everything.
        if cosine <= LEAST_COSINE || (missing > 0.0 && missing * missing > size_squared) {
            return None;
        }
        Some((cosine, self.right.dot(direction) / cosine, self.up.dot(direction) / cosine))
    }

    /// `behind`, covered by the share of the area around a position, with the squared extent along each axis.
    #[inline]
    fn blend(&self, behind: Vec3, across: (f32, f32), upwards: (f32, f32)) -> Vec3 {
        let share = |(position, extent_squared): (f32, f32), half: f32| {
            // Not a number counts as the largest.
            let extent_squared =
                if extent_squared < MAX_EXTENT_SQUARED { extent_squared } else { MAX_EXTENT_SQUARED };
            // Variances add: w² / 12 of a box, w² / 20 of the slope of a smoothstep.
            cover(position, half, (self.edge * self.edge + extent_squared * (20.0 / 12.0)).sqrt())
        };
        behind + (self.radiance - behind) * (share(across, self.half[0]) * share(upwards, self.half[1]))
    }
}

/// Directions around a unit vector that two differentials span.
pub(super) struct Parallelogram {
    direction: Vec3,
    differentials: [Vec3; 2],
    /// Sum of the squares of both.
    size_squared: f32,
}

impl Parallelogram {
    #[inline]
    pub(super) fn new(direction: Vec3, differentials: [Vec3; 2]) -> Self {
        let [a, b] = differentials;
        Self { direction, differentials, size_squared: a.dot(a) + b.dot(b) }
    }
}

/// Unit vector of an azimuth and an elevation in degrees.
pub(super) fn direction(azimuth: f32, elevation: f32) -> Vec3 {
    let (sin_azimuth, cos_azimuth) = libm::sincosf(azimuth.to_radians());
    let (sin_elevation, cos_elevation) = libm::sincosf(elevation.to_radians());
    Vec3::new(cos_elevation * sin_azimuth, sin_elevation, cos_elevation * cos_azimuth)
}

/// Share of an interval from −`half` to `half` with edges `edge` wide. Its integral is 2 `half` for any edge.
#[inline]
fn cover(position: f32, half: f32, edge: f32) -> f32 {
    let rise = |from_middle: f32| smoothstep([0.0, 1.0], from_middle / edge + 0.5);
    rise(position + half) - rise(position - half)
}
