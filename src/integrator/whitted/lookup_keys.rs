//! Keys of the sample points of environment lookups.

use crate::integrator::zsobol::DimensionKeys;

/// Dimensions of the sample points of one ray.
const DIMENSIONS: u32 = 2;

/// Rays of one lookup at most.
const MAX_RAYS: u32 = 4096;

/// The keys of the sample points of each lookup's first ray, which is most often its only one.
#[derive(Debug, Default)]
pub(super) struct LookupKeys {
    /// By number of the lookup: a seed, and its keys.
    of_lookups: Vec<Option<(u32, [DimensionKeys; DIMENSIONS as usize])>>,
}

impl LookupKeys {
    /// The keys of a ray of a lookup, in sequences with this seed.
    pub(super) fn get(&mut self, seed: u32, lookup: usize, ray: u32) -> [DimensionKeys; DIMENSIONS as usize] {
        let first = (lookup as u32 * MAX_RAYS + ray) * DIMENSIONS;
        let new = || std::array::from_fn(|i| DimensionKeys::new(seed, first + i as u32));
        if ray != 0 {
            return new();
        }
        if self.of_lookups.len() <= lookup {
            self.of_lookups.resize(lookup + 1, None);
        }
        match &mut self.of_lookups[lookup] {
            Some((known_seed, keys)) if *known_seed == seed => *keys,
            slot => slot.insert((seed, new())).1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::zsobol::ZSobol;

    #[test]
    fn keys_of_lookups_are_those_of_their_dimensions() {
        let mut keys = LookupKeys::default();
        // Sample 5 is beyond the four of a pixel and has a seed of its own.
        for (lookup, ray, sample) in [(9, 0, 1), (9, 3, 1), (9, 0, 2), (9, 0, 5), (2, 0, 5), (9, 0, 1)] {
            let sequence = ZSobol::new(4, 7).sequence((10, 20), sample);
            let keys = keys.get(sequence.seed(), lookup, ray);
            let dimension = (lookup as u32 * MAX_RAYS + ray) * DIMENSIONS;
            assert_eq!(sequence.point_by(&keys[0]), sequence.point(dimension));
            assert_eq!(sequence.number_by(&keys[1]), sequence.number(dimension + 1));
        }
    }
}
