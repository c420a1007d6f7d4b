//! Hits of rays with triangles.

/// The side of a triangle that a ray hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Facing {
    /// The counter-clockwise side.
    Front,
    /// The clockwise side.
    Back,
}

/// Hit of a ray with a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Ray parameter.
    pub t: f32,
    /// Barycentric weight of the second vertex.
    pub u: f32,
    /// Barycentric weight of the third vertex. The weight of the first is `1 − u − v`.
    pub v: f32,
    /// The side that was hit.
    pub facing: Facing,
}
