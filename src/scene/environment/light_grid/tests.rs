//! Positions in cells, searches, and grids that are kept.

use std::sync::Arc;

use fearless_simd::Level;

use super::*;
use crate::scene::{BuiltInLight, ComposedEnvironment, Environment};

fn points(count: u32) -> impl Iterator<Item = Vec2> {
    let fraction = |x: f32| x - x.floor();
    (0..count).map(move |i| {
        let i = i as f32 + 0.5;
        Vec2::new(fraction(i * 0.754_877_7), fraction(i * 0.569_840_3))
    })
}

#[test]
fn places_in_a_cell_are_where_its_light_is() {
    // Evenly where the light is even, or not known
    for light in [3.0, 0.0, f32::INFINITY, f32::NAN] {
        let even = CellLight::new(&[[light; PARTS]; PARTS]);
        for u in points(100) {
            assert!(even.place(u).distance(u) < 1e-6, "{light}: {u}");
        }
    }
    // By the light of parts of which some are dark
    let mut parts = [[0.0; PARTS]; PARTS];
    (parts[1][3], parts[2][0], parts[2][1]) = (1.0, 5.0, 2.0);
    let (cell, count) = (CellLight::new(&parts), 8000);
    let mut counts = [[0; PARTS]; PARTS];
    for u in points(count) {
        let Vec2 { x, y } = cell.place(u) * PARTS as f32;
        counts[x as usize][y as usize] += 1;
    }
    for (part, expected) in parts.as_flattened().iter().enumerate() {
        let share = counts.as_flattened()[part] as f32 / count as f32;
        assert!((share - expected / 8.0).abs() < 2e-3 && (share > 0.0) == (*expected > 0.0), "{counts:?}");
    }
}

#[test]
fn counting_sums_is_a_search() {
    let ramp: [f32; CELLS] = std::array::from_fn(|i| i as f32);
    let steps = ramp.map(|sum| (sum / 5.0).floor());
    let overflow = ramp.map(|sum| if sum > 20.0 { f32::INFINITY } else { sum });
    let unknown = ramp.map(|sum| if sum > 20.0 { f32::NAN } else { sum });
    for sums in [ramp, steps, overflow, unknown, [0.0; CELLS]] {
        for chosen in [0.0, 0.5, 1.0, 5.5, 20.0, 31.0, 40.0, f32::INFINITY, f32::NAN] {
            let expected = sums.partition_point(|&sum| sum <= chosen);
            assert_eq!(count_up_to(&sums, chosen), expected, "{chosen} in {sums:?}");
        }
    }
}

#[test]
fn parts_are_chosen_by_their_share() {
    // Five parts of 2, of which each begins where three dark ones end
    let ends: [f32; CELLS] = std::array::from_fn(|i| 10.0 + 2.0 * ((i + 1) / 4).min(5) as f32);
    for (chosen, index, start, place) in [
        (10.0, 3, 10.0, 0.0),
        (11.5, 3, 10.0, 0.75),
        (12.0, 7, 12.0, 0.0),
        (19.0, 19, 18.0, 0.5),
        // Rounding may reach the end.
        (20.0, 19, 18.0, 1.0),
    ] {
        let part = part_of(&ends, 10.0, chosen).unwrap();
        assert_eq!((part.index, part.start, part.sum), (index, start, 2.0), "{chosen}");
        assert!((part.place - place).abs() < 1e-6, "{chosen}: {}", part.place);
    }
    for dark in [0.0, 7.0, f32::NAN] {
        assert!(part_of(&[dark; CELLS], dark, dark).is_none());
    }
    let overflow = ends.map(|sum| if sum > 15.0 { f32::INFINITY } else { sum });
    assert!(part_of(&overflow, 10.0, 11.0).is_none());
}

#[test]
fn directions_in_lanes_are_those_of_single_normals() {
    let lit = Environment::BuiltIn(BuiltInLight::Studio).light_grid();
    // Light from above leaves surfaces that face down dark.
    let above = LightGrid::new(|lookups, _, radiances| {
        for lane in lookups.lanes {
            let height = lookups.directions.get(lane).y;
            radiances.set(lane, Vec3::splat(if height > 0.9 { height } else { 0.0 }));
        }
    });
    let mut dark = 0;
    for grid in [&*lit, &above] {
        let numbers: Vec<Vec2> = points(64 * LANES as u32).collect();
        for (block, u) in numbers.chunks(LANES).enumerate() {
            let (mut normals, mut us) = (Vec3Lanes::default(), Vec2Lanes::default());
            let mut randoms = F32Lanes::default();
            for (lane, u) in u.iter().enumerate() {
                let turned = Vec2::new(u.y, u.x * 0.37 + block as f32 / 100.0);
                normals.set(lane, LuminanceImage::direction_from_uv(turned));
                us.set(lane, *u);
                randoms[lane] = (lane * 4099 + block) as f32 / (1 << 16) as f32;
            }
            let lanes = ActiveLanes::first(LANES).filtered(|lane| lane != block % LANES);
            for level in [Level::fallback(), Level::new()] {
                let lookups = LookupLanes { level, directions: &normals, lanes };
                let mut directions = Vec3Lanes::default();
                let lit = grid.diffuse_lanes(&lookups, &us, &randoms, &mut directions);
                for lane in lanes {
                    let found = lit.contains(lane).then(|| directions.get(lane));
                    assert_eq!(found, grid.diffuse(normals.get(lane), us.get(lane), randoms[lane]));
                    dark += u32::from(found.is_none());
                }
                assert!(!lit.contains(block % LANES));
            }
        }
    }
    assert!((100..2000).contains(&dark), "{dark}");
}

#[test]
fn grids_are_kept_where_the_light_stays_the_same() {
    let studio = || Environment::BuiltIn(BuiltInLight::Studio);
    assert!(Arc::ptr_eq(&studio().light_grid(), &studio().light_grid()));
    let composed = |intensity: f32| {
        Environment::Composed(Box::new(ComposedEnvironment { light: studio(), intensity, background: None }))
    };
    assert!(Arc::ptr_eq(&composed(1.0).light_grid(), &studio().light_grid()));
    let [one, two] = [1.0, 2.0].map(|intensity| composed(intensity).light_grid().irradiance(Vec3::Y));
    assert!((two / one - 2.0).abs() < 1e-5, "{two} {one}");
}
