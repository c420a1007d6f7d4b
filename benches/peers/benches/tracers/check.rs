//! Check that all configurations give equal answers, to the last bit.
//!
//! The expected answers are those of the plain LBVH without splits, traversed by scalar code one ray at a time: index and bits of
//! `t` of the closest hit, or occlusion. Every configuration must give the same at every SIMD level of this machine, one by one
//! and in batches. Brute force must give the same for a sample.

use std::io::Write;

use rayframe::bvh::{BuildSettings, BuilderKind, Bvh, Hit, SimdLevel, TraversalCounters};
use rayframe::geometry::Ray;
use rayon::prelude::*;

use crate::Result;
use crate::folder::Subject;
use peers::configuration::CONFIGURATIONS;
use peers::hierarchy::hierarchy;
use peers::ray_set::Query;
use peers::trace::BATCH;

/// All levels; unsupported ones are skipped.
const LEVELS: [SimdLevel; 5] = SimdLevel::ALL;

/// Rays and their query.
struct Questions<'a> {
    name: String,
    query: Query,
    rays: &'a [Ray],
}

/// Single rays or batches.
#[derive(Clone, Copy, Debug)]
enum Mode {
    Single,
    Batches,
}

/// Compares all configurations; returns the number of differing answers.
pub(crate) fn differences(subject: &Subject, sample: usize, out: &mut impl Write) -> Result<usize> {
    let questions = questions(subject);
    let [plain, ..] = CONFIGURATIONS;
    let settings = BuildSettings { simd: SimdLevel::Scalar, ..plain.settings() };
    let bvh = hierarchy(&subject.soup, &settings)?;
    let expected: Vec<_> = questions.iter().map(|asked| answers(&bvh, asked, Mode::Single)).collect();
    let mut differing = brute_force(subject, sample, (&questions, &expected), out)?;
    for configuration in &CONFIGURATIONS {
        for level in LEVELS.into_iter().filter(|level| level.is_supported()) {
            let settings = BuildSettings { simd: level, ..configuration.settings() };
            let bvh = hierarchy(&subject.soup, &settings)?;
            for mode in [Mode::Single, Mode::Batches] {
                for (asked, expected) in questions.iter().zip(&expected) {
                    let wrong = count(&answers(&bvh, asked, mode), expected);
                    differing += wrong;
                    let name = format!("{} {level:?} {mode:?} {}", configuration.name, asked.name);
                    report(out, &subject.name, &name, (asked.rays.len(), wrong))?;
                }
            }
        }
    }
    Ok(differing)
}

/// All sets, and shadow rays that start at the light.
fn questions(subject: &Subject) -> Vec<Questions<'_>> {
    let mut questions = Vec::new();
    for set in &subject.sets {
        questions.push(Questions { name: set.name.to_owned(), query: set.query, rays: &set.rays });
        if let Some(rays) = &set.from_light {
            questions.push(Questions {
                name: format!("{} from the light", set.name),
                query: set.query,
                rays,
            });
        }
    }
    questions
}

/// Compares brute force on `sample` rays, spread evenly over all questions.
fn brute_force(
    subject: &Subject,
    sample: usize,
    (questions, expected): (&[Questions<'_>], &[Vec<u64>]),
    out: &mut impl Write,
) -> Result<usize> {
    let settings = BuildSettings { builder: BuilderKind::BruteForce, ..BuildSettings::default() };
    let bvh = hierarchy(&subject.soup, &settings)?;
    let mut differing = 0;
    for (asked, expected) in questions.iter().zip(expected) {
        let step = (asked.rays.len() * questions.len()).div_ceil(sample.max(1)).max(1);
        let rays: Vec<Ray> = asked.rays.iter().copied().step_by(step).collect();
        let expected: Vec<u64> = expected.iter().copied().step_by(step).collect();
        let some = Questions { name: asked.name.clone(), query: asked.query, rays: &rays };
        let wrong = count(&answers(&bvh, &some, Mode::Single), &expected);
        differing += wrong;
        report(out, &subject.name, &format!("brute force {}", asked.name), (rays.len(), wrong))?;
    }
    Ok(differing)
}

fn count(answers: &[u64], expected: &[u64]) -> usize {
    answers.iter().zip(expected).filter(|(answer, expected)| answer != expected).count()
}

fn report(out: &mut impl Write, scene: &str, name: &str, (rays, wrong): (usize, usize)) -> Result<()> {
    Ok(writeln!(out, "{scene:<8} {name:<44} {rays:>8} rays {wrong:>6} differ")?)
}

/// One number per ray that identifies its answer.
fn answers(bvh: &Bvh, asked: &Questions<'_>, mode: Mode) -> Vec<u64> {
    let mut answers = vec![0; asked.rays.len()];
    let tasks = asked.rays.par_chunks(BATCH).zip(answers.par_chunks_mut(BATCH));
    tasks.for_each(|(rays, answers)| match mode {
        Mode::Single => answer_singly(bvh, rays, asked.query, answers),
        Mode::Batches => answer_together(bvh, rays, asked.query, answers),
    });
    answers
}

fn answer_singly(bvh: &Bvh, rays: &[Ray], query: Query, answers: &mut [u64]) {
    let mut counters = TraversalCounters::default();
    for (ray, answer) in rays.iter().zip(answers) {
        *answer = match query {
            Query::Closest => bits(bvh.closest_hit(ray, None, |_| true, &mut counters)),
            Query::Occluded => u64::from(bvh.occluded(ray, |_| true, &mut counters)),
        };
    }
}

fn answer_together(bvh: &Bvh, rays: &[Ray], query: Query, answers: &mut [u64]) {
    let mut counters = TraversalCounters::default();
    match query {
        Query::Closest => {
            let mut hits = vec![None; rays.len()];
            bvh.closest_hits(rays, |_, _| true, &mut hits, &mut counters);
            answers.iter_mut().zip(hits).for_each(|(answer, hit)| *answer = bits(hit));
        }
        Query::Occluded => {
            let mut occluded = vec![false; rays.len()];
            bvh.occluded_rays(rays, |_, _| true, &mut occluded, &mut counters);
            answers.iter_mut().zip(occluded).for_each(|(answer, occluded)| *answer = u64::from(occluded));
        }
    }
}

fn bits(hit: Option<Hit>) -> u64 {
    hit.map_or(u64::MAX, |hit| u64::from(hit.triangle) << 32 | u64::from(hit.t.to_bits()))
}
