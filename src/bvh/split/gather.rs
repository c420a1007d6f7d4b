//! References of a build: boxes of whole triangles, or of parts of triangles where splitting helps.
//!
//! Splitting pays where boxes overlap heavily, and does harm elsewhere. `E`, the sum of the boxes' areas over the area of the
//! scene's box, is the average number of boxes that a line through the scene intersects. [`Split::Auto`] splits nothing while
//! `E ≤ 16`. It splits nothing either where the average box takes more than a quarter of the scene's area, because a few cuts
//! cannot separate such triangles (identical ones, for example). Otherwise it aims at
//! `R = min(budget, 1 + ((E − 16) / 118)^0.57)` references per triangle ([`super::priority`]). [`Split::Area`] follows Ernst
//! and Greiner ([`super::area`]).

use std::time::Instant;

use super::{area, priority};
use crate::bvh::references::{Input, Measures, Reference, gather_whole, measure};
use crate::bvh::settings::{BuildSettings, Split};
use crate::bvh::wide_tree::MAX_TRIANGLES;
use crate::cancel::Cancelled;

/// Overlap `E` up to which `Split::Auto` splits nothing.
const OVERLAP_WORTH_SPLITTING: f64 = 16.0;
/// Share of the scene's area of the average box above which `Split::Auto` splits nothing.
const SHARE_BEYOND_SPLITTING: f64 = 0.25;
/// Overlap beyond [`OVERLAP_WORTH_SPLITTING`] at which `Split::Auto` aims at one more reference per triangle.
const OVERLAP_SCALE: f64 = 118.0;
/// Exponent of the growth of references with that excess.
const OVERLAP_EXPONENT: f64 = 0.57;

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
            let threshold = area::gather(input, f64::from(sa_max), limit, &mut scratch.area, references)?;
            (gathered.sa_max, gathered.budget_reached) = (threshold.sa_max, threshold.budget_reached);
        }
        Split::Auto if automatic_aim(&whole, budget) > whole.count as u64 => {
            let aim = automatic_aim(&whole, budget).min(limit) as usize;
            priority::split(input, &whole, aim, &mut scratch.priority, references)?;
        }
        _ => return Ok(gathered),
    }
    gathered.measures = measure(references);
    Ok(gathered)
}

/// Number of references that [`Split::Auto`] aims at.
fn automatic_aim(whole: &Measures, budget: f64) -> u64 {
    let overlap = whole.overlap();
    let share = overlap / whole.count as f64;
    if !overlap.is_finite() || overlap <= OVERLAP_WORTH_SPLITTING || share > SHARE_BEYOND_SPLITTING {
        return whole.count as u64;
    }
    let ratio = 1.0 + libm::pow((overlap - OVERLAP_WORTH_SPLITTING) / OVERLAP_SCALE, OVERLAP_EXPONENT);
    (whole.count as f64 * ratio.min(budget)) as u64
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
        let flags = vec![TriangleFlags::default(); triangles.len()];
        let cancel = CancelFlag::new();
        let input = Input { triangles, flags: &flags, cancel: &cancel };
        let settings = BuildSettings { split, reference_budget: budget, ..BuildSettings::default() };
        let mut references = Vec::new();
        let mut gathered = gather(input, &settings, &mut Scratch::default(), &mut references).unwrap();
        gathered.bounds_seconds = 0.0;
        (gathered, references.len())
    }

    #[test]
    fn scattered_triangles_are_not_split() {
        // 1000 small triangles in a large box: E is far below 16.
        let triangles: Vec<Triangle> = (0..1000)
            .map(|i| {
                let p = Vec3::new((i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32);
                Triangle { vertices: [p, p + Vec3::X * 0.1, p + Vec3::Y * 0.1] }
            })
            .collect();
        assert_eq!(chosen(&triangles, Split::Auto, 4.0).0.sa_max, f64::INFINITY);
    }

    #[test]
    fn identical_triangles_are_not_split() {
        let triangles = vec![Triangle { vertices: [Vec3::ZERO, Vec3::X, Vec3::ONE] }; 1000];
        assert_eq!(chosen(&triangles, Split::Auto, 4.0), (chosen(&triangles, Split::Off, 4.0).0, 1000));
    }

    #[test]
    fn auto_comes_near_its_aim() {
        let triangles = bars(2000);
        let (threshold, count) = chosen(&triangles, Split::Auto, 4.0);
        assert!(!threshold.budget_reached);
        // The mean extents of such boxes are a third of the cube's, so E is about 2000 / 9 and the aim about 2.4.
        let ratio = count as f64 / 2000.0;
        assert!((2.0..=2.5).contains(&ratio), "{ratio}");
        // A smaller budget holds.
        let ratio = chosen(&triangles, Split::Auto, 1.5).1 as f64 / 2000.0;
        assert!((1.2..=1.5).contains(&ratio), "{ratio}");
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
    fn no_triangles_need_no_threshold() {
        for split in [Split::Off, Split::Auto, Split::Area(0.0)] {
            assert_eq!(chosen(&[], split, 4.0).1, 0);
        }
    }
}
