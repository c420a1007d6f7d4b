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
    let none = ([f32::INFINITY; N], [f32::NEG_INFINITY; N]);
    let both = |(mut low, mut high): ([f32; N], [f32; N]), (other_low, other_high): ([f32; N], [f32; N])| {
        low.iter_mut().zip(other_low).for_each(|(low, other)| *low = if other < *low { other } else { *low });
        high.iter_mut()
            .zip(other_high)
            .for_each(|(high, other)| *high = if other > *high { other } else { *high });
        (low, high)
    };
    let of_task = |task: &[[f32; N]]| task.iter().fold(none, |all, &element| both(all, (element, element)));
    let (low, high) = elements.par_chunks(ELEMENTS_PER_TASK).map(of_task).reduce(|| none, both);
    let largest = low.iter().chain(&high).fold(0.0_f32, |largest, value| largest.max(value.abs()));
    for (name, stated, actual) in [("min", &accessor.min, low), ("max", &accessor.max, high)] {
        let Some(stated) = stated.as_ref().and_then(|value| value.as_array()) else {
            continue;
        };
        let wrong = stated.iter().zip(actual).find_map(|(stated, actual)| {
            let stated = stated.as_f64()? as f32;
            let difference = (stated - actual).abs();
            (difference > TOLERANCE * largest.max(stated.abs())).then_some((stated, actual))
        });
        if let Some((stated, actual)) = wrong {
            context.warn(
                format!("/accessors/{index}/{name}"),
                format!("is {stated}, but the elements have {actual}; the elements are used"),
            );
        }
    }
}
