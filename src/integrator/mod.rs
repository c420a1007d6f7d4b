//! From samples of a tile to radiance.
