//! Measured builds of hierarchies.

use rayframe::bvh::{BuildSettings, BuildStatistics, Builder, Bvh};
use rayframe::cancel::{CancelFlag, Cancelled};
use rayon::ThreadPool;

use crate::clock::wall_seconds;
use crate::soup::Soup;

/// Rebuilds with reused memory; the best counts.
const REBUILDS: usize = 6;

/// Build times of a hierarchy.
pub struct Cost {
    /// Seconds of the first build, with a new [`Builder`].
    pub build_seconds: f64,
    /// Seconds of the best rebuild, with the builder and the memory of the last hierarchy reused.
    pub rebuild_seconds: f64,
    /// Statistics of the best rebuild.
    pub fastest: BuildStatistics,
}

/// Builds on the threads of `pool`, first with new memory, then with reused memory.
pub fn measure(soup: &Soup, settings: &BuildSettings, pool: &ThreadPool) -> Result<(Bvh, Cost), Cancelled> {
    pool.install(|| {
        let mut builder = Builder::default();
        let mut build = |recycled| {
            let cancel = CancelFlag::new();
            wall_seconds(|| builder.build(&soup.triangles, &soup.flags, settings, &cancel, recycled))
        };
        let (fresh, build_seconds) = build(None);
        let mut bvh = fresh?;
        let mut cost = Cost { build_seconds, rebuild_seconds: f64::INFINITY, fastest: bvh.statistics() };
        for _ in 0..REBUILDS {
            let (again, seconds) = build(Some(bvh));
            bvh = again?;
            if seconds < cost.rebuild_seconds {
                cost = Cost { rebuild_seconds: seconds, fastest: bvh.statistics(), ..cost };
            }
        }
        Ok((bvh, cost))
    })
}
