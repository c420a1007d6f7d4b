//! Uneven samples of an interval: from thirteen on, nothing periodic in it matches them all.

/// One share of an interval from 0 to 1 in each of `count` equal parts, at a hashed offset: in order, always the same.
pub(crate) fn uneven_shares(count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |index| (index as f64 + offset(index)) / count as f64)
}

/// A number from 0 to 1 that depends on the index alone: the output function of SplitMix64 (Steele, Lea and Flood 2014).
fn offset(index: usize) -> f64 {
    let mut x = (index as u64).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_has_a_share() {
        for (index, share) in uneven_shares(100).enumerate() {
            assert_eq!((share * 100.0) as usize, index);
        }
        assert_eq!(uneven_shares(0).count(), 0);
    }

    #[test]
    fn no_period_is_missed() {
        for count in [13, 15, 16, 100] {
            for cycles in 1..200 {
                let phases: Vec<f64> =
                    uneven_shares(count).map(|share| (share * f64::from(cycles)).fract()).collect();
                for half in [0.0, 0.5] {
                    let within = phases.iter().filter(|phase| (half..half + 0.5).contains(*phase)).count();
                    assert!(4 * within > count / 2, "{within} of {count} in a half of {cycles} cycles");
                }
            }
        }
    }
}
