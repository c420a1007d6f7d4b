//! Resizing of lists by all threads.

use rayon::prelude::*;

/// Values of one parallel task.
const VALUES_PER_TASK: usize = 16_384;

/// Resizes `list` to `count` values, where new ones are those of `value`. The first write to a page of fresh memory costs more than
/// all later ones together, so that all threads share these.
pub(crate) fn resize_with<T: Send>(list: &mut Vec<T>, count: usize, value: impl Fn() -> T + Sync + Send) {
    list.truncate(count);
    let missing = count - list.len();
    list.reserve_exact(missing);
    list.par_extend((0..missing).into_par_iter().with_min_len(VALUES_PER_TASK).map(|_| value()));
}

/// Resizes `list` to `count` values, where new ones are `zero`, all of whose bits are clear. Old ones are kept where the list's memory suffices, and
/// are `zero`, too, where it does not. Large lists come zeroed from the operating system, so that only what is written to costs anything.
pub(crate) fn resize_zeroed<T: Copy>(list: &mut Vec<T>, count: usize, zero: T) {
    if list.capacity() < count {
        *list = Vec::new();
        *list = vec![zero; count];
    } else {
        list.resize(count, zero);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_values_are_zero_and_old_ones_zero_or_kept() {
        let mut list = vec![7_u32; 3];
        resize_zeroed(&mut list, 70_000, 0);
        assert_eq!(list, vec![0; 70_000]);
        list[1] = 5;
        resize_zeroed(&mut list, 2, 0);
        assert_eq!(list, [0, 5]);
        resize_zeroed(&mut list, 4, 0);
        assert_eq!(list, [0, 5, 0, 0]);
    }

    #[test]
    fn lists_are_as_after_a_serial_resize() {
        let mut list: Vec<usize> = Vec::new();
        let mut expected = list.clone();
        for (value, count) in [0, 3, 70_000, 70_000, 5, 40_000, 0, 1].into_iter().enumerate() {
            resize_with(&mut list, count, || value);
            expected.resize(count, value);
            assert_eq!(list, expected, "{count} values");
        }
    }
}
