//! Hierarchies of traces, built without measurement.

use rayframe::bvh::{BuildSettings, Builder, Bvh};
use rayframe::cancel::{CancelFlag, Cancelled};

use crate::soup::Soup;

/// Builds a hierarchy over `soup`.
pub fn hierarchy(soup: &Soup, settings: &BuildSettings) -> Result<Bvh, Cancelled> {
    Builder::default().build(&soup.triangles, &soup.flags, settings, &CancelFlag::new(), None)
}
