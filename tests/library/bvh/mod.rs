//! Tests of the hierarchy: every query equals brute force to the last bit for all settings; cost and depth of trees.

mod inputs;
mod queries;
mod trees;

use rayframe::bvh::{BuildSettings, Builder, BuilderKind, Bvh, SimdLevel, Split, TriangleFlags};
use rayframe::cancel::CancelFlag;
use rayframe::geometry::Triangle;

/// Builders that create a hierarchy.
const HIERARCHIES: [BuilderKind; 3] = [BuilderKind::Lbvh, BuilderKind::Karras, BuilderKind::Ploc];

fn flags(n: usize) -> Vec<TriangleFlags> {
    (0..n)
        .map(|i| match i % 6 {
            0 => TriangleFlags::SINGLE_SIDED,
            1 => TriangleFlags::FILTERED,
            2 => TriangleFlags::FILTERED.with(TriangleFlags::SINGLE_SIDED),
            3 if i % 12 == 3 => TriangleFlags::HIDDEN,
            _ => TriangleFlags::default(),
        })
        .collect()
}

#[expect(clippy::unwrap_used, reason = "only tests call this, and nothing raises the flag")]
fn build(triangles: &[Triangle], flags: &[TriangleFlags], settings: &BuildSettings) -> Bvh {
    Builder::default().build(triangles, flags, settings, &CancelFlag::new(), None).unwrap()
}

fn settings(builder: BuilderKind, split: Split, simd: SimdLevel) -> BuildSettings {
    BuildSettings { builder, split, simd, ..BuildSettings::default() }
}

/// Both trees with every kind of splitting at every supported SIMD level, and the reference implementation of one of them.
fn all_settings() -> Vec<BuildSettings> {
    let mut all = vec![settings(BuilderKind::Karras, Split::Auto, SimdLevel::best())];
    for builder in [BuilderKind::Lbvh, BuilderKind::Ploc] {
        for split in [Split::Off, Split::Auto, Split::Area(1.0e-3), Split::Area(1.0e-30)] {
            for simd in crate::supported_simd_levels() {
                all.push(settings(builder, split, simd));
            }
        }
    }
    all
}
