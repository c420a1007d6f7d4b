//! Scenes of our own, of any size, each with one difficulty. They are the same on every machine, and fit one camera.
//!
//! * `sphere`: an octahedron cut finely, blown up to a sphere and dented: an even mesh;
//! * `soup`: small triangles anywhere in a cube: nothing to find;
//! * `bars`: long thin boxes in all directions through each other: boxes that overlap massively;
//! * `dense`: a fine sphere on a ground of kilometres: nearly everything is in one place.

mod sphere;
mod spread;

use rayframe::geometry::Triangle;

/// A scene within about a metre of the origin.
pub(crate) struct Subject {
    pub(crate) name: &'static str,
    pub(crate) triangles: Vec<Triangle>,
}

/// All scenes, each of about `size` triangles.
pub(crate) fn all(size: usize) -> [Subject; 4] {
    [
        Subject { name: "sphere", triangles: sphere::dented(size) },
        Subject { name: "soup", triangles: spread::soup(size) },
        Subject { name: "bars", triangles: spread::bars(size) },
        Subject { name: "dense", triangles: sphere::on_wide_ground(size) },
    ]
}
