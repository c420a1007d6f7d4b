//! Axis-aligned bounding boxes.

use glam::Vec3;

/// Axis-aligned bounding box; empty if any component of `min` exceeds that of `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Aabb {
    /// Lowest corner.
    pub min: Vec3,
    /// Highest corner.
    pub max: Vec3,
}

impl Aabb {
    /// The empty box, the neutral element of [`Aabb::union`].
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box around all `points`.
    pub fn from_points(points: &[Vec3]) -> Self {
        points.iter().fold(Self::EMPTY, |bounds, &point| bounds.union_point(point))
    }

    /// The smallest box around both boxes.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The smallest box around this one and `point`.
    #[must_use]
    pub fn union_point(self, point: Vec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// Whether the box contains no point.
    pub fn is_empty(&self) -> bool {
        self.min.x > self.max.x || self.min.y > self.max.y || self.min.z > self.max.z
    }

    /// The centre, computed without overflow.
    pub fn center(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// Edge lengths.
    pub fn extent(&self) -> Vec3 {
        self.max - self.min
    }

    /// The surface area, computed without overflow; zero for an empty box.
    pub fn area(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let e = self.max.as_dvec3() - self.min.as_dvec3();
        2.0 * (e.x * e.y + e.y * e.z + e.z * e.x)
    }

    /// The box with every face moved outward by `distance`.
    #[must_use]
    pub fn grown(self, distance: f32) -> Self {
        Self { min: self.min - distance, max: self.max + distance }
    }

    /// Whether `other` lies entirely inside; faces may touch.
    pub fn contains(&self, other: &Self) -> bool {
        self.min.cmple(other.min).all() && self.max.cmpge(other.max).all()
    }
}
