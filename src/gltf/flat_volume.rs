//! Meshes of absorbing volumes that lie in a plane. `KHR_materials_volume` asks for closed meshes, and files use it for window panes.

use glam::{DVec3, Vec3};

use super::context::Context;
use crate::scene::{Material, Primitive};

/// Distance from the plane, as a share of the mesh's extent, up to which a mesh is flat.
const FLAT: f64 = 1e-4;

/// Warns of a mesh whose volumes enclose nothing: light that enters them never leaves, and is absorbed.
pub(super) fn check(context: &mut Context, materials: &[Material], primitives: &[Primitive], pointer: &str) {
    let absorbs =
        |primitive: &&Primitive| materials.get(primitive.material.index()).is_some_and(is_absorbing);
    let bounds: Vec<_> = primitives.iter().filter(absorbs).collect();
    let is_deformed =
        bounds.iter().any(|primitive| !primitive.targets.is_empty() || primitive.influences.is_some());
    let positions = || bounds.iter().flat_map(|primitive| &primitive.positions);
    if !is_deformed && is_flat(positions) {
        let message = "is flat and encloses no volume by itself, so that light which enters it is absorbed on its whole way; \
                       a thicknessFactor of 0 makes a pane";
        context.warn(pointer, message);
    }
}

fn is_absorbing(material: &Material) -> bool {
    let absorbs = |volume: crate::scene::Volume| {
        volume.attenuation_distance < f32::INFINITY && volume.attenuation_color != Vec3::ONE
    };
    material.is_volume() && material.volume.is_some_and(absorbs)
}

/// Whether all points lie in one plane, and not on a line.
fn is_flat<'p, P: Iterator<Item = &'p Vec3>>(positions: impl Fn() -> P) -> bool {
    let Some(first) = positions().next() else { return false };
    let offsets = || positions().map(|position| position.as_dvec3() - first.as_dvec3());
    let longest = |of: &dyn Fn(DVec3) -> DVec3| {
        offsets().map(of).max_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or_default()
    };
    let along = longest(&|offset| offset);
    let normal = longest(&|offset| offset.cross(along));
    let (extent, height) = (along.length(), normal.length());
    // `height` is the area that the widest triangle spans.
    let has_area = extent > 0.0 && height > FLAT * extent * extent;
    has_area && offsets().all(|offset| offset.dot(normal / height).abs() <= FLAT * extent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_are_flat_and_bodies_and_lines_are_not() {
        let flat = |points: &[Vec3]| is_flat(|| points.iter());
        let turned = glam::Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 0.7);
        let grid: Vec<_> =
            (0..25).map(|i| turned * Vec3::new((i % 5) as f32, (i / 5) as f32, 0.0) + Vec3::ONE).collect();
        assert!(flat(&grid));
        let mut bent = grid.clone();
        bent[12] += turned * Vec3::Z * 0.01;
        assert!(!flat(&bent));
        let line: Vec<_> = (0..5).map(|i| Vec3::new(i as f32, 2.0 * i as f32, 0.0)).collect();
        assert!(!flat(&line) && !flat(&[]) && !flat(&[Vec3::ONE; 3]));
    }
}
