//! A hierarchy whose building nobody measures.

use rayframe::bvh::{BuildSettings, Builder, Bvh};
use rayframe::cancel::{CancelFlag, Cancelled};

use crate::soup::Soup;

pub(crate) fn hierarchy(soup: &Soup, settings: &BuildSettings) -> Result<Bvh, Cancelled> {
    Builder::default().build(&soup.triangles, &soup.flags, settings, &CancelFlag::new(), None)
}
