//! The `min` and `max` of accessors, compared with their elements. The import never relies on them.
//!
//! Source: glTF 2.0 specification, section 3.6.2.5 (accessor bounds).

use gltf::json::Accessor;
use rayon::prelude::*;

use super::context::Context;

/// Allowed difference, as a share of the largest magnitude. Exporters print rounded decimals.
const TOLERANCE: f32 = 1e-3;
/// Elements of one parallel task.
const ELEMENTS_PER_TASK: usize = 16_384;

/// Most components of an element: those of a 4 x 4 matrix.
const MOST_COMPONENTS: usize = 16;

/// Least and largest value of each component; infinities beyond the last.
type Extremes = [[f32; MOST_COMPONENTS]; 2];

/// Those of no elements.
const NONE: Extremes = [[f32::INFINITY; MOST_COMPONENTS], [f32::NEG_INFINITY; MOST_COMPONENTS]];

/// Warns if `accessor`, which stores the floats `elements`, states another `min` or `max`.
pub(super) fn check_extremes<const N: usize>(
    context: &mut Context,
    accessor: &Accessor,
    index: usize,
    elements: &[[f32; N]],
) {
    if accessor.min.is_none() && accessor.max.is_none() {
        return;
    }
    let block = N.saturating_mul(ELEMENTS_PER_TASK);
    let [low, high] = extremes(elements.as_flattened(), block, &block_extremes::<N>);
    let [low, high] = [&low, &high].map(|values| values.get(..N).unwrap_or_default());
    let largest = low.iter().chain(high).fold(0.0_f32, |largest, value| largest.max(value.abs()));
    for (name, stated, actual) in [("min", &accessor.min, low), ("max", &accessor.max, high)] {
        let Some(stated) = stated.as_ref().and_then(|value| value.as_array()) else {
            continue;
        };
        let wrong = stated.iter().zip(actual).find_map(|(stated, actual)| {
            let stated = stated.as_f64()? as f32;
            let difference = (stated - actual).abs();
            (difference > TOLERANCE * largest.max(stated.abs())).then_some((stated, *actual))
        });
        if let Some((stated, actual)) = wrong {
            context.warn(
                format!("/accessors/{index}/{name}"),
                format!("is {stated}, but the elements have {actual}; the elements are used"),
            );
        }
    }
}

/// Extremes of all blocks of `components`. It is not generic, as compilers spend much on every copy of a parallel loop.
fn extremes(components: &[f32], block: usize, of_block: &(dyn Fn(&[f32]) -> Extremes + Sync)) -> Extremes {
    let both = |[mut low, mut high]: Extremes, [other_low, other_high]: Extremes| {
        lower(&mut low, &other_low);
        raise(&mut high, &other_high);
        [low, high]
    };
    components.par_chunks(block).map(of_block).reduce(|| NONE, both)
}

/// Extremes of elements of `N` components.
fn block_extremes<const N: usize>(components: &[f32]) -> Extremes {
    let (mut low, mut high) = ([f32::INFINITY; N], [f32::NEG_INFINITY; N]);
    for element in components.as_chunks::<N>().0 {
        lower(&mut low, element);
        raise(&mut high, element);
    }
    let mut extremes = NONE;
    for (all, of_block) in extremes.iter_mut().zip([low, high]) {
        all.iter_mut().zip(of_block).for_each(|(all, value)| *all = value);
    }
    extremes
}

/// Takes the lesser of each pair of values; a NaN changes nothing.
fn lower(low: &mut [f32], others: &[f32]) {
    low.iter_mut().zip(others).for_each(|(low, &other)| *low = if other < *low { other } else { *low });
}

/// Takes the larger of each pair of values; a NaN changes nothing.
fn raise(high: &mut [f32], others: &[f32]) {
    high.iter_mut().zip(others).for_each(|(high, &other)| *high = if other > *high { other } else { *high });
}
