//! Cameras that frame the scene: the automatic one, orbits, named views, turntables, and changes to a file's camera.
//!
//! [`resolve_camera`] replaces what was requested by a camera that [`crate::frame::Frame::pose`] can evaluate at any time. Cameras
//! depend on the scene, the selected clips and the aspect ratio of the image, never on the frames that are rendered.

mod added_times;
mod blocks;
mod enclosure;
mod extent;
mod fit;
mod ground;
mod inside;
mod interior;
mod left_out;
mod moving_surfaces;
mod orbit;
mod own_camera;
mod posed_triangles;
mod resolve;
mod shared;
mod subject;
mod supports;

pub use ground::ground_below;
pub use interior::is_interior;
pub use orbit::NamedView;
pub use own_camera::CameraRule;
pub(crate) use posed_triangles::kept_bytes;
pub use resolve::{ResolvedCamera, framed_nodes, resolve_camera};
pub(crate) use shared::SharedFraming;
