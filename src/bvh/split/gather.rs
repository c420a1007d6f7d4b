//! References of a build: boxes of whole triangles, or of parts of triangles where splitting helps.
//!
//! Splitting pays where many boxes overlap that are nearly empty, and does harm elsewhere. `E`, the sum of the boxes' areas over
//! the area of the scene's box, is the average number of boxes that a line through the scene intersects; `D` is the same sum over
//! sparse boxes alone, those at least four times as large as what splits could leave of them ([`priority::sparse_overlap`]).
//! Walls and floors have large boxes that splits cannot empty: they count in `E` and not in `D`. [`Split::Auto`] splits nothing
//! while `D ≤ 4`. It splits nothing either where the average box takes more than a quarter of the scene's area, because a few
//! cuts cannot separate such triangles (identical ones, for example). Otherwise it aims at `R = min(budget, 1 + (D / 118)^0.57)`
//! references per triangle ([`super::priority`]), if the rays of the frame save the time that this takes. [`Split::Area`] follows Ernst and
//! Greiner ([`super::area`]).

use std::time::Instant;

use super::{area, priority};
use crate::bvh::references::{Input, Measures, Reference, gather_whole, measure};
use crate::bvh::settings::{BuildSettings, Split};
use crate::bvh::wide_tree::MAX_TRIANGLES;
use crate::cancel::Cancelled;

/// Overlap `D` of sparse boxes up to which `Split::Auto` splits nothing.
const OVERLAP_WORTH_SPLITTING: f64 = 4.0;
/// Share of the scene's area of the average box above which `Split::Auto` splits nothing.
const SHARE_BEYOND_SPLITTING: f64 = 0.25;
/// Overlap `D` at which `Split::Auto` aims at one more reference per triangle.
const OVERLAP_SCALE: f64 = 118.0;
/// Exponent of the growth of references with `D`.
const OVERLAP_EXPONENT: f64 = 0.57;

/// Nanoseconds of the build that a triangle takes where some are split: finding those, measured as 90 to 130.
const NS_PER_TRIANGLE: f64 = 90.0;
/// Nanoseconds of the build that each further reference takes: cutting, sorting, clustering and collapsing.
const NS_PER_SPLIT: f64 = 300.0;
/// Nanoseconds per ray that splits save at one unit of `D` above the least, and the exponent of their growth with it. Measured were 3 ns at
/// `D` = 7.6 (an engine), 580 ns at 128 (a forest of beams) and 1800 ns at 201 (long bars); this gives 3, 610 and 1220.
const SAVED_NS_PER_RAY: f64 = 0.44;
const SAVED_EXPONENT: f64 = 1.5;

/// Scratch memory kept between builds.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    area: area::Scratch,
    priority: priority::Scratch,
}

/// Measures of gathered references, and how they were split.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gathered {
    /// Count, bounds and area sums of the references.
    pub(crate) measures: Measures,
    /// Number of traced triangles.
    pub(crate) triangles: usize,
    /// SA_max that was used, square metres; infinite for none.
    pub(crate) sa_max: f64,
    /// Whether an explicit SA_max was raised to stay within the budget.
    pub(crate) budget_reached: bool,
    /// Seconds spent on the boxes of whole triangles.
    pub(crate) bounds_seconds: f64,
}

/// Fills `references` with boxes, split according to `settings`.
pub(crate) fn gather(
    input: Input,
    settings: &BuildSettings,
    scratch: &mut Scratch,
    references: &mut Vec<Reference>,
) -> Result<Gathered, Cancelled> {
    // Boxes of whole triangles.
    let start = Instant::now();
    let whole = gather_whole(input, references)?;
    let mut gathered = Gathered {
        measures: whole,
        triangles: whole.count,
        sa_max: f64::INFINITY,
        budget_reached: false,
        bounds_seconds: start.elapsed().as_secs_f64(),
    };

    // Boxes of parts.
    let budget = if settings.reference_budget >= 1.0 { f64::from(settings.reference_budget) } else { 1.0 };
    let limit = ((whole.count as f64 * budget) as u64).min(MAX_TRIANGLES as u64);
    match settings.split {
        Split::Area(sa_max) if sa_max < f32::INFINITY => {
            let sa_max = f64::from(sa_max).max(0.0);
            let threshold = area::gather(input, sa_max, limit, &mut scratch.area, references)?;
            (gathered.sa_max, gathered.budget_reached) = (threshold.sa_max, threshold.budget_reached);
        }
        Split::Auto => {
            let rays = settings.expected_rays;
            let aim = automatic_aim(input, &whole, references, (budget, rays))?.min(limit) as usize;
            if aim <= whole.count {
                return Ok(gathered);
            }
            priority::split(input, &whole, aim, &mut scratch.priority, references)?;
        }
        Split::Area(_) | Split::Off => return Ok(gathered),
    }
    gathered.measures = measure(references);
    Ok(gathered)
}

/// Number of references that [`Split::Auto`] aims at.
fn automatic_aim(
    input: Input,
    whole: &Measures,
    references: &[Reference],
    (budget, rays): (f64, u64),
) -> Result<u64, Cancelled> {
    let count = whole.count as u64;
    let overlap = whole.overlap();
    let share = overlap / whole.count as f64;
    let saves = |overlap: f64, ratio: f64| {
        let cost = whole.count as f64 * (NS_PER_TRIANGLE + NS_PER_SPLIT * (ratio - 1.0));
        let beyond = (overlap - OVERLAP_WORTH_SPLITTING).max(0.0);
        SAVED_NS_PER_RAY * libm::pow(beyond, SAVED_EXPONENT) * rays as f64 > cost
    };
    // `D` is `E` at most: most scenes need no second pass over their triangles.
    if !overlap.is_finite() || !saves(overlap, 1.0) || share > SHARE_BEYOND_SPLITTING {
        return Ok(count);
    }
    let sparse = priority::sparse_overlap(input, whole, references)?;
    let ratio = (1.0 + libm::pow(sparse / OVERLAP_SCALE, OVERLAP_EXPONENT)).min(budget);
    Ok(if saves(sparse, ratio) { (whole.count as f64 * ratio) as u64 } else { count })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::TriangleFlags;
    use crate::cancel::CancelFlag;
    use crate::geometry::Triangle;
    use glam::Vec3;

    /// Long thin diagonal triangles through a unit cube, whose boxes overlap heavily.
    fn bars(n: usize) -> Vec<Triangle> {
        let mut state = 3_u32;
        let mut random = || {
            state = state.wrapping_mul(747796405).wrapping_add(2891336453);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        (0..n)
            .map(|_| {
                let [a, b] = [0; 2].map(|_| Vec3::new(random(), random(), random()));
                Triangle { vertices: [a, b, b + Vec3::new(0.001, 0.002, 0.0)] }
            })
            .collect()
    }

    fn chosen(triangles: &[Triangle], split: Split, budget: f32) -> (Gathered, usize) {
        let settings = BuildSettings { split, reference_budget: budget, ..BuildSettings::default() };
        gathered(triangles, &settings)
    }

    fn gathered(triangles: &[Triangle], settings: &BuildSettings) -> (Gathered, usize) {
        let flags = vec![TriangleFlags::default(); triangles.len()];
        let cancel = CancelFlag::new();
        let input = Input { triangles, flags: &flags, cancel: &cancel };
        let mut references = Vec::new();
        let mut gathered = gather(input, settings, &mut Scratch::default(), &mut references).unwrap();
        gathered.bounds_seconds = 0.0;
        (gathered, references.len())
    }

    #[test]
    fn scattered_triangles_are_not_split() {
        // 1000 small triangles in a large box: E is far below 4.
        let triangles: Vec<Triangle> = (0..1000)
            .map(|i| {
                let p = Vec3::new((i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32);
                Triangle { vertices: [p, p + Vec3::X * 0.1, p + Vec3::Y * 0.1] }
            })
            .collect();
        assert_eq!(chosen(&triangles, Split::Auto, 4.0).1, 1000);
    }

    /// A thin triangle along the line from `a` to `b`, as finely divided pipes have.
    fn strip(a: Vec3, b: Vec3) -> Triangle {
        let side = (b - a).any_orthonormal_vector() * 0.01;
        Triangle { vertices: [a, b, a + side] }
    }

    #[test]
    fn sparse_boxes_decide_and_full_ones_do_not() {
        // Twenty floors of two triangles each: E is 20 and more, but no split can empty their boxes.
        let floors: Vec<Triangle> = (0..40)
            .map(|i| {
                let y = (i / 2) as f32 * 0.05;
                let corner = |x: i32, z: i32| Vec3::new(x as f32, y, z as f32);
                let last = if i % 2 == 0 { corner(1, 0) } else { corner(0, 1) };
                Triangle { vertices: [corner(0, 0), corner(1, 1), last] }
            })
            .collect();
        assert_eq!(chosen(&floors, Split::Auto, 4.0), (chosen(&floors, Split::Off, 4.0).0, 40));

        // Slanted strips along the diagonals of cells: E is between 4 and 16, and nearly all of it is air.
        let strips: Vec<Triangle> = (0..240)
            .map(|i| {
                let cell = Vec3::new((i % 4) as f32, (i / 4 % 4) as f32, (i / 16 % 4) as f32);
                let lift = Vec3::splat(0.02 * (i / 64) as f32);
                // Different lengths, since equal ones would get equal numbers of splits.
                strip(cell + lift, cell + lift + Vec3::new(0.9, 0.8, 0.85) * (0.7 + 0.001 * i as f32))
            })
            .collect();
        let (whole, _) = chosen(&strips, Split::Off, 4.0);
        assert!((4.0..16.0).contains(&whole.measures.overlap()), "{}", whole.measures.overlap());
        let (split, count) = chosen(&strips, Split::Auto, 4.0);
        assert!(count > 240 && split.measures.overlap() < 0.9 * whole.measures.overlap(), "{count}");
    }

    #[test]
    fn identical_triangles_are_not_split() {
        let triangles = vec![Triangle { vertices: [Vec3::ZERO, Vec3::X, Vec3::ONE] }; 1000];
        assert_eq!(chosen(&triangles, Split::Auto, 4.0), (chosen(&triangles, Split::Off, 4.0).0, 1000));
    }

    #[test]
    fn auto_comes_near_its_aim() {
        let triangles = bars(2000);
        let (_, count) = chosen(&triangles, Split::Auto, 4.0);
        // The mean extents of such boxes are a third of the cube's, so E is about 2000 / 9 and the aim about 2.4.
        let ratio = count as f64 / 2000.0;
        assert!((2.0..=2.5).contains(&ratio), "{ratio}");
        // A smaller budget holds.
        let ratio = chosen(&triangles, Split::Auto, 1.5).1 as f64 / 2000.0;
        assert!((1.2..=1.5).contains(&ratio), "{ratio}");
    }

    #[test]
    fn triangles_are_split_for_rays_that_save_the_time() {
        // D is about 200, so that a ray saves some 1.2 µs. Finding what to split takes 0.2 ms, and splitting another 0.8 ms.
        let triangles = bars(2000);
        let references = |expected_rays| {
            let settings = BuildSettings { expected_rays, ..BuildSettings::default() };
            gathered(&triangles, &settings).1
        };
        assert_eq!([0, 100, 500].map(references), [2000; 3]);
        assert_eq!(references(1500), references(u64::MAX));
        assert!(references(1500) > 2000);
    }

    #[test]
    fn a_tiny_area_keeps_to_the_budget() {
        let triangles = bars(2000);
        for area in [1.0e-9, 1.0e-30, 0.0] {
            let (threshold, count) = chosen(&triangles, Split::Area(area), 3.0);
            assert!(threshold.budget_reached);
            assert!((5500..=6000).contains(&count), "{count}");
        }
        let one = &triangles[..1];
        assert!(chosen(one, Split::Area(1.0e-30), 4.0).1 <= 4);
        assert_eq!(chosen(one, Split::Area(1.0e-30), f32::NAN).1, 1);
    }

    #[test]
    fn an_area_within_the_budget_is_used_as_it_is() {
        let (threshold, count) = chosen(&bars(500), Split::Area(1.0), 4.0);
        assert_eq!((threshold.sa_max, threshold.budget_reached), (1.0, false));
        assert!(count > 500);
        assert_eq!(chosen(&bars(500), Split::Area(f32::NAN), 4.0).1, 500);
    }

    #[test]
    fn areas_below_zero_are_zero() {
        for area in [-0.0, -1.0e-30, -1.0, f32::MIN, f32::NEG_INFINITY] {
            assert_eq!(chosen(&[], Split::Area(area), 4.0), chosen(&[], Split::Area(0.0), 4.0));
            let one = bars(1);
            assert_eq!(chosen(&one, Split::Area(area), 4.0), chosen(&one, Split::Area(0.0), 4.0));
        }
    }

    #[test]
    fn no_triangles_make_no_references() {
        for split in [Split::Off, Split::Auto, Split::Area(0.0), Split::Area(1.0)] {
            let (found, count) = chosen(&[], split, 4.0);
            assert_eq!((found.measures, found.triangles, count), (Measures::NONE, 0, 0));
            assert!(!found.budget_reached);
        }
    }
}
