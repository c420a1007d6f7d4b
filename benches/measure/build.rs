//! Building a hierarchy and measuring it.

use rayframe::bvh::{BuildSettings, BuildStatistics, Builder, Bvh};
use rayframe::cancel::{CancelFlag, Cancelled};
use rayon::ThreadPool;

use crate::clock::wall_seconds;
use crate::soup::Soup;

/// Builds with memory of an earlier one, of which the best counts.
const REBUILDS: usize = 6;

/// What a hierarchy cost.
pub(crate) struct Cost {
    /// With a fresh [`Builder`].
    pub(crate) build_seconds: f64,
    /// From triangles to a structure that rays can walk, with the builder and the last structure's memory at hand.
    pub(crate) rebuild_seconds: f64,
    /// What the build of `rebuild_seconds` says of itself.
    pub(crate) fastest: BuildStatistics,
}

/// Builds on the threads of `pool`, first freshly, then again and again.
pub(crate) fn measure(
    soup: &Soup,
    settings: &BuildSettings,
    pool: &ThreadPool,
) -> Result<(Bvh, Cost), Cancelled> {
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
