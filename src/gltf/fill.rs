//! Filling of long lists by all threads.

use rayon::prelude::*;

/// Calls `fill` with each block of `values` and its index. All blocks but the last have `block` values, which is not 0.
///
/// It is not generic over `fill`, as compilers spend much on every copy of a parallel loop.
pub(super) fn fill_blocks<T: Send>(values: &mut [T], block: usize, fill: &(dyn Fn(usize, &mut [T]) + Sync)) {
    values.par_chunks_mut(block).enumerate().for_each(|(index, values)| fill(index, values));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_belongs_to_one_block() {
        for length in [0, 1, 6, 7, 8, 1000] {
            let mut values = vec![usize::MAX; length];
            fill_blocks(&mut values, 7, &|index, block| {
                for (i, value) in block.iter_mut().enumerate() {
                    *value = index * 7 + i;
                }
            });
            assert_eq!(values, (0..length).collect::<Vec<_>>());
        }
    }
}
