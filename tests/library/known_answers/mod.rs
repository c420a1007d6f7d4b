//! Renders with known answers: a comment derives every expected number.
//!
//! Unless a test says otherwise, an image is one pixel of one sample, so that the camera's axis is the only camera ray.

mod coincident_lamps;
mod dark_sides;
mod diffuse_volumes;
mod distributed;
mod environment_shadows;
mod environments;
mod far;
mod frosted_glass;
mod glass;
mod ground;
mod lamps_through_glass;
mod light;
mod light_passes;
mod lit_occluders;
mod material_extensions;
mod normals;
mod path;
mod reflection;
mod skin;
mod surface;
mod textured_lamps;
mod thin_walls;
mod touching;
mod visible_environment;
