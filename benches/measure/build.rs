//! Building a hierarchy and measuring it.

use rayframe::bvh::{BuildSettings, BuildStatistics, Builder, Bvh, PrimitiveFlags};
use rayframe::cancel::{CancelFlag, Cancelled};
use rayframe::geometry::Triangle;
use rayon::ThreadPool;

use crate::clock::wall_seconds;

/// Builds with memory of an earlier one, of which the best counts.
const REBUILDS: usize = 6;

/// Opaque, double-sided triangles.
pub(crate) struct Soup {
    /// World space.
    pub(crate) triangles: Vec<Triangle>,
    /// One a triangle.
    pub(crate) flags: Vec<PrimitiveFlags>,
}

/// A hierarchy and what it cost.
pub(crate) struct Built {
    /// Of the last build.
    pub(crate) bvh: Bvh,
    /// With a fresh [`Builder`].
    pub(crate) build_seconds: f64,
    /// From triangles to a structure that rays can walk, with the builder and the last structure's memory at hand.
    pub(crate) rebuild_seconds: f64,
    /// What the build of `rebuild_seconds` says of itself.
    pub(crate) fastest: BuildStatistics,
}

impl Soup {
    pub(crate) fn new(triangles: Vec<Triangle>) -> Self {
        let flags = vec![PrimitiveFlags::default(); triangles.len()];
        Self { triangles, flags }
    }

    /// A hierarchy that nobody measures.
    pub(crate) fn bvh(&self, settings: &BuildSettings) -> Result<Bvh, Cancelled> {
        Builder::default().build(&self.triangles, &self.flags, settings, &CancelFlag::new(), None)
    }

    /// Builds on the threads of `pool`, first freshly, then again and again.
    pub(crate) fn measure(&self, settings: &BuildSettings, pool: &ThreadPool) -> Result<Built, Cancelled> {
        pool.install(|| {
            let mut builder = Builder::default();
            let mut build = |recycled| {
                let cancel = CancelFlag::new();
                wall_seconds(|| builder.build(&self.triangles, &self.flags, settings, &cancel, recycled))
            };
            let (fresh, build_seconds) = build(None);
            let mut bvh = fresh?;
            let (mut rebuild_seconds, mut fastest) = (f64::INFINITY, bvh.statistics());
            for _ in 0..REBUILDS {
                let (again, seconds) = build(Some(bvh));
                bvh = again?;
                if seconds < rebuild_seconds {
                    (rebuild_seconds, fastest) = (seconds, bvh.statistics());
                }
            }
            Ok(Built { bvh, build_seconds, rebuild_seconds, fastest })
        })
    }
}
