//! Division of a sequence into chunks of equal cost.

/// How frames are dealt to tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ChunkRule {
    /// Each task has frames that follow each other.
    Contiguous,
    /// Task k of n has the frames k, k + n, k + 2n, ….
    Interleaved,
}

/// Divides `frames` into `count` chunks, none of them empty. `costs` holds the cost of each frame; contiguous chunks end where the running
/// total is closest to their equal share.
pub(super) fn chunks(frames: &[i64], costs: &[f64], count: usize, rule: ChunkRule) -> Vec<Vec<i64>> {
    let count = count.clamp(1, frames.len().max(1));
    match rule {
        ChunkRule::Interleaved => {
            (0..count).map(|first| frames.iter().skip(first).step_by(count).copied().collect()).collect()
        }
        ChunkRule::Contiguous => {
            let ends = ends(costs, count);
            let starts = std::iter::once(0).chain(ends.iter().copied());
            starts.zip(&ends).map(|(start, &end)| frames[start..end].to_vec()).collect()
        }
    }
}

/// Where each of `count` chunks ends.
fn ends(costs: &[f64], count: usize) -> Vec<usize> {
    let total: f64 = costs.iter().sum();
    let mut ends = Vec::with_capacity(count);
    let (mut end, mut before) = (0, 0.0);
    for chunk in 1..=count {
        let share = total * chunk as f64 / count as f64;
        // Leave a frame for each chunk that follows.
        let last = costs.len() - (count - chunk);
        let first = end;
        while end < last && (end == first || before + costs[end] / 2.0 <= share) {
            before += costs[end];
            end += 1;
        }
        ends.push(if chunk == count { costs.len() } else { end });
    }
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    fn divided(costs: &[f64], count: usize, rule: ChunkRule) -> Vec<Vec<i64>> {
        let frames: Vec<i64> = (1..=costs.len() as i64).collect();
        let chunks = chunks(&frames, costs, count, rule);
        let mut all: Vec<i64> = chunks.concat();
        all.sort_unstable();
        assert_eq!(all, frames, "every frame is in one chunk");
        assert!(chunks.iter().all(|chunk| !chunk.is_empty()));
        chunks
    }

    #[test]
    fn every_frame_is_in_one_chunk() {
        for length in [1, 2, 3, 10, 24, 101] {
            for count in [1, 2, 3, 7, 24, 500] {
                for rule in [ChunkRule::Contiguous, ChunkRule::Interleaved] {
                    let costs: Vec<f64> = (0..length).map(|frame| f64::from(frame % 5)).collect();
                    assert_eq!(divided(&costs, count, rule).len(), count.min(length as usize));
                    assert_eq!(
                        divided(&vec![0.0; length as usize], count, rule).len(),
                        count.min(length as usize)
                    );
                }
            }
        }
    }

    #[test]
    fn chunks_have_equal_costs() {
        assert_eq!(divided(&[1.0; 6], 3, ChunkRule::Contiguous), [[1, 2], [3, 4], [5, 6]]);
        // 1 + 1 + 1 + 1 = 4.
        assert_eq!(
            divided(&[1.0, 1.0, 1.0, 1.0, 4.0], 2, ChunkRule::Contiguous),
            [vec![1, 2, 3, 4], vec![5]]
        );
        assert_eq!(
            divided(&[4.0, 1.0, 1.0, 1.0, 1.0], 2, ChunkRule::Contiguous),
            [vec![1], vec![2, 3, 4, 5]]
        );
        assert_eq!(divided(&[1.0; 5], 2, ChunkRule::Interleaved), [vec![1, 3, 5], vec![2, 4]]);
    }
}
