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
            4 => [
                TriangleFlags::TRANSMISSIVE,
                TriangleFlags::TRANSMISSIVE.with(TriangleFlags::SINGLE_SIDED),
                TriangleFlags::TRANSMISSIVE.with(TriangleFlags::FILTERED),
            ][i / 6 % 3],
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

const SPLITS: [Split; 4] = [Split::Off, Split::Auto, Split::Area(1.0e-3), Split::Area(1.0e-30)];

/// Both trees with every kind of splitting at every supported SIMD level, and the reference implementation of one of them.
fn all_settings() -> Vec<BuildSettings> {
    settings_with(|_, _| true)
}

/// [`all_settings`], but every kind of splitting at one SIMD level only, which changes from input to input.
fn rotated_settings(input: usize) -> Vec<BuildSettings> {
    let levels = crate::supported_simd_levels().count();
    settings_with(|split, level| (input + split) % levels == level)
}

/// Those of [`all_settings`] whose indices of splitting and SIMD level are included.
fn settings_with(includes: impl Fn(usize, usize) -> bool) -> Vec<BuildSettings> {
    let mut all = vec![settings(BuilderKind::Karras, Split::Auto, SimdLevel::best())];
    for builder in [BuilderKind::Lbvh, BuilderKind::Ploc] {
        for (at, split) in SPLITS.into_iter().enumerate() {
            let levels = crate::supported_simd_levels().enumerate();
            let included = levels.filter(|(level, _)| includes(at, *level));
            all.extend(included.map(|(_, simd)| settings(builder, split, simd)));
        }
    }
    all
}
