//! Tests of all elements of long lists.

use rayon::prelude::*;

/// Elements of one parallel task.
const ELEMENTS_PER_TASK: usize = 16_384;

/// Index of the first element for which `is_wrong` holds. Elements are tested without branches until a task has a wrong one, which is
/// faster by far than to look for the first one by one.
pub(super) fn first_wrong<T: Sync>(elements: &[T], is_wrong: impl Fn(&T) -> bool + Sync) -> Option<usize> {
    let any_wrong = |task: &[T]| task.iter().fold(false, |any, element| any | is_wrong(element));
    let task = elements.par_chunks(ELEMENTS_PER_TASK).position_first(any_wrong)?;
    let start = task.saturating_mul(ELEMENTS_PER_TASK);
    let within = elements.get(start..)?.iter().position(is_wrong)?;
    Some(start.saturating_add(within))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_several_wrong_elements_is_found() {
        let last = 3 * ELEMENTS_PER_TASK + 4;
        let is_wrong = |wrong: &[usize]| {
            let mut elements = vec![0_u8; last + 1];
            for &index in wrong {
                elements[index] = 1;
            }
            first_wrong(&elements, |&element| element == 1)
        };
        assert_eq!(is_wrong(&[]), None);
        for first in [0, 1, ELEMENTS_PER_TASK - 1, ELEMENTS_PER_TASK, ELEMENTS_PER_TASK + 9, last] {
            assert_eq!(is_wrong(&[first, last]), Some(first));
        }
        assert_eq!(first_wrong(&[], |_: &u8| true), None);
    }
}
