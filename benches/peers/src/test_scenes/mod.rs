//! Generated test scenes of any size, each with one difficulty. They are equal on every machine and fit one camera.
//!
//! * `sphere`: a finely divided octahedron projected to a sphere and dented: an even mesh;
//! * `soup`: small triangles at random in a cube: no structure;
//! * `bars`: long thin boxes in all directions through each other: bounding boxes that overlap heavily;
//! * `dense`: a fine sphere on a ground of kilometres: nearly all triangles in a small part of the scene.

mod sphere;
mod spread;

use rayframe::geometry::Triangle;

/// Triangles within about a metre of the origin, with a name.
pub struct TestScene {
    /// Name on the command line and in tables.
    pub name: &'static str,
    /// Triangles in world space.
    pub triangles: Vec<Triangle>,
}

/// All scenes, each of about `size` triangles.
pub fn all(size: usize) -> [TestScene; 4] {
    [
        TestScene { name: "sphere", triangles: sphere::dented(size) },
        TestScene { name: "soup", triangles: spread::soup(size) },
        TestScene { name: "bars", triangles: spread::bars(size) },
        TestScene { name: "dense", triangles: sphere::on_wide_ground(size) },
    ]
}
